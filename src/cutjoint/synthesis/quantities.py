"""What a design is judged by: quantities of a closed robot, each a number with a unit and a better side.

A quantity is a row of `QUANTITIES`.  Those along a trajectory ask the robot at the anchors of its reference, so that
an unreachable trajectory is a design that does not do; the trajectory is that of the robot as it was, in the world.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.motion import Reference, Trajectory
from cutjoint.motion.reference import Desired
from cutjoint.reprs import line
from cutjoint.retiming import limits_of, retime
from cutjoint.stiffness import Springs, stiffness
from cutjoint.synthesis.following import moving_mass
from cutjoint.workspace import largest, workspace

Goal = Literal["most", "least"]
INSTANTS = 33
"""At which quantities along a trajectory are asked for, evenly spread."""


def followed(reference: Reference) -> tuple[Desired, ...]:
    """The desired motion at instants along a reference.

    Raises:
        CutjointError: it cannot be followed.
    """
    return tuple(map(reference.at, np.linspace(0.0, reference.duration, INSTANTS).tolist()))


@dataclass(frozen=True)
class Subject:
    """A robot that is judged.

    Attributes:
        chain: the robot.
        trajectories: those that quantities name, by their spec.
    """

    chain: ClosedChain
    trajectories: Mapping[str, Trajectory]
    _followed: dict[str, tuple[Desired, ...]] = field(default_factory=dict, repr=False)

    __repr__ = line("chain")

    def along(self, spec: str) -> tuple[Desired, ...]:
        """The desired motion at instants along a trajectory; it is followed once.

        Raises:
            UnreachableError, LimitError, SingularError: it cannot be followed.
        """
        if spec not in self._followed:
            self._followed[spec] = followed(Reference(self.trajectories[spec], self.chain))
        return self._followed[spec]

    @cached_property
    def kinds(self) -> frozenset[str]:
        """Whether actuators turn or slide."""
        return frozenset(one.kind for one in self.chain.actuators)

    def efforts(self, spec: str) -> Array:
        """Of all actuators along a trajectory, shape (instants, n), [N] or [N m].

        Raises:
            CutjointError: it cannot be followed.
        """
        chain = self.chain
        return np.array([chain.inverse_dynamics(one.posture, one.v, one.a) for one in self.along(spec)])


Options = Mapping[str, float | str]
Judge = Callable[[Subject, Options], float]


@dataclass(frozen=True)
class QuantityRow:
    """A quantity.

    Attributes:
        about: what it is.
        unit: of its values: {effort} and {extent} are the robot's own.
        goal: which side is better.
        judge: (robot, options) -> value.
        options: number or text that it takes -> what it is, with its default; None where it must be given.
    """

    about: str
    unit: str
    goal: Goal
    judge: Judge
    options: Mapping[str, tuple[str, float | str | None]] = field(default_factory=dict)

    __repr__ = line("about", "unit", "goal")


TRAJECTORY: tuple[str, str | None] = ("trajectory, as of `cutjoint simulate`", "about-home")


def _mass(subject: Subject, options: Options) -> float:
    return moving_mass(subject.chain.description)


def _effort(subject: Subject, options: Options) -> float:
    return float(np.abs(_alike(subject, str(options["trajectory"]))).max())


def _rms_effort(subject: Subject, options: Options) -> float:
    """Of the actuator that has the largest, over time."""
    return float(np.sqrt(np.mean(_alike(subject, str(options["trajectory"])) ** 2, axis=0)).max())


def _alike(subject: Subject, spec: str) -> Array:
    """Efforts that can be compared with each other.

    Raises:
        InputError: some are forces and some torques.
    """
    if len(subject.kinds) > 1:
        raise InputError("some actuators turn and some slide: the largest effort has no meaning; take power")
    return subject.efforts(spec)


def _power(subject: Subject, options: Options) -> float:
    spec = str(options["trajectory"])
    speeds = np.array([one.v for one in subject.along(spec)])
    return float(np.abs(subject.efforts(spec) * speeds).max())


def _isotropy(subject: Subject, options: Options) -> float:
    """1 / condition number of the tool's Jacobian, the worst along a trajectory."""
    worst = np.inf
    for one in subject.along(str(options["trajectory"])):
        condition = subject.chain.mobility(one.posture).condition
        if not np.isfinite(condition):
            return 0.0
        worst = min(worst, 1.0 / condition)
    return float(worst)


def _workspace(subject: Subject, options: Options) -> float:
    return float(workspace(subject.chain, cells=int(options["cells"])).extent)


def _box(subject: Subject, options: Options) -> float:
    """The largest box along the axes in the workspace, by its volume; 0 where none fits."""
    space = workspace(subject.chain, cells=int(options["cells"]))
    try:
        return float(largest(space).extent)
    except InputError:  # nowhere two cells thick
        return 0.0


def _stiffness(subject: Subject, options: Options) -> float:
    """The least of moving the tool along any direction, the worst along a trajectory."""
    springs = Springs({one.name: float(options["actuator"]) for one in subject.chain.actuators})
    worst = np.inf
    for one in subject.along(str(options["trajectory"]))[:: INSTANTS // 8]:
        worst = min(worst, stiffness(subject.chain, springs, one.posture).translation.softest)
    return float(worst)


def _cycle(subject: Subject, options: Options) -> float:
    limits = limits_of(subject.chain, effort=float(options["effort"]))
    return float(retime(subject.chain, subject.trajectories[str(options["trajectory"])], limits).duration)


QUANTITIES: Mapping[str, QuantityRow] = {
    "workspace": QuantityRow(
        "extent of the workspace around home", "{extent}", "most", _workspace, {"cells": ("cells along an axis", 24.0)}
    ),
    "box": QuantityRow(
        "extent of the largest box in the workspace around home",
        "{extent}",
        "most",
        _box,
        {"cells": ("cells along an axis", 24.0)},
    ),
    "stiffness": QuantityRow(
        "least stiffness against a push at the tool, along a trajectory",
        "N/m",
        "most",
        _stiffness,
        {"trajectory": TRAJECTORY, "actuator": ("stiffness of each actuator [N/m] or [N m/rad]", None)},
    ),
    "isotropy": QuantityRow(
        "least 1 / condition number of the tool's Jacobian along a trajectory",
        "",
        "most",
        _isotropy,
        {"trajectory": TRAJECTORY},
    ),
    "effort": QuantityRow(
        "largest effort of an actuator along a trajectory", "{effort}", "least", _effort, {"trajectory": TRAJECTORY}
    ),
    "rms-effort": QuantityRow(
        "largest root mean square effort of an actuator along a trajectory",
        "{effort}",
        "least",
        _rms_effort,
        {"trajectory": TRAJECTORY},
    ),
    "power": QuantityRow(
        "largest power of an actuator along a trajectory", "W", "least", _power, {"trajectory": TRAJECTORY}
    ),
    "cycle": QuantityRow(
        "least time for a trajectory's path within an effort limit",
        "s",
        "least",
        _cycle,
        {"trajectory": TRAJECTORY, "effort": ("limit of each actuator [N] or [N m]", None)},
    ),
    "mass": QuantityRow("mass of all links that move", "kg", "least", _mass),
}
