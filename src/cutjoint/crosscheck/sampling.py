"""Random reachable states of a mechanism.

The workspace is boxed by walking from home along the axes of the tool until the robot cannot follow; tool positions are
drawn evenly from that box and kept where the robot can be closed and is well conditioned.  Near a singularity two right
models differ by conditioning alone, so such postures are left out (and counted).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.errors import ClosureError, CutjointError, DynamicsError, SingularError, UnreachableError
from cutjoint.mechanism import Mechanism, Posture

WORST_CONDITION = 100.0
"""Postures where the tool Jacobian or the mass matrix is worse conditioned are not sampled."""

REFUSED = (UnreachableError, ClosureError, SingularError, DynamicsError)


@dataclass(frozen=True, eq=False)
class Workspace:
    """Box of tool positions around home: lower and upper corner, shape (3,) [m]."""

    lower: Array
    upper: Array

    @property
    def diagonal(self) -> float:
        """Length of the box's diagonal [m]."""
        return float(np.linalg.norm(self.upper - self.lower))


@dataclass(frozen=True, eq=False)
class State:
    """A posture of the reference model with velocity, acceleration and effort of the actuators, shape (n,) each."""

    at: Posture
    position: Array
    v: Array
    a: Array
    effort: Array


class Reacher:
    """Takes a mechanism to tool positions all over its workspace, each time from the nearest one it has been to."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        home = mechanism.home
        self._known: list[tuple[Array, Posture]] = [(mechanism.tool(home).position, home)]

    def reach(self, position: Array) -> Posture:
        """The posture with the tool at `position` (3,), on the branch of home.

        Raises:
            UnreachableError, SingularError: as the mechanism's `reach`.
        """
        near = min(self._known, key=lambda one: float(np.sum(np.square(one[0] - position))))[1]
        at = self._mechanism.reach(position, near)
        self._known.append((position, at))
        return at


def workspace_box(mechanism: Mechanism, resolution: float = 1e-3, furthest: float = 10.0) -> Workspace:
    """How far the tool of `mechanism` gets from home along each axis, to `resolution` [m]."""
    home = mechanism.tool(mechanism.home).position
    corners = np.zeros((2, 3))
    for axis in range(3):
        for row, sign in enumerate((-1.0, 1.0)):
            inside, outside = 0.0, resolution
            while outside < furthest and _reaches(mechanism, home, axis, sign * outside):
                inside, outside = outside, 2.0 * outside
            while outside - inside > resolution:
                middle = 0.5 * (inside + outside)
                if _reaches(mechanism, home, axis, sign * middle):
                    inside = middle
                else:
                    outside = middle
            corners[row, axis] = home[axis] + sign * inside
    return Workspace(readonly(corners[0]), readonly(corners[1]))


def sample_states(mechanism: Mechanism, samples: int, seed: int) -> Iterator[State]:
    """`samples` random states of `mechanism`; the same for the same seed.

    Speeds and accelerations are drawn so that the tool moves at up to about one workspace a second; efforts are those
    of the acceleration plus a random part of the same size, so that forward dynamics is not asked what inverse dynamics
    just answered.

    Raises:
        CutjointError: hardly any posture around home can be closed and is well conditioned.
    """
    random = np.random.default_rng(seed)
    box = workspace_box(mechanism)
    made = 0
    for _ in range(1000 * samples):
        if made == samples:
            return
        try:
            at = mechanism.reach(random.uniform(box.lower, box.upper))
            tool, terms = mechanism.tool(at), mechanism.terms(at)
        except REFUSED:
            continue
        if max(_condition(tool.jacobian), _condition(terms.mass)) > WORST_CONDITION:
            continue
        speed = box.diagonal / max(float(np.linalg.norm(tool.jacobian, 2)), 1e-12)
        v = speed * random.normal(size=mechanism.n)
        a = 10.0 * speed * random.normal(size=mechanism.n)
        effort = terms.mass @ a + terms.gravity
        effort = effort + float(np.abs(effort).max()) * random.normal(size=mechanism.n)
        made += 1
        yield State(at, tool.position, readonly(v), readonly(a), readonly(effort))
    if made < samples:
        raise CutjointError(
            f"of {1000 * samples} random tool positions of {mechanism.name} between {box.lower.tolist()} and "
            f"{box.upper.tolist()} m only {made} can be reached and are well conditioned; {samples} were asked for"
        )


def _reaches(mechanism: Mechanism, home: Array, axis: int, distance: float) -> bool:
    target = np.array(home)
    target[axis] += distance
    try:
        mechanism.reach(target)
    except REFUSED:
        return False
    return True


def _condition(matrix: Array) -> float:
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 0.0 else float("inf")
