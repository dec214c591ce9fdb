"""The loop: plant, law, reference and integrator, run together."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, positive
from cutjoint.control import Law
from cutjoint.errors import CutjointError, InputError, SimulationError
from cutjoint.mechanism import Posture
from cutjoint.motion import Desired, Reference
from cutjoint.simulation.integrators import Adaptive, Integrator
from cutjoint.simulation.integrators.method import Step, StepError
from cutjoint.simulation.plant import Plant, State
from cutjoint.simulation.recorder import Recorder
from cutjoint.simulation.result import Result

# Two instants nearer than this to each other [s] are one.
SAME = 1e-12


def run(
    plant: Plant,
    law: Law,
    reference: Reference,
    *,
    integrator: Integrator | None = None,
    duration: float | None = None,
    rate: float | None = None,
    limits: npt.ArrayLike | None = None,
    every: float | None = None,
    start: Posture | None = None,
    start_velocity: npt.ArrayLike | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Simulate the plant under the law.

    Args:
        plant: the robot.
        law: the controller.
        reference: what it should follow.
        integrator: default `Adaptive()`, which is DOP853.
        duration: [s]; default that of the reference.
        rate: of the controller [Hz], whose effort is held in between (zero-order hold); default continuous control.
        limits: largest |effort|, scalar or one an actuator, [N] or [N m]; default none.
        every: distance of the samples in the result [s]; default the integrator's own steps.
        start: posture of the plant's mechanism; default the desired one at time 0.
        start_velocity: of the actuators, shape (n,); default at rest.
        progress: called with the time [s] after every step.

    Raises:
        InputError: an argument is out of its range.
        UnreachableError, ClosureError, SingularError: no start.
        SimulationError: the run diverged or met a singularity; it holds the result until then.
    """
    desired = reference.at(0.0)
    n = plant.mechanism.n
    span = positive("duration", reference.duration if duration is None else duration, "s")
    period = None if rate is None else 1.0 / positive("rate", rate, "Hz")
    spacing = None if every is None else positive("every", every, "s")
    at = desired.posture_of(plant.mechanism) if start is None else start
    v = np.zeros(n) if start_velocity is None else np.array(start_velocity, dtype=np.float64)
    if v.shape != (n,) or not np.isfinite(v).all():
        raise InputError(f"start_velocity must be {n} finite numbers, found {start_velocity!r}")
    method = Adaptive() if integrator is None else integrator
    loop = _Loop(plant, law, reference, _limits(limits, n), sampled=period is not None)
    loop.begin(plant.start(at, v))
    about = {
        "robot": plant.mechanism.name,
        "plant": plant.name,
        "law": law.name,
        "gains": law.gains,
        "trajectory": reference.trajectory.name,
        "reference": reference.mechanism.name,
        "integrator": method.name,
        "rate": rate,
        "limits": None if limits is None else np.asarray(limits, dtype=np.float64).tolist(),
        "actuators": [[one.name, one.kind] for one in plant.mechanism.actuators],
    }
    return _drive(loop, method, span, period, spacing, about, progress)


def _limits(limits: npt.ArrayLike | None, n: int) -> Array | None:
    if limits is None:
        return None
    try:
        array = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"limits must be one number or {n} numbers, found {limits!r}") from error
    if array.shape not in ((), (n,)) or not (array > 0.0).all():
        raise InputError(f"limits must be one number > 0 or {n} of them, found {limits!r}")
    return array


@dataclass(eq=False)
class _Loop:
    """The coupled equations in the chart around the last accepted state: y = (u, v, memory, work)."""

    plant: Plant
    law: Law
    reference: Reference
    limits: Array | None
    sampled: bool

    def begin(self, state: State) -> None:
        self.n = self.plant.mechanism.n
        self.memory_size = self.law.memory(self.n)
        self.held: Array | None = None
        self.failure: CutjointError | None = None
        self.evaluations = 0
        self.strayed = 0.0
        self._desired: list[Desired] = []
        self._given: tuple[float, Array, Array] | None = None
        self.origin = state
        self.y = np.concatenate([self.plant.chart(state), state.v, np.zeros(self.memory_size + 1)])
        self.cut = state.v.size

    def desired(self, t: float) -> Desired:
        """Methods ask several times at one instant; the last two answers are kept."""
        for known in self._desired:
            if known.t == t:
                return known
        self._desired = [self.reference.at(t), *self._desired[:1]]
        return self._desired[0]

    def state(self, y: Array) -> State:
        k = self.cut
        return self.plant.moved(self.origin, y[:k], y[k : 2 * k])

    def memory(self, y: Array) -> Array:
        return y[2 * self.cut : -1]

    def control(self, t: float, state: State, memory: Array) -> tuple[Array, Array]:
        """Effort after saturation and rate of the law's memory."""
        q, v = self.plant.measured(state)
        desired = self.desired(t)
        asked = self.law.effort(desired, q, v, memory)
        if not np.isfinite(asked).all():
            raise InputError(f"law '{self.law.name}' asks for an effort that is not finite: {asked.tolist()}")
        given = asked if self.limits is None else np.clip(asked, -self.limits, self.limits)
        return given, self.law.memory_rate(desired, q, v, asked, given)

    def field(self, t: float, y: Array) -> Array:
        """dy/dt; not a number where the plant or the law cannot go."""
        self.evaluations += 1
        k = self.cut
        out = np.empty(y.size)
        try:
            state = self.state(y)
            if self.held is None:
                effort, out[2 * k : -1] = self.control(t, state, self.memory(y))
                self._given = (t, y, effort)
            else:
                effort, out[2 * k : -1] = self.held, 0.0
            out[:k] = self.plant.chart_rate(self.origin, state)
            out[k : 2 * k] = self.plant.acceleration(state, effort)
            out[-1] = effort @ self.plant.measured(state)[1]
        except (CutjointError, np.linalg.LinAlgError) as error:
            self.failure = error if isinstance(error, CutjointError) else InputError(str(error))
            out[:] = np.nan
        return out

    def effort(self, t: float) -> Array:
        """Effort from the accepted state at `t` on."""
        if self.held is not None:
            return self.held
        if self._given is not None and self._given[0] == t and self._given[1] is self.y:
            return self._given[2]
        return self.control(t, self.origin, self.memory(self.y))[0]

    def sample(self, t: float, period: float) -> None:
        """Read the state and hold the effort; the law's memory moves on by one period."""
        effort, memory_rate = self.control(t, self.origin, self.memory(self.y))
        self.held = effort
        if self.memory_size:
            self.y = self.y.copy()
            self.y[2 * self.cut : -1] += period * memory_rate

    def accept(self, y: Array) -> bool:
        """Take `y` as the new state, back on its loops; whether the chart stayed as it was."""
        state, off = self.plant.settled(self.state(y))
        self.strayed = max(self.strayed, off)
        self.origin = state
        u = self.plant.chart(state)
        same = off == 0.0 and np.array_equal(u, y[: self.cut])
        self.y = y if same else np.concatenate([u, state.v, y[2 * self.cut :]])
        return same


def _drive(
    loop: _Loop,
    method: Integrator,
    span: float,
    period: float | None,
    spacing: float | None,
    about: dict[str, Any],
    progress: Callable[[float], None] | None,
) -> Result:
    recorder = Recorder()
    t, steps, samples, outputs = 0.0, 0, 0, 0
    h: float | None = None
    slope: Array | None = None

    def result() -> Result:
        closing = {"steps": steps, "evaluations": loop.evaluations, "strayed": loop.strayed}
        return recorder.result({**about, **closing})

    def stopped(reason: str) -> SimulationError:
        q, v = loop.plant.measured(loop.origin)
        return SimulationError(
            f"the simulation stopped at t = {t:.6g} s of {span:g} s: {reason}; actuated coordinates "
            f"{np.array2string(q, precision=6)}, velocities {np.array2string(v, precision=6)}",
            t=t,
            q=q,
            v=v,
            result=result(),
        )

    try:
        if period is not None:
            loop.sample(0.0, period)
        recorder.add(0.0, loop.plant.observe(loop.origin), loop.desired(0.0), loop.effort(0.0), 0.0)
        while span - t > SAME:
            end = span
            if period is not None:
                end = min(end, (samples + 1) * period)
            grid = math.inf if spacing is None else (outputs + 1) * spacing
            if grid >= span - SAME:
                grid = span
            if slope is None:
                loop.failure = None
                slope = loop.field(t, loop.y)
                if not np.isfinite(slope).all():
                    raise stopped(str(loop.failure or "the acceleration is not finite"))
            if h is None:
                h = method.first(loop.field, t, loop.y, slope, span)
            stop = end if method.interpolates else min(end, grid)
            try:
                with np.errstate(all="ignore"):
                    step = method.step(loop.field, t, loop.y, slope, h, stop, span)
            except StepError as error:
                raise stopped(f"{loop.failure or error}") from error
            if not np.isfinite(step.y).all():
                raise stopped(str(loop.failure or "the state is not finite; the step is too long or the gains diverge"))
            # Output instants inside the step.
            while spacing is not None and step.between is not None and grid < step.t - SAME:
                _record_between(loop, recorder, grid, step)
                outputs += 1
                grid = (outputs + 1) * spacing
            clipped = step.t >= stop - SAME and stop < span
            h = max(h, step.ahead) if clipped else step.ahead
            t_new = step.t if abs(step.t - end) > SAME else end
            same = loop.accept(step.y)
            t, steps = t_new, steps + 1
            slope = step.slope if same else None
            if period is not None and t >= (samples + 1) * period - SAME:
                samples += 1
                loop.sample(t, period)
                slope = None
            if spacing is None or t >= grid - SAME or t >= span - SAME:
                recorder.add(t, loop.plant.observe(loop.origin), loop.desired(t), loop.effort(t), float(loop.y[-1]))
                outputs += 1
            if progress is not None:
                progress(t)
    except SimulationError:
        raise
    except (CutjointError, np.linalg.LinAlgError) as error:
        raise stopped(str(error)) from error
    return result()


def _record_between(loop: _Loop, recorder: Recorder, t: float, step: Step) -> None:
    assert step.between is not None
    y = step.between(t)
    state, _ = loop.plant.settled(loop.state(y))
    desired = loop.desired(t)
    effort = loop.held if loop.held is not None else loop.control(t, state, loop.memory(y))[0]
    recorder.add(t, loop.plant.observe(state), desired, effort, float(y[-1]))
