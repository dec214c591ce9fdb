"""What closes loops, couples joints or acts on them in a file, counted in its text: no reader of cutjoint is asked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

import yaml

Element = ElementTree.Element

TIES = frozenset(
    {"connect", "weld", "joint equality", "tendon equality", "second parent", "gazebo joint", "loop", "coupling"}
    | {"mimic", "gearbox", "screw", "loop joint", "closing frames", "drake constraint", "bushing", "closed loop"}
    | {"constraint", "world child"}
)
"""Kinds that each make a cut or a coupling."""


def contents(path: Path) -> Mapping[str, int]:
    """Kind -> how many of them stand in a file; included files of MJCF are counted with it.

    A file that is no XML, such as robot.yaml, counts nothing.
    """
    root = _root(path)
    if root is None:
        return _yaml(path) if path.suffix in (".yaml", ".yml") else {}
    count = {"mujoco": _mjcf, "robot": _urdf, "sdf": _sdf, "gazebo": _sdf}.get(root.tag, _none)(root, path)
    return {kind: number for kind, number in sorted(count.items()) if number}


def closures(count: Mapping[str, int]) -> int | None:
    """How many cuts and couplings these things make; None where the text does not tell."""
    if count.keys() & {"xacro", "include"}:
        return None
    return sum(count.get(kind, 0) for kind in TIES)


def _root(path: Path) -> Element | None:
    try:
        return ElementTree.fromstring(path.read_bytes())
    except (OSError, ElementTree.ParseError):
        return None


def _none(root: Element, path: Path) -> Counter[str]:
    return Counter()


def _yaml(path: Path) -> Mapping[str, int]:
    """Of a robot.yaml of Gepetto: the pairs of frames under `closed_loop`, and what its URDF has."""
    said = yaml.safe_load(path.read_text(encoding="utf-8"))
    count = {"closed loop": len(said.get("closed_loop", []))} if isinstance(said, dict) else {}
    tree = path.parent / "robot.urdf"
    return {**(contents(tree) if tree.is_file() else {}), **count}


def _parts(root: Element, path: Path, depth: int = 0) -> Iterator[Element]:
    """A file of MJCF and those that it includes."""
    yield root
    for one in root.iter("include"):
        inner = _root(path.parent / str(one.get("file"))) if depth < 8 else None
        if inner is not None:
            yield from _parts(inner, path, depth + 1)


def _mjcf(root: Element, path: Path) -> Counter[str]:
    count: Counter[str] = Counter()
    for part in _parts(root, path):
        for group in part.iter("equality"):
            for one in group:
                if one.get("active") == "false":
                    count["inactive"] += 1
                else:
                    count[one.tag if one.tag in ("connect", "weld", "flex") else f"{one.tag} equality"] += 1
        for group in part.iter("tendon"):
            count.update(f"{one.tag} tendon" for one in group)
        for group in part.iter("actuator"):
            count.update("actuator" if one.get("tendon") is None else "tendon actuator" for one in group)
        count["plugin"] += len(part.findall(".//plugin[@instance]")) + len(part.findall("worldbody//composite"))
    return count


def _urdf(root: Element, path: Path) -> Counter[str]:
    text = path.read_text(encoding="utf-8", errors="replace")
    children = Counter(str(one.get("link")) for one in root.findall("joint/child"))
    count = Counter(
        {
            "second parent": sum(number - 1 for number in children.values()),
            "mimic": len(root.findall("joint/mimic")),
            "gazebo joint": sum(len(one.findall("joint")) for one in root.iter("gazebo")),
            "loop": len(root.findall("loop")),
            "loop joint": len(root.findall("loop_joint")),
            "coupling": len(root.findall("coupling")),
            "constraint": len(root.findall("constraint")),
            "closing frames": len(set(re.findall(r'<link name="closing_(\w+)_1"', text))),
            "drake constraint": len(re.findall(r"<drake:(?:ball|weld|distance|tendon)_constraint[\s>]", text)),
            "bushing": len(re.findall(r"<drake:linear_bushing\w*[\s>]", text)),
            "actuator": len(root.findall("transmission")),
            "plugin": len(root.findall("gazebo/plugin")),
        }
    )
    if "<xacro:" in text:
        count["xacro"] = text.count("<xacro:")
    return count


def _sdf(root: Element, path: Path) -> Counter[str]:
    count: Counter[str] = Counter()
    for model in root.iter("model"):
        joints = model.findall("joint")
        plain = [one for one in joints if one.get("type") not in ("gearbox", "screw")]
        children = Counter((one.findtext("child") or "").strip() for one in plain)
        count["second parent"] += sum(number - 1 for name, number in children.items() if name != "world")
        count["world child"] += children["world"]
        count.update(kind for one in joints if (kind := str(one.get("type"))) in ("gearbox", "screw", "revolute2"))
        count["mimic"] += len(model.findall("joint/axis/mimic"))
        count["plugin"] += len(model.findall("plugin"))
    count["include"] = len(list(root.iter("include")))
    return count
