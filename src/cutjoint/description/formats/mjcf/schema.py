"""MuJoCo's own list of elements and attributes, for the nearest known name where a file has an unknown one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from cutjoint.description.formats.mjcf.source import MjcfText
from cutjoint.description.model import Place
from cutjoint.description.xml import Element, children
from cutjoint.findings import Findings, clip, nearest

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


def unknown_names(source: MjcfText, schema: Node, findings: Findings) -> bool:
    """Note every element and attribute that MuJoCo does not know; whether there is one."""
    nodes: list[Node | None] = []
    found = False
    for element, above, place in zip(source.elements, source.above, source.places, strict=True):
        parent = nodes[above] if nodes else schema
        node = None if parent is None else parent.children.get(str(element.tag))
        nodes.append(node)
        found |= parent is not None and _unknown(element, parent, place, findings)
    for element, above, place in source.plugins:
        parent = nodes[above]
        if parent is not None:
            for one, node in _within(element, parent):
                found |= _unknown(one, node, place, findings)
    return found


def _unknown(element: Element, parent: Node, place: Place, findings: Findings) -> bool:
    """Note an element that `parent` does not have, or the attributes that it does not have itself."""
    tag = str(element.tag)
    node = parent.children.get(tag)
    if node is None:
        above = element.getparent()
        where = "" if above is None else f" in <{above.tag}>"
        findings.error(
            f"unknown element <{clip(tag)}>{where}", _several(parent.children), nearest(tag, parent.children), place
        )
        return True
    names = [name for name in map(str, element.attrib) if ":" not in name and "{" not in name]
    unknown = [name for name in names if name not in node.attributes]
    for name in unknown:
        text = f"unknown attribute '{clip(name)}' of <{tag}>"
        findings.error(text, _several(node.attributes), nearest(name, node.attributes), place)
    return bool(unknown)


def _within(element: Element, parent: Node) -> Iterator[tuple[Element, Node]]:
    """An element and all in it, each with what its parent may have."""
    yield element, parent
    node = parent.children.get(str(element.tag))
    if node is not None:
        for child in children(element):
            yield from _within(child, node)


def _several(names: object) -> str:
    words = sorted(map(str, names)) if isinstance(names, (set, dict)) else []
    return f"one of {', '.join(words)}" if words else "nothing there"
