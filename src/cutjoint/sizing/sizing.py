"""Sizing as one question: a robot, its trajectories, and the motors there are."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce

from cutjoint.arrays import Values
from cutjoint.doors import door_but, of_type
from cutjoint.errors import InputError
from cutjoint.mechanism import NO_LOADS, Actuator, Mechanism
from cutjoint.motion import Reference
from cutjoint.reprs import line
from cutjoint.sizing.bearings import BearingLoad, bearing_loads, chain_of
from cutjoint.sizing.cycle import LoadCycle, sized_cycle
from cutjoint.sizing.gearing import Gearing
from cutjoint.sizing.matching import MotorFit, matched
from cutjoint.sizing.motor import ServoMotor
from cutjoint.sizing.moving import Mover, SizingLoads
from cutjoint.sizing.values import Duty, SizedCycle

UNBALANCED = 1e-6
"""Balance from which on there is something wrong with a trajectory, and a warning."""


@dataclass(frozen=True, eq=False)
class Sizing(Values):
    """What motors, gears, brakes and bearings of a robot must give.

    Attributes:
        robot: its name.
        actuators: of it.
        payload: that it carries [kg].
        cycles: its trajectories, one after the other.
        worst: of every actuator and quantity the worst of all trajectories.
        fits: every motor at every actuator, best first; empty without motors.
        gearing: between them.
        bearings: what joints and cuts carry; empty where that was not asked for.
        demands: what any motor is judged by, a trajectory each.
    """

    robot: str
    actuators: tuple[Actuator, ...]
    payload: float
    cycles: tuple[SizedCycle, ...]
    worst: tuple[Duty, ...]
    fits: tuple[MotorFit, ...]
    gearing: Gearing
    bearings: tuple[BearingLoad, ...]
    demands: tuple[LoadCycle, ...]

    __repr__ = line("robot", "payload", "cycles", "worst", "fits", "bearings", payload="kg")

    def fits_of(self, actuator: str) -> tuple[MotorFit, ...]:
        """The motors at an actuator, best first; none where it has no such name."""
        return tuple(one for one in self.fits if one.actuator.name == actuator)

    @property
    def balance(self) -> float:
        """The worst power balance of all trajectories, see `SizedCycle.balance`."""
        return max(one.balance for one in self.cycles)


@door_but("references", "loads")
def size(
    robot: Mechanism,
    references: Reference | Sequence[Reference],
    *,
    motors: Sequence[ServoMotor] = (),
    gearing: Gearing | None = None,
    loads: SizingLoads = NO_LOADS,
    payload: float = 0.0,
    bearings: bool = False,
    samples: int = 101,
    progress: Callable[[float], None] | None = None,
) -> Sizing:
    """What the actuators of a robot must do along trajectories, and which motors do it.

    Args:
        robot: any robot whose actuators determine its motion; it is compiled where it can be.
        references: the trajectories, as `Reference(trajectory, robot)` sees them.
        motors: to choose from, such as `motors_from_file(path)`; none for the duties alone.
        gearing: ratios, efficiency and inertia of gears, pitch of screws, factor of brakes; default any ratio, no loss.
        loads: from outside, constant ones or a function of time [s].
        payload: mass at the tool [kg].
        bearings: whether to tell what joints and cuts carry.
        samples: even instants of a trajectory at which they are looked at.
        progress: called with the number of trajectories, and then of instants of the bearings, that are done.

    Raises:
        InputError: no reference, one of another robot, motors that fit no actuator, or wrong numbers.
        ActuationError, SingularError: the actuators do not determine the motion.
    """
    named = _named(references)
    if samples < 2:
        raise InputError(f"samples must be at least 2, found {samples}")
    between = Gearing() if gearing is None else gearing
    between.check(robot.actuators, motors)
    mover = Mover(robot, payload, loads)
    named = {name: mover.followed(one) for name, one in named.items()}
    if bearings:
        chain_of(mover)
    found = []
    for number, (name, one) in enumerate(named.items(), start=1):
        found.append(sized_cycle(mover, one, name))
        if progress is not None:
            progress(number)
    _warn(mover.plain.name, [one for one, _ in found])
    cycles, demands = tuple(one for one, _ in found), tuple(one for _, one in found)
    rows = zip(*(one.duties for one in cycles), strict=True)
    worst = tuple(reduce(Duty.or_worse, row) for row in rows)
    return Sizing(
        mover.plain.name,
        robot.actuators,
        float(payload),
        cycles,
        worst,
        matched(demands, robot.actuators, motors, between) if motors else (),
        between,
        bearing_loads(mover, named, samples, progress) if bearings else (),
        demands,
    )


def _warn(robot: str, cycles: Sequence[SizedCycle]) -> None:
    """Say where work and energies do not balance."""
    for one in cycles:
        if one.balance > max(UNBALANCED, one.error):
            warnings.warn(
                f"{robot} along '{one.name}': the work of the actuators misses the energies by {one.balance:.2g} of "
                "what moves; is the velocity of the trajectory the derivative of its position?",
                stacklevel=3,
            )


def _named(references: Reference | Sequence[Reference]) -> dict[str, Reference]:
    """The references by the names of their trajectories, which get a number where they are not one of a kind.

    Raises:
        InputError: there is none, or something else.
    """
    several = tuple(references) if isinstance(references, list | tuple) else (references,)
    for one in several:
        of_type("references of size", one, Reference)
    if not several:
        raise InputError("there is no reference to size along; Reference(trajectory, robot) makes one")
    names = [str(one.trajectory.name) for one in several]
    named: dict[str, Reference] = {}
    for number, (name, one) in enumerate(zip(names, several, strict=True), start=1):
        own = name if names.count(name) == 1 else f"{name} ({number})"
        while own in named:
            own += "'"
        named[own] = one
    return named
