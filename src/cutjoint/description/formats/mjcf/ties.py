"""Couplings, distances and tendons as MJCF: what `<equality>` holds of joints and tendons, and tendons that act.

MuJoCo counts from `qpos0`, where all coordinates are 0 in what is written here: a joint, or the length of a fixed
tendon (a weighted sum of joints), is a polynomial of degree 4 at most of one other.  So a coupling may have one driver
along such a curve; its further ones, along straight lines, go into the tendon of the joint that it drives.  The length
of a tendon between two sites is held at more or less than it has there.  A joint that stands for the length of a fixed
tendon, as the reader makes it, is that tendon again.
"""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from cutjoint.description.curves import Polynomial
from cutjoint.description.formats.common.exact import number, words
from cutjoint.description.formats.mjcf.body import WORLD
from cutjoint.description.formats.mjcf.types import OWN, TENDON
from cutjoint.description.model import Coupling, JointType, RobotDescription
from cutjoint.description.xml import Element
from cutjoint.errors import InputError

TERMS = 5
"""Coefficients of a polynomial in MuJoCo."""


def tendon_lengths(robot: RobotDescription) -> dict[str, Coupling]:
    """Joint -> its coupling, for the joints that stand for lengths of fixed tendons and for nothing else."""
    couplings = {one.joint: one for one in robot.couplings}
    used = {frame.link for cut in robot.cuts for frame in (cut.a, cut.b)} | {joint.parent for joint in robot.joints}
    used |= set() if robot.tool is None else {robot.tool.link}
    driving = {driver for one in robot.couplings for driver in one.drivers}
    found = {}
    for joint in robot.joints:
        length, link = couplings.get(joint.name), robot.link(joint.child)
        if length is None or not joint.child.startswith(TENDON) or length.name != f"{joint.name}_length":
            continue
        bare = link.inertial is None and not link.visuals and not link.collisions and link.name not in used
        usual = joint.parent == robot.root == WORLD and joint.type is JointType.PRISMATIC and joint.name not in driving
        if bare and usual and length.ratios and length.offset == 0.0:
            found[joint.name] = length
    return found


def write_tendons(robot: RobotDescription, tendon: Element) -> dict[str, Element]:
    """The fixed tendons of a robot, by the names of their joints."""
    return {
        name: _fixed(tendon, robot.joint(name).child.removeprefix(TENDON), length.ratios or {})
        for name, length in tendon_lengths(robot).items()
    }


def tied(robot: RobotDescription) -> list[Coupling]:
    """The couplings of a robot but for lengths of tendons."""
    lengths = tendon_lengths(robot)
    return [one for one in robot.couplings if one.joint not in lengths]


def write_couplings(robot: RobotDescription, plain: bool, equality: Element, tendon: Element) -> None:
    """The couplings of a robot; unless `plain` they stand in the custom text too, and have names here that its reader
    passes over.

    Raises:
        InputError: MJCF has no word for one.
    """
    for number_of, coupling in enumerate(tied(robot), 1):
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


def _fixed(tendon: Element, name: str, terms: Mapping[str, float]) -> Element:
    element = etree.SubElement(tendon, "fixed", name=name)
    for joint, value in terms.items():
        etree.SubElement(element, "joint", joint=joint, coef=number(value))
    return element
