"""The numbers of a description at their paths (`cutjoint.description.paths`): read, and changed in a copy.

Roll, pitch and yaw are turns about fixed axes, as in a URDF; one alone is set with the other two as the rotation has
them.  A spring that nobody gave a place of rest reads 0, a friction without a speed the default.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.description.curves import Polynomial
from cutjoint.description.model import Coupling, CutJoint, Frame, Inertial, Joint, JointPhysics, Link, RobotDescription
from cutjoint.description.paths import PHYSICS, PLACE, TENSOR, Path, numbers_at
from cutjoint.description.transforms import from_rotation, rotation_from_rpy, rpy_from_rotation
from cutjoint.errors import InputError


def value(robot: RobotDescription, path: str) -> float | Array:
    """The number at a path, or the numbers, shape (3,) or (6,), where it names several.

    Raises:
        UnknownNameError: there is none; it names the nearest path.
    """
    found = numbers_at(robot, path)
    return number(robot, found[0]) if len(found) == 1 else np.array([number(robot, one) for one in found])


def number(robot: RobotDescription, path: Path) -> float:
    """The number at a path that is known to be there."""
    head, _, last = path.field.rpartition(".")
    match path.part:
        case "links":
            inertial = robot.link(path.name).inertial or Inertial(0.0)
            if head == "":
                return float(inertial.mass)
            return float(inertial.com[PLACE.index(last)] if head == "com" else inertial.entries[TENSOR.index(last)])
        case "gravity":
            return float(robot.gravity[PLACE.index(last)])
        case "couplings":
            coupling = next(one for one in robot.couplings if one.name == path.name)
            return coupling.gear[1] if last == "ratio" and coupling.gear else coupling.offset
    if last in PLACE:
        return place_of(placement_at(robot, path))[PLACE.index(last)]
    if last == "length":
        return _cut(robot, path.name).length
    if head == "bushing":
        return float(getattr(_cut(robot, path.name).bushing, last))
    physics = physics_of(robot, path)
    found = physics.speed if last == "friction_speed" else getattr(physics, last)
    return 0.0 if found is None else float(found)


def physics_of(robot: RobotDescription, path: Path) -> JointPhysics:
    """What the joint or cut of a path does by itself."""
    return (robot.joint(path.name) if path.part == "joints" else _cut(robot, path.name)).physics


def placement_at(robot: RobotDescription, path: Path) -> Array:
    """The placement (4, 4) that a path into one is in."""
    if path.part == "joints":
        return robot.joint(path.name).placement
    if path.part == "cuts":
        cut = _cut(robot, path.name)
        return (cut.a if path.field.startswith("a.") else cut.b).placement
    assert robot.tool is not None, "see `numbers_at`"
    return robot.tool.placement


def place_of(placement: Array) -> tuple[float, ...]:
    """x, y, z, roll, pitch, yaw of a placement (4, 4)."""
    return (*placement[:3, 3].tolist(), *rpy_from_rotation(placement[:3, :3]))


def scalars(robot: RobotDescription, values: Mapping[str, npt.ArrayLike]) -> dict[Path, Array]:
    """Values by path as values of single numbers: what names several has their values along its last axis.

    Raises:
        UnknownNameError: no such path.
        InputError: wrong shape, not finite, or negative where that means nothing.
    """
    found: dict[Path, Array] = {}
    for text, given in values.items():
        named = numbers_at(robot, text)
        try:
            array = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"{text} must be numbers, found {given!r}") from error
        if len(named) > 1 and array.shape[-1:] != (len(named),):
            raise InputError(f"{text} must be {len(named)} numbers, found shape {array.shape}")
        for k, path in enumerate(named):
            if path in found:
                raise InputError(f"{path} is given twice")
            found[path] = array if len(named) == 1 else array[..., k]
            path.check(found[path])
    return found


def with_values(robot: RobotDescription, values: Mapping[str, npt.ArrayLike]) -> RobotDescription:
    """A copy of a robot with other numbers at some paths.

    Whether a body can have its inertia is for `check` to say.

    Raises:
        UnknownNameError: no such path; it names the nearest one.
        InputError: wrong shape, not finite, or negative where that means nothing.
    """
    by_thing: dict[tuple[str, str], dict[str, float]] = {}
    for path, given in scalars(robot, values).items():
        if given.ndim:
            raise InputError(f"{path} must be one number, found shape {given.shape}")
        by_thing.setdefault((path.part, path.name), {})[path.field] = float(given)

    def changes(part: str, name: str) -> dict[str, float]:
        return by_thing.get((part, name), {})

    gravity, tool = changes("gravity", ""), changes("tool", "")
    return replace(
        robot,
        links=tuple(_link(one, changes("links", one.name)) for one in robot.links),
        joints=tuple(_joint(one, changes("joints", one.name)) for one in robot.joints),
        cuts=tuple(_changed_cut(one, changes("cuts", one.name)) for one in robot.cuts),
        couplings=tuple(_coupling(one, changes("couplings", one.name)) for one in robot.couplings),
        tool=None if robot.tool is None else _frame(robot.tool, tool),
        gravity=np.array([gravity.get(axis, old) for axis, old in zip("xyz", robot.gravity.tolist(), strict=True)]),
    )


# -- inside ----------------------------------------------------------------------------------------------------------


def _cut(robot: RobotDescription, name: str) -> CutJoint:
    return next(cut for cut in robot.cuts if cut.name == name)


def _part(values: Mapping[str, float], prefix: str) -> dict[str, float]:
    """Those values whose field is under a prefix, without it."""
    return {field[len(prefix) + 1 :]: x for field, x in values.items() if field.startswith(f"{prefix}.")}


def _placed(old: Array, values: Mapping[str, float]) -> Array:
    """A placement with other numbers; a rotation of which nothing is given stays as it is."""
    if not values:
        return old
    place = [values.get(name, x) for name, x in zip(PLACE, place_of(old), strict=True)]
    turned = any(name in values for name in PLACE[3:])
    return from_rotation(rotation_from_rpy(place[3:]) if turned else old[:3, :3], place[:3])


def _frame(old: Frame, values: Mapping[str, float]) -> Frame:
    return replace(old, placement=_placed(old.placement, values))


def _link(old: Link, values: Mapping[str, float]) -> Link:
    if not values:
        return old
    inertial = old.inertial or Inertial(0.0)
    com = [_part(values, "com").get(axis, x) for axis, x in zip(PLACE, inertial.com.tolist(), strict=False)]
    entries = [_part(values, "inertia").get(name, x) for name, x in zip(TENSOR, inertial.entries, strict=True)]
    return replace(old, inertial=Inertial.of(values.get("mass", inertial.mass), com, entries))


def _physics(old: JointPhysics, values: Mapping[str, float]) -> JointPhysics:
    return replace(old, **{field: x for field, x in values.items() if field in PHYSICS})


def _joint(old: Joint, values: Mapping[str, float]) -> Joint:
    if not values:
        return old
    return replace(
        old, placement=_placed(old.placement, _part(values, "origin")), physics=_physics(old.physics, values)
    )


def _changed_cut(old: CutJoint, values: Mapping[str, float]) -> CutJoint:
    if not values:
        return old
    a, b = _frame(old.a, _part(values, "a")), _frame(old.b, _part(values, "b"))
    changed = replace(old, a=a, b=b, physics=_physics(old.physics, values), length=values.get("length", old.length))
    return (
        changed if old.bushing is None else replace(changed, bushing=replace(old.bushing, **_part(values, "bushing")))
    )


def _coupling(old: Coupling, values: Mapping[str, float]) -> Coupling:
    drives = old.drives
    if "ratio" in values:
        drives = (replace(drives[0], curve=Polynomial((0.0, values["ratio"]))),)
    return replace(old, drives=drives, offset=values.get("offset", old.offset))
