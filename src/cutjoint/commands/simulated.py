"""What `cutjoint simulate` simulates: the robot, what its controller believes, and who leads it where."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from cutjoint.commands.options import gains_of, trajectory_of
from cutjoint.mechanism import is_mechanism
from cutjoint.motion.catalogue import numbers_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from cutjoint.chain import ClosedChain
    from cutjoint.control import Law
    from cutjoint.mechanism import JointLimits, Load, Mechanism
    from cutjoint.motion import Reference
    from cutjoint.simulation import Plant

MANY = 16
"""Actuators from which a robot is not compiled unasked: that takes longer than the short run by default."""
ABOUT_HOME = "about-home"
Robot = TypeVar("Robot", bound="Mechanism")


class Robots(NamedTuple):
    """What moves, the chain of the same robot, what the controller believes, what was chosen unasked, and the link that
    was taken for the tool of a robot that names none."""

    moving: Plant | Mechanism
    chain: ClosedChain
    inside: Mechanism
    told: tuple[str, ...]
    link: str | None

    @property
    def robot(self) -> Mechanism:
        """What moves, without its plant, and not compiled."""
        moving = self.moving
        robot = moving if is_mechanism(moving) else moving.mechanism  # type: ignore[union-attr]
        plain: Mechanism = getattr(robot, "plain", robot)
        return plain


class Leader(NamedTuple):
    """Who gives the efforts, what is followed, what was chosen unasked, and whether the run may end where a joint that
    nothing drives meets its limits."""

    law: Law
    reference: Reference | None
    told: tuple[str, ...] = ()
    may_end: bool = False

    @property
    def duration(self) -> float:
        """How long the run takes where nothing else is said [s]: as what is followed, the law's own way, or 1 s."""
        if self.reference is not None:
            return self.reference.duration
        from cutjoint.control.led import LedActuators

        return self.law.seconds if isinstance(self.law, LedActuators) else 1.0


def robots_of(
    robot: str,
    variant: str | None,
    plant: str | None,
    model: str | None,
    payload: float,
    ideal: bool,
    lenient: bool,
    default: bool,
) -> Robots:
    """The robot called `robot` with what moves it; `default` says that it makes the motion that is taken unasked.

    Raises:
        UnknownNameError: there is no such robot, variant, plant or model.
        InputError: these do not fit each other.
    """
    from cutjoint.errors import InputError, UnknownNameError
    from cutjoint.robots import PUBLISHED, load, published
    from cutjoint.simulation import ConstrainedPlant
    from cutjoint.simulation.choice import quick
    from cutjoint.simulation.watched import watched

    for option, side, known in (("plant", plant, ("compiled", "chain", "paper")), ("model", model, ("chain", "paper"))):
        if side is not None and side not in known:
            raise UnknownNameError(option, side, known)
    chain, link = watched(load(robot, variant, dynamics="ideal" if ideal else "real", lenient=lenient))
    if link is not None and payload != 0.0:
        raise InputError(f"{robot} has no tool frame to carry a payload; name one under [tool] in its loops.toml")
    told = [] if link is None else [f"no tool is named: recorded is link '{link}', the end of the longest limb"]
    name = chain.description.name
    acting = chain.description.acting
    if plant == "paper" and acting:
        raise InputError(
            f"--plant paper moves freely, and {robot} has physics of {', '.join(acting)}; take --plant chain or "
            "--ideal, or published(...).with_motors(...) in Python"
        )
    believes = model or ("paper" if name in PUBLISHED and not acting else "chain")
    inside: Mechanism = published(name) if believes == "paper" else chain
    if plant is None and default and chain.n > MANY:
        told.append(f"not compiled: {chain.n} actuators take a while; --plant compiled does it, once")
        plant = "chain"
    if plant == "chain":
        return Robots(ConstrainedPlant(_loaded(chain, payload)), chain, inside, tuple(told), link)
    quickly = quick(inside)
    if inside is chain and plant != "paper" and payload == 0.0:
        return Robots(quickly, chain, quickly, tuple(told), link)
    moving: Mechanism = _loaded(published(name) if plant == "paper" else chain, payload)
    return Robots(moving, chain, quickly, tuple(told), link)


def led_by(
    robots: Robots,
    controller: str | None,
    trajectory: str | None,
    duration: float | None,
    gains: Mapping[str, str],
    joints: JointLimits,
) -> Leader:
    """Who leads a robot, and along what.

    Raises:
        InputError: it has no actuator, or controller, gains and trajectory do not fit.
        UnreachableError, LimitError: it cannot follow the trajectory.
    """
    from cutjoint.errors import ActuationError, InputError
    from cutjoint.motion import Reference

    chain = robots.chain
    if chain.n == 0:
        raise InputError(_no_actuator(chain))
    is_about_home = trajectory is None or trajectory.partition(":")[0] == ABOUT_HOME
    if controller is None and is_about_home and not chain.mobility().determined:
        return _undetermined(chain, gains, numbers_of(trajectory or ABOUT_HOME))
    spec = trajectory
    if spec is None:
        spec = "paper" if has_paper(chain) else ABOUT_HOME
    try:
        law, told = _following(robots, controller or "computed-torque", gains)
        if trajectory is None:
            told += _beyond(chain)
        made = trajectory_of(chain, spec, robots.inside)
        reference = Reference(made, robots.inside, duration, limits=joints)
    except ActuationError as error:
        raise InputError(
            f"{error}. Without --controller its actuators are led about home, with --trajectory about-home or none; "
            "with --free it falls"
        ) from error
    told += getattr(made, "chosen", ())
    return Leader(law, reference, tuple(told))


def _undetermined(chain: ClosedChain, gains: Mapping[str, str], way: Sequence[float]) -> Leader:
    """A robot whose actuators do not determine its motion; `way` is how far and how long [s] it goes about home."""
    from cutjoint.errors import InputError
    from cutjoint.simulation.leading import led

    if not np.isnan(chain.mobility().type2):
        raise InputError(
            f"the home of {chain.name} is singular: with the actuators locked it still moves, so nothing tells where "
            "it would go from there; give it a home elsewhere, the first under [home] of its loops.toml"
        )
    known = {name: np.asarray(one) for name, one in gains_of(chain.description.name, "computed-torque", gains).items()}
    if many := [name for name, one in known.items() if one.ndim]:
        raise InputError(f"gain {many[0]} must be one number where actuators are led about home")
    size, seconds = way
    law, told = led(chain, seconds, float(known["kp"]), float(known["kd"]), size)
    return Leader(law, None, (*_beyond(chain), *told), may_end=True)


def has_paper(chain: ClosedChain) -> bool:
    """Whether a robot has a published trajectory."""
    from cutjoint.robots import PUBLISHED

    row = PUBLISHED.get(chain.description.name)
    return row is not None and row.path is not None


def _beyond(chain: ClosedChain) -> list[str]:
    """What is to be told of joints that are beyond their limits at home."""
    found = chain.limit_violations(chain.home)
    if not found:
        return []
    name, (value, lower, upper) = next(iter(found.items()))
    more = f" and {len(found) - 1} more" if len(found) > 1 else ""
    return [f"at home {name} is at {value:.4g}, beyond its limits {lower:.4g} to {upper:.4g}{more}"]


def _no_actuator(chain: ClosedChain) -> str:
    names = [one.name for one in chain.description.joints if one.type.coordinates]
    if not names:
        return f"{chain.name} has no joint that moves, so there is nothing to simulate"
    shown = ", ".join(f'"{name}"' for name in names[:3]) + (", ..." if len(names) > 3 else "")
    return (
        f"{chain.name} has no actuator that could follow anything; add some to its description, such as "
        f"actuators = [{shown}] in a loops.toml, or take --free and it falls"
    )


def law_of(robots: Robots, controller: str, gains: Mapping[str, str]) -> Law:
    """The control law of that name with its gains."""
    from cutjoint.control import law

    return law(controller, robots.inside, gains_of(robots.chain.description.name, controller, gains))


def _following(robots: Robots, controller: str, gains: Mapping[str, str]) -> tuple[Law, list[str]]:
    """The law that follows a motion, and what of its gains was chosen: where none are given or known, usual ones.

    Raises:
        UnknownNameError: no such controller.
        InputError: gains do not fit it.
        ActuationError: actuators that do not determine the motion feel no inertia that tells usual ones.
    """
    from cutjoint.control import LAWS, law
    from cutjoint.control.usual_gains import SPEED, usual_gains
    from cutjoint.tuning.known import GAINS

    known = GAINS.get(robots.chain.description.name, {})
    takes = list(LAWS[controller].gains) if controller in LAWS else []
    usual = takes and set(takes) <= {"kp", "ki", "kd"} and controller != "computed-torque"
    if gains or controller in known or not usual:
        return law_of(robots, controller, gains), []
    found = usual_gains(robots.inside)
    told = f"gains for {SPEED:g} rad/s with the inertia of every actuator at home"
    return law(controller, robots.inside, {name: found[name] for name in takes}), [told]


def unled(
    robots: Robots,
    controller: str | None,
    trajectory: str | None,
    efforts: Path | None,
    lock: Sequence[str],
    gains: Mapping[str, str],
) -> Leader:
    """Who gives the efforts of a robot that follows nothing.

    Raises:
        InputError: a trajectory, controller or gains are given that have no use, or nothing moves.
    """
    from cutjoint.control import efforts_from_csv
    from cutjoint.errors import InputError

    if trajectory is not None:
        raise InputError(
            f"with {'--free' if efforts is None else '--efforts'} nothing is followed; leave out --trajectory"
        )
    if robots.chain.nv == 0:
        raise InputError(_no_actuator(robots.chain))
    if efforts is None:
        return Leader(law_of(robots, controller or "none", gains), None)
    if controller is not None or gains:
        raise InputError("with --efforts there is no controller; leave out --controller and gains")
    return Leader(efforts_from_csv(efforts, robots.chain.actuators, lock), None)


def check_loads(robots: Robots, loads: Sequence[Load]) -> None:
    """Raises InputError where a load acts at the tool of a robot that names none."""
    from cutjoint.errors import InputError

    if robots.link is not None and any(load.link is None for load in loads):
        raise InputError(f"{robots.chain.name} names no tool for a load to act at; give a link")


def _loaded(robot: Robot, payload: float) -> Robot:
    return robot.with_payload(payload) if payload != 0.0 else robot
