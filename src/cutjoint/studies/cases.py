"""Cases: the combinations of variant, trajectory, controller and hardware that a study crosses with its samples, and
what of them travels to another process."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy.typing as npt

from cutjoint.arrays import Values
from cutjoint.chain import ClosedChain
from cutjoint.control import Law, law
from cutjoint.control.catalogue import law_row
from cutjoint.control.usual_gains import SPEED, usual_gains
from cutjoint.description import RobotDescription, load_description
from cutjoint.description.fingerprint import fingerprint
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.files import is_file, read_file
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Reference, Trajectory
from cutjoint.motion.catalogue import trajectory
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.reprs import line
from cutjoint.robots import PUBLISHED, published
from cutjoint.simulation.hardware import Hardware
from cutjoint.studies.paths import GAINS, check_bound, is_of_robot, nominal_of
from cutjoint.studies.spreads import Spread
from cutjoint.studies.values import FollowingLaw, Study

LARGEST_MOTION = 2**30
COMPUTED_TORQUE: Mapping[str, float] = {"kp": SPEED**2, "kd": 2.0 * SPEED}


@dataclass(frozen=True, eq=False)
class StudyCase(Values):
    """One combination.

    Attributes:
        name: what tells it from the others; empty where there is one.
        robot: the description of the closed chain; None for a published model.
        variant: the variant of inertias.
        trajectory: that is followed.
        law: the controller; its gains are all there.
        hardware: between controller and joints.
        spreads: where the values of every varied path come from, in their order.
    """

    name: str
    robot: RobotDescription | None
    variant: str | None
    trajectory: Trajectory
    law: FollowingLaw
    hardware: Hardware | None
    spreads: tuple[Spread, ...]

    __repr__ = line("name", "variant", "law")


@dataclass(frozen=True, eq=False)
class Recipe(Values):
    """All that a process needs to simulate any block of a study.

    Attributes:
        study: what the file says.
        cases: in their order; run number k of a study is sample k % samples of case k // samples.
        fingerprint: of the robot.
        motions: SHA-256 of the files of motions that it follows, by trajectory.
        told: what was chosen unasked.
    """

    study: Study
    cases: tuple[StudyCase, ...]
    fingerprint: str
    motions: Mapping[str, str]
    told: tuple[str, ...] = ()

    __repr__ = line("study", "fingerprint")

    @cached_property
    def packed(self) -> bytes:
        """As bytes to be sent."""
        return pickle.dumps(self, protocol=5)

    @property
    def key(self) -> str:
        """What tells it from other recipes."""
        return hashlib.sha256(self.packed).hexdigest()


def recipe_of(study: Study) -> Recipe:
    """The recipe of a study.

    Raises:
        UnknownNameError: no such robot, variant, trajectory, controller, gain or path.
        InputError: they do not fit each other, or a range is none of its path.
        DescriptionError: the robot's files are wrong.
    """
    cases, told, robots = [], dict[str, None](), []
    for variant in study.variants:
        model, robot = _model(study, variant)
        robots.append(robot)
        ways = {one: _trajectory(study, model, one) for one in study.trajectories}
        laws = [_with_gains(study, one, model, told) for one in study.laws]
        for (way, path), own, (built, hardware) in product(ways.items(), laws, study.hardware):
            parts = {
                variant: study.variants, way: study.trajectories, own.name: study.laws, built: study.hardware
            }  # fmt: skip
            name = ", ".join(str(part or "own") for part, every in parts.items() if len(every) > 1)
            spreads = tuple(_spreads(study, model, own, hardware))
            cases.append(StudyCase(name, robot, variant, path, own, hardware, spreads))
    names = [one.name for one in cases]
    cases = [one if names.count(one.name) == 1 else _numbered(one, k) for k, one in enumerate(cases)]
    prints = [PUBLISHED_PRINT.format(study.robot) if one is None else _fingerprint(one) for one in robots]
    return Recipe(study, tuple(cases), " ".join(prints), _motions(study), tuple(told))


PUBLISHED_PRINT = "published {}"


def model_of(study: Study, case: StudyCase) -> Mechanism:
    """The robot of a case, not compiled."""
    return published(study.robot) if case.robot is None else ClosedChain(case.robot)


def inside_of(study: Study, case: StudyCase, model: Mechanism) -> Mechanism:
    """What the controller of a case believes."""
    return _inside(study, case.law, model)


def law_of(study: Study, case: StudyCase, inside: Mechanism) -> Law:
    """The control law of a case."""
    return law(case.law.name, inside, case.law.gains)


def reference_of(study: Study, case: StudyCase, inside: Mechanism) -> Reference:
    """What is followed; it stays within the limits of the joints."""
    return Reference(case.trajectory, inside, study.duration)


def _motions(study: Study) -> dict[str, str]:
    files = [one for one in study.trajectories if is_file(one)]
    return {Path(one).name: hashlib.sha256(read_file(one, LARGEST_MOTION)).hexdigest() for one in files}


def _numbered(case: StudyCase, k: int) -> StudyCase:
    return StudyCase(f"{case.name} {k + 1}", case.robot, case.variant, case.trajectory, case.law, case.hardware,
                     case.spreads)  # fmt: skip


def _fingerprint(robot: RobotDescription) -> str:
    """That of the motion, and of the tool."""
    tool = "" if robot.tool is None else hashlib.sha256(pickle.dumps(robot.tool)).hexdigest()[:4]
    return fingerprint(robot) + tool


def _model(study: Study, variant: str | None) -> tuple[Mechanism, RobotDescription | None]:
    if study.model == "published":
        return published(study.robot), None
    robot = load_description(study.robot, variant)
    robot = robot.ideal() if study.ideal else robot
    chain = ClosedChain(robot)
    if chain.n == 0:
        raise InputError(f"{chain.name} has no actuator that could follow anything; add some to its description")
    return chain, robot


def _inside(study: Study, own: FollowingLaw, model: Mechanism) -> Mechanism:
    if isinstance(model, ClosedFormModel):
        return model
    assert isinstance(model, ClosedChain)
    name = model.description.name
    if own.believes == "published":
        return published(name)
    if own.believes == "chain" or name not in PUBLISHED or model.description.acting:
        return model
    return published(name)


def _trajectory(study: Study, model: Mechanism, spec: str) -> Trajectory:
    """A trajectory by its words; none is the paper's, or a small motion about home."""
    name = model.description.name if isinstance(model, ClosedChain) else study.robot
    row = PUBLISHED.get(name)
    if spec == "paper" or (not spec and row is not None and row.path is not None):
        if row is None or row.path is None:
            raise InputError(f"{name} has no published trajectory; give another")
        return row.trajectory()
    return trajectory(spec or "about-home", model)


def _with_gains(study: Study, own: FollowingLaw, model: Mechanism, told: dict[str, None]) -> FollowingLaw:
    """A controller whose gains are all given: usual ones where the study gives none."""
    row = law_row(own.name)
    if unknown := [name for name in own.gains if name not in row.gains]:
        raise UnknownNameError(f"gain of controller '{own.name}'", unknown[0], list(row.gains))
    gains: dict[str, npt.ArrayLike] = dict(own.gains)
    varied = [one.path.removeprefix(GAINS) for one in study.varied if one.path.startswith(GAINS)]
    missing = [name for name in row.needed if name not in gains]
    if missing and not gains and set(row.gains) <= {"kp", "ki", "kd"}:
        found = COMPUTED_TORQUE if own.name == "computed-torque" else usual_gains(_inside(study, own, model))
        gains = {name: found[name] for name in row.gains}
        told[f"{own.name}: gains for {SPEED:g} rad/s with the inertia of every actuator at home"] = None
    elif missing:
        raise InputError(f"controller '{own.name}' needs {', '.join(missing)} under [controller.gains]")
    for name in varied:
        if name not in row.gains:
            raise UnknownNameError(f"gain of controller '{own.name}' that varies", name, list(row.gains))
    return FollowingLaw(own.name, gains, own.believes)


def _spreads(study: Study, model: Mechanism, own: FollowingLaw, hardware: Hardware | None) -> Iterator[Spread]:
    """Where values come from, with "relative" as ranges.

    Raises:
        UnknownNameError: no such path.
        InputError: a path names several numbers, is 0 where it shall vary by a part, or its range cannot be.
    """
    for one in study.varied:
        nominal = nominal_of(model, own.gains, hardware, one.path)
        if one.spread.kind == "relative" and nominal == 0.0:
            what = model.name if is_of_robot(one.path) else "the study"
            raise InputError(f"{one.path} is 0 in {what}, so it cannot vary by a part of it; give uniform = [..]")
        spread = one.spread.about(nominal)
        for bound in spread.bounds:
            check_bound(model, hardware, one.path, bound, spread)
        yield spread
