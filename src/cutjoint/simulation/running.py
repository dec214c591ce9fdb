"""A run from its first instant to its last: steps of the integrator, what falls due between them, and the record.

A step ends early where the hardware has an instant, where a joint begins to stick or to slip, and where the run ends;
with a method that has no interpolant also where a sample is recorded.  Between instants of the hardware a plant that
integrates itself takes the whole way in one stride.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, NoReturn

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import CutjointError, InputError, Interrupted, LimitError, SimulationError
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.integrators import Integrator, Step, StepError
from cutjoint.simulation.interpolant import Begin, between
from cutjoint.simulation.joint_limits import JointGuard, Passed, crossing
from cutjoint.simulation.mode_ends import ModeEnds
from cutjoint.simulation.plant import Advancing, State
from cutjoint.simulation.recording import Kept, Recorder
from cutjoint.simulation.result import About, Result, result_of
from cutjoint.simulation.sampling import Sampling

SAME = 1e-12
"""Two instants nearer to each other than this part of the whole run are one."""
CREEPING, CREEPS = 1e-8, 50
"""Steps shorter than this part of the whole run get nowhere, and so many of them on end are a wall that is crept up to,
or a law that jumps to and fro."""


class Span(NamedTuple):
    """How long a run is [s], how far apart its records are [s], and whether every step is one."""

    length: float
    spacing: float
    every_step: bool


class Running:
    """One run.

    Args:
        coupled: its equations.
        method: that takes the steps.
        itself: the plant, where it integrates itself between instants of the hardware.
        guard: watches the limits of joints, or None.
        span: how long, and what is recorded.
        about: what the result says of itself.

    Attributes:
        t: time now [s].
        h: length of the step that comes next [s].
        slope: dy/dt now where it is known.
    """

    def __init__(
        self,
        coupled: Coupled,
        method: Integrator,
        itself: Advancing | None,
        guard: JointGuard | None,
        span: Span,
        about: About,
    ) -> None:
        self.coupled, self.method, self.itself, self.guard, self.about = coupled, method, itself, guard, about
        self.span, self.spacing, self.every_step = span
        self.same = SAME * self.span
        self.sampling = Sampling(coupled)
        self.mode_ends = ModeEnds(coupled, method, self.span)
        self.recorder = Recorder(coupled.plant)
        self.t, self.steps, self.records, self.creeps = 0.0, 0, 0, 0
        self.h, self.recorded = math.inf, 0.0
        self.slope: Array | None = None

    def go(self, progress: Callable[[float], None] | None) -> Result:
        """From 0 to the end of the span; `progress` is called with the time [s] after every step.

        Raises:
            SimulationError: it stopped early.
            Interrupted: so did a `KeyboardInterrupt`.
        """
        self.sampling.begin()
        self.record(0.0, self.coupled.origin, self.coupled.y)
        try:
            while self.span - self.t > self.same:
                try:
                    self.advance()
                except (CutjointError, np.linalg.LinAlgError) as error:
                    raise self.stopped(str(error)) from error
                if progress is not None:
                    self.tell(progress)
            return self.result()
        except KeyboardInterrupt as error:
            raise self.interrupted() from error

    def tell(self, progress: Callable[[float], None]) -> None:
        """Call `progress`; where it interrupts, the state is whole and becomes the last sample."""
        try:
            progress(self.t)
        except KeyboardInterrupt:
            if self.t - self.recorded > self.same:
                self.record(self.t, self.coupled.origin, self.coupled.y)
            raise

    # ---- steps -----------------------------------------------------------------------------------------------------

    def advance(self) -> None:
        """One accepted step, and what falls due at its end."""
        coupled = self.coupled
        coupled.failure = None
        end = min(self.span, self.sampling.next_instant())
        if self.stride(min(end, self.next_record())):
            self.fall_due()
            return
        stop = end if self.method.interpolates else min(end, self.next_record())
        begin, step = self.step(stop)
        step, ended = self.mode_ends.cut_short(begin, step)
        self.record_between(begin, step)
        origin = coupled.origin
        unchanged = coupled.accept(step.y)
        if self.guard is not None:
            if self.guard.passed(coupled.origin) is not None:
                coupled.origin, coupled.y = origin, begin.y
                self.stop_at_limit(self.guard, begin, step, step.t)
            self.guard.accept(coupled.origin)
        # A step that only ended early because something fell due does not shorten the next one.
        cut_short = stop < self.span and step.t >= stop
        self.h = max(self.h, step.ahead) if cut_short else step.ahead
        self.slope = step.slope if unchanged else None
        self.t, self.steps = step.t, self.steps + 1
        if ended is not None:
            self.mode_ends.switch(self.t, ended)
            self.slope = None
        self.fall_due()

    def step(self, stop: float) -> tuple[Begin, Step]:
        """One step of the method, not past `stop` [s], and where it begins.

        Raises:
            CutjointError: the equations, or the method, get no further.
        """
        coupled = self.coupled
        if self.mode_ends.let_go(self.t):
            self.slope = None
        if self.slope is None:
            self.slope = coupled.field(self.t, coupled.y)
        if not np.isfinite(self.slope).all():
            raise coupled.failure or InputError("the acceleration is not finite")
        begin = Begin(self.t, coupled.y, self.slope)
        with np.errstate(all="ignore"):
            if self.steps == 0:
                self.h = self.method.first(coupled.field, *begin, self.span)
                if not self.h > 0.0:
                    raise StepError("no step is small enough at the start: what acts is out of proportion")
            try:
                step = self.method.step(coupled.field, *begin, self.h, stop, self.span)
            except StepError as error:
                raise coupled.failure or error from error
        if not np.isfinite(step.y).all():
            raise coupled.failure or InputError("the state is not finite: the step is too long or the gains diverge")
        self.creeps = self.creeps + 1 if step.t - self.t < CREEPING * self.span else 0
        if self.creeps == CREEPS:
            raise coupled.failure or StepError(
                f"steps of {step.t - self.t:.2g} s get nowhere; a law that jumps needs a sample rate (rate=, --rate), "
                "at a stretched limb full coordinates go on (ConstrainedPlant)"
            )
        return begin, step

    def stride(self, stop: float) -> bool:
        """Let the plant integrate itself until `stop` [s]; False where it does not, or a joint passes its limits."""
        coupled, held = self.coupled, self.sampling.held()
        if self.itself is None or held is None:
            return False
        done = self.itself.advance(coupled.origin, held, stop - self.t, self.h)
        if done is None:
            return False
        if self.guard is not None:
            if self.guard.passed(done.state) is not None:
                return False
            self.guard.accept(done.state)
        coupled.put(done)
        self.t, self.steps, self.h, self.slope = stop, self.steps + 1, done.ahead, None
        return True

    def fall_due(self) -> None:
        """What falls due at the end of a step."""
        while self.t >= self.sampling.next_instant() - self.same:
            self.sampling.sample(self.t)
            self.slope = None
        if self.every_step or self.t >= self.next_record() - self.same:
            self.records += 1
            self.record(self.t, self.coupled.origin, self.coupled.y)

    def stop_at_limit(self, guard: JointGuard, begin: Begin, step: Step, beyond: float) -> NoReturn:
        """Go on to where the first joint passes its limits, which is before `beyond` [s] in the step, and raise."""
        coupled, known = self.coupled, between(self.coupled, begin, step)

        def passed(t: float) -> Passed | None:
            return guard.passed(coupled.plant.settled(coupled.state(known(t)))[0])

        found = passed(beyond)
        hit = crossing(self.t, beyond, passed)
        if hit > self.t:
            coupled.accept(known(hit))
            self.t, self.steps = hit, self.steps + 1
            if hit > self.recorded:
                self.record(hit, coupled.origin, coupled.y)
        assert found is not None
        raise LimitError(
            f'{found}; start elsewhere, ask for less, or ignore the limits (joint_limits="ignore", --ignore-limits)',
            joint=found.joint,
            value=found.value,
            bounds=(found.lower, found.upper),
            target=coupled.plant.measured(coupled.origin)[0],
            progress=self.t / self.span,
        )

    # ---- the record ------------------------------------------------------------------------------------------------

    def next_record(self) -> float:
        """Next instant to record [s]; the end is always recorded."""
        t = (self.records + 1) * self.spacing
        return self.span if t > self.span - self.same else t

    def record_between(self, begin: Begin, step: Step) -> None:
        """The instants to record inside a step."""
        coupled = self.coupled
        while step.between is not None and (t := self.next_record()) < step.t - self.same:
            y = step.between(t)
            state, _ = coupled.plant.settled(coupled.state(y))
            if self.guard is not None and self.guard.passed(state) is not None:
                self.stop_at_limit(self.guard, begin, step, t)
            self.records += 1
            self.record(t, state, y)

    def record(self, t: float, state: State, y: Array) -> None:
        """Take one sample; `y` is the flat vector of the state."""
        self.recorded, coupled = t, self.coupled
        desired = None if coupled.asking.reference is None else coupled.asking.desired(t)
        signals = self.sampling.signals(y) if "hardware" in self.about else None
        self.recorder.keep(Kept(t, state, desired, coupled.effort_at(t, state, y), coupled.works(y), signals))

    def result(self, why: str = "") -> Result:
        """Everything until now; `why` it ends there, if early."""
        coupled = self.coupled
        ending = About(steps=self.steps, evaluations=coupled.evaluations, strayed=coupled.strayed)
        if why:
            ending["stopped"] = f"at {self.recorded:.6g} s of {self.span:g} s: {why}"
        return result_of(self.recorder.columns(), {**self.about, **ending})

    def stopped(self, reason: str) -> SimulationError:
        """The error that ends a run early; nothing is lost."""
        q, v = self.coupled.plant.measured(self.coupled.origin)
        return SimulationError(
            f"the simulation stopped at t = {self.t:.6g} s of {self.span:g} s: {reason}; actuated coordinates then "
            f"{np.array2string(q, precision=6)}, velocities {np.array2string(v, precision=6)}",
            t=self.t,
            q=q,
            v=v,
            result=self.result(reason.partition("; ")[0]),
        )

    def interrupted(self) -> Interrupted:
        """What is raised on an interrupt, which may come amid a step: everything until the last sample."""
        result = self.result("interrupted")
        end = float(result.time[-1])
        return Interrupted(
            f"the simulation was interrupted; its result goes to t = {end:.6g} s of {self.span:g} s",
            done=end / self.span,
            result=result,
        )
