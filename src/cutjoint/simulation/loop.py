"""A simulation is set up: plant, law, reference, hardware, loads and integrator, checked and put together."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import as_vector, positive
from cutjoint.chain import ClosedChain
from cutjoint.control import GivenEfforts, Law, NoControl, fitted_law
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.motion import Reference
from cutjoint.simulation.asking import Asking
from cutjoint.simulation.choice import plant_of
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.extent import check_extent
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.checks import check_robot, check_span
from cutjoint.simulation.hardware.control import control_of, limits_of
from cutjoint.simulation.hardware.electronics import Electronics
from cutjoint.simulation.hardware.parts import parts_of
from cutjoint.simulation.integrators import Adaptive, Integrator
from cutjoint.simulation.joint_limits import JointGuard
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import Advancing, Plant, State
from cutjoint.simulation.pushing import Pushing, RunLoads
from cutjoint.simulation.result import About, Result
from cutjoint.simulation.robot_words import check_moves, robot_words
from cutjoint.simulation.running import SAME, Running, Span


# long: its arguments and what they mean
@door
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
    lock: str | Sequence[str] = (),
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
        DynamicsError: actuators or joint physics act on a motion of several joints that moves no mass.
        SimulationError: the run diverged, met a singularity, or a joint passed its limits; it holds the state and the
            result until then.
        Interrupted: a `KeyboardInterrupt` (Ctrl-C) came; it is one, and holds the result until then.
    """
    plant, not_compiled = plant_of(robot)
    n = plant.mechanism.n
    control = _law(law, reference, n)
    span = _span(duration, control, reference)
    spacing = math.inf if every is None else positive("every", every, "s")
    bounds = limits_of(limits, n)
    between = control_of(hardware, rate, bounds)
    if isinstance(between, Hardware):
        check_span(between, span)
    if hardware is None and run_number != 0:
        raise InputError("a run number picks the noise of hardware; give hardware too")
    locks = Locks(plant, lock)
    v = np.zeros(n) if start_velocity is None else as_vector("start_velocity", start_velocity, n)
    first = start if isinstance(start, State) else plant.start(_posture(plant, reference, start), v)
    locks.check_rest(first)
    check_moves(plant.mechanism, first)
    method = Adaptive() if integrator is None else integrator
    check_extent(span, spacing, method)
    about: About = {
        "robot": plant.mechanism.name,
        "plant": plant.name,
        "law": control.name,
        "gains": control.gains,
        "integrator": method.name,
        "rate": rate,
        "limits": None if bounds is None else bounds.tolist(),
        **robot_words(plant.mechanism),
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
    drives = Electronics(between, n, run_number) if isinstance(between, Hardware) else between
    coupled = Coupled(plant, Asking(control, reference, drives), locks, first, pushing)
    guard = JointGuard(plant.mechanism, first) if joint_limits == "respect" else None
    itself = plant if integrator is None and isinstance(plant, Advancing) and coupled.holds else None
    if itself is not None:
        about["integrator"] = itself.method
    running = Running(coupled, method, itself, guard, Span(span, spacing, every is None), about)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # a run that diverges is told as such
        return running.go(progress)


def _law(law: Law | Callable[..., npt.ArrayLike] | None, reference: Reference | None, n: int) -> Law:
    if law is not None:
        return fitted_law(law, n)
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


def _check_start(mechanism: Mechanism, start: Posture) -> None:
    """Raises InputError or ClosureError where a posture is none of this robot."""
    robot = getattr(mechanism, "plain", mechanism)  # of a compiled robot, the one it was made from
    if isinstance(robot, ClosedChain):
        robot.posture(start)
    else:
        robot.terms(start)


def _posture(plant: Plant, reference: Reference | None, start: Posture | None) -> Posture:
    """Where to start."""
    if start is not None:
        _check_start(plant.mechanism, start)
        return start
    return plant.mechanism.home if reference is None else reference.at(0.0).posture_of(plant.mechanism)
