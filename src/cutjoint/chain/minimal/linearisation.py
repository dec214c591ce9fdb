"""Small motions around an equilibrium: x' = A x + B u, with x the change of the coordinates and their velocities.

    A = [[0, 1], [da/dq, da/dv]],   B = [0; M^-1 B_effort]

Accelerations are differentiated along the coordinates by central differences of sixth order, the loops closed at every
point.  With steps of a hundredth of a radian or link length their error is that of rounding, some 1e-12 of the terms.
Along velocities the acceleration is a polynomial as long as dry friction is in its smooth part (of degree five), and
the differences are exact but for rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, Frozen
from cutjoint.chain.actuation import ActuatorEfforts
from cutjoint.chain.kinematics import Kinematics
from cutjoint.errors import InputError
from cutjoint.mechanism import Loads, Posture, Terms
from cutjoint.reprs import line

STEP = 0.01
"""Step of the differences, in radians or link lengths; velocities in these times the pace of the robot."""

_STENCIL = ((1.0, 45.0 / 60.0), (2.0, -9.0 / 60.0), (3.0, 1.0 / 60.0))
"""Multiples of the step on either side, and their weights, of the central difference of sixth order."""


@dataclass(frozen=True, eq=False)
class Linearisation(Frozen):
    """x' = state @ x + input @ u near an equilibrium; x is the change of the n coordinates, then of their velocities.

    Attributes:
        state: A, shape (2 n, 2 n).
        input: B, shape (2 n, actuators): what a change of the efforts does.
        effort: of the actuators at the equilibrium, shape (actuators,), [N] or [N m].
        names: of the n coordinates.
    """

    state: Array
    input: Array
    effort: Array
    names: tuple[str, ...]

    __repr__ = line()

    @property
    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """Of A [1/s], by their real part, the largest first."""
        values = np.linalg.eigvals(self.state)
        return np.asarray(values[np.lexsort((values.imag, -values.real))])


class InMinimal(Protocol):
    """What is asked of minimal coordinates."""

    n: int
    names: tuple[str, ...]
    v_index: Array

    def tangent(self, at: Posture) -> Array: ...
    def moved(self, at: Posture, change: Array) -> Posture: ...
    def effort_map(self, at: Posture) -> Array: ...
    def terms(self, at: Posture) -> Terms: ...
    def load_effort(self, at: Posture, loads: Loads) -> Array: ...
    def efforts(self, at: Posture, v: Array, a: Array, loads: Loads) -> ActuatorEfforts: ...
    def forward_dynamics(self, at: Posture, v: Array, effort: Array, loads: Loads) -> Array: ...


def linearised(
    robot: InMinimal, kinematics: Kinematics, at: Posture, effort: Array | None, loads: Loads
) -> Linearisation:
    """See `MinimalCoordinates.linearised`."""
    n, k, still = robot.n, kinematics, np.zeros(robot.n)
    given = robot.efforts(at, still, still, loads).effort if effort is None else effort
    _need_rest(robot, k, at, given, loads)
    tangent, terms = robot.tangent(at), robot.terms(at)
    largest = np.abs(tangent / k.column_scale[:, None]).max(axis=0)

    def turned(change: Array) -> Array:
        return robot.forward_dynamics(robot.moved(at, change), still, given, loads)

    def hurried(v: Array) -> Array:
        return robot.forward_dynamics(at, v, given, loads)

    by_q = _slopes(turned, STEP / largest)
    by_v = _slopes(hurried, _velocity_step(k, tangent))
    state = np.block([[np.zeros((n, n)), np.eye(n)], [by_q, by_v]])
    pushed = np.linalg.solve(terms.mass, robot.effort_map(at)) if n else robot.effort_map(at)
    return Linearisation(state, np.concatenate([np.zeros_like(pushed), pushed]), given, robot.names)


def _slopes(value: Callable[[Array], Array], steps: Array) -> Array:
    """Derivatives of a function at zero by each argument, shape (values, arguments)."""
    columns = []
    for one, step in zip(np.eye(len(steps)), steps, strict=True):
        sides = ((weight, value(many * step * one) - value(-many * step * one)) for many, weight in _STENCIL)
        columns.append(sum(weight * difference for weight, difference in sides) / step)
    return np.stack(columns, axis=1) if columns else np.zeros((0, 0))


def _velocity_step(kinematics: Kinematics, tangent: Array) -> Array:
    """Steps of the velocities (n,) at which dry friction stays smooth.

    Raises:
        InputError: some friction sticks.
    """
    k = kinematics
    parts = {joint.name: joint.physics for joint in k.description.joints}
    parts |= {cut.name: cut.physics for cut in k.description.cuts}
    for name, physics in parts.items():
        if physics.sticks:
            raise InputError(
                f"the friction of '{name}' sticks, so nothing is linear around rest; give it a friction speed > 0"
            )
    pull = float(np.linalg.norm(k.model.gravity.linear)) or k.length
    rates = np.abs(tangent / k.column_scale[:, None])
    steps = STEP * np.sqrt(pull / k.length) / rates.max(axis=0)
    slowest = min((one.speed for one in parts.values() if one.friction > 0.0), default=np.inf)
    # the fastest that a joint or a cut may be, in [m/s] and in [rad/s], where all add up; three steps stay below
    fastest = rates.sum(axis=0) * max(1.0, k.reach)
    return np.asarray(np.minimum(steps, slowest / (3.0 * fastest)))


def _need_rest(robot: InMinimal, kinematics: Kinematics, at: Posture, effort: Array, loads: Loads) -> None:
    """Raises InputError where the robot would not stay."""
    k, n = kinematics, robot.n
    map_, terms = robot.effort_map(at), robot.terms(at)
    given = (robot.load_effort(at, loads), -terms.gravity, -terms.springs)
    unit = k.column_scale[robot.v_index]
    left = unit * np.abs(map_ @ effort + sum(given))
    size = unit * (np.abs(map_) @ np.abs(effort) + sum(np.abs(one) for one in given))
    rounding = tolerances.ROUNDED.value * k.load(terms.mass, np.zeros(k.model.nv), np.zeros(k.model.nv))
    if n and left.max() > tolerances.REACHED.value * size.max() + rounding:
        worst = int(left.argmax())
        raise InputError(
            f"{k.name} does not stand still here: forces of {left[worst] / unit[worst]:.3g} N or N m are left along "
            f"'{robot.names[worst]}'; linearise at an equilibrium, with the efforts and loads that hold it"
        )
