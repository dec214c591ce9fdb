"""Slips of the keyboard: two letters swapped, one lost, one doubled, in every name and word of a robot's file.

A slip is *silent*, a fault, where strict loading finds no problem that the sound file has not.  Names that a person is
free to choose are no slips: where the file says the word in one place only, and where the description says what the
file says.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
from lxml import etree

from attacks.judging import Attack, Wrong
from attacks.seeds import laid, seeds
from cutjoint.description import read_checked
from cutjoint.description.formats import Reading

WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w+")
OTHERS = frozenset({"plugin", "param", "hardwareInterface"})
"""Elements whose content belongs to other programs."""
IDLE = frozenset(
    {"transmission/type", "ros2_control", "command_interface", "state_interface", "gazebo/material"}  # URDF
    | {"collision_filter_group", "surface", "gazebo/mu1"}
    | {"atmosphere", "physics", "scene", "light", "sensor", "camera", "self_collide", "allow_auto_disable"}  # SDF
    | {"enable_wind", "cast_shadows", "material/script"}
    | {"motor", "position", "velocity", "site", "eulerseq"}  # MJCF
)
"""Elements (or PARENT/ELEMENT) in which what stands does not act on the motion: any value is as good as another; and an
attribute whose letters may come in any order."""
XML = (".urdf", ".xml", ".sdf", ".xacro")


@dataclass(frozen=True)
class Slip:
    """One slip: where it is, what was meant, what is said, the file with it, and whether a name may be anything."""

    where: str
    meant: str
    said: str
    text: str
    free: bool


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` slips, drawn from all of all seeds; all of them in turn where there are not so many."""
    rng = np.random.default_rng(seed)
    for source, files in seeds().items():
        every = [(name, one) for name, text in files.items() for one in slips(name, text)]
        most = min(len(every), -(-count // len(seeds())))
        for number in sorted(rng.choice(len(every), most, replace=False)):
            name, one = every[number]
            yield Attack(
                f"typo in {source}: {one.said} for {one.meant}, {one.where}", partial(act, files, name, one, folder)
            )


def silent(files: Mapping[str, str], folder: Path, start: int = 0, step: int = 1) -> tuple[int, list[str]]:
    """How many slips of all were tried in the files of a robot, and those of which nothing is said."""
    every = [(name, one) for name, text in files.items() for one in slips(name, text)][start::step]
    quiet = []
    for name, one in every:
        try:
            act(files, name, one, folder)
        except Wrong:
            quiet.append(f"{one.said} for {one.meant}, {one.where}")
    return len(every), quiet


def act(files: Mapping[str, str], name: str, slip: Slip, folder: Path) -> str:
    """Load the files with a slip in that called `name`: "told", or "a name"; raises `Wrong`."""
    sound = _sound(tuple(files.items()), folder)
    reading = read_checked(laid({**files, name: slip.text}, folder / "robot"))
    if {one.found for one in reading.problems} - {one.found for one in sound.problems}:
        return "told"
    words = _words(reading.description)
    if slip.free or (slip.said in words and words != _words(sound.description)):
        return "a name"
    raise Wrong("nothing is said of it")


@cache
def _sound(files: tuple[tuple[str, str], ...], folder: Path) -> Reading:
    return read_checked(laid(dict(files), folder / "robot"))


def _words(value: object) -> tuple[str, ...]:
    """All words that a description says, in order."""
    if isinstance(value, str):
        return tuple(re.findall(r"\w+", value))
    if dataclasses.is_dataclass(value):
        return _words([getattr(value, one.name) for one in dataclasses.fields(value)])
    if isinstance(value, Mapping):
        return _words([*value, *value.values()])
    if isinstance(value, tuple | list):
        return tuple(word for one in value for word in _words(one))
    return ()


def slips(name: str, text: str) -> Iterator[Slip]:
    """Every slip in a file; of what stands in the same place of another element, one of each kind."""
    if name.endswith(XML):
        yield from _in_xml(text)
    else:
        yield from _in_lines(text, usd=name.endswith(".usda"))


def spelt(word: str, few: bool = False, at: int = 0) -> Iterator[str]:
    """A word with two letters swapped, one lost and one doubled, at every place or (`few`) at one."""
    places = range(len(word))
    if few:
        places = range(at % len(word), at % len(word) + 1)
    found = set()
    for k in places:
        found |= {
            word[:k] + word[k + 1 : k + 2] + word[k] + word[k + 2 :],
            word[:k] + word[k + 1 :],
            word[: k + 1] + word[k:],
        }
    yield from sorted(one for one in found - {word} if one.isidentifier())


def _in_lines(text: str, usd: bool) -> Iterator[Slip]:
    """In every word of a text of lines, but in comments, and in the names and paths of prims."""
    seen: set[tuple[str, str]] = set()
    for number, match in enumerate(WORD.finditer(text)):
        start = text.rfind("\n", 0, match.start()) + 1
        line, column = text[start : text.find("\n", match.start())], match.start() - start
        if "#" in line[:column] or (usd and _is_path(line, column)):
            continue
        key = (match.group(), re.sub(r"[\d.]+|\"[^\"]*\"", "", line).strip())
        for said in spelt(match.group(), key in seen, number):
            free = usd and bool(re.match(r"\s*(def|over|class) (\w+ )?\"", line)) and '"' in line[:column]
            spoiled = text[: match.start()] + said + text[match.end() :]
            yield Slip(f"in '{line.strip()[:60]}'", match.group(), said, spoiled, free)
        seen.add(key)


def _is_path(line: str, column: int) -> bool:
    return "</" in line and column > line.index("</")


def _in_xml(text: str) -> Iterator[Slip]:
    """In every tag, every attribute and every word of a value."""
    root = etree.fromstring(text.encode(), etree.XMLParser(remove_comments=True))
    seen: set[tuple[str, ...]] = set()
    referred = frozenset(word for element in root.iter(etree.Element) for word in _referred(element))
    for number, element in enumerate(root.iter(etree.Element)):
        above = [etree.QName(one).localname for one in (element, *element.iterancestors())]
        if OTHERS & {*above[1:]}:
            continue
        pairs = {f"{outer}/{inner}" for inner, outer in itertools.pairwise(above)}
        idle = bool((IDLE | OTHERS) & {*above, *pairs}) or element is root
        for key, where, meant, said in _of_element(element, above[1:2], seen, number):
            free = key[-1] == "value" and (idle or key[-2] in IDLE or (key[-2] == "name" and meant not in referred))
            yield Slip(f"{where} in line {element.sourceline}", meant, said, etree.tostring(root).decode(), free)


def _referred(element: etree._Element) -> Iterator[str]:
    """Words that an element says of others."""
    for value in (*(value for name, value in element.attrib.items() if name != "name"), element.text or ""):
        yield from WORD.findall(str(value))


def _of_element(
    element: etree._Element, above: Sequence[str], seen: set[tuple[str, ...]], number: int
) -> Iterator[tuple[tuple[str, ...], str, str, str]]:
    """While each slip stands in the element: the kind of its place, where, what was meant, and what is said."""
    tag = str(element.tag)
    key = (*above, tag)
    for wrong in _renamed(tag, key in seen, number):
        element.tag = wrong
        yield key, f"<{tag}>", tag, wrong
    element.tag = tag
    seen.add(key)
    for name, value in [(str(name), str(value)) for name, value in element.attrib.items()]:
        key = (*above, tag, name)
        for wrong in _renamed(name, key in seen, number):
            if wrong not in element.attrib:
                del element.attrib[name]
                element.attrib[wrong] = value
                yield key, f"{name}= of <{tag}>", name, wrong
                del element.attrib[wrong]
                element.attrib[name] = value
        for match, wrong in _misspelt(value, key in seen, number):
            element.attrib[name] = value[: match.start()] + wrong + value[match.end() :]
            yield (*key, "value"), f"in {name}= of <{tag}>", match.group(), wrong
        element.attrib[name] = value
        seen.add(key)
    if (whole := str(element.text or "")).strip() and tag not in OTHERS:
        key = (*above, tag, "", "value")
        for match, wrong in _misspelt(whole, key in seen, number):
            element.text = whole[: match.start()] + wrong + whole[match.end() :]
            yield key, f"text of <{tag}>", match.group(), wrong
        element.text = whole
        seen.add(key)


def _renamed(name: str, few: bool, number: int) -> Iterator[str]:
    """Slips in a tag or attribute, behind its prefix."""
    head, brace, word = name.rpartition("}")
    front, colon, tail = word.rpartition(":")
    for one in spelt(tail, few, number):
        yield head + brace + front + colon + one


def _misspelt(value: str, few: bool, number: int) -> Iterator[tuple[re.Match[str], str]]:
    for match in WORD.finditer(value):
        for wrong in spelt(match.group(), few, number):
            yield match, wrong
