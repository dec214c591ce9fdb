"""Random reachable states of a mechanism.

The workspace is boxed by walking from home along each axis until the robot cannot follow; targets are drawn evenly from
that box and kept where the robot can be closed and is well conditioned.  A target is a position of the tool where three
actuators place it in space, and else the coordinates of the actuators.  Near a singularity two right models differ by
conditioning alone, so such postures are left out; joint limits are no business of the equations, and ignored.  A robot
without a tool is sampled by its actuators.  Lengths count in characteristic lengths of the robot, so a robot a thousand
times as large is sampled at the same postures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from cutjoint.arrays import Array, Values, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import (
    ClosureError,
    CutjointError,
    DynamicsError,
    InputError,
    SingularError,
    UnreachableError,
)
from cutjoint.mechanism import Mechanism, Posture, Terms, Tool
from cutjoint.reprs import line

WORST_CONDITION = 100.0
"""Postures where the tool's frame Jacobian or the mass matrix, per natural unit of the actuators, is worse conditioned
are not sampled."""

WEIGHTLESS = 1e-9 * 9.81
"""A robot that falls more slowly than this, in its lengths [m/s2], does not fall: it is rounding."""

REFUSED = (UnreachableError, ClosureError, SingularError, DynamicsError)


@dataclass(frozen=True, eq=False)
class TargetBox(Values):
    """Box of targets around home: lower and upper corner, shape (3,) [m] of the tool, or (n,) of the actuators."""

    lower: Array
    upper: Array

    __repr__ = line(lower="m or rad", upper="m or rad")

    @property
    def diagonal(self) -> float:
        """Length of the box's diagonal."""
        return float(np.linalg.norm(self.upper - self.lower))


@dataclass(frozen=True, eq=False)
class SampledState(Values):
    """A posture of the reference model with velocity, acceleration and effort of the actuators, shape (n,) each.

    `position` (3,) is that of the tool, where there is one.
    """

    at: Posture
    position: Array
    v: Array
    a: Array
    effort: Array

    __repr__ = line(position="m", v="m/s or rad/s", a="m/s2 or rad/s2", effort="N or N m")


class Reacher:
    """Takes a mechanism to states that another model of the robot was sampled at: its tool each time from the nearest
    posture it has been to, its actuators from home, straight as they were sampled, since on another way there may be
    another assembly mode at the end of it."""

    __repr__ = line()

    def __init__(self, mechanism: Mechanism) -> None:
        self._of_point = leads_point(mechanism)
        self._origin, self._go = _targets(mechanism, self._of_point)
        self._known: list[tuple[Array, Posture]] = [(self._origin, mechanism.home)]

    def take_up(self, state: SampledState) -> Posture:
        """The posture of `state`, on the branch of home.

        Raises:
            UnreachableError, ClosureError, SingularError: as the mechanism's `reach` or `close`.
        """
        if not self._of_point:
            return self._go(state.at.q, None)
        target = state.position
        near = min(self._known, key=lambda one: float(np.sum(np.square(one[0] - target))))[1]
        at = self._go(target, near)
        self._known.append((target, at))
        return at


def length_of(mechanism: Mechanism) -> float:
    """Characteristic length [m], so that nothing here depends on how large a robot is.

    The mechanism's own `length` where it has one (closed chains and the published models do), else how far the tool
    moves for a radian of its rotary actuators at home, else a metre.
    """
    own = getattr(mechanism, "length", None)
    if own is not None:
        return float(own)
    turning = [one.kind == "rotation" for one in mechanism.actuators]
    lever = float(np.linalg.norm(mechanism.tool(mechanism.home).jacobian[:, turning]))
    return lever if lever > 0.0 else 1.0


def units_of(mechanism: Mechanism) -> Array:
    """Natural unit of each actuated coordinate, shape (n,): the characteristic length [m], or a radian."""
    length = length_of(mechanism)
    return np.array([length if one.kind == "translation" else 1.0 for one in mechanism.actuators])


@door
def workspace_box(mechanism: Mechanism, resolution: float = 1e-3, furthest: float = 10.0) -> TargetBox:
    """How far `mechanism` gets from home along each axis.

    Args:
        mechanism: the robot.
        resolution: how exactly, as a fraction of the distance.
        furthest: where the search ends, in characteristic lengths or radians.

    Raises:
        InputError: `resolution` or `furthest` is not > 0.
    """
    positive("resolution", resolution)
    positive("furthest", furthest)
    of_point = leads_point(mechanism)
    origin, go = _targets(mechanism, of_point)
    units = np.full(3, length_of(mechanism)) if of_point else units_of(mechanism)

    def goes(axis: int, distance: float) -> bool:
        target = np.array(origin)
        target[axis] += distance
        try:
            go(target, None)
        except REFUSED:
            return False
        return True

    corners = np.zeros((2, len(origin)))
    for axis, unit in enumerate(units):
        for row, sign in enumerate((-1.0, 1.0)):
            inside, outside = 0.0, resolution * unit
            while outside < furthest * unit and goes(axis, sign * outside):
                inside, outside = outside, 2.0 * outside
            while outside - inside > resolution * max(outside, resolution * unit):
                middle = 0.5 * (inside + outside)
                if goes(axis, sign * middle):
                    inside = middle
                else:
                    outside = middle
            corners[row, axis] = origin[axis] + sign * inside
    return TargetBox(readonly(corners[0]), readonly(corners[1]))


def leads_point(mechanism: Mechanism) -> bool:
    """Whether three actuators place the tool point in space, and nothing else is led."""
    if mechanism.n != 3:
        return False
    try:
        task = mechanism.task
    except InputError:  # it cannot be told: the actuators do tell where the robot is
        return False
    return task.is_of_point and len(task.names) == 3


def has_tool(mechanism: Mechanism) -> bool:
    """Whether the robot has a tool."""
    try:
        mechanism.tool(mechanism.home)
    except InputError:
        return False
    return True


def frame_jacobian(tool: Tool, units: Array, length: float) -> Array:
    """The six rows per natural unit of the actuators, those of the angular velocity at the arm of a length [m]."""
    return np.concatenate([tool.jacobian, length * tool.frame_jacobian[3:]]) * units


def _targets(mechanism: Mechanism, of_point: bool) -> tuple[Array, Callable[[Array, Posture | None], Posture]]:
    """Home as a target, and what takes the mechanism to a target."""
    if of_point:
        return mechanism.tool(mechanism.home).position, partial(mechanism.reach, limits="ignore")
    return mechanism.home.q, partial(mechanism.close, limits="ignore")


@door
def sample_states(mechanism: Mechanism, samples: int, seed: int) -> Iterator[SampledState]:
    """`samples` random states of `mechanism`; the same for the same seed.

    Speeds and accelerations are drawn so that the robot moves through about one workspace in the time in which it would
    fall through it, so that what gravity, speeds and accelerations do has one size; efforts are those of the
    acceleration plus a random part of the same size, so that forward dynamics is not asked what inverse dynamics just
    answered.

    Raises:
        InputError: samples < 1, or a seed < 0.
        CutjointError: hardly any posture around home can be closed and is well conditioned.
    """
    if samples < 1 or seed < 0:
        raise InputError(f"samples must be at least 1 and the seed at least 0, found {samples} and {seed}")
    random, led = np.random.default_rng(seed), has_tool(mechanism)
    box, of_point = workspace_box(mechanism), leads_point(mechanism)
    go, units, length = _targets(mechanism, of_point)[1], units_of(mechanism), length_of(mechanism)
    made = 0
    for _ in range(1000 * samples):
        if made == samples:
            return
        try:
            at = go(random.uniform(box.lower, box.upper), None)
            tool, terms = mechanism.tool(at) if led else None, mechanism.terms(at)
        except REFUSED:
            continue
        jacobian = np.eye(mechanism.n) if tool is None else frame_jacobian(tool, units, length)
        if max(_condition(jacobian), _condition(terms.mass * np.outer(units, units))) > WORST_CONDITION:
            continue
        reach = box.upper - box.lower
        if of_point:
            reach = box.diagonal / float(np.linalg.norm(jacobian, 2)) * units
        pace = _pace(terms, reach / units, units, WEIGHTLESS / length)
        v = pace * reach * random.normal(size=mechanism.n)
        a = 3.0 * pace * pace * reach * random.normal(size=mechanism.n)
        effort = terms.mass @ a + terms.gravity
        effort = effort + float(np.abs(effort * units).max()) / units * random.normal(size=mechanism.n)
        made += 1
        position = readonly(np.zeros(3)) if tool is None else tool.position
        yield SampledState(at, position, readonly(v), readonly(a), readonly(effort))
    if made < samples:
        raise CutjointError(
            f"of {1000 * samples} random targets of {mechanism.name} between {box.lower.tolist()} and "
            f"{box.upper.tolist()} only {made} can be reached and are well conditioned; {samples} were asked for"
        )


def _pace(terms: Terms, reach: Array, units: Array, least: float) -> float:
    """One over the time that the actuators take to fall through their reach [1/s]; 1/s where they fall with less than
    `least` [1/s2], all per natural unit."""
    falls = np.abs(np.linalg.solve(terms.mass, terms.gravity)) / units
    if not float(falls.max(initial=0.0)) > least:
        return 1.0
    fastest = float(np.divide(falls, reach, out=np.zeros_like(falls), where=reach > 0.0).max())
    return float(np.sqrt(0.5 * fastest)) if fastest > 0.0 else 1.0


def _condition(matrix: Array) -> float:
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 0.0 else float("inf")
