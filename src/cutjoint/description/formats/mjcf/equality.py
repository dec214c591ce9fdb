"""`<equality>` in MJCF as cut joints and couplings.

`connect` by body1, body2 and anchor joins the two points that coincide at zero; by sites it joins the sites.  `weld`
keeps the relative placement at zero, or joins the frame relpose of body1 to the anchor of body2.  `joint` with a linear
polycoef is a coupling.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.mjcf.body import WORLD, Bodies
from cutjoint.description.formats.mjcf.types import EQUALITIES
from cutjoint.description.model import Coupling, CutJoint, Frame, Place
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import from_rotation, inverse, rotation_from_quaternion
from cutjoint.description.xml import Element, children


def read_equalities(
    root: Element, bodies: Bodies, known: Collection[str], findings: Findings
) -> tuple[list[CutJoint], list[Coupling]]:
    """All active equalities but those of cuts that are `known` already (named NAME or NAME/1, NAME/2, ...)."""
    cuts: list[CutJoint] = []
    couplings: list[Coupling] = []
    number = 0
    for section in children(root, "equality"):
        for element in children(section):
            get = bodies.defaults.attributes(element, "")
            number += 1
            name = get.get("name") or f"{element.tag}_{number}"
            if get.get("active") == "false" or name.split("/")[0] in known:
                continue
            if element.tag == "joint":
                coupling = _coupling(element, get, name, bodies, findings)
                couplings += [] if coupling is None else [coupling]
            elif element.tag in EQUALITIES:
                cut = _cut(element, get, name, bodies, findings)
                cuts += [] if cut is None else [cut]
            else:
                found = f"<{element.tag}> in <equality>"
                findings.error(found, "connect, weld or joint", 'remove it, or set active="false"', element.sourceline)
    return cuts, couplings


def _cut(element: Element, get: dict[str, str], name: str, bodies: Bodies, findings: Findings) -> CutJoint | None:
    kind = EQUALITIES[str(element.tag)]
    frames = _site_frames(element, get, name, bodies, findings)
    if "site1" not in get and "site2" not in get:
        frames = _body_frames(element, get, name, bodies, findings)
    if frames is None:
        return None
    return CutJoint(name, kind, frames[0], frames[1], Place(findings.file, element.sourceline))


def _site_frames(
    element: Element, get: dict[str, str], name: str, bodies: Bodies, findings: Findings
) -> tuple[Frame, Frame] | None:
    found = []
    for key in ("site1", "site2"):
        site = get.get(key, "")
        if key in get and site not in bodies.sites:
            remedy = nearest(site, bodies.sites)
            found_text = f"<{element.tag}> '{name}' names the unknown site '{site}'"
            findings.error(found_text, "a <site>", remedy, element.sourceline)
        if site in bodies.sites:
            found.append(bodies.sites[site])
    if len(found) == 1 and ("site1" in get) != ("site2" in get):
        findings.error(f"<{element.tag}> '{name}' with one site", "site1 and site2", "", element.sourceline)
    return (found[0], found[1]) if len(found) == 2 else None


def _body_frames(
    element: Element, get: dict[str, str], name: str, bodies: Bodies, findings: Findings
) -> tuple[Frame, Frame] | None:
    what, line = f"<{element.tag}> '{name}'", element.sourceline
    first, second = get.get("body1", ""), get.get("body2", WORLD)
    for body in (first, second):
        if body not in bodies.world:
            remedy = nearest(body, bodies.world)
            findings.error(f"{what} names the unknown body '{body}'", "a <body>", remedy, line)
    if first not in bodies.world or second not in bodies.world:
        return None
    relative = inverse(bodies.world[second]) @ bodies.world[first]
    if element.tag == "connect":
        anchor = read_numbers(get.get("anchor"), 3, f"anchor of {what}", findings, line)
        if anchor is None:
            return None
        at = from_rotation(np.eye(3), anchor)
        point = from_rotation(np.eye(3), (relative @ [*anchor, 1.0])[:3])
        return Frame(first, at), Frame(second, point)
    anchor = read_numbers(get.get("anchor", "0 0 0"), 3, f"anchor of {what}", findings, line)
    pose = _relpose(get, what, findings, line)
    if anchor is None:
        return None
    at = from_rotation(np.eye(3), anchor)
    placed = readonly(inverse(relative) @ at) if pose is None else pose
    return Frame(first, placed), Frame(second, at)


def _relpose(get: dict[str, str], what: str, findings: Findings, line: int | None) -> Array | None:
    """The frame on body1 that meets the anchor on body2, or None where that is the one at zero."""
    if "relpose" not in get:
        return None
    values = read_numbers(get["relpose"], 7, f"relpose of {what}", findings, line)
    if values is None or np.linalg.norm(values[3:]) < 1e-9:
        return None
    return from_rotation(rotation_from_quaternion(values[3:]), values[:3])


def _coupling(element: Element, get: dict[str, str], name: str, bodies: Bodies, findings: Findings) -> Coupling | None:
    what, line = f"<joint> '{name}' in <equality>", element.sourceline
    joint, driver = get.get("joint1", ""), get.get("joint2", "")
    for one in (joint, driver):
        if one and one not in bodies.joint_names:
            remedy = nearest(one, bodies.joint_names)
            findings.error(f"{what} names the unknown joint '{one}'", "a joint", remedy, line)
            return None
    words = get.get("polycoef", "0 1 0 0 0").split()
    values = read_numbers(" ".join(words), len(words), f"polycoef of {what}", findings, line)
    if values is None:
        return None
    offset, ratio, *higher = (*values, *([0.0] * (2 - len(values))))
    if any(higher):
        findings.error(f"{what} has a polynomial of higher degree", "polycoef with two numbers", "", line)
        return None
    if not joint or not driver:
        findings.error(f"{what} with one joint", "joint1 and joint2", "a joint held still is a fixed joint", line)
        return None
    return Coupling.geared(name, joint, driver, ratio, offset, Place(findings.file, line))
