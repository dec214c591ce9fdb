"""`<equality>` in MJCF as cut joints and couplings.

`connect` joins two points, `weld` two frames (with a `torquescale` of 0 two points), both as MuJoCo has them: those of
sites, or of bodies where they are at `qpos0`.  `joint` and `tendon` tie coordinates, with polynomials about `qpos0`.  A
spatial tendon between two sites that is held is a distance.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial as Series

from cutjoint.description.curves import Polynomial
from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.compiled import EqualityRow, Numbers
from cutjoint.description.formats.mjcf.couplings import Followers, Relation
from cutjoint.description.formats.mjcf.tendon import lengths_of, quoted
from cutjoint.description.formats.mjcf.told_apart import passed_over
from cutjoint.description.formats.mjcf.types import EQUALITIES, NUMBERED, OWN
from cutjoint.description.model import Coupling, CutJoint, CutType, DriverCurve, Frame, Place
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion
from cutjoint.findings import Findings, listing, nearest


def read_equalities(
    bodies: Bodies, known: Collection[str], actuated: Collection[str], findings: Findings
) -> tuple[list[CutJoint], Followers]:
    """All active equalities but those of cuts and couplings that are `known` already (named NAME or NAME/1, NAME/2,
    ..., or as this package names what its text tells).

    What is `actuated` follows others only where nothing else can.
    """
    cuts: list[CutJoint] = []
    followers = Followers(findings)
    for number, row in enumerate(bodies.model.equalities, 1):
        name = row.name or f"{row.kind}_{number}"
        place = bodies.source.place(row.line, row.kind) or Place(findings.file)
        if not row.active or passed_over(name, known):
            continue
        if known and name.startswith(OWN):
            own = name.removeprefix(OWN)
            if not (passed_over(own, known) or passed_over(NUMBERED.sub("", own), known)):
                found = f"<{row.kind}> '{name}' is of no cut or coupling of the text that cutjoint wrote"
                findings.error(found, f"{OWN} and one of {listing(sorted(known))}", nearest(own, known), place)
            continue
        if row.kind in EQUALITIES:
            cuts.append(_cut(row, name, bodies, place))
        elif row.kind == "joint":
            _joints(row, name, bodies, followers, place)
        elif row.kind == "tendon":
            cuts += _tendons(row, name, bodies, followers, actuated, place)
        else:
            found = f"<{row.kind}> in <equality>"
            findings.error(found, "connect, weld, joint or tendon", 'remove it, or set active="false"', place)
    return cuts, followers


def _cut(row: EqualityRow, name: str, bodies: Bodies, place: Place) -> CutJoint:
    kind, data = EQUALITIES[row.kind], row.data
    if row.kind == "weld" and data[10] == 0.0:
        kind = CutType.SPHERICAL
    if row.by_sites:
        return CutJoint(name, kind, bodies.frame(row.first), bodies.frame(row.second), place)
    first, second = bodies.names[row.first], bodies.names[row.second]
    if row.kind == "connect":
        a, b = from_rotation(np.eye(3), data[:3]), from_rotation(np.eye(3), data[3:6])
    else:
        a, b = from_rotation(rotation_from_quaternion(data[6:10]), data[3:6]), from_rotation(np.eye(3), data[:3])
    return CutJoint(name, kind, Frame(first, a), Frame(second, b), place)


def _joints(row: EqualityRow, name: str, bodies: Bodies, followers: Followers, place: Place) -> None:
    """y - y0 = a0 + a1 (x - x0) + ..., or y - y0 = a0 where there is one joint."""
    joint, driver = bodies.joints[row.first], bodies.joints[row.second] if row.second >= 0 else ""
    what = f"<joint> '{name}' in <equality>"
    from_zero = bodies.references[joint]
    if not driver:
        relation = Relation(name, {joint: 1.0}, from_zero + row.data[0], [joint], what, place)
        followers.relate(relation)
        return
    constant, *slopes = about(row.data[:5], bodies.references[driver])
    if any(slopes[1:]):
        drive = DriverCurve(driver, Polynomial(_trimmed((0.0, *slopes))))
        followers.follow(Coupling(name, joint, (drive,), from_zero + constant, place), what)
    else:
        terms = {joint: 1.0, driver: -slopes[0]}
        followers.relate(Relation(name, terms, from_zero + constant, [joint, driver], what, place))


def _tendons(
    row: EqualityRow, name: str, bodies: Bodies, followers: Followers, actuated: Collection[str], place: Place
) -> list[CutJoint]:
    """The same of the lengths of tendons; a held distance between two sites is a cut."""
    tendons = bodies.model.tendons
    first, second = tendons[row.first], tendons[row.second] if row.second >= 0 else None
    what = f"<tendon> '{name}' in <equality>"
    sites = [index for kind, index, _ in first.path if kind == "site"]
    if len(first.path) == len(sites) == 2 and second is None:
        length = first.length + row.data[0]
        a, b = (bodies.frame(site) for site in sites)
        return [CutJoint(name, CutType.DISTANCE, a, b, place, length=length)]
    terms = lengths_of(first, bodies)
    others = {} if second is None else lengths_of(second, bodies)
    if terms is None or others is None:
        spatial = first if terms is None else second
        found = f"{what} holds the spatial tendon {quoted(spatial)}" if spatial else what
        expected = "a fixed tendon, or one between two sites alone, held at a length"
        followers.findings.error(found, expected, 'remove it, or set active="false"', place)
        return []
    wished = sorted(terms, key=lambda joint: joint in actuated)
    if second is None:
        followers.relate(Relation(name, terms, first.length + row.data[0], wished, what, place))
        return []
    constant, *slopes = about(row.data[:5], second.length)
    if not any(slopes[1:]):
        both = {joint: terms.get(joint, 0.0) - slopes[0] * others.get(joint, 0.0) for joint in {**terms, **others}}
        wished += [joint for joint in others if joint not in terms]
        followers.relate(Relation(name, both, first.length + constant, wished, what, place))
        return []
    _curved(name, terms, first.length + constant, others, slopes, followers, wished, what, place)
    return []


def _curved(
    name: str, terms: dict[str, float], constant: float, others: dict[str, float], slopes: list[float],
    followers: Followers, wished: list[str], what: str, place: Place,
) -> None:  # fmt: skip
    """sum of terms = constant + the polynomial of one other joint."""
    able = [joint for joint in wished if joint not in others]
    follower = followers.free({**terms, **others}, able)
    if len(others) != 1 or follower is None:
        found, expected = f"{what} has a polynomial of {len(others)} joints", "a polynomial of one other joint"
        followers.findings.error(found, expected, "give the polynomial of each joint by itself", place)
        return
    ((driver, by),) = others.items()
    scale = terms[follower]
    powers = (0.0, *(slope * by**power / scale for power, slope in enumerate(slopes, 1)))
    drives = [DriverCurve(driver, Polynomial(_trimmed(powers)))]
    for joint, value in terms.items():
        if joint == driver:
            drives[0] = replace(drives[0], curve=Polynomial((0.0, powers[1] - value / scale, *powers[2:])))
        elif joint != follower:
            drives.append(DriverCurve(joint, Polynomial((0.0, -value / scale))))
    followers.follow(Coupling(name, follower, tuple(drives), constant / scale, place), what)


def about(coefficients: Numbers, centre: float) -> list[float]:
    """The coefficients, about 0, of a polynomial that is given about `centre`."""
    if centre == 0.0:
        return list(coefficients)
    expanded = Series(coefficients)(Series([-centre, 1.0]))
    values = [float(value) for value in expanded.coef] if isinstance(expanded, Series) else [float(expanded)]
    return (values + [0.0] * len(coefficients))[: len(coefficients)]


def _trimmed(powers: Numbers) -> Numbers:
    """Without zeros at its end."""
    last = max((power for power, value in enumerate(powers) if value != 0.0), default=1)
    return powers[: max(last, 1) + 1]
