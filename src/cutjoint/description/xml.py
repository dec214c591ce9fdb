"""XML from strangers: no DTD, no entities, no network, bounded size and depth; problems carry line numbers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from cutjoint.description.numbers import is_xacro
from cutjoint.findings import Findings, clip, closest, read_text_file, slip

DEEPEST = 100
"""Levels of nested elements; robot files have about ten."""

_NEVER_EXTENDED = frozenset(
    {"origin", "mass", "inertia", "inertial", "axis", "parent", "child", "color"}
    | {"parent_origin", "child_origin", "parent_axis", "child_axis", "predecessor", "successor"}
    | {"box", "cylinder", "capsule", "sphere"}
)
_DRAKE = ("{http://drake.mit.edu}", "{https://drake.mit.edu}", "drake:")
"""How the names of Drake's extensions of URDF and SDF begin, with its namespace declared or not."""

Element = Any
"""An lxml element (lxml ships no types)."""


def read_xml(path: Path, findings: Findings, kind: str) -> Element | None:
    """The root element of an XML file, or None after noting why not."""
    data = read_text_file(path, findings, kind)
    return None if data is None else parse_xml(data, findings, kind)


def parse_xml(data: bytes, findings: Findings, kind: str) -> Element | None:
    """The root element of XML in memory, or None after noting why not."""
    root = _parse(data, findings, kind)
    if root is None:
        return None
    if root.getroottree().docinfo.internalDTD is not None:
        _refuse_doctype(findings, _line_of(data, b"<!DOCTYPE"))
        return None
    depth = _depth(root)
    if depth > DEEPEST:
        findings.error(f"XML nested {depth} levels deep", f"at most {DEEPEST} levels", "robot files are flat")
        return None
    return root


def _parse(data: bytes, findings: Findings, kind: str) -> Element | None:
    parser = _parser()
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        log = parser.error_log  # the log of the exception holds those of earlier files too
        if log and all(entry.domain_name == "NAMESPACE" for entry in log):
            return etree.fromstring(data, _parser(recover=True))  # prefixes nobody declared; they carry no robot
        if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
            _refuse_doctype(findings, _line_of(data, b"<!"))
            return None
        text, line = clip(str(error.msg or error), 160), error.lineno or None
        findings.error(f"the XML does not parse: {text}", f"well-formed {kind}", _advice(text), line)
        return None
    except ValueError as error:
        findings.error(f"the XML does not parse: {clip(str(error), 160)}", f"well-formed {kind}")
        return None


def _parser(recover: bool = False) -> etree.XMLParser:
    return etree.XMLParser(
        resolve_entities=False,
        load_dtd=False,
        dtd_validation=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
        recover=recover,
    )


def _refuse_doctype(findings: Findings, line: int | None) -> None:
    findings.error(
        "a DOCTYPE or entity declaration",
        "plain XML without DTD and entities, which are refused for safety",
        "remove the <!DOCTYPE ...> block and write the values out",
        line,
    )


def _advice(text: str) -> str:
    if "depth" in text.lower():
        return f"robot files nest at most {DEEPEST} levels"
    if "Premature end" in text or "EndTag: '</' not found" in text:
        return "the file ends early: it was truncated, or a closing tag is missing"
    if "mismatch" in text:
        return "close every tag with its own name, in the reverse order of opening"
    if "Start tag expected" in text:
        return "the file does not begin with an element: is it XML at all?"
    if "xmlParseEntityRef" in text or "Entity" in text:
        return "write & as &amp; and < as &lt;"
    return ""


def _line_of(data: bytes, mark: bytes) -> int | None:
    at = data.find(mark)
    return None if at < 0 else data.count(b"\n", 0, at) + 1


def _depth(root: Element) -> int:
    deepest, level = 0, 0
    for event, _ in etree.iterwalk(root, events=("start", "end")):
        level += 1 if event == "start" else -1
        deepest = max(deepest, level)
    return deepest


def children(element: Element, tag: str | None = None) -> Iterator[Element]:
    """Child elements of `element`, all or those called `tag`."""
    for child in element:
        if isinstance(child.tag, str) and (tag is None or child.tag == tag):
            yield child


def only_child(element: Element, tag: str, findings: Findings) -> Element | None:
    """The child called `tag`, or None; notes a problem where there are several."""
    found = list(children(element, tag))
    if len(found) > 1:
        findings.error(f"{len(found)} <{tag}> in one <{element.tag}>", "at most one", "keep one", found[1].sourceline)
    return found[0] if found else None


def drake_name(name: str) -> str | None:
    """What follows `drake:` in the name of an element or attribute of Drake's, None for all others."""
    start = next((one for one in _DRAKE if name.startswith(one)), None)
    return None if start is None else name[len(start) :]


def short(name: str) -> str:
    """The name of an element or attribute as people write it: with a prefix at most."""
    own = drake_name(name)
    return f"drake:{own}" if own is not None else name.rsplit("}", 1)[-1]


def check_known(
    element: Element, attributes: frozenset[str], tags: frozenset[str], ignored: frozenset[str], findings: Findings
) -> None:
    """Note attributes and children of `element` that the format does not have.

    One that looks like a slip of a known name, or is in an element that nobody extends, is an error because what was
    meant would be lost; anything else is somebody's extension and only a warning.  Names of Drake's, which `attributes`
    and `tags` give as `drake:NAME`, are held to the same; those of other namespaces are free.
    """
    what = f"<{short(str(element.tag))}>"
    for name in map(str, element.attrib):
        if not _foreign(name) and short(name) not in attributes:
            said = clip(short(name))
            _unknown(f"attribute '{said}' of {what}", said, attributes, attributes, element, findings)
    for child in children(element):
        tag = str(child.tag)
        if not _foreign(tag) and short(tag) not in tags and short(tag) not in ignored:
            said = clip(short(tag))
            _unknown(f"element <{said}> in {what}", said, tags, tags | ignored, child, findings, element)


def _foreign(name: str) -> bool:
    """Whether a name is in a namespace that belongs to neither the format nor Drake."""
    return ("{" in name or ":" in name) and drake_name(name) is None


def _unknown(
    found: str,
    name: str,
    told: frozenset[str],
    known: frozenset[str],
    at: Element,
    findings: Findings,
    parent: Element | None = None,
) -> None:
    """Note an unknown name; those of `known` that are `told` are listed."""
    strict = short(str((at if parent is None else parent).tag)) in _NEVER_EXTENDED
    near = closest(name, known, cutoff=0.6 if strict else 0.8) or slip(name, known)
    own = sorted(one for one in told if not one.startswith("drake:") or name.startswith("drake:"))
    expected = f"one of {', '.join(own)}" if own else "nothing there"
    if near or strict:
        findings.error(f"unknown {found}", expected, f"did you mean '{near}'?" if near else "remove it", at.sourceline)
    else:
        findings.warn(f"unknown {found} is ignored", expected, "", at.sourceline)


def left_in(root: Element) -> list[tuple[str, int | None]]:
    """Xacro tags and expressions that are left in a file, the first of each element, with their lines."""
    found = []
    for element in root.iter(etree.Element):
        tag = str(element.tag)
        inside = next((f'{key}="{value}"' for key, value in element.attrib.items() if is_xacro(value)), "")
        if "xacro" in tag.lower():
            inside = tag.rsplit("}", 1)[-1].removeprefix("xacro:")
            inside = f"<xacro:{inside}>"
        if inside:
            found.append((clip(inside), element.sourceline))
    return found


def refuse_xacro(root: Element, findings: Findings) -> None:
    """Note all xacro that is left in a file, as an error each."""
    for inside, line in left_in(root):
        mend = "expand it first: xacro robot.urdf.xacro > robot.urdf"
        findings.error(f"xacro left in: {inside}", "a plain file without xacro", mend, line)


def name_of(element: Element, findings: Findings) -> str | None:
    """The attribute `name` without blanks around it, or None after noting that it is missing."""
    name = str(element.get("name") or "").strip()
    if not name:
        findings.error(f"<{element.tag}> without a name", f'<{element.tag} name="...">', "", element.sourceline)
        return None
    return name
