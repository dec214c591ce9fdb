"""The `<plugin>`s of an SDF that act on joints.

Gazebo's joint controllers are actuators, its plugin for joints that mimic others is a coupling.  One that closes loops
or couples joints otherwise is refused; others that name a joint are noted.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from cutjoint.description.findings import clip
from cutjoint.description.formats.sdf.scope import Scope
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.model import Coupling, Place
from cutjoint.description.numbers import read_numbers
from cutjoint.description.xml import Element, check_known, children, only_child

_WORD = re.compile("[^a-z0-9]")
_DRIVES = re.compile("joint(position|velocity|trajectory|)controller|applyjointforce")
_READS = ("publisher", "jointstate", "odometry", "sensor", "video", "logger")
_BINDS = re.compile("attach|detach|loop|clos|constraint|gear|tendon|cable|spring|mimic|coupl|differential|grasp|vacuum")
_MIMIC = frozenset({"joint", "mimicJoint", "multiplier", "offset", "sensitiveness", "maxEffort", "hasPID"})
_MIMIC_IGNORED = frozenset({"robotNamespace"})


@dataclass
class Plugged:
    """What plugins do: full names of driven joints, and couplings."""

    driven: list[str] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)


def read_plugins(scopes: Sequence[Scope]) -> Plugged:
    """All plugins of models and worlds, with a note on each that acts and is not read."""
    acting = Plugged()
    for scope in scopes:
        elements = [*children(scope.element, "plugin")]
        elements += [one for item in scope.items for one in item.element.iter("plugin") if item.kind != "model"]
        for element in elements:
            _read(element, scope, acting)
    return acting


def _read(element: Element, scope: Scope, acting: Plugged) -> None:
    name, file = str(element.get("name") or ""), str(element.get("filename") or "")
    kind = _WORD.sub("", f"{file} {name}".lower())
    what = f"plugin '{clip(name or file)}'"
    line, findings = element.sourceline, scope.findings
    if any(word in kind for word in _READS):
        return
    if "mimicjoint" in kind:
        _mimic(element, what, scope, acting)
    elif _DRIVES.search(kind):
        names = [text_of(one) for one in element.iter("joint_name")]
        for joint in names:
            item = scope.look(joint, ("joint",), f"{what} drives the unknown joint", line)
            if item is not None and item.full not in acting.driven:
                acting.driven.append(item.full)
        if not names:
            findings.warn(f"{what}, which names no joints, is not read", "<joint_name>", "", line)
    elif _BINDS.search(kind):
        inside = ", ".join(f"{one.tag} {text_of(one)}" for one in children(element))
        found = f"{what} ({clip(inside)}), which may hold or couple links, is not read"
        findings.doubt(found, "joints and <mimic>", "write what it does as a joint", line)
    else:
        named = next((one for one in element.iter() if scope.find(text_of(one), ("joint",)) is not None), None)
        if named is not None:
            found = f"{what}, which names joint '{text_of(named)}', is not read"
            findings.warn(found, "joint controllers", "", line)


def _mimic(element: Element, what: str, scope: Scope, acting: Plugged) -> None:
    """The plugin of roboticsgroup: coordinate of mimicJoint = multiplier * that of joint + offset."""
    findings, line = scope.findings, element.sourceline
    check_known(element, frozenset({"name", "filename"}), _MIMIC, _MIMIC_IGNORED, findings)
    ends = []
    for tag in ("joint", "mimicJoint"):
        text = text_of(only_child(element, tag, findings))
        item = scope.look(text, ("joint",), f"<{tag}> of {what} is the unknown joint", line)
        ends += [] if item is None else [item.full]
    values = []
    for tag, default in (("multiplier", "1"), ("offset", "0")):
        part = only_child(element, tag, findings)
        number = read_numbers(default if part is None else part.text, 1, f"{tag} of {what}", findings, line)
        values += [] if number is None else [number[0]]
    if len(ends) == len(values) == 2:
        (driver, joint), (ratio, offset) = ends, values
        place = Place(findings.file, line)
        acting.couplings.append(Coupling.geared(f"{joint}_mimic", joint, driver, ratio, offset, place))
