"""The names of SDF: every element and attribute of a file is one of the specification's, or is noted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from cutjoint.description.formats.sdf.values import Version
from cutjoint.description.xml import Element, children
from cutjoint.findings import Findings, clip, closest

_DECOR = frozenset(
    {"visual", "collision", "sensor", "light", "projector", "audio", "audio_sink", "audio_source", "battery", "gripper"}
    | {"particle_emitter", "gui", "scene", "physics", "actor", "road", "atmosphere", "wind", "spherical_coordinates"}
    | {"population", "magnetic_field"}
)
"""Elements in which nothing says how a robot moves: what is unknown there is a warning."""
MOST = 100
"""Unknown names of a file that are told."""
_STATES = frozenset({"state", "model_state"})
_OLD: dict[tuple[str, str], tuple[str, Version, str]] = {
    ("pose", "frame"): ("attribute", (1, 7), "relative_to"),
    ("axis", "use_parent_model_frame"): ("element", (1, 7), '<xyz expressed_in="__model__">'),
    ("axis2", "use_parent_model_frame"): ("element", (1, 7), '<xyz expressed_in="__model__">'),
}
"""(element, name) -> what it is, the version that has it no more, and what it has instead."""


@cache
def _known() -> dict[str, tuple[frozenset[str], frozenset[str]]]:
    """Element, or parent/element -> its attributes and its children."""
    table = {}
    for line in files(__package__).joinpath("elements.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            name, _, rest = line.partition(":")
            words = rest.split()
            attributes = frozenset(word[1:] for word in words if word.startswith("@"))
            table[name] = attributes, frozenset(word for word in words if not word.startswith("@"))
    return table


@dataclass(frozen=True)
class _Unknown:
    """A name that SDF does not have, those it could have been, and whether it is where nothing tells of motion."""

    found: str
    name: str
    known: frozenset[str]
    decor: bool
    line: int | None


def check_names(root: Element, version: Version, findings: Findings) -> None:
    """Note every element and attribute below `root` that SDF does not have, up to `MOST` of them.

    Names with a prefix belong to others, and so does what is inside a `<plugin>`.
    """
    for number, one in enumerate(_unknown(root, version, findings)):
        if number == MOST:
            findings.error(f"more than {MOST} unknown names", "a file of SDF", "is this another format?", one.line)
            return
        near = closest(one.name, one.known, cutoff=0.5)
        expected = f"one of {', '.join(sorted(one.known))}" if one.known else "nothing there"
        mend = f"did you mean '{near}'?" if near else "remove it"
        if one.decor:
            findings.warn(f"unknown {one.found} is ignored", expected, mend, one.line)
        elif near:
            findings.error(f"unknown {one.found}", expected, mend, one.line)
        else:
            findings.doubt(f"unknown {one.found}", expected, mend, one.line)


def _unknown(root: Element, version: Version, findings: Findings) -> Iterator[_Unknown]:
    stack = [(root, "", False)]
    while stack:
        element, parent, decor = stack.pop()
        tag, line = str(element.tag), element.sourceline
        table = _known()
        attributes, tags = table.get(f"{parent}/{tag}") or table.get(tag) or (frozenset(), frozenset())
        for name in map(str, element.attrib):
            if name in attributes:
                _out_of_date(tag, name, version, findings, line)
            elif not _foreign(name):
                yield _Unknown(f"attribute '{clip(name)}' of <{tag}>", name, attributes, decor, line)
        if "*" in tags:
            continue
        within = parent if parent == "state" else "state" if tag in _STATES else tag
        for child in children(element):
            name = str(child.tag)
            if name in tags:
                _out_of_date(tag, name, version, findings, child.sourceline)
                stack.append((child, within, decor or name in _DECOR or within == "state"))
            elif not _foreign(name):
                yield _Unknown(f"element <{clip(name)}> in <{tag}>", name, tags, decor, child.sourceline)


def _foreign(name: str) -> bool:
    return "{" in name or ":" in name


def _out_of_date(tag: str, name: str, version: Version, findings: Findings, line: int | None) -> None:
    kind, since, instead = _OLD.get((tag, name), ("", version, ""))
    if kind and version >= since:
        old = ".".join(map(str, since))
        findings.doubt(f"{kind} {name} of <{tag}>, which SDF {old} has no more", instead, "", line)
