"""The loop: plant, law, reference and integrator, run together and recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, positive
from cutjoint.control import GivenEfforts, Law, NoControl, as_law
from cutjoint.errors import CutjointError, InputError, LimitError, SimulationError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.motion import Reference
from cutjoint.simulation.choice import plant_of
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.hardware import Clock, Drive, Hardware
from cutjoint.simulation.hardware.checks import check_robot, check_span
from cutjoint.simulation.hardware.electronics import Electronics
from cutjoint.simulation.hardware.parts import parts_of
from cutjoint.simulation.integrators import Adaptive, Integrator, Step, StepError
from cutjoint.simulation.joint_limits import JointGuard, Passed, crossing, hermite
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import Advancing, Plant, State
from cutjoint.simulation.pushing import Pushing, RunLoads
from cutjoint.simulation.recording import Kept, Recording
from cutjoint.simulation.result import About, Result, result_of
from cutjoint.simulation.stiction import LOOKS

# Two instants nearer to each other than this part of the whole run are one.
SAME = 1e-12
# Steps shorter than this part of the whole run get nowhere, and so many of them on end are a wall that is crept up to,
# or a law that jumps to and fro.
CREEPING, CREEPS = 1e-8, 50
# How often a step that ends where a joint comes to rest is taken again.
RESTEPS = 3


# long: its arguments and what they mean
def run(
    robot: Plant | Mechanism,
    law: Law | Callable[..., npt.ArrayLike] | None = None,
    reference: Reference | None = None,
    *,
    integrator: Integrator | None = None,
    duration: float | None = None,
    rate: float | None = None,
    limits: npt.ArrayLike | None = None,
    hardware: Hardware | None = None,
    run_number: int = 0,
    every: float | None = None,
    start: Posture | State | None = None,
    start_velocity: npt.ArrayLike | None = None,
    lock: Sequence[str] = (),
    loads: RunLoads | None = None,
    joint_limits: JointLimits = "respect",
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Simulate a robot under a law.

    Args:
        robot: as a plant, or as a mechanism, of which the compiled plant is taken where there can be one; the result's
            `about` says which, and why not.
        law: the controller, or a function (t, desired, q, v) -> efforts; without a reference also a function t ->
            efforts, and by default no effort at all, which is free fall.
        reference: what it should follow; default nothing, and the result has no columns of what was desired.
        integrator: default that of a compiled plant while efforts are held, else `Adaptive()`, which is DOP853.
        duration: [s]; default that of the reference, or of the efforts where they have an end.
        rate: of the controller [Hz], whose effort is held in between (zero-order hold); default continuous control.
        limits: largest |effort|, scalar or one an actuator, [N] or [N m]; default none.
        hardware: all that is between law and joints, in place of rate and limits; the result then has what was
            measured, asked for and commanded too.
        run_number: which noise and jitter of the hardware's seed.
        every: distance of the samples in the result [s]; default the integrator's own steps.
        start: posture of the plant's mechanism, or a whole state of the plant; default the desired posture at time 0,
            or home where nothing is followed.
        start_velocity: of the actuators at a posture, shape (n,); default at rest.
        lock: names of actuators that brakes hold where they start; the effort that is recorded of them is what holds.
        loads: forces from outside: one `Load` or several, or a function (t, observation) -> loads of the time [s] and
            what is seen of the state (`Observation`), such as a wall or a spring.  The result has their work.
        joint_limits: whether the run stops where a joint without stops passes its limits.
        progress: called with the time [s] after every step.

    Raises:
        InputError: an argument is out of its range, or the law asks for a desired motion where there is none.
        UnknownNameError: there is no such actuator to lock, or no such link to push.
        UnreachableError, ClosureError, SingularError: no start.
        SimulationError: the run diverged, met a singularity, or a joint passed its limits; it holds the state and the
            result until then.
    """
    plant, not_compiled = plant_of(robot)
    n = plant.mechanism.n
    control = _law(law, reference)
    span = _span(duration, control, reference)
    spacing = math.inf if every is None else positive("every", every, "s")
    bounds = None if limits is None else _limits(limits, n)
    built = _built(hardware, rate, bounds, run_number)
    if built is not None:
        check_span(built, span)
    locks = Locks(plant, lock)
    v = np.zeros(n) if start_velocity is None else as_vector("start_velocity", start_velocity, n)
    first = start if isinstance(start, State) else plant.start(_posture(plant, reference, start), v)
    locks.check_rest(first)
    method = Adaptive() if integrator is None else integrator
    about: About = {
        "robot": plant.mechanism.name,
        "plant": plant.name,
        "law": control.name,
        "gains": control.gains,
        "integrator": method.name,
        "rate": rate,
        "limits": None if bounds is None else bounds.tolist(),
        "actuators": [[one.name, one.kind] for one in plant.mechanism.actuators],
    }
    if reference is not None:
        about |= {"trajectory": reference.trajectory.name, "reference": reference.mechanism.name}
    if not_compiled is not None:
        about["not_compiled"] = not_compiled
    if locks.names:
        about["locked"] = list(locks.names)
    pushing = None if loads is None else Pushing(plant, loads)
    if pushing is not None:
        about["loads"] = pushing.about
        pushing.on(0.0, first)  # what is wrong with them is wrong before the first step
    if hardware is not None:
        check_robot(hardware, plant.mechanism, locks.names)
        about |= {"rate": hardware.clock.rate, "hardware": parts_of(hardware), "run_number": run_number}
        if (top := hardware.drive.limits) is not None:
            about["limits"] = np.asarray(top).tolist()
    between = bounds if built is None else Electronics(built, n, run_number)
    coupled = Coupled(plant, control, reference, between, locks, first, pushing)
    guard = JointGuard(plant.mechanism, first) if joint_limits == "respect" else None
    running = _Run(coupled, method, guard, (span, spacing, every is None), about)
    if integrator is None and isinstance(plant, Advancing) and coupled.holds:
        about["integrator"] = plant.method
        running.itself = plant
    return running.go(progress)


def _law(law: Law | Callable[..., npt.ArrayLike] | None, reference: Reference | None) -> Law:
    if law is not None:
        return as_law(law)
    if reference is not None:
        raise InputError("a reference needs a law that follows it; NoControl() lets the robot fall")
    return NoControl()


def _span(duration: float | None, law: Law, reference: Reference | None) -> float:
    """How long to run [s].

    Raises:
        InputError: nobody says, or the efforts end before.
    """
    end = law.duration if isinstance(law, GivenEfforts) else math.inf
    usual = end if reference is None else reference.duration
    if duration is None and not math.isfinite(usual):
        raise InputError("without a reference there is nothing that says how long to run; give the duration [s]")
    span = positive("duration", usual if duration is None else duration, "s")
    if span > end * (1.0 + SAME):
        raise InputError(f"the efforts are given until {end:.6g} s, which is before the end of the run at {span:.6g} s")
    return span


def _posture(plant: Plant, reference: Reference | None, start: Posture | None) -> Posture:
    """Where to start."""
    if start is not None:
        return start
    return plant.mechanism.home if reference is None else reference.at(0.0).posture_of(plant.mechanism)


def _limits(limits: npt.ArrayLike, n: int) -> Array:
    wanted = f"limits must be one number > 0 or {n} of them, found {limits!r}"
    try:
        array = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(wanted) from error
    if array.shape not in ((), (n,)) or not (array > 0.0).all():
        raise InputError(wanted)
    return array


def _built(hardware: Hardware | None, rate: float | None, bounds: Array | None, run_number: int) -> Hardware | None:
    """What is between law and joints, or None under continuous control.

    Raises:
        InputError: hardware is given twice, or the number of a run without any.
    """
    if hardware is None:
        if run_number != 0:
            raise InputError("a run number picks the noise of hardware; give hardware too")
        if rate is None:
            return None
        clock = Clock(positive("rate", rate, "Hz"))
        return Hardware(clock, drive=Drive(None if bounds is None else bounds.tolist()))
    if not isinstance(hardware, Hardware):
        raise InputError(f"hardware must be Hardware(Clock(rate), ...), found {hardware!r}")
    if rate is not None or bounds is not None:
        raise InputError("rate and limits are in the hardware (clock and drive); leave them out beside it")
    return hardware


class _Run:
    """One run: a clock over steps, instants of the hardware and record samples (every `spacing`)."""

    def __init__(
        self,
        coupled: Coupled,
        method: Integrator,
        guard: JointGuard | None,
        clock: tuple[float, float, bool],
        about: About,
    ) -> None:
        self.coupled, self.method, self.guard, self.about = coupled, method, guard, about
        self.span, self.spacing, self.every_step = clock
        self.same = SAME * self.span
        self.recording = Recording(coupled.plant)
        self.t, self.steps, self.records, self.creeps = 0.0, 0, 0, 0
        self.h, self.recorded = math.inf, 0.0
        self.slope: Array | None = None
        self.itself: Advancing | None = None

    def go(self, progress: Callable[[float], None] | None) -> Result:
        """From 0 to the end of the span."""
        self.coupled.begin()
        self.record(0.0, self.coupled.origin, self.coupled.y)
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
        end = min(self.span, coupled.next_instant())
        if self.stride(min(end, self.next_record())):
            self.fall_due()
            return
        stop = end if self.method.interpolates else min(end, self.next_record())
        if coupled.let_go(self.t):
            self.slope = None
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
        self.creeps = self.creeps + 1 if step.t - self.t < CREEPING * self.span else 0
        if self.creeps == CREEPS:
            raise coupled.failure or StepError(
                f"steps of {step.t - self.t:.2g} s get nowhere; a law that jumps needs a sample time (rate=, --rate), "
                "at a stretched limb full coordinates go on (ConstrainedPlant)"
            )
        step, ended = self.until_a_mode_ends(step)
        self.record_between(step)
        began = coupled.origin, coupled.y
        unchanged = coupled.accept(step.y)
        if self.guard is not None:
            if self.guard.passed(coupled.origin) is not None:
                coupled.origin, coupled.y = began
                self.stop_at_limit(self.guard, step, step.t)
            self.guard.accept(coupled.origin)
        # A step that only ended early because something fell due does not shorten the next one.
        cut_short = stop < self.span and step.t >= stop
        self.h = max(self.h, step.ahead) if cut_short else step.ahead
        self.slope = step.slope if unchanged else None
        self.t, self.steps = step.t, self.steps + 1
        if ended is not None:
            coupled.switch(self.t, ended)
            self.slope = None
        self.fall_due()

    def stride(self, stop: float) -> bool:
        """Let the plant integrate itself until `stop` [s]; False where it does not, or a joint passes its limits."""
        coupled, held = self.coupled, self.coupled.held()
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
        coupled = self.coupled
        while self.t >= coupled.next_instant() - self.same:
            coupled.sample(self.t)
            self.slope = None
        if self.every_step or self.t >= self.next_record() - self.same:
            self.records += 1
            self.record(self.t, coupled.origin, coupled.y)

    def until_a_mode_ends(self, step: Step) -> tuple[Step, int | None]:
        """The step, or its part until a joint with stiction begins to stick or to slip, and which joint that is."""
        coupled = self.coupled
        if coupled.stiction is None:
            return step, None
        known = self.between(step)
        looks = LOOKS if self.method.interpolates else 0
        found = coupled.stiction.first(self.t, step.t, lambda t: coupled.mode_ends(t, known(t)), looks)
        if found is None:
            return step, None
        t, joint = found
        assert self.slope is not None
        for _ in range(RESTEPS):
            # the method is more exact at the end of a step than its interpolant within
            again = self.method.step(coupled.field, self.t, coupled.y, self.slope, t - self.t, t, self.span)
            if again.t < t:
                return again, None
            late = coupled.late(again.t, again.y, joint)
            if not (abs(late) > SAME * (t - self.t) and self.t < t - late < step.t):
                break
            t -= late
        return Step(again.t, again.y, None, step.ahead, again.between), joint

    def between(self, step: Step) -> Callable[[float], Array]:
        """The interpolant of a step, or the cubic through both ends where the method has none."""
        if step.between is not None:
            return step.between
        assert self.slope is not None
        slope = self.coupled.field(step.t, step.y) if step.slope is None else step.slope
        return hermite((self.t, self.coupled.y, self.slope), (step.t, step.y, slope))

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
            if self.guard is not None and self.guard.passed(state) is not None:
                self.stop_at_limit(self.guard, step, t)
            self.records += 1
            self.record(t, state, y)

    def stop_at_limit(self, guard: JointGuard, step: Step, beyond: float) -> NoReturn:
        """Go on to where the first joint passes its limits, which is before `beyond` [s] in the step, and raise."""
        coupled, known = self.coupled, self.between(step)

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

    def record(self, t: float, state: State, y: Array) -> None:
        """Take one sample; `y` is the flat vector of the state."""
        self.recorded, coupled = t, self.coupled
        desired = None if coupled.reference is None else coupled.desired(t)
        signals = coupled.signals(y) if "hardware" in self.about else None
        self.recording.keep(Kept(t, state, desired, coupled.effort_at(t, state, y), coupled.works(y), signals))

    def result(self) -> Result:
        """Everything until now."""
        coupled = self.coupled
        ending = About(steps=self.steps, evaluations=coupled.evaluations, strayed=coupled.strayed)
        return result_of(self.recording.columns(), {**self.about, **ending})

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
