"""The loop: plant, law, reference and integrator, run together and recorded."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, positive
from cutjoint.control import Law
from cutjoint.errors import CutjointError, InputError, SimulationError
from cutjoint.mechanism import Posture
from cutjoint.motion import Reference
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.integrators import Adaptive, Integrator, Step, StepError
from cutjoint.simulation.observables import OBSERVABLES, Instant
from cutjoint.simulation.plant import Plant, State
from cutjoint.simulation.result import About, Result, result_of

# Two instants nearer to each other than this part of the whole run are one.
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
    start: Posture | State | None = None,
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
        start: posture of the plant's mechanism, or a whole state of the plant; default the desired posture at time 0.
        start_velocity: of the actuators at a posture, shape (n,); default at rest.
        progress: called with the time [s] after every step.

    Raises:
        InputError: an argument is out of its range.
        UnreachableError, ClosureError, SingularError: no start.
        SimulationError: the run diverged or met a singularity; it holds the state and the result until then.
    """
    n = plant.mechanism.n
    span = positive("duration", reference.duration if duration is None else duration, "s")
    period = math.inf if rate is None else 1.0 / positive("rate", rate, "Hz")
    spacing = math.inf if every is None else positive("every", every, "s")
    bounds = None if limits is None else _limits(limits, n)
    v = np.zeros(n) if start_velocity is None else as_vector("start_velocity", start_velocity, n)
    if isinstance(start, State):
        first = start
    else:
        first = plant.start(reference.at(0.0).posture_of(plant.mechanism) if start is None else start, v)
    method = Adaptive() if integrator is None else integrator
    about: About = {
        "robot": plant.mechanism.name,
        "plant": plant.name,
        "law": law.name,
        "gains": law.gains,
        "trajectory": reference.trajectory.name,
        "reference": reference.mechanism.name,
        "integrator": method.name,
        "rate": rate,
        "limits": None if bounds is None else bounds.tolist(),
        "actuators": [[one.name, one.kind] for one in plant.mechanism.actuators],
    }
    coupled = Coupled(plant, law, reference, bounds, first)
    return _Run(coupled, method, span, period, spacing, every is None, about).go(progress)


def _limits(limits: npt.ArrayLike, n: int) -> Array:
    wanted = f"limits must be one number > 0 or {n} of them, found {limits!r}"
    try:
        array = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(wanted) from error
    if array.shape not in ((), (n,)) or not (array > 0.0).all():
        raise InputError(wanted)
    return array


class _Run:
    """One run: a clock over steps, control samples (every `period`) and record samples (every `spacing`)."""

    def __init__(
        self,
        coupled: Coupled,
        method: Integrator,
        span: float,
        period: float,
        spacing: float,
        every_step: bool,
        about: About,
    ) -> None:
        self.coupled, self.method, self.about = coupled, method, about
        self.span, self.period, self.spacing, self.every_step = span, period, spacing, every_step
        self.same = SAME * span
        self.columns: dict[str, list[npt.ArrayLike]] = {name: [] for name in OBSERVABLES}
        self.t, self.steps, self.samples, self.records = 0.0, 0, 0, 0
        self.h = math.inf
        self.slope: Array | None = None

    def go(self, progress: Callable[[float], None] | None) -> Result:
        """From 0 to the end of the span."""
        if math.isfinite(self.period):
            self.coupled.sample(0.0, self.period)
        self.record(0.0, self.coupled.origin, self.coupled.effort(0.0), 0.0)
        while self.span - self.t > self.same:
            try:
                self.advance()
            except (CutjointError, np.linalg.LinAlgError) as error:
                raise self.stopped(str(error)) from error
            if progress is not None:
                progress(self.t)
        return self.result()

    def advance(self) -> None:
        """One accepted step, and what falls due at its end."""
        coupled = self.coupled
        coupled.failure = None
        end = min(self.span, (self.samples + 1) * self.period)
        stop = end if self.method.interpolates else min(end, self.next_record())
        if self.slope is None:
            self.slope = coupled.field(self.t, coupled.y)
        if not np.isfinite(self.slope).all():
            raise coupled.failure or InputError("the acceleration is not finite")
        with np.errstate(all="ignore"):
            if self.steps == 0:
                self.h = self.method.first(coupled.field, self.t, coupled.y, self.slope, self.span)
            try:
                step = self.method.step(coupled.field, self.t, coupled.y, self.slope, self.h, stop, self.span)
            except StepError as error:
                raise coupled.failure or error from error
        if not np.isfinite(step.y).all():
            raise coupled.failure or InputError("the state is not finite: the step is too long or the gains diverge")
        self.record_between(step)
        # A step that only ended early because something fell due does not shorten the next one.
        cut_short = stop < self.span and step.t >= stop
        self.h = max(self.h, step.ahead) if cut_short else step.ahead
        unchanged = coupled.accept(step.y)
        self.slope = step.slope if unchanged else None
        self.t, self.steps = step.t, self.steps + 1
        if self.t >= (self.samples + 1) * self.period - self.same:
            self.samples += 1
            coupled.sample(self.t, self.period)
            self.slope = None
        if self.every_step or self.t >= self.next_record() - self.same:
            self.records += 1
            self.record(self.t, coupled.origin, coupled.effort(self.t), float(coupled.y[-1]))

    def next_record(self) -> float:
        """Next instant to record [s]; the end is always recorded."""
        t = (self.records + 1) * self.spacing
        return self.span if t > self.span - self.same else t

    def record_between(self, step: Step) -> None:
        """The instants to record inside a step."""
        coupled = self.coupled
        while step.between is not None and (t := self.next_record()) < step.t - self.same:
            y = step.between(t)
            state, _ = coupled.plant.settled(coupled.state(y))
            effort = coupled.control(t, state, y)[0] if coupled.held is None else coupled.held
            self.records += 1
            self.record(t, state, effort, float(y[-1]))

    def record(self, t: float, state: State, effort: Array, work: float) -> None:
        """Take one sample."""
        now = Instant(t, self.coupled.plant.observe(state), self.coupled.desired(t), effort, work)
        for name, one in OBSERVABLES.items():
            self.columns[name].append(one.take(now))

    def result(self) -> Result:
        """Everything until now."""
        coupled = self.coupled
        ending = About(steps=self.steps, evaluations=coupled.evaluations, strayed=coupled.strayed)
        columns = {name: np.array(samples, dtype=np.float64) for name, samples in self.columns.items()}
        return result_of(columns, {**self.about, **ending})

    def stopped(self, reason: str) -> SimulationError:
        """The error that ends a run early; nothing is lost."""
        q, v = self.coupled.plant.measured(self.coupled.origin)
        return SimulationError(
            f"the simulation stopped at t = {self.t:.6g} s of {self.span:g} s: {reason}; actuated coordinates then "
            f"{np.array2string(q, precision=6)}, velocities {np.array2string(v, precision=6)}",
            t=self.t,
            q=q,
            v=v,
            result=self.result(),
        )
