"""Exact derivatives of what is wanted, by the design variables.

The tool goes along its trajectory whatever the lengths are, so the actuators must follow the numbers p of the robot.
With C the condition of the task (see `cutjoint.motion.following`), J the frame Jacobian and T how the tool moves with p
while the actuators are held (`tool_by_parameters`),

    dq/dp = D = -(C J)^+ C (T - T_home),     dv/dp = dD/dt,     da/dp = d2D/dt2,

where T_home is how what is not prescribed, and stays as at home, goes along with home.  Time and p may be exchanged, so
the rates of D are those along the motion q(s) = q + v s + a s^2 / 2, which has the same first two derivatives as the
true one: seven postures on it, and the polynomial through them.  Then

    d effort/dp = (inverse dynamics by p) + by_q dq/dp + by_v dv/dp + by_a da/dp,

all of it of one robot that is compiled once, with what the variables change as its arguments.  Before they are used
they are held against differences of the efforts of robots that are built anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile import CompiledChain, compiled
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.task import NAMES
from cutjoint.motion import Reference, ToolMotion, Trajectory
from cutjoint.motion.following import size_of
from cutjoint.motion.reference import Desired
from cutjoint.motion.values import POSITION, ROTATION
from cutjoint.reprs import line, told
from cutjoint.synthesis.following import FollowedNumbers
from cutjoint.synthesis.judging import Design, DesignProblem, closed
from cutjoint.synthesis.quantities import Subject, followed
from cutjoint.synthesis.wants import Want

EXACT = ("effort", "rms-effort", "power", "mass")
"""Quantities with exact derivatives."""
STRIDE = 0.02
"""How far the motion is followed to either side for the rates of D [rad], or in sizes of the robot."""
AGREE = 1e-5
"""How far a quantity of the compiled robot may be from that of the robot that is built anew, as a part of it: more is
another branch."""
DIFFER = 1e-3
"""How far derivatives may be from differences, in parts of the largest: these have three to six digits."""
CHECK = 1e-4
"""Step of the differences that derivatives are held against, in parts of a variable's range."""


class EffortRates(NamedTuple):
    """Efforts and powers along a trajectory, with derivatives by the variables.

    Attributes:
        efforts: shape (instants, n).
        speeds: of the actuators, shape (instants, n).
        by_effort: shape (instants, n, variables).
        by_speed: shape (instants, n, variables).
    """

    efforts: Array
    speeds: Array
    by_effort: Array
    by_speed: Array

    def __repr__(self) -> str:
        return told(self, efforts="N or N m", speeds="m/s or rad/s")


class ExactSlopes:
    """Derivatives of all wants of a problem, by a robot that is compiled once.

    Raises:
        CutjointError: it cannot be compiled for these variables, or a want has no exact derivative.
    """

    __repr__ = line()

    def __init__(self, problem: DesignProblem) -> None:
        beside = [one.quantity for one in problem.wants if one.quantity not in EXACT]
        if beside:
            raise InputError(f"{', '.join(beside)} has none that is exact")
        self._problem = problem
        self._numbers = FollowedNumbers(problem.robot, problem.variables)
        chain = closed(problem, problem.now)
        self._robot: CompiledChain | None = None
        if any(one.quantity != "mass" for one in problem.wants):
            names = [one.name for one in self._numbers.groups]
            ranges = {one.name: (one.low, one.high) for one in self._numbers.groups}
            robot = compiled(chain, parameters=names, ranges=ranges, quick=True)
            assert isinstance(robot, CompiledChain)
            for function in ("tool_by_parameters", "inverse_by_parameters", "inverse_derivatives"):
                robot.kernel(function)
            self._robot = robot
        self._is_checked = False

    def of(self, design: Design) -> dict[str, Array]:
        """Want by name -> derivatives by the variables at a design, shape (variables,).

        Raises:
            CutjointError: there are none here.
        """
        specs = {str(one.options["trajectory"]) for one in self._problem.wants if "trajectory" in one.options}
        numbers, (slopes, by_mass) = self._numbers.at(design.values), self._numbers.slopes(design.values)
        rates: dict[str, EffortRates] = {}
        if self._robot is not None:
            names = [one.name for one in self._numbers.groups]
            robot = self._robot.with_parameters(dict(zip(names, numbers.tolist(), strict=True)))
            rates = {spec: rates_along(robot, self._problem, spec, slopes) for spec in sorted(specs)}
            if not self._is_checked:
                self._check(design.values, rates)
                self._is_checked = True
        found = {one.name: _slope(one, rates, by_mass) for one in self._problem.wants}
        for want in self._problem.wants:
            if want.quantity != "mass":
                own, other = found[want.name][0], design.found[want.name]
                if abs(own - other) > AGREE * abs(other):
                    raise InputError(f"the compiled robot has another {want.name}: {own:.6g}, not {other:.6g}")
        return {name: slope for name, (_, slope) in found.items()}

    def _check(self, values: Array, rates: Mapping[str, EffortRates]) -> None:
        """Hold derivatives of efforts, in a direction through all variables, against differences.

        Raises:
            InputError: they are not the same.
        """
        spans = np.array([one.high - one.low for one in self._problem.variables])
        inwards = np.where(values < 0.5 * np.array([one.low + one.high for one in self._problem.variables]), 1.0, -1.0)
        way = CHECK * spans * inwards
        points = [values + k * way for k in (1.0, 2.0)]  # inwards only: an end of a range may be an end of the robot
        subjects = [Subject(closed(self._problem, one), self._problem.trajectories) for one in points]
        for spec, rate in rates.items():
            near, far = (one.efforts(spec) for one in subjects)
            slope = 2.0 * near - 0.5 * far - 1.5 * rate.efforts
            size = CHECK * float(np.abs(rate.efforts).max()) + float(np.abs(slope).max())
            if np.abs(slope - rate.by_effort @ way).max() > DIFFER * size:
                raise InputError("differences of robots that are built anew are others than the derivatives")


def _slope(want: Want, rates: Mapping[str, EffortRates], by_mass: Array) -> tuple[float, Array]:
    """A quantity's value and its derivatives, shape (variables,)."""
    if want.quantity == "mass":
        return 0.0, by_mass
    rate = rates[str(want.options["trajectory"])]
    if want.quantity == "rms-effort":
        sizes = np.sqrt(np.mean(rate.efforts**2, axis=0))
        worst = int(sizes.argmax())
        if sizes[worst] == 0.0:
            raise InputError("no effort at all has no derivative")
        slope = np.mean(rate.efforts[:, worst, None] * rate.by_effort[:, worst], axis=0) / sizes[worst]
        return float(sizes[worst]), np.asarray(slope)
    asked, by = rate.efforts, rate.by_effort
    if want.quantity == "power":
        by = by * rate.speeds[:, :, None] + asked[:, :, None] * rate.by_speed
        asked = asked * rate.speeds
    where = np.unravel_index(np.abs(asked).argmax(), asked.shape)
    return float(abs(asked[where])), np.asarray(np.sign(asked[where]) * by[where])


def rates_along(robot: CompiledChain, problem: DesignProblem, spec: str, slopes: Array) -> EffortRates:
    """Efforts along a trajectory, and their derivatives by the variables.

    Args:
        robot: with the numbers of the design.
        problem: has the trajectory.
        spec: which one.
        slopes: how the parameters follow the variables, shape (parameters, variables).

    Raises:
        CutjointError: it cannot be followed, or is too near to a singularity.
    """
    trajectory = problem.trajectories[spec]
    moving = _Moving(robot, trajectory, slopes)
    efforts, speeds, by_effort, by_speed = [], [], [], []
    for one in followed(Reference(trajectory, robot)):
        by_q, by_v, by_a = moving.of(one)
        own = robot.inverse_derivatives(one.posture, one.v, one.a)
        direct = robot.inverse_by_parameters(one.posture, one.v, one.a) @ slopes
        by_effort.append(direct + own.by_q @ by_q + own.by_v @ by_v + own.by_input @ by_a)
        efforts.append(own.value)
        speeds.append(one.v)
        by_speed.append(by_v)
    return EffortRates(np.array(efforts), np.array(speeds), np.array(by_effort), np.array(by_speed))


class _Moving:
    """How the actuators follow the variables along a motion of the tool."""

    def __init__(self, robot: CompiledChain, trajectory: Trajectory, slopes: Array) -> None:
        self._robot, self._slopes, self._task = robot, slopes, robot.geometry.task
        start = trajectory.at(0.0)
        is_of_tool = self._is_of_tool = isinstance(start, ToolMotion)
        self._given = start.prescribed if isinstance(start, ToolMotion) else ()
        rows = len(self._task.rows)
        if is_of_tool and robot.n > rows:
            raise InputError(f"more actuators, {robot.n}, than rows of the task, {rows}")
        size = size_of(robot)
        self._weights = np.array([size if row < 3 else 1.0 for row in self._task.rows])
        self._units = np.array([1.0 if one.kind == "rotation" else size for one in robot.actuators])
        self._home = robot.tool_by_parameters(robot.home) @ slopes if is_of_tool else np.zeros((6, slopes.shape[1]))

    def of(self, desired: Desired) -> tuple[Array, Array, Array]:
        """Derivatives of q, v and a, shape (n, variables) each."""
        shape = self._robot.n, self._slopes.shape[1]
        if not self._is_of_tool:
            return np.zeros(shape), np.zeros(shape), np.zeros(shape)
        kept = self._kept()
        speed, rate = (float(np.abs(x / self._units).max()) for x in (desired.v, desired.a))
        if speed == 0.0 and rate == 0.0:
            return self._followed(desired.posture, kept), np.zeros(shape), np.zeros(shape)
        step = STRIDE / 3.0 / max(speed, np.sqrt(STRIDE * rate))
        table = []
        for k in range(-3, 4):
            s = k * step
            at = desired.q + desired.v * s + 0.5 * desired.a * s * s
            posture = self._robot.close(at, desired.posture, limits="ignore") if k else desired.posture
            table.append(self._followed(posture, kept))
        found = np.array(table)
        first = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / (60.0 * step)
        second = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / (180.0 * step * step)
        return found[3], np.tensordot(first, found, 1), np.tensordot(second, found, 1)

    def _kept(self) -> Array:
        """How the wanted pose goes along with home, shape (6, variables): in what is not prescribed."""
        given = self._given
        along = np.zeros_like(self._home)
        if set(given).isdisjoint(ROTATION):
            along[3:] = self._home[3:]
        if not set(given).issuperset(POSITION):
            basis = self._task.basis
            left = basis @ np.diag([float(name not in given) for name in NAMES[:3]]) @ basis.T
            along[:3] = left @ self._home[:3]
        return along

    def _followed(self, posture: Posture, kept: Array) -> Array:
        """D at a posture, shape (n, variables)."""
        robot, task = self._robot, self._task
        tool = robot.tool(posture)
        condition = task.towards(tool.pose, task.rows).matrix(tool.rotation) / self._weights[:, None]
        led = condition @ tool.frame_jacobian * self._units
        moved = condition @ (robot.tool_by_parameters(posture) @ self._slopes - kept)
        return np.asarray(-self._units[:, None] * np.linalg.lstsq(led, moved, rcond=None)[0])


def slopes_of(problem: DesignProblem) -> tuple[ExactSlopes | None, str]:
    """Exact derivatives of a problem where it has them, and a sentence about it."""
    try:
        return ExactSlopes(problem), "derivatives: exact ones of the compiled robot"
    except CutjointError as error:
        return None, f"derivatives: central differences of designs, since {short(error)}"


def short(error: CutjointError) -> str:
    """The first sentence of an error."""
    return str(error).partition(". ")[0].partition("\n")[0].rstrip(".")
