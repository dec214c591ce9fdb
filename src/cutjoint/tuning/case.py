"""What is tuned: a robot, a law of some name, what they follow, and all that stands between them.

Runs of a case go through the compiled loop, many at a time; its linear loops are those at rest at some postures along
the reference, with every payload.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Literal, cast

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Sealed
from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, Compiled, Options, compiled
from cutjoint.control import Law, law
from cutjoint.control.catalogue import LawRow, law_row
from cutjoint.errors import ActuationError, InputError, SingularError
from cutjoint.mechanism import Mechanism
from cutjoint.mechanism.physics import LARGEST_PAYLOAD
from cutjoint.motion import Desired, Reference
from cutjoint.simulation.choice import quick
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.control import control_of, limits_of
from cutjoint.tuning.linear import LinearPlant, at_rest, linear_law, linear_plant, without_dry_friction
from cutjoint.tuning.loop import LinearLoop, timing_of

PAYLOAD = "payload"
DRAWS, MOST_DRAWS = 3, 1000
"""Runs with other noise where there is some and nobody says how many, and the most."""
POSTURES = 5
"""Postures along the reference at which the loop is linear."""
STEP = 2e-3
"""Longest step of the integrator [s]."""
STIFF = 0.4
"""Longest step times the fastest rate of a loop; the method is stable up to 2.7."""
MOST_STEPS = 400_000

Gains = Mapping[str, npt.ArrayLike]
Of = Literal["tool", "actuators"]


class TuningCase(Sealed):
    """A loop whose gains are sought; see `tune` for the arguments.

    Attributes:
        robot: compiled, the payload among its arguments where there is one to carry.
        name: of the law, as in the catalogue.
        row: its row there.
        model: what the law believes.
        reference: what is followed.
        hardware: between law and joints, or None under continuous control.
        limits: efforts that should not be exceeded, shape (n,), [N] or [N m], or None; nothing is cut off there (that
            is for the drive of the hardware).
        payloads: masses at the tool [kg], of which the worst counts.
        of: whether errors are those of the tool's point or of the actuators.
        after: from when on the late error counts [s].
        draws: runs of every set of gains and payload, each with other noise and jitter; the worst counts.

    Raises:
        InputError: arguments that are wrong or do not fit each other, or the actuators do not determine the motion.
        UnknownNameError: there is no such law.
    """

    def __init__(
        self,
        robot: Mechanism,
        name: str,
        reference: Reference,
        *,
        model: Mechanism | None = None,
        hardware: Hardware | None = None,
        limits: npt.ArrayLike | None = None,
        payloads: npt.ArrayLike = (0.0,),
        after: float = 0.0,
        of: Of | None = None,
        draws: int | None = None,
    ) -> None:
        self.name, self.row = name, _with_gains(name)
        self.payloads = _payloads(payloads)
        if not 0.0 <= float(after) < reference.duration:
            raise InputError(
                f"the late error counts from a time in the run on, from 0 to {reference.duration:g} s; found "
                f"after={after!r}"
            )
        self.after = float(after)
        self.robot = _compiled(robot, carries=bool(self.payloads.any()))
        believed = robot if model is None else model
        if believed.n != self.robot.n or reference.mechanism.n != self.robot.n:
            raise InputError(
                f"the law's model has {believed.n} actuators and the reference is for {reference.mechanism.n}; the "
                f"robot has {self.robot.n}"
            )
        self.model = self._quick(believed)
        self.reference, self.hardware = _seen_through(reference, self._quick(reference.mechanism)), hardware
        control_of(hardware, None, None)
        self.draws = draws_of(draws, hardware)
        bounds = limits_of(limits, self.robot.n)
        self.limits = None if bounds is None else np.broadcast_to(bounds, self.robot.n)
        self.of: Of = _usual_error(reference) if of is None else of
        self._smooth = without_dry_friction(self.robot)

    @property
    def mixes(self) -> bool:
        """Whether some actuators slide and some turn."""
        return len({one.kind for one in self.robot.actuators}) > 1

    @property
    def error_unit(self) -> str:
        """Of late errors: where some actuators slide and some turn, those that slide are in lengths of the robot."""
        if self.of == "tool":
            return "m"
        kind = self.robot.actuators[0].kind
        return "rad or lengths" if self.mixes else "m" if kind == "translation" else "rad"

    def _quick(self, model: Mechanism) -> Mechanism:
        """A model that is asked at every sample: the plant itself where it is the same chain."""
        plain = getattr(model, "plain", model)
        if not isinstance(plain, ClosedChain):
            return model
        return self.robot if plain is getattr(self.robot, "plain", None) else quick(model)

    @property
    def is_smooth(self) -> bool:
        """Whether nothing of the robot rubs, so that its linear equations leave nothing out."""
        return self._smooth is self.robot

    @property
    def effort_unit(self) -> str:
        """[N] or [N m], or both."""
        return " or ".join(dict.fromkeys(one.effort_unit for one in self.robot.actuators))

    def units(self) -> dict[str, str]:
        """Unit of every gain of the law for the actuators of this robot."""
        kinds = {one.kind for one in self.robot.actuators}
        found = {}
        for gain, about in self.row.gains.items():
            parts = about.unit.split(" or ")
            one_kind = len(parts) == 2 and len(kinds) == 1
            found[gain] = parts[0 if kinds == {"translation"} else 1] if one_kind else about.unit
        return found

    def law(self, gains: Gains) -> Law:
        """The law with these gains."""
        return law(self.name, self.model, gains)

    def carrying(self, payload: float, *, smooth: bool = False) -> Compiled:
        """The robot with a payload [kg]; `smooth` without dry friction."""
        robot = self._smooth if smooth else self.robot
        return robot.with_parameters({PAYLOAD: payload}) if PAYLOAD in robot.options.parameters else robot

    @cached_property
    def plants(self) -> tuple[tuple[Desired, tuple[LinearPlant, ...]], ...]:
        """Where the loop is linear: to rest at postures along the reference, and the robot there with every payload."""
        span = min(self.reference.duration, self.reference.trajectory.duration)
        robots = [self.carrying(one, smooth=True) for one in self.payloads.tolist()]
        found = []
        for t in np.linspace(0.0, span, POSTURES, endpoint=False).tolist():
            desired = at_rest(self.reference.mechanism, self.reference.at(t).q)
            there = [linear_plant(one, one.close(desired.q, limits="ignore")) for one in robots]
            found.append((desired, tuple(there)))
        return tuple(found)

    def linear(self, gains: Gains, *, ideal: bool = False) -> list[LinearLoop]:
        """The loop at rest at postures along the reference, with every payload; `ideal` under continuous control."""
        made, timing = self.law(gains), timing_of(None if ideal else self.hardware)
        loops = []
        for desired, plants in self.plants:
            about = linear_law(made, desired)
            loops += [LinearLoop(plant, about, timing) for plant in plants]
        return loops

    def step_for(self, gains: Gains) -> float:
        """A step of the integrator that is short against the loop's fastest rate [s]."""
        loops = self.linear(gains)
        if self.hardware is None:
            rate = max(float(np.abs(one.poles).max()) for one in loops)
        else:  # efforts are held: between two samples the plant moves by itself
            rate = max(float(np.abs(np.linalg.eigvals(one.plant.state)).max()) for one in loops)
        if not np.isfinite(rate):
            raise InputError(f"the loop of gains {_told(gains)} has no finite poles")
        longest = min(STEP, STIFF / max(rate, 1e-300))
        step = STEP / np.ceil(STEP / longest)
        if self.reference.duration > MOST_STEPS * step:
            raise InputError(
                f"with gains {_told(gains)} the loop moves at up to {rate:.3g} 1/s, and {self.reference.duration:g} s "
                f"would take more than {MOST_STEPS} steps; give smaller gains or a shorter motion"
            )
        return float(step)

    def loop(self, gains: Gains) -> ClosedLoop:
        """The compiled loop in which all gains vary.

        Raises:
            InputError: the law cannot be traced, or its model cannot be asked where the sensors say the robot is.
        """
        names = tuple(self.row.gains)
        return ClosedLoop(self.robot, self.law(gains), self.reference.mechanism, gains=names, hardware=self.hardware)


def draws_of(asked: int | None, hardware: Hardware | None) -> int:
    """How many runs each set of gains gets for its noise and jitter."""
    by_chance = hardware is not None and any(
        np.any(one) for one in (hardware.clock.jitter, hardware.encoder.noise, getattr(hardware.speed, "noise", 0.0))
    )
    if asked is None:
        return DRAWS if by_chance else 1
    if isinstance(asked, bool) or not isinstance(asked, int) or not 1 <= asked <= MOST_DRAWS:
        raise InputError(f"draws of noise are a whole number from 1 to {MOST_DRAWS}, found {asked!r}")
    if asked > 1 and not by_chance:
        raise InputError(
            f"{asked} draws are asked for, and nothing of this loop is by chance; give it noise or jitter, or leave "
            "the draws out"
        )
    return asked


def _seen_through(reference: Reference, mechanism: Mechanism) -> Reference:
    if reference.mechanism is mechanism:
        return reference
    return Reference(reference.trajectory, mechanism, reference.duration, limits=reference.limits)


def _told(gains: Gains) -> str:
    return ", ".join(f"{name} = {np.asarray(one).tolist()}" for name, one in gains.items())


def _with_gains(name: str) -> LawRow:
    row = law_row(name)
    if not row.gains:
        raise InputError(f"controller '{name}' has no gains, so there is nothing to tune")
    return row


def _payloads(values: npt.ArrayLike) -> Array:
    try:
        found = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise InputError(f"payloads must be masses [kg], found {values!r}") from error
    if found.ndim != 1 or not len(found) or not ((found >= 0.0) & (found <= LARGEST_PAYLOAD)).all():
        raise InputError(f"payloads must be masses from 0 to {LARGEST_PAYLOAD:g} kg, found {found.tolist()}")
    return found


def _compiled(robot: Mechanism, *, carries: bool) -> Compiled:
    """Raises InputError where no loop in actuated coordinates can be tuned."""
    if robot.n == 0:
        raise InputError(f"{robot.name} has no actuator, so there is no loop to tune")
    options = getattr(robot, "options", None)
    try:
        if isinstance(options, Options) and (not carries or PAYLOAD in options.parameters):
            made = robot
        else:
            made = compiled(getattr(robot, "plain", robot), parameters=(PAYLOAD,) if carries else (), quick=True)
        made.terms(made.home)
    except SingularError as error:
        raise InputError(f"no loop can be tuned at the home of {robot.name}, which is singular: {error}") from error
    except ActuationError as error:
        raise InputError(
            f"{error}. A law in actuated coordinates needs as many actuators as there are motions: change them in the "
            "description of the robot"
        ) from error
    return cast("Compiled", made)


def _usual_error(reference: Reference) -> Of:
    """The tool's, where the reference moves its point."""
    places = np.array([reference.at(t).tool.position for t in np.linspace(0.0, reference.duration, 9).tolist()])
    size = float(getattr(reference.mechanism, "length", 1.0))
    return "tool" if float(np.ptp(places, axis=0).max()) > 1e-9 * size else "actuators"
