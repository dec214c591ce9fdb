"""What other schemas than UsdPhysics say that closes loops, couples joints or acts on them: read, or never silent."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from cutjoint.description.formats.usd.bodies import API as BODY
from cutjoint.description.formats.usd.facts import Facts, Prim
from cutjoint.description.formats.usd.joints import ACTUATOR, DEGREE, MIMIC, Edge, is_joint, targets_of
from cutjoint.description.formats.usd.typos import OTHERS
from cutjoint.description.model import Coupling, Joint, Place
from cutjoint.findings import Findings, clip, listing, nearest

_CLOSES = re.compile(r"joint|equality|tendon|gear|rack|pulley|mimic|constraint|attachment|weld|connect", re.IGNORECASE)
_ACTS = re.compile(r"force|spring|thruster|actuator|muscle|wheel|vehicle|gripper", re.IGNORECASE)
_PHYSICS = re.compile(
    r"damping|stiffness|friction|armature|spring|gear|ratio$|mimic|limit|effort|gravcomp|equality|coef", re.IGNORECASE
)
_HARMLESS = re.compile(r"Robot|Isaac|ContactReport|Filtered|State|Vis|Material|Collision|Articulation|Scene")
"""Schemas that describe joints and bodies to other tools, and nothing that moves them."""


def check_foreign(facts: Facts, findings: Findings) -> None:
    """Note the types and schemas of others that would hold, couple or move something."""
    joints = {prim.path for prim in facts.prims if is_joint(prim)}
    for prim in facts.prims:
        if prim.type.endswith(ACTUATOR) and targets_of(prim) and targets_of(prim) <= joints:
            found = (
                f"the {clip(prim.type)} <{prim.path}> is read as an actuator of its joint: nothing else of it is used"
            )
            findings.warn(found, "PhysicsDriveAPI", "give its gains to a control law")
        elif prim.type and prim.type not in facts.known:
            _unread(prim, prim.type, f"<{prim.path}> of type {clip(prim.type)}", findings)
        for api in prim.apis:
            base = api.partition(":")[0]
            if base not in facts.known and base not in OTHERS and not _HARMLESS.search(base):
                _unread(prim, base, f"the schema {clip(api)} of <{prim.path}>", findings)
        if is_joint(prim) or prim.has(BODY):
            _values(prim, findings)
    _bodies([prim for prim in facts.prims if prim.has(BODY)], findings)


def _unread(prim: Prim, name: str, what: str, findings: Findings) -> None:
    if _CLOSES.search(name) and not name.endswith("JointAPI"):
        findings.error(f"{what} closes loops or couples joints, and is not read", "joints of UsdPhysics", "remove it")
    elif _ACTS.search(name):
        findings.error(f"{what} acts on the robot, and is not read", "joints and bodies of UsdPhysics", "remove it")


def _values(prim: Prim, findings: Findings) -> None:
    """Note numbers of unread schemas on a joint or body that would change how it moves."""
    read = {name.split(":#")[0].rpartition(":")[0] or name.split(":")[0] for names in OTHERS.values() for name in names}
    unread = [
        name
        for name in prim.authored
        if name not in prim.defined
        and not name.startswith(("physics:", "drive:", "limit:", "state:", "primvars:"))
        and name.split(":")[0] not in read
        and _PHYSICS.search(name.rpartition(":")[2])
        and prim.values.get(name, 0.0) not in (0.0, "")
    ]
    if unread:
        findings.warn(
            f"{listing(map(clip, unread))} of <{prim.path}> are not used", "properties of UsdPhysics or PhysX"
        )


def _bodies(prims: Sequence[Prim], findings: Findings) -> None:
    for prim in prims:
        for name in ("lockedPosAxis", "lockedRotAxis"):
            if prim.number(f"physxRigidBody:{name}") != 0.0:
                findings.error(
                    f"physxRigidBody:{name} holds body <{prim.path}>, and is not read", "a joint to the world"
                )
        for name in ("linearDamping", "angularDamping"):
            if prim.number(f"physxRigidBody:{name}") != 0.0:
                found = f"physxRigidBody:{name} of body <{prim.path}> is not used"
                findings.warn(found, "damping in joints")


def couplings_of(edges: Sequence[Edge], joints: Sequence[Joint], facts: Facts, findings: Findings) -> list[Coupling]:
    """The mimic joints of PhysX: coordinate + gearing * coordinate of the reference + offset = 0, in degrees or units.

    https://nvidia-omniverse.github.io/PhysX/physx/5.4.0/_api_build/class_px_articulation_mimic_joint.html
    """
    by_path = {edge.prim.path: edge for edge in edges}
    kept = {joint.name for joint in joints}
    found = []
    for edge in edges:
        for instance in edge.prim.instances(MIMIC):
            coupling = _mimic(edge, instance, by_path, kept, facts, findings)
            if coupling is not None:
                found.append(coupling)
    return found


def _mimic(
    edge: Edge, instance: str, by_path: Mapping[str, Edge], kept: set[str], facts: Facts, findings: Findings
) -> Coupling | None:
    prim, head = edge.prim, f"physxMimicJoint:{instance}"
    targets = prim.targets.get(f"{head}:referenceJoint", ())
    leader = by_path.get(targets[0]) if len(targets) == 1 else None
    if leader is None:
        found = f"{head}:referenceJoint of <{prim.path}> is {listing(f'<{one}>' for one in targets)}"
        findings.error(found, "one joint", nearest(targets[0], by_path) if targets else "")
        return None
    for one in (edge, leader):
        if one.joint.name not in kept or not one.joint.type.single:
            found = f"{MIMIC} of <{prim.path}> couples joint <{one.prim.path}>"
            findings.error(found, "joints of the tree with one coordinate")
            return None
    gearing = prim.number(f"{head}:gearing")
    if gearing == 0.0 or f"{head}:gearing" not in prim.values:
        findings.error(f"{head}:gearing of <{prim.path}> is missing or 0", "how it moves against its reference")
        return None
    if prim.number(f"{head}:naturalFrequency") > 0.0 and prim.number(f"{head}:dampingRatio") > 0.0:
        findings.warn(f"{head}:naturalFrequency of <{prim.path}> is not used: the coupling is rigid", "0")
    own, other = (DEGREE if one.joint.type.turns else facts.length for one in (edge, leader))
    offset = -own * prim.number(f"{head}:offset")
    return Coupling.geared(f"{edge.joint.name}_mimic", edge.joint.name, leader.joint.name, -gearing * own / other,
                           offset or 0.0, Place(findings.file))  # fmt: skip
