"""The `<plugin>`s of Gazebo that act on joints and links, in an SDF or in the `<gazebo>` of a URDF.

Read are joint controllers (what they drive), mimic plugins with `joint`, `mimicJoint`, `multiplier` and `offset`, as
that of roboticsgroup (https://github.com/roboticsgroup/roboticsgroup_gazebo_plugins) and its relatives, and detachable
joints of Gazebo Sim (gz::sim::systems::DetachableJoint) between two links of the robot, which hold until someone
detaches them.  One that names parts of the robot and by its own name couples or holds something is quoted as a doubt;
others that name a joint are told.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field

from cutjoint.description.model import Coupling, Place
from cutjoint.description.numbers import read_numbers
from cutjoint.description.xml import Element, check_known, children
from cutjoint.findings import Findings, clip, nearest

_APART = re.compile("[^a-z0-9]")
_DRIVES = re.compile("joint(position|velocity|trajectory|)controller|applyjointforce")
_READS = re.compile("publisher|jointstate|odometry|sensor|video|logger|camera|plot|contact|bumper")
_BINDS = re.compile(
    "mimic|attach|detach|loop|clos(ed|ing|ure)|parallel|constrain|coupl|gear(box|ed|ing|joint)|tendon|spring|cable|weld"
    "|linkage|differential(?!drive|steer|wheel)|disablelink"
)
"""What a plugin is called that couples or holds parts, in lower case, without anything between words."""
_MIMIC = frozenset({"joint", "mimicJoint", "multiplier", "offset", "sensitiveness", "maxEffort", "hasPID"})
_MIMIC_IGNORED = frozenset({"robotNamespace"})


@dataclass(frozen=True)
class PluginNames:
    """What the texts in a plugin may mean: functions that give the full name of a joint or link, or None.

    `models` is what the robot's own model is called there, `joints` the names of joints that are suggested.
    """

    joint: Callable[[str], str | None]
    link: Callable[[str], str | None]
    models: Collection[str]
    joints: Collection[str]


@dataclass
class Plugged:
    """What plugins do: joints driven, couplings, and pairs of links (a, b, a name, where) that are held together."""

    driven: list[str] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    held: list[tuple[str, str, str, Place]] = field(default_factory=list)


def read_plugin(element: Element, names: PluginNames, done: Plugged, findings: Findings) -> None:
    """Add to `done` what a `<plugin>` does; one that acts and cannot be read is noted."""
    name, file = str(element.get("name") or ""), str(element.get("filename") or "")
    kind = _APART.sub("", f"{file} {name}".lower())
    what, line = f"plugin '{clip(name or file)}'", element.sourceline
    values = {str(one.tag): str(one.text or "").strip() for one in children(element)}
    joint = next((one for one in _texts(element) if names.joint(one) is not None), None)
    if "mimicjoint" in kind or {"joint", "mimicJoint"} <= values.keys():
        check_known(element, frozenset({"name", "filename"}), _MIMIC, _MIMIC_IGNORED, findings)
        _mimic(values, what, line, names, done, findings)
    elif _READS.search(kind):
        return
    elif _DRIVES.search(kind):
        given = [str(one.text or "").strip() for one in element.iter("joint_name")]
        for one in given:
            full = names.joint(one)
            if full is None:
                findings.error(f"{what} drives the unknown joint '{one}'", "a joint", nearest(one, names.joints), line)
            elif full not in done.driven:
                done.driven.append(full)
        if not given:
            findings.warn(f"{what}, which names no joints, is not read", "<joint_name>", "", line)
    elif "detachablejoint" in kind and _held(values, name, Place(findings.file, line), names, done):
        return
    elif _BINDS.search(kind):
        said = ", ".join(f"<{tag}>{text}" for tag, text in values.items())
        found = f"{what} ({clip(file)}: {clip(said, 120)}), which may hold or couple parts, is not read"
        if joint is not None or any(names.link(one) is not None for one in _texts(element)):
            mend = "say what it does as <mimic> or as a joint, or in a loops.toml, and remove it"
            findings.doubt(found, "a mimic plugin, or a detachable joint between two links", mend, line)
        else:
            findings.warn(found, "names of joints or links", "", line)
    elif joint is not None:
        findings.warn(f"{what}, which names joint '{joint}', is not read", "joint controllers", "", line)


def _texts(element: Element) -> Iterator[str]:
    """All words in a plugin that may be names."""
    for one in element.iter("{*}*"):
        yield from re.split(r"[\s,;]+", str(one.text or "").strip())
        if one is not element:
            yield from (str(value).strip() for value in one.attrib.values())


def _mimic(
    values: dict[str, str], what: str, line: int | None, names: PluginNames, done: Plugged, findings: Findings
) -> None:
    """The coordinate of mimicJoint = multiplier * that of joint + offset."""
    ends = []
    for tag in ("joint", "mimicJoint"):
        full = names.joint(values.get(tag, ""))
        if full is None:
            said = values.get(tag, "")
            found = f"<{tag}> of {what} is the unknown joint '{clip(said)}'"
            findings.error(found, "a joint", nearest(said, names.joints), line)
        ends += [] if full is None else [full]
    if len(ends) == 2:
        words = (ends[1], ends[0], values.get("multiplier") or "1", values.get("offset") or "0")
        coupling = geared(words, what, line, findings)
        done.couplings += [] if coupling is None else [coupling]


def geared(said: tuple[str, str, str, str], what: str, line: int | None, findings: Findings) -> Coupling | None:
    """The coupling of a follower, its driver, multiplier and offset (as texts), or None after noting what is wrong."""
    joint, driver = said[:2]
    numbers: list[float] = []
    for key, text in zip(("multiplier", "offset"), said[2:], strict=True):
        numbers += read_numbers(text, 1, f"{key} of {what} of joint '{joint}'", findings, line) or ()
    if len(numbers) != 2:
        return None
    ratio, offset = numbers
    return Coupling.geared(f"{joint}_mimic", joint, driver, ratio, offset, Place(findings.file, line))


def _held(values: dict[str, str], name: str, place: Place, names: PluginNames, done: Plugged) -> bool:
    """Whether a detachable joint is one between two links of the robot."""
    ends = [names.link(values.get(tag, "")) for tag in ("parent_link", "child_link")]
    if values.get("child_model", "") not in names.models or ends[0] is None or ends[1] is None or ends[0] == ends[1]:
        return False
    title = f"{ends[0]}_{ends[1]}_{name.rpartition('::')[2] or 'detachable'}"
    done.held.append((ends[0], ends[1], title, place))
    return True
