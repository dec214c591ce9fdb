"""Slips of the pen in a USD file: properties, types, schemas and metadata that USD does not know and hence skips."""

from __future__ import annotations

import re
from collections.abc import Collection

from cutjoint.description.formats.usd.facts import Facts, Prim
from cutjoint.findings import Findings, clip, closest

NEAR = 0.82
"""How alike a name and a known one are from which on it is taken for a slip, unless its letters are the same ones."""
TYPES = ("bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double", "timecode", "string", "token",
         "asset", "opaque", "group", "pathExpression", "matrix2d", "matrix3d", "matrix4d", "frame4d",
         *(f"quat{kind}" for kind in "hfd"),
         *(f"{base}{size}" for base in ("int", "half", "float", "double") for size in "234"),
         *(f"{base}3{kind}" for base in ("point", "vector", "normal", "color") for kind in "hfd"))  # fmt: skip
STAGE = ("metersPerUnit", "kilogramsPerUnit", "upAxis", "defaultPrim", "subLayers", "timeCodesPerSecond",
         "startTimeCode", "endTimeCode", "customLayerData", "documentation", "framesPerSecond", "comment")  # fmt: skip
PRIM = ("apiSchemas", "references", "payload", "inherits", "specializes", "variants", "variantSets", "instanceable",
        "active", "kind", "hidden", "customData", "assetInfo", "documentation", "displayName")  # fmt: skip
OWNERS = ("Physx", "Newton", "Isaac", "Omni", "Mjc")
"""What schemas of others begin with: PhysxCollisionAPI is no slip of PhysicsCollisionAPI."""
OTHERS = {
    "PhysicsJointStateAPI": ("state:#:physics:position", "state:#:physics:velocity"),
    "PhysxJointAPI": ("physxJoint:armature", "physxJoint:jointFriction", "physxJoint:maxJointVelocity",
                      "physxJoint:enableProjection"),
    "PhysxJointAxisAPI": ("physxJointAxis:#:armature", "physxJointAxis:#:dynamicFrictionEffort",
                          "physxJointAxis:#:maxJointVelocity", "physxJointAxis:#:staticFrictionEffort",
                          "physxJointAxis:#:viscousFrictionCoefficient"),
    "PhysxMimicJointAPI": ("physxMimicJoint:#:gearing", "physxMimicJoint:#:offset", "physxMimicJoint:#:referenceJoint",
                           "physxMimicJoint:#:referenceJointAxis", "physxMimicJoint:#:naturalFrequency",
                           "physxMimicJoint:#:dampingRatio"),
    "MaterialBindingAPI": ("material:binding", "material:binding:physics", "material:binding:preview",
                           "material:binding:full"),
    "PhysicsRigidBodyAPI": ("physics:linearVelocity",),  # what some write for physics:velocity
    "PhysxRigidBodyAPI": ("physxRigidBody:disableGravity", "physxRigidBody:linearDamping",
                          "physxRigidBody:angularDamping", "physxRigidBody:lockedPosAxis",
                          "physxRigidBody:lockedRotAxis"),
}  # fmt: skip
"""Schemas of others that are read, and their properties; # stands for the name of an instance.

https://docs.omniverse.nvidia.com/kit/docs/omni_usd_schema_physics/latest/
"""
_OPS = ("translate", "scale", "orient", "transform", "rotateX", "rotateY", "rotateZ",
        *(f"rotate{order}" for order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")))  # fmt: skip


def check_names(facts: Facts, findings: Findings) -> None:
    """Note what is not known and near to something known, or in a namespace that is USD's own."""
    for name in facts.strange:
        _metadata(name, STAGE, "the stage", findings)
    apis = {name for name in facts.known if name.endswith("API")} | set(OTHERS)
    types = sorted(facts.known - apis)
    for prim in facts.prims:
        for name in prim.strange:
            _metadata(name, PRIM, f"<{prim.path}>", findings)
        if not prim.typed and (near := _slip(prim.type, _alike(prim.type, types))):
            findings.error(f"<{prim.path}> of the unknown type '{clip(prim.type)}'", "a type of USD", _did(near))
        for api in prim.apis:
            base = api.partition(":")[0]
            if base not in apis and (near := _slip(base, _alike(base, apis))) and not _numbered(base, near):
                found = f"the unknown schema '{clip(base)}' is applied to <{prim.path}>"
                findings.error(found, "a schema of USD", _did(near))
        _properties(prim, findings)
        for name, found, allowed in prim.wrong:
            what = f"'{clip(name)}' of <{prim.path}> is {'' if allowed else 'of the type '}'{clip(found)}'"
            findings.error(
                what, f"one of {', '.join(allowed)}" if allowed else "a type of USD", _near(found, allowed or TYPES)
            )


def _alike(name: str, known: Collection[str]) -> list[str]:
    """The known names that may have been meant: only those of the same owner, where a name has that in front."""
    owner = next((one for one in OWNERS if name.startswith(one)), "")
    return sorted(one for one in known if one.startswith(owner))


def _metadata(name: str, known: Collection[str], of: str, findings: Findings) -> None:
    near = _slip(name, known)
    if near:
        findings.error(f"{of} has the unknown metadata '{clip(name)}'", "metadata of USD", _did(near))


def _properties(prim: Prim, findings: Findings) -> None:
    known = set(prim.defined)
    for api, names in OTHERS.items():
        for instance in prim.instances(api) or (("",) if prim.has(api) else ()):
            known |= {name.replace("#", instance) for name in names}
    for name in prim.authored:
        if name in known or name in prim.ops or name.removesuffix(":indices") in known:
            continue
        if name.startswith("xformOp:"):
            kind = name.split(":")[1]
            if kind not in _OPS:
                findings.error(f"<{prim.path}> has the unknown '{clip(name)}'", "a transformation", _near(kind, _OPS))
            elif name in prim.idle:
                found = f"'{clip(name)}' of <{prim.path}> is not in its xformOpOrder, and does nothing"
                findings.warn(found, "every transformation in the order", "name it there, or remove it")
        elif name.startswith(("physics:", "drive:", "limit:")):
            found = f"<{prim.path}> has the unknown property '{clip(name)}'"
            mend = _near(name, known) or "apply the schema that it belongs to, or remove it"
            (findings.error if _slip(name, sorted(known)) else findings.doubt)(found, _schemas(prim), mend)
        elif not name.startswith(("outputs:", "inputs:")):
            near = _slip(name, sorted(known | set(OTHERS["MaterialBindingAPI"])))
            if near and not _numbered(name, near):
                found = f"<{prim.path}> has the unknown property '{clip(name)}'"
                findings.error(found, _schemas(prim), _did(near))
    for name in prim.ops:
        found = f"xformOpOrder of <{prim.path}> names '{clip(name)}', which it does not have"
        findings.error(found, "transformations of its own", _near(name, [n for n in prim.authored if "xformOp" in n]))


def _schemas(prim: Prim) -> str:
    named = ", ".join(one for one in (prim.type, *prim.apis) if one)
    return f"a property of {named}" if named else "a property of its type or schemas"


def _numbered(name: str, near: str) -> bool:
    """Whether two names differ in a number only, as `body0` and `body1` do: no slip."""
    return re.sub(r"\d", "#", name) == re.sub(r"\d", "#", near)


def _slip(name: str, known: Collection[str]) -> str:
    """The known name that was meant, or empty: one of the same letters in another order, or a very like one."""
    letters = sorted(name.lower())
    same = next((one for one in known if sorted(one.lower()) == letters and one != name), "")
    return same or closest(name, [one for one in known if abs(len(one) - len(name)) <= 2], NEAR)


def _near(name: str, known: Collection[str]) -> str:
    near = closest(name, sorted(known), 0.6)
    return _did(near) if near else ""


def _did(near: str) -> str:
    return f"did you mean '{near}'?"
