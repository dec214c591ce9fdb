"""MuJoCo's own list of elements and attributes, for the nearest known name where a file has an unknown one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from cutjoint.description.findings import Findings, clip, nearest
from cutjoint.description.formats.mjcf.source import Source
from cutjoint.description.xml import Element, children

_ROW = re.compile(r"^( *)(\S+) +\(.\) *(.*)$")
_PLACED = frozenset({"name", "childclass", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"})
_REPEATED = frozenset({"count", "sep", "offset", "euler", "childclass"})


@dataclass
class Node:
    """An element as MuJoCo knows it."""

    attributes: set[str] = field(default_factory=set)
    children: dict[str, Node] = field(default_factory=dict)


def parse_schema(text: str) -> Node:
    """The root of what `mujoco.mj_printSchema` prints: an element a row, deeper ones farther to the right."""
    top = Node()
    above: list[tuple[int, Node]] = [(-1, top)]
    node = top
    for line in text.splitlines():
        row = _ROW.match(line)
        if row is None:
            node.attributes |= set(line.split())
            continue
        indent, name = len(row[1]), row[2].removeprefix("(world)")
        while above[-1][0] >= indent:
            above.pop()
        node = above[-1][1].children[name] = Node(set(row[3].split()))
        above.append((indent, node))
    root = top.children["mujoco"]
    body, default = root.children["body"], root.children["default"]
    frame, several = Node(set(_PLACED), body.children), Node(set(_REPEATED), body.children)
    body.children |= {"body": body, "frame": frame, "replicate": several}
    default.children["default"] = default
    root.children["worldbody"] = root.children.pop("body")
    return top


def unknown_names(source: Source, schema: Node, findings: Findings) -> bool:
    """Note every element and attribute that MuJoCo does not know; whether there is one."""
    places = {id(element): place for element, place in zip(source.elements, source.places, strict=True)}
    found = False
    for element, node in _known(source.root, schema.children["mujoco"]):
        place = places.get(id(element), element.sourceline)
        for name in map(str, element.attrib):
            if name not in node.attributes and ":" not in name and "{" not in name:
                text = f"unknown attribute '{clip(name)}' of <{element.tag}>"
                findings.error(text, _several(node.attributes), nearest(name, node.attributes), place)
                found = True
        for child in children(element):
            tag = str(child.tag)
            if tag not in node.children and tag != "include" and ":" not in tag and "{" not in tag:
                text = f"unknown element <{clip(tag)}> in <{element.tag}>"
                at = places.get(id(child), child.sourceline)
                findings.error(text, _several(node.children), nearest(tag, node.children), at)
                found = True
    return found


def _known(element: Element, node: Node) -> Iterator[tuple[Element, Node]]:
    yield element, node
    for child in children(element):
        if child.tag in node.children:
            yield from _known(child, node.children[str(child.tag)])


def _several(names: object) -> str:
    words = sorted(map(str, names)) if isinstance(names, (set, dict)) else []
    return f"one of {', '.join(words)}" if words else "nothing there"
