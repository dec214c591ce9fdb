"""Elementary joints, and the inertia they carry, regrouped so that as little of it as possible has to move.

A mass sitting on a joint's axis moves with the parent just as well.  So going from the leaves to the root, everything
of a body that cannot tell the child from the parent is handed to the parent, exactly:

- turns and balls: the mass, as a point at the joint's origin;
- turns: also the first moment along the axis, and an inertia J (1 - a a') that is the same about all directions across
  the axis a; J is chosen so that one of the two moments across vanishes;
- slides: the second moments, which turn with the parent.

The result describes the same robot (same energies for every motion) with fewer numbers: the base parameters of
W. Khalil and J.-F. Kleinfinger, Minimum operations and minimum parameters of the dynamic models of tree structure
robots, IEEE J. Robot. Autom. 3(6), 1987.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.joints import StepKind, TreeStep
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ROUNDING, Vector, constant_vector, scale


@dataclass(frozen=True, eq=False)
class BodyInertia:
    """What moves with a step, after regrouping (see `regrouped`).

    Attributes:
        step: the step.
        mass: [kg].
        moment: mass times centre of mass, in the step's frame [kg m].
        base, axes: inertia about the step's origin: base 1 + sum of weight e e' over axes (weight, e) [kg m2].
    """

    step: int
    mass: Number
    moment: Vector
    base: Number
    axes: tuple[tuple[Number, Vector], ...]

    def scaled(self, factor: Number) -> BodyInertia:
        """The same, so many times as heavy."""
        moment, base = scale(factor, self.moment), factor * self.base
        axes = tuple((factor * weight, axis) for weight, axis in self.axes)
        return BodyInertia(self.step, factor * self.mass, moment, base, axes)


@dataclass(frozen=True, eq=False)
class PointMass:
    """A mass that is an argument of the compiled function (a payload), at `lever` in the frame of a step."""

    step: int
    mass: Number
    lever: Vector


@dataclass(frozen=True, eq=False)
class Moments:
    """Mass [kg], first moment (3,) [kg m] and inertia (3, 3) [kg m2] about a step's origin in its frame."""

    mass: float
    first: Array
    second: Array

    def __add__(self, other: Moments) -> Moments:
        return Moments(self.mass + other.mass, self.first + other.first, self.second + other.second)


def regrouped(
    steps: Sequence[TreeStep], moments: Mapping[int, Moments], loose: Collection[int] = ()
) -> tuple[list[BodyInertia], Vector]:
    """The bodies of a tree (step 0 is the world) after handing inwards all that can be; nothing goes through the steps
    `loose`, whose place in the parent is an argument.

    Returns:
        The bodies, and the first moment [kg m] that ended up on the world: it only sets the zero of potential energy.
    """
    none = Moments(0.0, np.zeros(3), np.zeros((3, 3)))
    carried = {k: moments.get(k, none) for k in range(len(steps))}
    for k in range(len(steps) - 1, 0, -1):
        step = steps[k]
        if k in loose:
            continue
        kept, handed = _split(step, carried[k])
        carried[k] = kept
        rotation, offset = np.array(step.rotation, dtype=float), np.array(step.translation, dtype=float)
        first, second = rotation @ handed.first, rotation @ handed.second @ rotation.T
        mass = handed.mass
        moved = Moments(
            mass,
            first + mass * offset,
            second
            + mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
            + 2.0 * (first @ offset) * np.eye(3)
            - np.outer(first, offset)
            - np.outer(offset, first),
        )
        carried[step.parent] = carried[step.parent] + moved
    bodies = [body for k in range(1, len(steps)) if (body := body_inertia(k, carried[k])) is not None]
    return bodies, constant_vector(carried[0].first)


def _split(step: TreeStep, own: Moments) -> tuple[Moments, Moments]:
    """What stays with a step, and what its parent takes (in the step's frame at its zero)."""
    nothing, none = np.zeros(3), np.zeros((3, 3))
    if step.kind.slides:
        return Moments(own.mass, own.first, none), Moments(0.0, nothing, own.second)
    if step.kind is StepKind.BALL:
        return Moments(0.0, own.first, own.second), Moments(own.mass, nothing, none)
    axis = np.eye(3)[step.axis]
    along = own.first[step.axis] * axis
    across = [i for i in range(3) if i != step.axis]
    # moving the moment along the axis inwards leaves the second moments about the origin as they are
    largest = float(np.linalg.eigvalsh(own.second[np.ix_(across, across)])[-1])
    symmetric = largest * (np.eye(3) - np.outer(axis, axis))
    return Moments(0.0, own.first - along, own.second - symmetric), Moments(own.mass, along, symmetric)


def body_inertia(step: int, own: Moments) -> BodyInertia | None:
    """What a step carries, or None where that is nothing."""
    base, axes = principal(own.second)
    if own.mass == 0.0 and not np.any(own.first) and base == 0.0 and not axes:
        return None
    return BodyInertia(step, own.mass, constant_vector(own.first), base, axes)


def principal(tensor: Array) -> tuple[float, tuple[tuple[float, Vector], ...]]:
    """A symmetric (3, 3) as `base` times the identity plus few weighted outer products: equal moments cost nothing."""
    size = max(float(np.abs(tensor).max()), 1e-300)
    values, directions = np.linalg.eigh(tensor)
    same = 8e-16 * size
    counts = [int(np.sum(np.abs(values - value) <= same)) for value in values]
    base = float(values[int(np.argmax(counts))]) if max(counts) > 1 else 0.0
    base = 0.0 if abs(base) <= same else base
    exact = np.where(np.abs(directions - np.round(directions)) <= ROUNDING, np.round(directions), directions)
    return base, tuple(
        (float(value) - base, constant_vector(exact[:, k]))
        for k, value in enumerate(values)
        if abs(value - base) > same
    )
