"""The text of an MJCF file as MuJoCo gets it: one piece, with `<include>`d files in it, read under our own guards.

Every element stands on a line of its own, so that a line which MuJoCo names leads back to the element, its file and its
line there.  Files that `<attach>` uses are read under the same guards and handed over beside it.  Left out are plugins,
whose code MuJoCo may not have, and what is in namespaces of others.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

from cutjoint.description.model import Place
from cutjoint.description.xml import DEEPEST, Element, children, read_xml
from cutjoint.findings import Findings, clip

_WORDS = re.compile(
    r"(?i)^(name|class|childclass|.*(joint|body|site|geom|mesh|tendon|file|dir|prefix|material|texture|data|target)\d?)$"
)
"""Attributes that may hold the text nan as a name."""
MOST_REPLICAS = 10_000
"""Of what is in nested `<replicate>`s; MuJoCo would fill the memory."""
_DEFORMS = ("flexcomp", "flex")
_NO_NUMBER = re.compile(r"(?i)^[+-]?(nan|inf|infinity)$")


@dataclass
class MjcfText:
    """What MuJoCo gets, and where it came from.

    Attributes:
        path: of the main file.
        elements: the element on each line of `text`; `places` its place, `above` the line that it is in, from 0.
        plugins: those that were left out, with the line that each was in, from 0, and its place.
        models: text of every file that an `<attach>` names, by the name that it goes by.
        folders: of all files that were read, where meshes are looked for.
    """

    path: Path
    root: Element
    findings: Findings
    lines: list[str] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)
    above: list[int] = field(default_factory=list)
    plugins: list[tuple[Element, int, Place]] = field(default_factory=list)
    models: dict[str, str] = field(default_factory=dict)
    folders: list[str] = field(default_factory=list)
    refused: bool = False
    """Whether it is too much for MuJoCo."""

    @property
    def text(self) -> str:
        """The whole file."""
        return "\n".join(self.lines)

    def element(self, line: int | None, *tags: str) -> Element | None:
        """The element on a line of `text`; with tags None where it is none of these."""
        if line is None or not 1 <= line <= len(self.elements):
            return None
        found = self.elements[line - 1]
        return found if not tags or found.tag in tags else None

    def place(self, line: int | None, *tags: str) -> Place | None:
        """The place of that element."""
        return None if line is None or self.element(line, *tags) is None else self.places[line - 1]

    def all(self, tag: str) -> Iterator[tuple[Element, Place]]:
        """All elements of a tag, included ones as well, with their places."""
        return ((one, place) for one, place in zip(self.elements, self.places, strict=True) if one.tag == tag)


def read_source(path: Path, findings: Findings) -> MjcfText | None:
    """An MJCF file with what it includes; None where it is no XML, or no MJCF."""
    root = read_xml(path, findings, "MJCF")
    if root is None:
        return None
    if root.tag != "mujoco":
        findings.error(f"the root element is <{root.tag}>", "<mujoco>", "is this another format?", root.sourceline)
        return None
    source = MjcfText(path, root, findings, folders=[str(path.parent.absolute())])
    _Reader(source, {path.resolve()}).emit(root, path, 0, "")
    return None if source.refused else source


def _count(element: Element) -> int:
    """How many replicas there are; 1 where that is no number, which MuJoCo tells."""
    text = str(element.get("count", ""))
    return int(text) if text.isdecimal() and len(text) < 10 else 1


@dataclass
class _Reader:
    """Writes elements into a source; `seen` are the files that are in it already."""

    source: MjcfText
    seen: set[Path]
    replicas: int = 1

    def emit(self, element: Element, file: Path, depth: int, section: str, above: int = 0) -> None:
        """An element and what is in it; `section` is the element below the root that it is in, `above` its parent."""
        source, findings, tag = self.source, self.source.findings, str(element.tag)
        place = Place(str(file), element.sourceline)
        if depth > DEEPEST:
            findings.error(f"<{tag}> is nested {depth} levels deep", f"at most {DEEPEST} levels", "", place)
        elif ":" in tag or "{" in tag:
            findings.warn(f"<{clip(tag)}> of another namespace is not read", "", "", place)
        elif tag == "include":
            for inner, where in self._included(element, place):
                self.emit(inner, where, depth, section, above)
        elif tag == "plugin":
            self._plugin(element, section, above, place)
        elif tag in _DEFORMS:
            findings.error(f"<{tag}>, a body that deforms", "rigid bodies", "", place)
        else:
            source.lines.append(f"<{tag}{self._attributes(element, place)}>")
            source.elements.append(element)
            source.places.append(place)
            source.above.append(above)
            here = len(source.lines) - 1
            if tag == "model" and section == "asset":
                self._model(element, place)
            before = self.replicas
            self.replicas *= _count(element) if tag == "replicate" else 1
            if self.replicas > MOST_REPLICAS:
                findings.error(f"{self.replicas} replicas", f"at most {MOST_REPLICAS}", "", place)
                self.source.refused = True
            for inner in children(element):
                self.emit(inner, file, depth + 1, section or ("" if depth == 0 else tag), here)
            self.replicas = before
            source.lines[-1] += f"</{tag}>"

    def _attributes(self, element: Element, place: Place) -> str:
        words = []
        for key, value in ((str(key), str(value)) for key, value in element.attrib.items()):
            if ":" in key or "{" in key:
                continue
            if not _WORDS.match(key) and any(_NO_NUMBER.match(word) for word in value.split()):
                found = f"{clip(key)} of <{element.tag}> is {clip(value)}"
                self.source.findings.error(found, "a finite number", "", place)
            words.append(f" {key}={quoteattr(value)}")
        return "".join(words)

    def _included(self, element: Element, place: Place) -> list[tuple[Element, Path]]:
        """What is in an included file, with that file."""
        name, findings = str(element.get("file") or ""), self.source.findings
        if not name or len(element.attrib) != 1 or len(element):
            shown = " ".join(f'{key}="{clip(str(value))}"' for key, value in element.attrib.items())
            findings.error(f"<include {shown}>", 'nothing but <include file="..."/>', "", place)
            return []
        found = self._read(name, place)
        return [] if found is None else [(one, found[1]) for one in children(found[0])]

    def _read(self, name: str, place: Place) -> tuple[Element, Path] | None:
        """The root of another file, looked for beside the main one and beside the one that names it."""
        beside = [self.source.path.parent / name, Path(place.file).parent / name]
        file = next((one for one in beside if one.exists()), beside[0])
        findings = self.source.findings
        if file.resolve() in self.seen:
            findings.error(f"'{clip(name)}' is read twice", "each file once", "MuJoCo refuses it too", place)
            return None
        self.seen.add(file.resolve())
        own = Findings(str(file))
        root = read_xml(file, own, "MJCF")
        findings.problems += own.problems
        if root is None:
            findings.error(f"'{clip(name)}' cannot be read", "an MJCF file", "", place)
            return None
        folder = str(file.parent.absolute())
        self.source.folders += [] if folder in self.source.folders else [folder]
        return root, file

    def _model(self, element: Element, place: Place) -> None:
        """The file that a `<model>` names, which `<attach>` takes parts of."""
        name = str(element.get("file") or "")
        if not name or name in self.source.models:
            return
        found = self._read(name, place)
        if found is None or found[0].tag != "mujoco":
            if found is not None:
                self.source.findings.error(f"'{clip(name)}' is a <{found[0].tag}>", "an MJCF file", "", place)
            return
        part = MjcfText(self.source.path, found[0], self.source.findings)
        self.source.models[name] = ""
        part.models, part.folders = self.source.models, self.source.folders
        _Reader(part, self.seen).emit(found[0], found[1], 0, "")
        self.source.refused |= part.refused
        self.source.models[name] = part.text

    def _plugin(self, element: Element, section: str, above: int, place: Place) -> None:
        """A plugin: noted where it is a shape, only is there or measures, doubted where it acts."""
        self.source.plugins.append((element, above, place))
        what = " ".join(f'{key}="{clip(str(value))}"' for key, value in element.attrib.items())
        parent = element.getparent().tag
        still = section in ("extension", "sensor", "asset") or parent == "geom"
        note = self.source.findings.warn if still else self.source.findings.doubt
        where = f" in <{parent}>"
        note(f"<plugin {what}>{where} is not used", "MJCF without plugins", "", place)
