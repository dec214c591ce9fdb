"""Couplings and distances as MJCF: what `<equality>` holds of joints and tendons.

MuJoCo counts from `qpos0`, where all coordinates are 0 in what is written here: a joint, or the length of a fixed
tendon (a weighted sum of joints), is a polynomial of degree 4 at most of one other.  So a coupling may have one driver
along such a curve; its further ones, along straight lines, go into the tendon of the joint that it drives.  The length
of a tendon between two sites is held at more or less than it has there.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.curves import Polynomial
from cutjoint.description.formats.common.exact import number, words
from cutjoint.description.formats.mjcf.body import OWN
from cutjoint.description.model import Coupling, CutJoint, RobotDescription
from cutjoint.description.xml import Element
from cutjoint.errors import InputError

TERMS = 5
"""Coefficients of a polynomial in MuJoCo."""


def plain_couplings(robot: RobotDescription) -> bool:
    """Whether MJCF says all couplings with nothing left over: gears and what is held, with names of their own."""
    cuts = {cut.name for cut in robot.cuts}
    return all((one.gear or not one.drives) and one.name and one.name not in cuts for one in robot.couplings)


def write_couplings(robot: RobotDescription, equality: Element, tendon: Element) -> None:
    """The couplings of a robot.  Where there are more than gears, all of them stand in the custom text too, and have
    names here that their reader knows.

    Raises:
        InputError: MJCF has no word for one.
    """
    plain = plain_couplings(robot)
    for number_of, coupling in enumerate(robot.couplings, 1):
        name = coupling.name if plain else f"{OWN}{coupling.name}#{number_of}"
        _coupling(coupling, name, equality, tendon)


def _coupling(coupling: Coupling, name: str, equality: Element, tendon: Element) -> None:
    straight, driver, powers = _sorted(coupling)
    if not straight:
        given = {"joint1": coupling.joint} | ({"joint2": driver} if driver else {})
        etree.SubElement(equality, "joint", given, name=name, polycoef=words(powers))
        return
    own = f"{name}/1" if name.startswith(OWN) else f"{OWN}{name}/1"
    _fixed(tendon, own, {coupling.joint: 1.0} | {joint: -ratio for joint, ratio in straight.items()})
    given = {"tendon1": own}
    if driver:
        given["tendon2"] = f"{own[:-1]}2"
        _fixed(tendon, given["tendon2"], {driver: 1.0})
    etree.SubElement(equality, "tendon", given, name=name, polycoef=words(powers))


def _sorted(coupling: Coupling) -> tuple[dict[str, float], str, list[float]]:
    """Driver -> ratio of those along straight lines, but for one: its name, and the polynomial of its coordinate."""
    powers = {one.driver: _powers(coupling, one.curve) for one in coupling.drives}
    curved = [driver for driver, own in powers.items() if any(own[2:])]
    if len(curved) > 1:
        raise _unsaid(coupling, f"follows {len(curved)} joints along curves")
    driver = curved[0] if curved else next(iter(powers)) if len(powers) == 1 else ""
    straight = {one: own[1] for one, own in powers.items() if one != driver}
    constant = coupling.offset + sum(own[0] for own in powers.values())
    return straight, driver, [constant, *(powers[driver][1:] if driver else [0.0] * (TERMS - 1))]


def _powers(coupling: Coupling, curve: object) -> list[float]:
    """The coefficients of a curve, five of them."""
    if not isinstance(curve, Polynomial):
        raise _unsaid(coupling, "follows a table of points")
    last = max((power for power, value in enumerate(curve.coefficients) if value != 0.0), default=0)
    if last >= TERMS:
        raise _unsaid(coupling, f"follows a polynomial of degree {last}, more than {TERMS - 1}")
    return [*curve.coefficients[: last + 1], *[0.0] * (TERMS - 1 - last)]


def _unsaid(coupling: Coupling, what: str) -> InputError:
    return InputError(
        f"MJCF cannot say coupling '{coupling.name}': '{coupling.joint}' {what}; write loops.toml (--to loops), which "
        "knows every coupling"
    )


def _fixed(tendon: Element, name: str, terms: Mapping[str, float]) -> None:
    element = etree.SubElement(tendon, "fixed", name=name)
    for joint, value in terms.items():
        etree.SubElement(element, "joint", joint=joint, coef=number(value))


def write_distance(cut: CutJoint, placed: Mapping[str, Array], equality: Element, tendon: Element) -> None:
    """A distance between two sites, NAME/a and NAME/b."""
    ends = [(placed[frame.link] @ frame.placement)[:3, 3] for frame in (cut.a, cut.b)]
    name = f"{OWN}{cut.name}"
    element = etree.SubElement(tendon, "spatial", name=name)
    for site in (f"{cut.name}/a", f"{cut.name}/b"):
        etree.SubElement(element, "site", site=site)
    more = cut.length - float(np.linalg.norm(ends[1] - ends[0]))
    etree.SubElement(equality, "tendon", name=cut.name, tendon1=name, polycoef=words((more, 0.0, 0.0, 0.0, 0.0)))


def at_zero(robot: RobotDescription) -> dict[str, Array]:
    """Placements of all links where all coordinates are 0."""
    placed = {robot.root: np.eye(4)}
    left = list(robot.joints)
    while left:
        known = [joint for joint in left if joint.parent in placed]
        for joint in known:
            placed[joint.child] = placed[joint.parent] @ joint.placement
        left = [joint for joint in left if joint.child not in placed]
    return placed
