"""Step responses of the loop as it is built: every actuator in turn is to move by a little.

The step is small against what saturates, and what the loop does without a step (a PD law sags under the weight) is
taken off: the response is the difference of two runs over the step, which for a linear loop is the response itself.
Noise and jitter of the hardware are left out, since they differ from run to run; all else of it is there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.compile import ClosedLoop
from cutjoint.errors import InputError
from cutjoint.motion import Reference
from cutjoint.reprs import line
from cutjoint.simulation.hardware import Hardware, Tachometer
from cutjoint.tuning.case import MOST_STEPS, PAYLOAD, STIFF, Gains, TuningCase
from cutjoint.tuning.linear import JointRest, steps_of

SIZE = 1e-3
"""Of a step, in [rad] or in lengths of the robot."""
LOW, HIGH, BAND = 0.1, 0.9, 0.02
ENOUGH, FEWEST, MOST = 6.0, 200, 6000
"""Time constants of the slowest pole that a response is looked at, and samples of it."""
LONGEST = 30.0
"""s."""


@dataclass(frozen=True, eq=False)
class StepResponse(Frozen):
    """What an actuator does when it is to move by a step.

    Attributes:
        actuator: its name.
        size: of the step, [m] or [rad].
        rise: time from 10 % to 90 % of the step [s]; NaN where it does not come there.
        overshoot: how far it goes beyond the step, as a part of it.
        settling: time from which on it stays within 2 % of where it ends [s]; NaN where it does not.
        steady: desired less actual coordinate at the end of the run, the sag under the weight included, [m] or [rad].
        time: of the samples, shape (m,) [s].
        response: over the step, shape (m,); 1 where it is to be.
    """

    actuator: str
    size: float
    rise: float
    overshoot: float
    settling: float
    steady: float
    time: Array
    response: Array

    __repr__ = line("actuator", "rise", "overshoot", "settling", "steady", rise="s", settling="s", steady="m or rad")


def step_responses(case: TuningCase, gains: Gains, decay: float, fastest: float) -> tuple[StepResponse, ...]:
    """Of all actuators at the first posture of the reference, with the first payload.

    Args:
        case, gains: the loop.
        decay, fastest: of its slowest pole, and the size of its fastest one [1/s].

    Raises:
        InputError: the loop does not decay, so it has no such response.
    """
    if not decay > 0.0:
        raise InputError("the loop is unstable, so it has no step response")
    n, robot = case.robot.n, case.carrying(float(case.payloads[0]))
    span = min(ENOUGH / decay, LONGEST)
    if case.hardware is None:
        hardware, step = None, min(span / FEWEST, STIFF / fastest)
    else:
        hardware, step = _still(case.hardware), case.step_for(gains)
        span = math.ceil(span / hardware.clock.period) * hardware.clock.period
    step = max(step, span / MOST_STEPS)
    sizes = SIZE * steps_of(robot)
    rest = case.reference.at(0.0).q
    reference = Reference(JointRest(rest, span), case.reference.mechanism, limits="ignore")
    loop = ClosedLoop(robot, case.law(gains), case.reference.mechanism, hardware=hardware)
    many = loop.run(
        reference,
        step=step,
        every=step * max(1, math.ceil(span / MOST / step)),
        start=np.vstack([rest, rest - np.diag(sizes)]),
        parameters={PAYLOAD: np.full(n + 1, case.payloads[0])} if PAYLOAD in robot.options.parameters else None,
    )
    if many.failed:
        raise InputError(f"the step response cannot be simulated: {next(iter(many.failed.values()))}")
    found = []
    for k, actuator in enumerate(robot.actuators):
        response = 1.0 + (many.q[k + 1, :, k] - many.q[0, :, k]) / sizes[k]
        found.append(
            response_of(actuator.name, float(sizes[k]), many.time, response, float(rest[k] - many.q[0, -1, k]))
        )
    return tuple(found)


def response_of(actuator: str, size: float, time: Array, response: Array, steady: float) -> StepResponse:
    """The figures of a response that is to go from 0 to 1, sampled at `time` [s]."""
    low, high = (_first(time, response, level) for level in (LOW, HIGH))
    end = float(response[-1])
    out = np.flatnonzero(np.abs(response - end) > BAND)
    came = int(out[-1]) + 1 if len(out) else 0
    settling = float(time[came]) if came < (1.0 - BAND) * len(time) - 1.0 else math.nan
    overshoot = max(0.0, float(response.max()) - 1.0)
    return StepResponse(actuator, size, high - low, overshoot, settling, steady, time, response)


def _first(time: Array, response: Array, level: float) -> float:
    """When the response first comes to a level, linear between samples."""
    above = np.flatnonzero(response >= level)
    if not len(above):
        return math.nan
    k = int(above[0])
    if k == 0:
        return float(time[0])
    part = (level - response[k - 1]) / (response[k] - response[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def _still(hardware: Hardware) -> Hardware:
    """The same without chance."""
    speed = Tachometer() if isinstance(hardware.speed, Tachometer) else hardware.speed
    return replace(
        hardware, clock=replace(hardware.clock, jitter=0.0), encoder=replace(hardware.encoder, noise=0.0), speed=speed
    )
