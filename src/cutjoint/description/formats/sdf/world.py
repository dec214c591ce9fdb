"""What an SDF says outside of links and joints: gravity, and what of a world and of other programs is not read."""

from __future__ import annotations

from collections.abc import Iterable

from cutjoint.description.formats.common.extras import EARTH
from cutjoint.description.formats.sdf.dynamics import ROTORS
from cutjoint.description.formats.sdf.scope import Scope
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.numbers import read_numbers
from cutjoint.description.xml import Element, children, drake_name, only_child
from cutjoint.findings import Findings, clip

_DEFAULT = (0.0, 0.0, -9.8)
"""m/s2 where a world says nothing, by the specification."""
_UNUSED = ("state", "population", "actor")
_HARMLESS = frozenset({"collision_filter_group", "proximity_properties", "diffuse_map", "accepting_renderer"})
_HARMLESS |= frozenset({"perception_properties", "illustration_properties", "convex", "visual", "declare_convex"})


def gravity_of(outer: Scope) -> tuple[float, ...]:
    """That of the world [m/s2], or of the earth where there is a model alone."""
    if outer.element.tag != "world":
        return tuple(map(float, EARTH))
    physics = next(children(outer.element, "physics"), None)
    for place in (outer.element, physics):
        element = None if place is None else only_child(place, "gravity", outer.findings)
        if element is not None:
            values = read_numbers(element.text, 3, "<gravity>", outer.findings, element.sourceline)
            return values or _DEFAULT
    return _DEFAULT


def note_world(outer: Scope) -> None:
    """Note the elements of a world that move things and are not read."""
    for tag in _UNUSED:
        for element in children(outer.element, tag):
            found = f"<{tag}> in a world is not read"
            outer.findings.warn(found, "models as they stand in the world", "", element.sourceline)


def note_foreign(scopes: Iterable[Scope]) -> None:
    """Note model states, and the elements of Drake's that act and are not read."""
    for scope in scopes:
        for element in children(scope.element, "model_state"):
            scope.findings.warn("<model_state> in a model is not read", "<pose>", "", element.sourceline)
        if scope.is_model:
            _drake(scope.element, scope.findings)


def _drake(element: Element, findings: Findings) -> None:
    for child in children(element):
        name = drake_name(str(child.tag))
        if name is None:
            if child.tag in ("joint", "link", "axis", "axis2"):
                _drake(child, findings)
        elif name not in _HARMLESS and not (name in ROTORS and element.tag == "joint"):
            inside = ", ".join(clip(text_of(one), 20) for one in children(child))
            found = f"<drake:{clip(name)}> ({clip(inside)}) is not read"
            findings.doubt(found, "joints, <mimic> and <dynamics> of SDF", "", child.sourceline)
