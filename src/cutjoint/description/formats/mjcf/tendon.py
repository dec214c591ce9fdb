"""`<tendon>` in MJCF: what it does by itself or under an actuator.

A fixed tendon, a weighted sum of coordinates, with a spring, damper, friction, rotor or actuator of its own is a
sliding joint called like it, between the world and a link without mass, whose coordinate is coupled to be the tendon's
length: a force on it is one along the tendon.  Where an actuator is all there is and the joints of the tendon move as
one, it acts on that one joint instead.  A spatial tendon that is a spring (and damper) between two sites is a bushing
of their distance; others that act are not read.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from cutjoint.description.formats.mjcf.body import WORLD, Bodies
from cutjoint.description.formats.mjcf.compiled import TendonRow
from cutjoint.description.formats.mjcf.couplings import Followers
from cutjoint.description.formats.mjcf.joint import ends, even, linear
from cutjoint.description.formats.mjcf.types import OWN, TENDON
from cutjoint.description.model import (
    Bushing,
    Coupling,
    CutJoint,
    CutType,
    Joint,
    JointPhysics,
    JointType,
    Limits,
    Link,
    Place,
)
from cutjoint.findings import Findings


def lengths_of(tendon: TendonRow, bodies: Bodies) -> dict[str, float] | None:
    """Joint -> what a unit of its coordinate adds to the length of a fixed tendon; None for a spatial one."""
    if any(kind != "joint" for kind, _, _ in tendon.path):
        return None
    terms: dict[str, float] = {}
    for _, index, coefficient in tendon.path:
        joint = bodies.joints[index]
        terms[joint] = terms.get(joint, 0.0) + coefficient
    return terms


def quoted(tendon: TendonRow) -> str:
    """A spatial tendon in words."""
    return f"'{tendon.name}' ({', '.join(kind for kind, _, _ in tendon.path)})"


def place_of(tendon: TendonRow, bodies: Bodies) -> Place:
    """Where a tendon stands."""
    return bodies.source.place(tendon.line, "fixed", "spatial") or Place(bodies.findings.file)


def acting(tendon: TendonRow) -> dict[str, float]:
    """What a tendon does by itself, by MuJoCo's names."""
    given = {"stiffness": tendon.stiffness, "damping": tendon.damping}
    found = {key: value[0] or max(value, key=abs) for key, value in given.items() if any(value)}
    found |= {"frictionloss": tendon.friction, "armature": tendon.armature}
    return {key: value for key, value in found.items() if value != 0.0}


def restore_tendons(bodies: Bodies, followers: Followers, findings: Findings) -> None:
    """Joints for all fixed tendons of a file that cutjoint wrote, in their order: it made them of such joints."""
    for tendon in bodies.model.tendons:
        if bodies.own and lengths_of(tendon, bodies) is not None and not tendon.name.startswith(OWN):
            as_joint(tendon, bodies, followers, findings)


def read_tendons(bodies: Bodies, followers: Followers, taken: Collection[str], findings: Findings) -> list[CutJoint]:
    """Joints for the fixed tendons that act, and springs between two sites, which are given back, with names that are
    not `taken`; what is left of the others is told."""
    springs: list[CutJoint] = []
    for tendon in bodies.model.tendons:
        acts, place = acting(tendon), place_of(tendon, bodies)
        terms = lengths_of(tendon, bodies)
        if acts and terms is None:
            springs += _spring(tendon, acts, bodies, taken, findings)
        elif acts:
            as_joint(tendon, bodies, followers, findings)
        elif tendon.range is not None and _joint(tendon, bodies) is None:
            kind = "spatial" if terms is None else "fixed"
            findings.warn(f"range of <{kind}> '{tendon.name}' not used", "limits of joints", "", place)
    return springs


def _spring(
    tendon: TendonRow, acts: Mapping[str, float], bodies: Bodies, taken: Collection[str], findings: Findings
) -> list[CutJoint]:
    """A spatial tendon as a bushing; nothing, and an error, where it is more than a spring between two sites."""
    what, place = f"<spatial> {quoted(tendon)}", place_of(tendon, bodies)
    sites = [index for kind, index, _ in tendon.path if kind == "site"]
    apart = len({bodies.model.sites[index].body for index in sites}) == len(sites) == len(tendon.path) == 2
    rest = tendon.rest[0]
    if not apart or not {"stiffness"} <= set(acts) <= {"stiffness", "damping"} or not tendon.rest[1] == rest > 0.0:
        found = f"{', '.join(acts)} of {what}, springlength {' '.join(f'{value:g}' for value in tendon.rest)}"
        expected = (
            "a fixed tendon, or a stiffness (with a damping) and one springlength > 0 between sites of two bodies"
        )
        findings.error(found, expected, "", place)
        return []
    if tendon.range is not None:
        findings.warn(f"range of {what} not used", "limits of joints", "", place)
    bushing = Bushing(
        _stiffness(tendon, what, findings, place), linear(tendon.damping, f"damping of {what}", findings, place)
    )
    name = _link(tendon) if not tendon.name or tendon.name in taken else tendon.name
    a, b = (bodies.frame(site) for site in sites)
    return [CutJoint(name, CutType.DISTANCE, a, b, place, bushing=bushing, length=rest)]


def _stiffness(tendon: TendonRow, what: str, findings: Findings, place: Place) -> float:
    if tendon.springyield != 0.0:
        found = f"springyield of {what} is {tendon.springyield:g}"
        findings.doubt(found, "a spring that does not yield", "", place)
    return linear(tendon.stiffness, f"stiffness of {what}", findings, place)


def _link(tendon: TendonRow) -> str:
    return f"{TENDON}{tendon.name or tendon.line}"


def _joint(tendon: TendonRow, bodies: Bodies) -> str | None:
    """The joint that stands for a tendon, if there is one."""
    return next((joint.name for joint in bodies.tree.joints if joint.child == _link(tendon)), None)


def as_joint(tendon: TendonRow, bodies: Bodies, followers: Followers, findings: Findings) -> str:
    """The joint that stands for a fixed tendon, made where it is not there yet; its name."""
    terms, place = lengths_of(tendon, bodies) or {}, place_of(tendon, bodies)
    taken = {joint.name for joint in bodies.tree.joints}
    there, link = _joint(tendon, bodies), _link(tendon)
    if there is not None:
        return there
    plain = link.removeprefix(TENDON)
    name = link if plain in taken else plain
    what = f"<fixed> '{plain}'"
    stiffness = _stiffness(tendon, what, findings, place)
    rest = None
    if stiffness != 0.0:
        rest = tendon.rest[0]
        if tendon.rest[0] != tendon.rest[1]:
            found = f"springlength of {what} is {tendon.rest[0]:g} {tendon.rest[1]:g}: a spring that rests between two"
            findings.doubt(found, "one length", "", place)
    damping = linear(tendon.damping, f"damping of {what}", findings, place)
    physics = JointPhysics(damping, tendon.friction, None, stiffness, rest, tendon.armature)
    lower, upper = ends(tendon.range)
    effort = even(tendon.force, f"actuatorfrcrange of {what}", findings, place)
    bodies.tree.links.append(Link(link, place=place))
    bodies.tree.joints.append(
        Joint(
            name, JointType.PRISMATIC, WORLD, link, limits=Limits(lower, upper, None, effort), physics=physics,
            place=place,
        )
    )  # fmt: skip
    followers.follow(Coupling.summed(f"{name}_length", name, terms, 0.0, place), what)
    bodies.tendons[name] = terms
    return name
