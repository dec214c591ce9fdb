"""Paths: the name of every number of a description.

    links.NAME      mass, com.x .y .z, inertia.xx .yy .zz .xy .xz .yz (about the centre of mass, along the link's axes)
    joints.NAME     origin.x .y .z .roll .pitch .yaw, and the joint's physics: damping, friction, stiffness, gear, ...
    cuts.NAME       a.x ... a.yaw, b.x ... b.yaw, its physics; bushing.stiffness ... where it is a bushing; length of a
                    distance
    couplings.NAME  offset, and ratio where one joint drives it in a fixed ratio
    tool            x .y .z .roll .pitch .yaw
    gravity         x .y .z

Only what does something has a path: no damping of what does not move, no rotor of a cut, no stops without limits.
Some paths are several numbers: `com`, `inertia`, `origin.xyz`, `origin.rpy`, `a.xyz`, ..., `gravity`.  A name may hold
dots.  What stands at a path is read and changed by `cutjoint.description.values`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from cutjoint.description.cuts import Freedom
from cutjoint.description.model import Bushing, CutJoint, Joint, JointPhysics, JointType, RobotDescription
from cutjoint.errors import InputError, UnknownNameError

PLACE = ("x", "y", "z", "roll", "pitch", "yaw")
"""A placement: [m] and [rad]."""
TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
"""An inertia [kg m2], as `Inertial.entries` has it."""
PHYSICS = tuple(one.name for one in fields(JointPhysics))
BUSHING = tuple(one.name for one in fields(Bushing))
_STOPS = ("stop_stiffness", "stop_damping")
_MOTOR = ("rotor", "gear", *_STOPS)
_SIGNED = {"rest", "gear", "ratio", "offset"}
"""What may be negative of what is no place, moment or inertia."""


def _under(prefix: str, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{prefix}.{name}" for name in names)


FIELDS: Mapping[str, tuple[str, ...]] = {
    "links": ("mass", *_under("com", PLACE[:3]), *_under("inertia", TENSOR)),
    "joints": (*_under("origin", PLACE), *PHYSICS),
    "cuts": (*_under("a", PLACE), *_under("b", PLACE), *PHYSICS, *_under("bushing", BUSHING), "length"),
    "couplings": ("ratio", "offset"),
    "tool": PLACE,
    "gravity": PLACE[:3],
}
"""Part of a description -> the numbers of one of its things."""
_PLACES = {"xyz": PLACE[:3], "rpy": PLACE[3:]}
GROUPS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "links": {"com": _under("com", PLACE[:3]), "inertia": _under("inertia", TENSOR)},
    "joints": {f"origin.{name}": _under("origin", few) for name, few in _PLACES.items()},
    "cuts": {f"{side}.{name}": _under(side, few) for side in "ab" for name, few in _PLACES.items()},
    "couplings": {},
    "tool": _PLACES,
    "gravity": {"": PLACE[:3]},
}
"""Part of a description -> names for several of these numbers at once."""
_NAMELESS = ("tool", "gravity")


@dataclass(frozen=True)
class Path:
    """Where one number stands.

    Attributes:
        part: `links`, `joints`, `cuts`, `couplings`, `tool` or `gravity`.
        name: of the link, joint, cut or coupling; empty for the tool and gravity.
        field: which of its numbers, one of `FIELDS`.
    """

    part: str
    name: str
    field: str

    def __str__(self) -> str:
        return ".".join(one for one in (self.part, self.name, self.field) if one)

    @property
    def of(self) -> str:
        """The thing that the number belongs to: the path without its last name."""
        return str(self).rpartition(".")[0]

    @property
    def last(self) -> str:
        """Its last name: `mass`, `x`, `yaw`, `damping`."""
        return self.field.rpartition(".")[2]

    @property
    def never_negative(self) -> bool:
        """Whether a value below zero means nothing."""
        return not (self.last in PLACE or self.last in TENSOR[3:] or self.field in _SIGNED)

    def check(self, values: npt.ArrayLike) -> None:
        """Check values, of any shape, that the number shall have.

        Raises:
            InputError: not finite, negative where that means nothing, or a gear or a length of 0.
        """
        numbers = np.asarray(values, dtype=np.float64)
        if not np.isfinite(numbers).all():
            raise InputError(f"{self} must be finite, found {numbers[~np.isfinite(numbers)].flat[0]}")
        if self.never_negative and (numbers < 0.0).any():
            raise InputError(f"{self} must be >= 0, found {float(numbers.min()):g}")
        if self.field == "gear" and (numbers == 0.0).any():
            raise InputError(f"{self} must be how many times as fast the rotor moves, found 0; 1 without a gear")
        if self.field == "length" and (numbers == 0.0).any():
            raise InputError(f"{self} must be > 0 m, found 0; a spherical cut holds two points together")


def paths(robot: RobotDescription) -> tuple[str, ...]:
    """Paths of all numbers of a robot, one by one."""
    return tuple(map(str, every_path(robot)))


def every_path(robot: RobotDescription) -> tuple[Path, ...]:
    """The same as values."""
    return tuple(Path(part, name, field) for part, name in _things(robot) for field in fields_of(robot, part, name))


def numbers_at(robot: RobotDescription, path: str) -> tuple[Path, ...]:
    """The numbers that a path means: one, or several where it names several.

    Raises:
        UnknownNameError: there is none; it names the nearest path.
        InputError: it is no text.
    """
    if not isinstance(path, str):
        raise InputError(f"a path is text such as 'links.NAME.mass', found {path!r}")
    things = list(_things(robot))
    for part, name in sorted(things, key=lambda thing: -len(thing[1])):
        start = ".".join(one for one in (part, name) if one)
        if path != start and not path.startswith(f"{start}."):
            continue
        field, known = path[len(start) + 1 :], fields_of(robot, part, name)
        if field in known:
            return (Path(part, name, field),)
        if field in GROUPS[part]:
            return tuple(Path(part, name, one) for one in GROUPS[part][field])
    every = [*paths(robot), *(str(Path(*thing, group)) for thing in things for group in GROUPS[thing[0]])]
    near = difflib.get_close_matches(path, every, n=5, cutoff=0.0)
    raise UnknownNameError(f"path into the description of {robot.name}", path, near)


# -- inside ----------------------------------------------------------------------------------------------------------


def _things(robot: RobotDescription) -> Iterator[tuple[str, str]]:
    """(part, name) of everything that has numbers."""
    for part, all_of in (
        ("links", robot.links), ("joints", robot.joints), ("cuts", robot.cuts), ("couplings", robot.couplings),
    ):  # fmt: skip
        yield from ((part, one.name) for one in all_of)
    yield from ((part, "") for part in _NAMELESS if part != "tool" or robot.tool is not None)


def fields_of(robot: RobotDescription, part: str, name: str) -> tuple[str, ...]:
    """The numbers of one of its things, those that do something."""
    unused: tuple[str, ...] = ()
    if part == "joints":
        unused = _unused_of_joint(robot.joint(name))
    elif part == "cuts":
        unused = _unused_of_cut(next(cut for cut in robot.cuts if cut.name == name))
    elif part == "couplings":
        unused = () if next(one for one in robot.couplings if one.name == name).gear else ("ratio",)
    return tuple(field for field in FIELDS[part] if field not in unused)


def _unused_of_joint(joint: Joint) -> tuple[str, ...]:
    """What of its physics does nothing, whatever number it has."""
    kind, limits = joint.type, joint.limits
    if not kind.moves:
        return PHYSICS
    if not kind.single and any(kind.lengths):
        return tuple(name for name in PHYSICS if name != "damping")
    stops = kind.single and limits.bounded
    return (*(() if stops else _STOPS), *(("rest",) if kind is JointType.SPHERICAL else ()))


def _unused_of_cut(cut: CutJoint) -> tuple[str, ...]:
    """The same; a bushing moves every way by itself, and a rigid cut has none."""
    freedoms, without = cut.type.freedoms, () if cut.type.has_length else ("length",)
    if cut.bushing is not None:
        turns = any(not one.is_length for one in cut.type.equations)
        return (*without, *PHYSICS, *(() if turns else _under("bushing", BUSHING[2:])))
    ball = ("rest",) if Freedom.BALL in freedoms else ()
    return (*without, *_under("bushing", BUSHING), *((*_MOTOR, *ball) if freedoms else PHYSICS))
