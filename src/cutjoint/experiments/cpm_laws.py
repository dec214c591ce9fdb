"""Runs that judge what Elkady et al. 2008 say of their four control laws (sections 4.2 to 4.6 and 5.4.4).

Controller and plant are equation (39) and the gains those of table 3, unless a run is about something else.  Where the
paper compares laws on a robot that follows its path, the robot starts on the path and at its speed, so that nothing is
left of the step at the start of table 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import sqrt

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.control import law
from cutjoint.errors import SimulationError
from cutjoint.experiments import cpm
from cutjoint.motion import Hold, JointMotion, Reference, ToolMotion, Trajectory
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.cpm.published import CIRCLE, SETTLING_TIME
from cutjoint.simulation import Adaptive, Integrator, ReducedPlant, Result, RungeKutta4, State, run

COLUMN = "equation"

LOW_RATE = 100.0
"""A rate that no digital controller finds high [Hz]."""

REASONABLE = 1.01
"""Accuracy counts as reasonable up to this multiple of what PD leaves under continuous control."""

SLOWEST, FASTEST = 48, 64
"""Between these rates the lowest that does is sought [Hz]; at the first all laws diverge or are far off."""

LOAD = 1.0
"""What the robot picks up [kg]; its tool m4 has 0.3 kg, and 3.78 kg move along each axis."""

PICKED_UP = 2.0
"""When: half way around the circle [s]."""

OFF = 0.1
"""By how much the controller's masses are wrong: all of table 2, relative."""

AWAY = 0.15
"""Starts off a constant reference: the corners of a cube with this half edge [m]."""

RATIOS = (0.8, 0.9, 1.0, 1.1, 1.25, 1.5)
"""Damping ratios at the natural frequency of table 3."""

SETTLED = 0.01
"""An error has settled when it stays below this part of the first one."""


@dataclass(frozen=True)
class Later:
    """A trajectory from `since` [s] on."""

    whole: Trajectory
    since: float

    @property
    def name(self) -> str:
        """For messages and tables."""
        return f"{self.whole.name} from {self.since:g} s on"

    @property
    def duration(self) -> float:
        """What is left [s]."""
        return self.whole.duration - self.since

    def at(self, t: float) -> ToolMotion | JointMotion:
        """The desired motion at time `t` [s] after `since`."""
        return self.whole.at(self.since + t)


# Section 4.3: the update rate.


def late_error(name: str, rate: float | None) -> float:
    """Largest error along any axis after the settling time [m]; infinite where the run diverges.

    From rest on the path as in table 3, the force held between the updates at `rate` [Hz]; None is continuous control.
    """
    # Under a held force the plant alone is integrated, which is smooth; the error swings between the updates.
    step = 2.0 * cpm.STEP if rate is None else 0.5 / rate
    made, way = cpm.controller(name, COLUMN), cpm.reference(COLUMN)
    try:
        result = run(cpm.plant(COLUMN), made, way, integrator=RungeKutta4(step), rate=rate)
    except SimulationError:
        return float("inf")
    return result.worst_axis_error(SETTLING_TIME)


@dataclass(frozen=True)
class UpdateRate:
    """What the update rate does.

    Attributes:
        continuous: late error of PD under continuous control [m].
        slow: the same at `LOW_RATE` [m].
        lowest: for every law, the lowest whole rate at which its late error is at most `REASONABLE` times that of PD
            under continuous control [Hz].
    """

    continuous: float
    slow: float
    lowest: Mapping[str, int]


def update_rate() -> UpdateRate:
    """How high a rate PD needs, and the others for the same accuracy."""
    continuous = late_error("pd", None)
    lowest = {}
    for name in cpm.ROWS:
        low, high = SLOWEST, FASTEST
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if late_error(name, middle) <= REASONABLE * continuous else (middle, high)
        lowest[name] = high
    return UpdateRate(continuous, late_error("pd", LOW_RATE), lowest)


def work(result: Result) -> float:
    """Mean over time of the motors' power, the sum of |F v| [W]: braking counts as work too."""
    power = np.abs(result.effort * result.v).sum(axis=1)
    return float(np.trapezoid(power, result.time) / (result.time[-1] - result.time[0]))


# Sections 4.4 and 4.5: on the path from the start.


def tracking_error(name: str, feedback: bool = True, duration: float = CIRCLE.duration) -> float:
    """Largest error of the tool along the circle [m], position and velocity error zero at first.

    Without feedback both gains are zero.
    """
    gains = {"kp": cpm.ROWS[name].k_p, "kd": cpm.ROWS[name].k_d} if feedback else {"kp": 0.0, "kd": 0.0}
    way = cpm.reference(COLUMN)
    made = law(name, cpm.model(COLUMN), gains)
    method, v = RungeKutta4(2.0 * cpm.STEP), way.at(0.0).v
    return run(cpm.plant(COLUMN), made, way, integrator=method, start_velocity=v, duration=duration).worst_error()


@dataclass(frozen=True)
class Held:
    """What a law does with a constant reference, from rest at eight corners around it.

    Attributes:
        left: largest distance from the reference that is left [m].
        rise: largest rise of the energy of robot and feedback between two samples, relative to that at first.
        duration: of the runs [s].
    """

    left: float
    rise: float
    duration: float


def held(name: str, duration: float = 1.0) -> Held:
    """A constant reference at the centre of the circle, from the corners of a cube around it.

    The energy is that of the robot, plus that of the springs K_P e, plus that of the constant force K(q_d): what the
    law of PD + gravity makes a Lyapunov function.
    """
    model = cpm.model(COLUMN)
    there = np.array(CIRCLE.centre)
    way = Reference(Hold(there, duration), model)
    made = cpm.controller(name, COLUMN)
    constant = made.effort(way.at(0.0), there, np.zeros(3), np.zeros(0))
    left = rise = 0.0
    for corner in product((-AWAY, AWAY), repeat=3):
        start = model.close(there + np.array(corner))
        result = run(cpm.plant(COLUMN), made, way, integrator=RungeKutta4(5e-3), start=start)
        springs = 0.5 * cpm.ROWS[name].k_p * np.einsum("ij,ij->i", result.error, result.error)
        energy = result.energy + springs - result.q @ constant
        energy -= model.potential_energy(way.at(0.0).posture) - there @ constant
        left = max(left, float(np.linalg.norm(result.error[-1])))
        rise = max(rise, float(np.diff(energy).max() / energy[0]))
    return Held(left, rise, duration)


@dataclass(frozen=True)
class Response:
    """What a load that the controller does not know does to a law.

    Attributes:
        deviation: largest change of the tool's error [m].
        rise_time: until nine tenths of it are reached [s].
    """

    deviation: float
    rise_time: float


def load_response(name: str, duration: float = 0.4) -> Response:
    """The robot follows the circle, and `LOAD` joins its tool at `PICKED_UP`, at the tool's own velocity."""
    model, way, made = cpm.model(COLUMN), cpm.reference(COLUMN), cpm.controller(name, COLUMN)
    assert isinstance(model, CpmModel)
    before = run(
        cpm.plant(COLUMN), made, way, integrator=RungeKutta4(4e-3), start_velocity=way.at(0.0).v, duration=PICKED_UP
    )
    rest = Reference(Later(way.trajectory, PICKED_UP), model)
    error = []
    for robot in (model.with_payload(LOAD), model):
        start = State(before.q[-1], before.v[-1], robot.close(before.q[-1]))
        after = run(ReducedPlant(robot), made, rest, integrator=RungeKutta4(2e-3), start=start, duration=duration)
        error.append(after.error)
    change = np.linalg.norm(error[0] - error[1], axis=1)
    return Response(float(change.max()), float(after.time[np.argmax(change >= 0.9 * change.max())]))


# Section 4.6: the linear error equation.


def linear_error(t: Array, e: float, rate: float, k_p: float, k_d: float) -> Array:
    """The solution of equation (44), e_ddot + k_d e_dot + k_p e = 0, from e(0) = e [m] and e_dot(0) = rate [m/s]."""
    half = 0.5 * k_d
    root = np.emath.sqrt(half * half - k_p)
    if root == 0.0:
        return np.asarray((e + (rate + half * e) * t) * np.exp(-half * t))
    one, two = root - half, -root - half
    first = (rate - two * e) / (one - two)
    return np.asarray(np.real(first * np.exp(one * t) + (e - first) * np.exp(two * t)))


MIXED = (np.array([400.0, 2550.25, 6400.0]), np.array([60.0, 101.0, 80.0]))
"""K_P [1/s2] and K_D [1/s] of x, y and z: over, critically and under damped (1.5, 1 and 0.5)."""

DISPLACED = np.array([0.04, -0.03, 0.02])
"""First error of the runs that start off the path [m]."""


def displaced_run(k_p: npt.ArrayLike, k_d: npt.ArrayLike, duration: float, integrator: Integrator) -> Result:
    """Computed torque with other gains, from `DISPLACED` off the path, at the path's speed; every millisecond."""
    model, way = cpm.model(COLUMN), cpm.reference(COLUMN)
    desired = way.at(0.0)
    return run(
        cpm.plant(COLUMN),
        law("computed-torque", model, {"kp": k_p, "kd": k_d}),
        way,
        integrator=integrator,
        start=model.close(desired.q - DISPLACED),
        start_velocity=desired.v,
        duration=duration,
        every=1e-3,
    )


def linearised() -> float:
    """Largest deviation from equation (44) with other gains along every axis, relative to the first error."""
    result = displaced_run(*MIXED, duration=0.5, integrator=Adaptive(1e-10, 1e-13))
    wanted = [linear_error(result.time, e, 0.0, *gains) for e, *gains in zip(DISPLACED, *MIXED, strict=True)]
    return float(np.abs(result.error - np.array(wanted).T).max() / np.abs(DISPLACED).max())


@dataclass(frozen=True)
class Damping:
    """How the error of a damping ratio dies.

    Attributes:
        overshoot: how far it swings past zero, relative to the first error; 0 where it does not.
        settling_time: from when on it stays below `SETTLED` of the first error [s].
    """

    overshoot: float
    settling_time: float


def damping() -> dict[float, Damping]:
    """The damping ratios at the natural frequency of table 3, along the axis of the largest first error."""
    k_p, found = cpm.ROWS["computed-torque"].k_p, {}
    for ratio in RATIOS:
        result = displaced_run(k_p, 2.0 * ratio * sqrt(k_p), duration=0.3, integrator=RungeKutta4(cpm.STEP))
        share = result.error[:, 0] / DISPLACED[0]
        late = np.flatnonzero(np.abs(share) > SETTLED)[-1] + 1
        # What is left of the integrator's error is not a swing.
        swing = float(max(0.0, -share.min()))
        found[ratio] = Damping(swing if swing > 1e-6 else 0.0, float(result.time[late]))
    return found


@dataclass(frozen=True)
class Decay:
    """The error of computed torque in table 3's run against equation (50).

    Attributes:
        deviation: largest distance from (50) [m].
        largest: largest error itself [m].
        rate: how fast ln(e / t) falls [1/s].
    """

    deviation: float
    largest: float
    rate: float


def decay(result: Result) -> Decay:
    """Compare a run from rest on the path with e = e_dot(0) t exp(-K_D t / 2)."""
    t = result.time
    wanted = result.velocity_error[0] * (t * np.exp(-0.5 * cpm.ROWS["computed-torque"].k_d * t))[:, None]
    error = np.linalg.norm(result.error, axis=1)
    # From the second sample on, until the error is a thousandth of its largest and the integrator's own is near.
    seen = (t > 0.0) & (t < SETTLING_TIME) & (error > 1e-3 * error.max())
    slope = np.polyfit(t[seen], np.log(error[seen] / t[seen]), 1)[0]
    return Decay(float(np.abs(result.error - wanted).max()), float(error.max()), float(-slope))


def critical_error(k_d: float) -> float:
    """Root of the mean over time of |error|^2 in the first half second [m], critically damped with `k_d` [1/s]."""
    model, way = cpm.model(COLUMN), cpm.reference(COLUMN)
    made = law("computed-torque", model, {"kp": 0.25 * k_d * k_d, "kd": k_d})
    result = run(cpm.plant(COLUMN), made, way, integrator=RungeKutta4(cpm.STEP), duration=0.5)
    return result.rmse_over_time().position


def wrong_model() -> tuple[float, float]:
    """Error of computed torque along the worst axis after the settling time [m], started on the path and at its speed.

    First with the exact model, then with all masses of the controller's model `OFF` too large.
    """
    exact, way = cpm.model(COLUMN), cpm.reference(COLUMN)
    assert isinstance(exact, CpmModel)
    masses = {name: (1.0 + OFF) * getattr(exact.parameters, name) for name in ("m1", "m2", "m3", "m4")}
    heavy = CpmModel(type(exact.parameters)(**masses), exact.signs)
    row, late = cpm.ROWS["computed-torque"], []
    for model in (exact, heavy):
        made = law("computed-torque", model, {"kp": row.k_p, "kd": row.k_d})
        result = run(cpm.plant(COLUMN), made, way, integrator=RungeKutta4(4e-3), start_velocity=way.at(0.0).v)
        late.append(result.worst_axis_error(SETTLING_TIME))
    return late[0], late[1]
