"""What may be off, and by how much: a deviation of any number that says where the tool is.

Numbers are named by their paths (`cutjoint.description.paths`): places of joints and of the frames of cuts, lengths of
distances, offsets and ratios of couplings, the tool; and `actuators.NAME`, the coordinate of an actuator, such as the
zero of its encoder.  Patterns (`cuts.ball*.b.z`) mean every number that fits, each for itself; an exact name goes
before a pattern.  Paths joined by `=` are one number that stands at all of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

from cutjoint.description.model import RobotDescription
from cutjoint.description.paths import GROUPS, PLACE, Path, every_path, numbers_at
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line

ACTUATORS = "actuators"
"""The part of a path that is no number of the description: the coordinate of an actuator."""
SIGMAS = 3.0
"""Standard deviations of a normal deviation that count as its bound."""


@dataclass(frozen=True)
class Deviation:
    """How far a number may be off its own value.

    Attributes:
        size: half the width of a uniform deviation, or the standard deviation of a normal one, [m] or [rad]; of a ratio
            in its own unit.
        normal: whether it is a normal one.
    """

    size: float
    normal: bool = False

    __repr__ = line(size="m or rad")

    def __post_init__(self) -> None:
        if isinstance(self.size, bool) or not isinstance(self.size, int | float):
            raise InputError(f"the size of a deviation must be a number >= 0, found {described(self.size)}")
        if not (math.isfinite(self.size) and self.size >= 0.0):
            raise InputError(f"the size of a deviation must be finite and >= 0, found {self.size!r}")

    @property
    def bound(self) -> float:
        """The most that is reckoned with: half the width, or three standard deviations."""
        return SIGMAS * self.size if self.normal else self.size

    @property
    def sigma(self) -> float:
        """Standard deviation."""
        return self.size if self.normal else self.size / math.sqrt(3.0)


Deviations = Mapping[str, "Deviation | float"]
"""Path, pattern or joined paths -> deviation; a number is half the width of a uniform one."""


@dataclass(frozen=True)
class ErrorSource:
    """A number that may be off.

    Attributes:
        name: its path, or its paths joined by ` = `.
        places: where it stands.
        kind: `length`, `angle` or `ratio`.
    """

    name: str
    places: tuple[Path, ...]
    kind: str

    __repr__ = line("name", "kind")

    @property
    def unit(self) -> str:
        """Of the number: m, rad, or nothing that can be told."""
        return {"length": "m", "angle": "rad"}.get(self.kind, "")


def sources(robot: RobotDescription, names: list[str]) -> tuple[ErrorSource, ...]:
    """The numbers that names mean, in their order.

    Raises:
        UnknownNameError: nothing is called so; the nearest is named.
        InputError: a number that does not say where the tool is, or one that is named twice.
    """
    return tuple(source for source, _ in _resolved(robot, names))


def deviating(robot: RobotDescription, given: Deviations) -> tuple[tuple[ErrorSource, ...], tuple[Deviation, ...]]:
    """The numbers that may be off, and how far.

    Raises:
        UnknownNameError, InputError: as `sources`, no deviation, or none at all.
    """
    found = _resolved(robot, list(given))
    if not found:
        raise InputError("no tolerance is given; name a path and how far it may be off, such as 'tool.z': 1e-4")
    places = [_told(path) for source, _ in found for path in source.places]
    if twice := sorted({one for one in places if places.count(one) > 1}):
        raise InputError(f"'{twice[0]}' has two tolerances: alone and joined by '=', or in two that are joined")
    many = [given[key] for _, key in found]
    wrong = [one for one in many if not isinstance(one, Deviation | int | float) or isinstance(one, bool)]
    if wrong:
        raise InputError(f"a tolerance is a number [m] or [rad], or a Deviation, found {described(wrong[0])}")
    sized = tuple(one if isinstance(one, Deviation) else Deviation(one) for one in many)
    return tuple(source for source, _ in found), sized


def _resolved(robot: RobotDescription, names: list[str]) -> list[tuple[ErrorSource, str]]:
    """Every number with the name by which it was meant; exact names go before patterns."""
    if robot.tool is None:
        raise InputError(f"{robot.name} has no tool frame; name one under [tool] in its loops.toml")
    every = {str(path): path for path in every_path(robot) if _moves(robot, path)}
    every |= {f"{ACTUATORS}.{name}": Path(ACTUATORS, name, "") for name in robot.actuators}
    groups = [
        str(Path(part, name, group))
        for part, name in dict.fromkeys((path.part, path.name) for path in every.values())
        for group in GROUPS.get(part, ())
        if group not in ("", "com", "inertia")
    ]
    exact, patterns = dict[str, tuple[ErrorSource, str]](), dict[str, tuple[ErrorSource, str]]()
    for name in names:
        if not isinstance(name, str):
            raise InputError(f"a tolerance is of a path such as 'tool.x', found {described(name)}")
        matched = [one for one in (*every, *groups) if fnmatchcase(one, name)] if name not in every else []
        if matched and name not in groups and any(sign in name for sign in "*?["):
            singles = [one for one in matched if one in every] or matched
            level, found = patterns, [one for single in singles for one in _joined(robot, single, every)]
        else:
            level, found = exact, _joined(robot, name, every)
        for source in found:
            if source.name in level:
                raise InputError(f"'{source.name}' has two tolerances, by '{level[source.name][1]}' and by '{name}'")
            level[source.name] = source, name
    taken = {str(path) for source, _ in exact.values() for path in source.places}
    rest = [pair for pair in patterns.values() if str(pair[0].places[0]) not in taken]
    return sorted([*exact.values(), *rest], key=lambda pair: names.index(pair[1]))


def _joined(robot: RobotDescription, name: str, every: Mapping[str, Path]) -> list[ErrorSource]:
    parts = [_numbers(robot, one.strip(), every) for one in name.split("=")] if name not in every else [[every[name]]]
    if len({len(part) for part in parts}) > 1:
        raise InputError(f"'{name}' joins paths that are not as many numbers each")
    made = []
    for places in zip(*parts, strict=True):
        kinds = {_kind(robot, path) for path in places}
        if len(kinds) > 1:
            raise InputError(f"'{name}' joins numbers of different kinds: {' and '.join(sorted(kinds))}")
        made.append(ErrorSource(" = ".join(_told(path) for path in places), tuple(places), kinds.pop()))
    return made


def _numbers(robot: RobotDescription, name: str, every: Mapping[str, Path]) -> list[Path]:
    if name in every:
        return [every[name]]
    if name.startswith(f"{ACTUATORS}."):
        raise UnknownNameError(f"actuator of {robot.name}", name.partition(".")[2], list(robot.actuators))
    try:
        found = list(numbers_at(robot, name))
    except UnknownNameError as error:
        raise UnknownNameError(f"number of {robot.name} that places the tool", name, [*error.known, *every]) from None
    for path in found:
        if str(path) not in every:
            why = "a bushing closes no loop" if path.part == "cuts" else "it is no length or angle of the mechanism"
            raise InputError(
                f"'{path}' of {robot.name} does not say where the tool is while the actuators hold: {why}; the "
                "stiffness tells what weights and springs do"
            )
    return found


def _told(path: Path) -> str:
    return f"{path.part}.{path.name}" if path.part == ACTUATORS else str(path)


def _moves(robot: RobotDescription, path: Path) -> bool:
    """Whether a number of the description says where the tool is."""
    if path.part == "cuts" and next(cut for cut in robot.cuts if cut.name == path.name).bushing is not None:
        return False
    return (
        path.part in ("couplings", "tool")
        or path.field.rpartition(".")[0] in ("origin", "a", "b")
        or (path.field == "length")
    )


def _kind(robot: RobotDescription, path: Path) -> str:
    if path.part == ACTUATORS:
        return "length" if robot.joint(path.name).type.slides else "angle"
    if path.part == "couplings":
        coupling = next(one for one in robot.couplings if one.name == path.name)
        if path.field == "ratio":
            return "ratio"
        return "length" if robot.joint(coupling.joint).type.slides else "angle"
    return "length" if path.last in (*PLACE[:3], "length") else "angle"
