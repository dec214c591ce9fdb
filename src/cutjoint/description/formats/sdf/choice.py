"""Which models of an SDF are the robot: those that move, with all that joints of the world tie to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cutjoint.description.formats.sdf.scope import KINDS, Item, Scope
from cutjoint.description.formats.sdf.values import WORLD, text_of
from cutjoint.description.xml import only_child
from cutjoint.findings import listing


@dataclass(frozen=True, eq=False)
class Picked:
    """The models of one robot and all its joints.

    `base_only`: it is a single model, which is static: what is meant is that its base does not move.
    """

    models: Sequence[Scope]
    joints: list[Item]
    name: str
    base_only: bool


def chosen(outer: Scope) -> Picked | None:
    """The robot of a file, or None after noting why there is not just one."""
    groups = _groups(outer)
    moving = [group for group in groups if not all(model.static for model in group)]
    robots = moving or groups
    if len(robots) != 1:
        models = [model for group in groups for model in group]
        found = f"{len(models)} models: {listing(model.name for model in models)}"
        mend = "keep the robot only, or mark what does not belong to it <static>true</static>"
        if not (outer.findings.failed and not models):
            outer.findings.error(found, "one model that moves, or models that joints connect", mend, _line(outer))
        return None
    robot = robots[0]
    scenery = [group[0].name for group in groups if group is not robot]
    if scenery:
        found = f"left out beside the robot: {listing(scenery)}, which no joint ties to it"
        outer.findings.warn(found, "", "", _line(outer))
    if len(robot) > 1:
        for model in robot:
            model.prefix = model.name
    name = robot[0].name if len(robot) == 1 else str(outer.element.get("name") or "")
    between = [item for item in outer.items if item.kind == "joint" and _tops(item, outer) & set(robot)]
    joints = [item for model in robot for item in model.each("joint")] + between
    return Picked(robot, joints, name, len(robot) == 1 and robot[0].static)


def _line(outer: Scope) -> int | None:
    line: int | None = outer.element.sourceline
    return line


def _groups(outer: Scope) -> list[list[Scope]]:
    """The models of the outermost scope, those together that its joints tie to each other."""
    models = [item.model for item in outer.items if item.model is not None]
    group = {model: [model] for model in models}
    for item in outer.items:
        ends = [*_tops(item, outer)] if item.kind == "joint" else []
        for other in ends[1:]:
            first, second = group[ends[0]], group[other]
            if first is not second:
                first += second
                group.update(dict.fromkeys(second, first))
    found = list({id(one): one for one in group.values()}.values())
    return [sorted(one, key=models.index) for one in found]


def _tops(joint: Item, outer: Scope) -> set[Scope]:
    """The models of the outermost scope that a joint of it names."""
    names = [text_of(only_child(joint.element, tag, outer.findings)) for tag in ("parent", "child")]
    seen: set[Item] = set()
    return {top for name in names if (top := _top(name, outer, seen)) is not None}


def _top(name: str, outer: Scope, seen: set[Item]) -> Scope | None:
    item = None if name in ("", WORLD) else outer.find(name, KINDS)
    if item is None:
        return None
    scope = item.model or item.scope
    if scope is outer:
        if item in seen:
            return None
        seen.add(item)
        to = item.child if item.kind == "joint" else str(item.element.get("attached_to") or "").strip()
        return _top(to, outer, seen)
    while scope.above is not None and scope.above is not outer:
        scope = scope.above
    return scope
