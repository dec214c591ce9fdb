"""A USD file composed by Pixar's own library, and what it says as plain values.

Spoiled files can crash that library: this module runs in a child process (`cutjoint.description.formats.common.child`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade

from cutjoint.description.formats.usd.facts import Facts, Prim, Value

MOST_PRIMS = 100_000
_MESSAGE = re.compile(r" in file \S+ : '(.*?)'(?=\n|\Z)", re.DOTALL)
"""A message in a Tf.ErrorException, which has places in the sources of USD around it."""
_VECTORS = (Gf.Vec2f, Gf.Vec3f, Gf.Vec4f, Gf.Vec2d, Gf.Vec3d, Gf.Vec4d, Gf.Vec3h)
_QUATERNIONS = (Gf.Quatf, Gf.Quatd, Gf.Quath)


def read(path: object) -> Facts:
    """The stage in a file, default values at the default time, payloads loaded and instances followed."""
    try:
        stage = Usd.Stage.Open(str(path))
        broken = [str(error).strip() for error in stage.GetCompositionErrors()]
        return Facts(errors=tuple(broken)) if broken else _facts(stage)
    except Tf.ErrorException as error:
        messages = [" ".join(one.split()) for one in _MESSAGE.findall(str(error))]
        told = [one for one in messages if not one.startswith("Failed to open layer")]
        return Facts(errors=tuple(told or messages) or (str(error).strip() or "USD cannot open it",))


def _facts(stage: Usd.Stage) -> Facts:
    cache = UsdGeom.XformCache(Usd.TimeCode.Default())
    prims: list[Prim] = []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if len(prims) == MOST_PRIMS:
            return Facts(errors=(f"it has more than {MOST_PRIMS} prims",))
        prims.append(_prim(prim, cache))
    registry = Usd.SchemaRegistry()
    kinds = Tf.Type.FindByName("UsdSchemaBase").GetAllDerivedTypes()
    return Facts(
        length=float(UsdGeom.GetStageMetersPerUnit(stage)),
        lengths=bool(UsdGeom.StageHasAuthoredMetersPerUnit(stage)),
        mass=float(UsdPhysics.GetStageKilogramsPerUnit(stage)),
        up=str(UsdGeom.GetStageUpAxis(stage)),
        name=str(stage.GetRootLayer().defaultPrim),
        prims=tuple(prims),
        strange=tuple(_strange(stage.GetPseudoRoot())),
        known=frozenset(name for kind in kinds if (name := str(registry.GetSchemaTypeName(kind)))),
    )


def _prim(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Prim:
    names = [str(one.GetName()) for one in prim.GetAuthoredProperties()]
    defined = frozenset(map(str, prim.GetPrimDefinition().GetPropertyNames()))
    values, moving = {}, []
    for attribute in prim.GetAttributes():
        if attribute.GetNumTimeSamples() and attribute.Get() in (None, attribute.GetTypeName().defaultValue):
            moving.append(str(attribute.GetName()))
        value = _value(attribute)
        if value is not None:
            values[str(attribute.GetName())] = value
    targets = {str(one.GetName()): tuple(map(str, one.GetForwardedTargets())) for one in prim.GetRelationships()}
    order = [one.removeprefix("!invert!") for one in prim.GetAttribute("xformOpOrder").Get() or ()]
    return Prim(
        path=str(prim.GetPath()),
        type=str(prim.GetTypeName()),
        typed=bool(prim.GetPrimTypeInfo().GetSchemaTypeName()) or not prim.GetTypeName(),
        apis=_apis(prim),
        defined=defined,
        authored=tuple(names),
        values=values,
        targets=targets,
        world=_world(prim, cache),
        moving=tuple(moving),
        ops=tuple(one for one in order if one != "!resetXformStack!" and not prim.HasAttribute(one)),
        idle=tuple(one for one in names if one.startswith("xformOp:") and one not in order),
        material=_material(prim),
        strange=tuple(_strange(prim)),
        wrong=tuple(_wrong(prim)),
    )


def _apis(prim: Usd.Prim) -> tuple[str, ...]:
    """Those that USD knows, with what they bring along, and the others as the file names them."""
    listed = prim.GetMetadata("apiSchemas")
    named = [] if listed is None else list(listed.ApplyOperations([]))
    return tuple(dict.fromkeys([*map(str, prim.GetAppliedSchemas()), *map(str, named)]))


def _value(attribute: Usd.Attribute) -> Value | None:
    value = attribute.Get()
    if attribute.GetName() == "primvars:displayColor" and value:
        value = value[0]
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, _VECTORS):
        return tuple(map(float, value))
    if isinstance(value, _QUATERNIONS):
        return (float(value.GetReal()), *map(float, value.GetImaginary()))
    return None


def _world(prim: Usd.Prim, cache: UsdGeom.XformCache) -> tuple[tuple[float, ...], ...] | None:
    if not prim.IsA(UsdGeom.Xformable):
        return None
    matrix = cache.GetLocalToWorldTransform(prim)
    return tuple(tuple(float(matrix[column][row]) for column in range(4)) for row in range(4))


def _material(prim: Usd.Prim) -> str:
    if not prim.HasAPI(UsdPhysics.CollisionAPI):
        return ""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    return str(material.GetPath()) if material else ""


def _wrong(prim: Usd.Prim) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    for attribute in prim.GetAuthoredAttributes():
        name = str(attribute.GetName())
        for spec in attribute.GetPropertyStack():
            if isinstance(spec, Sdf.AttributeSpec) and not Sdf.ValueTypeNames.Find(str(spec.typeName)):
                yield name, str(spec.typeName), ()
        allowed = tuple(map(str, attribute.GetMetadata("allowedTokens") or ()))
        value = str(attribute.Get() or "")
        if allowed and value and value not in allowed:
            yield name, value, allowed
    kind = prim.GetMetadata("kind")
    if kind and not Kind.Registry.HasKind(kind):
        yield "kind", str(kind), tuple(map(str, Kind.Registry.GetAllKinds()))


def _strange(prim: Usd.Prim) -> Iterator[str]:
    for name, value in prim.GetAllAuthoredMetadata().items():
        if isinstance(value, Sdf.UnregisteredValue):
            yield str(name)
