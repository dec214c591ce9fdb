"""The open tree of a Pinocchio model, taken apart into elementary joints, with all constants that expressions need.

A joint with a slanted axis gets a frame of its own whose z axis is that axis: constants only, and short expressions.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.joints import type_of
from cutjoint.compile.equations.inertia import BodyInertia, Moments, body_inertia, regrouped
from cutjoint.compile.equations.joints import JOINTS, StepKind, TreeStep
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import (
    IDENTITY,
    ZERO,
    Matrix,
    Vector,
    constant_rotation,
    constant_vector,
    frame_along,
)
from cutjoint.errors import InputError


@dataclass(frozen=True, eq=False)
class Mount:
    """Where a joint of the model sits: step and constant rotation from the joint's frame to the step's, or of its
    first step from the step's to the joint's placement."""

    step: int
    rotation: Array


class JointTree:
    """Constant data of the tree.

    Attributes:
        steps: elementary joints, parents first; index 0 is the world.
        bodies: what has mass, regrouped.
        mass: of all moving bodies [kg].
        anchored: first moment that rests on the world [kg m].
        mounts: for every joint of the model, the step that carries its body.
        nq, nv: sizes of configuration and velocity.
        gravity: acceleration of gravity [m/s2].
        first: for every joint of the model, its first step, and the constant rotation from its placement to that.

    Args:
        model: the tree.
        loose: joints whose placement in the parent is an argument: no inertia is handed through them.
    """

    def __init__(self, model: pin.Model, loose: Collection[int] = ()) -> None:
        self.nq, self.nv = int(model.nq), int(model.nv)
        self.gravity = constant_vector(np.asarray(model.gravity.linear))
        self.steps: list[TreeStep] = [TreeStep(-1, IDENTITY, ZERO, StepKind.TURN, 0, -1, -1, 0)]
        self.mounts: list[Mount] = [Mount(0, np.eye(3))]
        self.first: list[Mount] = [Mount(0, np.eye(3))]
        for joint in range(1, model.njoints):
            self._add(model, joint)
        self.mass = sum(float(model.inertias[joint].mass) for joint in range(1, model.njoints))
        self.bodies, self.anchored = regrouped(
            self.steps, self._moments(model), {self.first[joint].step for joint in loose}
        )

    def _add(self, model: pin.Model, joint: int) -> None:
        """The elementary joints of a joint; the second and later ones stand where the one before has its origin."""
        kind_of_joint = type_of(model, joint)
        if kind_of_joint not in JOINTS:
            raise InputError(
                f"joint '{model.names[joint]}' of type {kind_of_joint} cannot be compiled; types that can: "
                f"{', '.join(JOINTS)}"
            )
        kinds = JOINTS[kind_of_joint]
        mount, placement = self.mounts[model.parents[joint]], model.jointPlacements[joint]
        parent, rotation = mount.step, mount.rotation @ np.asarray(placement.rotation)
        translation = mount.rotation @ np.asarray(placement.translation)
        q, u, body = int(model.idx_qs[joint]), int(model.idx_vs[joint]), len(self.steps) + len(kinds) - 1
        twists = motion_subspace(model, joint).T
        for kind in kinds:
            own, axis = np.eye(3), 2
            if kind.has_axis:
                own, axis = frame_along(twists[u - int(model.idx_vs[joint])].reshape(2, 3)[0 if kind.slides else 1])
            if len(self.first) == joint:
                self.first.append(Mount(len(self.steps), own))
            where = constant_rotation(rotation @ own), constant_vector(translation)
            self.steps.append(TreeStep(parent, *where, kind, axis, q, u, body))
            parent, rotation, translation = len(self.steps) - 1, own.T, np.zeros(3)
            q, u = q + kind.coordinates, u + kind.rates
        self.mounts.append(Mount(body, rotation))

    def _moments(self, model: pin.Model) -> dict[int, Moments]:
        """Mass, first and second moments of the body on each step, about the step's origin in its frame."""
        found: dict[int, Moments] = {}
        for joint in range(1, model.njoints):
            inertia, mount = model.inertias[joint], self.mounts[joint]
            mass, turn = float(inertia.mass), mount.rotation
            centre = turn @ np.asarray(inertia.lever)
            second = turn @ np.asarray(inertia.inertia) @ turn.T
            second = second + mass * (float(centre @ centre) * np.eye(3) - np.outer(centre, centre))
            found[mount.step] = Moments(mass, mass * centre, second)
        return found

    def scaled_body(self, joint: int, mass: Number, centre: Array, inertia: Array) -> BodyInertia:
        """A body on a joint whose mass is an expression; `centre` [m] and `inertia` per mass [m2] about the joint's
        origin, in the joint's frame."""
        mount = self.mounts[joint]
        unit = Moments(1.0, mount.rotation @ centre, mount.rotation @ inertia @ mount.rotation.T)
        body = body_inertia(mount.step, unit)
        assert body is not None
        return body.scaled(mass)

    def point(self, joint: int, position: Array) -> tuple[int, Vector]:
        """Step and lever of a point given in a joint's frame."""
        mount = self.mounts[joint]
        return mount.step, constant_vector(mount.rotation @ np.asarray(position))

    def frame(self, joint: int, placement: pin.SE3) -> tuple[int, Matrix, Vector]:
        """Step, rotation and lever of a frame given in a joint's frame."""
        step, lever = self.point(joint, np.asarray(placement.translation))
        return step, constant_rotation(self.mounts[joint].rotation @ np.asarray(placement.rotation)), lever

    def path(self, step: int) -> list[int]:
        """The steps from one to the world, which does not count."""
        found = []
        while step > 0:
            found.append(step)
            step = self.steps[step].parent
        return found


def motion_subspace(model: pin.Model, joint: int) -> Array:
    """Twists (linear, angular) of a joint's rates at its zero, in its own frame, shape (6, rates of the joint)."""
    one = model.joints[joint]
    data = one.createData()
    one.calc(data, pin.neutral(model))
    return np.asarray(data.S).reshape(6, -1)
