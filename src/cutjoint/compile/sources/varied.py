"""A chain's tree where numbers of its description are arguments: places, frames and bodies as expressions.

Only what an argument touches is an expression; all else stays the constant that the model has.  Links that fixed joints
carry are placed in the moving body, joint by joint, as `cutjoint.chain.build` does it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile.equations.inertia import BodyInertia, principal
from cutjoint.compile.equations.pose import PlacedFrame
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.expressions.vectors import (
    IDENTITY,
    Matrix,
    Vector,
    about,
    add,
    column,
    constant_rotation,
    constant_vector,
    dot,
    product,
    scale,
    sub,
    turn,
)
from cutjoint.compile.sources.parameters import Parameters
from cutjoint.description.model import Inertial, Joint
from cutjoint.description.paths import PLACE, TENSOR
from cutjoint.description.values import place_of

Placed = tuple[Matrix, Vector]
"""Rotation and translation."""
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Varied:
    """What of a model the parameters touch.

    Args:
        model: the tree.
        parameters: of the robot.

    Attributes:
        links: whose inertia in the body that carries them is an expression.
        loose: joints of the model whose placement in the parent is one.
    """

    def __init__(self, model: pin.Model, parameters: Parameters) -> None:
        self.model, self.robot = model, parameters.robot
        paths = [path for places in parameters.paths.values() for path in places]
        touched = {path.of for path in paths}
        children: dict[str, list[Joint]] = defaultdict(list)
        for joint in self.robot.joints:
            children[joint.parent].append(joint)
        self._above = {joint.child: joint for joint in self.robot.joints}
        self._moved: dict[str, bool] = {self.robot.root: False}
        loose: list[int] = []
        stack = [self.robot.root]
        while stack:
            parent = stack.pop()
            for joint in children[parent]:
                moved = self._moved[parent] or f"joints.{joint.name}.origin" in touched
                self._moved[joint.child] = moved and not joint.type.moves
                if moved and joint.type.moves:
                    loose.append(model.getJointId(joint.name))
                stack.append(joint.child)
        self.loose = tuple(loose)
        inert = {path.name for path in paths if path.part == "links"}
        self.links = tuple(
            link.name
            for link in self.robot.links
            if int(self._frame(link.name).parentJoint)
            and (link.name in inert or link.name in parameters.short or (self._moved[link.name] and link.inertial))
        )
        self._frames = self._touched_frames(touched)

    def _frame(self, link: str) -> pin.Frame:
        return self.model.frames[self.model.getFrameId(link, pin.FrameType.BODY)]

    def _touched_frames(self, touched: set[str]) -> dict[str, tuple[str, Array]]:
        """Name -> link and placement there, of the frames whose place is an expression."""
        tool = () if self.robot.tool is None else (("tool", self.robot.tool),)
        sides = ((f"cuts.{cut.name}.{side}", getattr(cut, side)) for cut in self.robot.cuts for side in "ab")
        return {
            name: (frame.link, frame.placement)
            for name, frame in (*tool, *sides)
            if name in touched or self._moved[frame.link]
        }

    # -- places ------------------------------------------------------------------------------------------------------

    def placed(self, tree: JointTree, numbers: Mapping[str, Number]) -> dict[int, Placed]:
        """Placement of every loose joint's first step in its parent."""
        found: dict[int, Placed] = {}
        for joint in (one for one in self.robot.joints if one.type.moves):
            index = self.model.getJointId(joint.name)
            if index not in self.loose:
                continue
            first, parent = tree.first[index], tree.mounts[self.model.parents[index]]
            rotation, translation = _within(self._link(joint.parent, numbers), self._origin(joint, numbers))
            step = tree.steps[first.step]
            if _is_constant(rotation):
                rotation = step.rotation
            else:
                # the model may turn a joint's frame to its axis; its child's frame turns back
                back = np.asarray(self._frame(joint.child).placement.rotation).T @ first.rotation
                rotation = product(constant_rotation(parent.rotation), product(rotation, constant_rotation(back)))
            found[first.step] = rotation, turn(constant_rotation(parent.rotation), translation)
        return found

    def frames(self, tree: JointTree, numbers: Mapping[str, Number]) -> dict[str, PlacedFrame]:
        """Frames by their name in `Arguments.frames`."""
        found: dict[str, PlacedFrame] = {}
        for name, (link, placement) in self._frames.items():
            joint, mount = self._carrier(tree, link)
            rotation, lever = _within(self._link(link, numbers), _place(placement, name, numbers))
            if _is_constant(rotation):
                whole = self._frame(link).placement * pin.SE3(np.array(placement))
                _, rotation, _ = tree.frame(joint, whole)
            else:
                rotation = product(mount, rotation)
            found[name] = tree.mounts[joint].step, rotation, turn(mount, lever)
        return found

    def _carrier(self, tree: JointTree, link: str) -> tuple[int, Matrix]:
        """The joint that carries a link, and the rotation from its frame to its step's."""
        joint = int(self._frame(link).parentJoint)
        return joint, constant_rotation(tree.mounts[joint].rotation)

    def _link(self, name: str, numbers: Mapping[str, Number]) -> Placed:
        """A link's placement in the joint that carries it."""
        if not self._moved[name]:
            here = self._frame(name).placement
            return constant_rotation(np.asarray(here.rotation)), constant_vector(np.asarray(here.translation))
        joint = self._above[name]
        return _within(self._link(joint.parent, numbers), self._origin(joint, numbers))

    def _origin(self, joint: Joint, numbers: Mapping[str, Number]) -> Placed:
        return _place(joint.placement, f"joints.{joint.name}.origin", numbers)

    # -- bodies ------------------------------------------------------------------------------------------------------

    def body(self, tree: JointTree, link: str, numbers: Mapping[str, Number], mass: Number | None) -> BodyInertia:
        """A link's inertia; with a `mass` its shape stays, and all of it is scaled."""
        inertial = self.robot.link(link).inertial or Inertial(0.0)
        joint, mount = self._carrier(tree, link)
        rotation, lever = self._link(link, numbers)
        if mass is not None and not self._moved[link] and not any(one.startswith(f"links.{link}.") for one in numbers):
            shape = pin.Inertia(1.0, np.array(inertial.com), inertial.inertia / inertial.mass)
            here = self._frame(link).placement.act(shape)
            at = np.asarray(here.lever)
            return tree.scaled_body(joint, mass, at, here.inertia + at @ at * np.eye(3) - np.outer(at, at))
        axes = product(mount, rotation)
        own = [numbers.get(f"links.{link}.com.{axis}", x) for axis, x in zip("xyz", inertial.com.tolist(), strict=True)]
        centre = turn(mount, add(lever, turn(rotation, (own[0], own[1], own[2]))))
        factor: Number = 1.0 if mass is None else mass * (1.0 / inertial.mass)
        heavy = numbers.get(f"links.{link}.mass", inertial.mass) if mass is None else mass
        tensor, given = np.array(inertial.inertia), []
        for name, (i, j) in zip(TENSOR, _ENTRIES, strict=True):
            entry = numbers.get(f"links.{link}.inertia.{name}")
            if entry is not None:
                tensor[i, j] = tensor[j, i] = 0.0
                given += _entry(entry, column(axes, i), column(axes, j), i == j)
        base, principals = principal(tensor)
        parts = [(factor * weight, turn(axes, axis)) for weight, axis in principals]
        return BodyInertia(
            tree.mounts[joint].step,
            heavy,
            scale(heavy, centre),
            factor * base + heavy * dot(centre, centre),
            (*parts, *given, (-heavy, centre)),
        )


def _entry(value: Number, x: Vector, y: Vector, is_moment: bool) -> list[tuple[Number, Vector]]:
    """An entry of an inertia along two of its axes as weighted outer products."""
    if is_moment:
        return [(value, x)]
    return [(0.5 * value, add(x, y)), (-0.5 * value, sub(x, y))]


def _place(placement: Array, name: str, numbers: Mapping[str, Number]) -> Placed:
    """A placement (4, 4) with those of its numbers that are arguments."""
    place: list[Number] = [numbers.get(f"{name}.{one}", x) for one, x in zip(PLACE, place_of(placement), strict=True)]
    rotation = constant_rotation(placement[:3, :3])
    if any(f"{name}.{one}" in numbers for one in PLACE[3:]):
        rotation = IDENTITY
        for axis, angle in enumerate(place[3:]):
            rotation = product(_turned(axis, angle), rotation)
    return rotation, (place[0], place[1], place[2])


def _turned(axis: int, angle: Number) -> Matrix:
    rotation = about(axis, functions.sin(angle), functions.cos(angle))
    return constant_rotation(np.array(rotation, dtype=float)) if _is_constant(rotation) else rotation


def _within(outer: Placed, inner: Placed) -> Placed:
    """A placement in a frame that is placed itself."""
    rotation = product(outer[0], inner[0])
    return rotation, add(outer[1], turn(outer[0], inner[1]))


def _is_constant(rotation: Matrix) -> bool:
    return not any(isinstance(x, Expression) for row in rotation for x in row)
