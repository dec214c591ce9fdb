"""What MuJoCo refuses in a text though it has no part in the motion: geoms without weight, materials, cameras."""

from __future__ import annotations

import re

from cutjoint.description.formats.mjcf.source import MjcfText
from cutjoint.description.numbers import parse_number

_NO_WEIGHT = ("material", "texture", "skin", "hfield", "camera", "light")
MOST = 100
"""Flaws that are left out, each with another run of MuJoCo."""


def left_out(line: int, words: str, source: MjcfText) -> bool:
    """Take the flaw of which MuJoCo complains in these words, on a line of its text, out of that text; whether it could
    be, without another motion: the colour or material of anything, or all of an element without weight."""
    element, at = source.element(line), line - 1
    if element is None:
        return False
    for key in ("material", "rgba", "texture"):
        if element.get(key) is not None and re.search(rf"\b{key}\b", words):
            source.lines[at] = re.sub(rf' {key}=("[^"]*"|\'[^\']*\')', "", source.lines[at], count=1)
            return True
    _, found, rest = source.lines[at].partition(f"></{element.tag}>")
    if not found or not (str(element.tag) in _NO_WEIGHT or (element.tag == "geom" and _weightless(at, source))):
        return False
    source.lines[at] = rest
    return True


def _weightless(at: int, source: MjcfText) -> bool:
    """Whether the inertia of no body comes from the geom on a line (from 0)."""
    if parse_number(str(source.elements[at].get("mass", "1"))) == 0.0:
        return True
    if any(one.get("inertiafromgeom") == "true" for one, _ in source.all("compiler")):
        return False
    body = source.above[at]
    while source.elements[body].tag in ("frame", "replicate"):
        body = source.above[body]
    inside = (one for one, above in zip(source.elements, source.above, strict=True) if above == body)
    return source.elements[body].tag == "worldbody" or any(one.tag == "inertial" for one in inside)
