"""MuJoCo's side of the reader, for a child process: text in, `compiled.Model` out.

Before it compiles, whatever has no part in the motion is taken out of the model: pictures, skins, height fields, and
the files of meshes whose inertia nobody asks for (a small ball stands where such a geom is).  So a robot whose looks
are missing loads, and none waits for the hulls of its pictures.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from cutjoint.description.formats.mjcf.compiled import (
    ActuatorRow,
    BodyRow,
    EqualityRow,
    GeomRow,
    JointRow,
    KeyRow,
    MeshRow,
    Model,
    Numbers,
    Refused,
    Request,
    SiteRow,
    TendonRow,
)

Spec = Any
"""`mujoco.MjSpec`, its elements, and `mujoco.MjModel`: MuJoCo ships no types for them."""

_CLOSE = 1e-9
"""Explicit moments are taken where MuJoCo's own agree so well: those have gone through a search for principal axes."""
LIFTED = 2e-12
"""Masses and moments below this are those that cutjoint's writer lets MuJoCo lift from zero."""
_GREY = (0.5, 0.5, 0.5, 1.0)
_SOFT = (
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
    ("margin", "jnt_margin", (0.0,)),
    ("solreffriction", "dof_solref", (0.02, 1.0)),
    ("solimpfriction", "dof_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)


def compile_model(request: Request) -> Model | Refused:
    """The model of a text, or why MuJoCo refuses it."""
    mujoco.set_mju_user_warning(lambda text: None)  # otherwise it writes a file MUJOCO_LOG.TXT where it runs
    schema = mujoco.mj_printSchema(False, False)
    meshes: dict[str, MeshRow] = {}
    os.chdir(request.folders[0])
    try:
        files = {name: text.encode() for name, text in request.models.items()}
        spec = mujoco.MjSpec.from_string(request.text, include=files)
        looks = _looks(spec)
        meshes = _lighten(spec, request.folders)
        if any(one.needed for one in meshes.values()):
            return Refused("", schema, tuple(meshes.values()))
        posed = [len(one.qpos) > 0 for one in spec.keys]
        model = spec.compile()
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        return Refused(str(error), schema, tuple(meshes.values()))
    finally:
        os.chdir("/")
    bodies = _bodies(spec, model, looks, request.own)
    return Model(
        name=spec.modelname,
        gravity=_numbers(model.opt.gravity),
        bodies=bodies,
        sites=_sites(spec, model),
        meshes=tuple(meshes.values()),
        equalities=_equalities(spec, model),
        tendons=_tendons(spec, model),
        actuators=_actuators(spec, model),
        keys=tuple(
            KeyRow(one.name, _numbers(model.key_qpos[one.id]))
            for one, said in zip(spec.keys, posed, strict=True)
            if said
        ),
        qpos0=_numbers(model.qpos0),
        schema=schema,
    )


def _line(element: Spec) -> int | None:
    found = re.search(r"line (\d+)", str(element.info))
    return int(found[1]) if found else None


def _numbers(values: Iterable[float]) -> Numbers:
    return tuple(float(value) for value in values)


def _range(limited: bool, values: Iterable[float], said: Iterable[float], wish: object) -> Numbers | None:
    """The range of what is limited; that of the file where MuJoCo silently takes none because it is upside down."""
    lower, upper = said
    if not limited and lower > upper and int(wish) != int(mujoco.mjtLimited.mjLIMITED_FALSE):  # type: ignore[call-overload]
        return (float(lower), float(upper))
    return _numbers(values) if limited else None


def _powers(first: float, model: Spec, name: str, index: int) -> Numbers:
    """The coefficients of powers 1, 2, 3; MuJoCo has the higher ones in an array of their own, if at all."""
    higher = getattr(model, name, None)
    return (float(first), *(() if higher is None else _numbers(np.atleast_1d(higher[index]))))


# --- what does not matter to the motion -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Looks:
    """A geom as the file has it: its type, its mesh, and its colour, its own or that of its material, if any."""

    kind: str
    mesh: str
    colour: Numbers | None


def _looks(spec: Spec) -> list[Looks]:
    """How every geom looks, before `_lighten`."""
    materials = {one.name: _colour(one.rgba) for one in spec.materials}
    looks = []
    for geom in spec.geoms:
        colour = _colour(geom.rgba)
        kind = mujoco.mjtGeom(int(geom.type)).name.removeprefix("mjGEOM_").lower()
        looks.append(Looks(kind, geom.meshname, materials.get(geom.material) if colour == _GREY else colour))
    return looks


def _colour(values: Iterable[np.float32]) -> Numbers:
    """Single precision as the shortest decimals that mean it."""
    return tuple(float(str(value)) for value in values)


def _lighten(spec: Spec, folders: Sequence[str]) -> dict[str, MeshRow]:
    """Take out what has no part in the motion; the meshes of the file by name, in their order."""
    compiler = spec.compiler
    compiler.fusestatic, compiler.discardvisual, compiler.LRopt.mode = False, False, 0
    meshes = {one.name: _mesh(one, folders) for one in spec.meshes}
    fields, textures, kept = {one.name for one in spec.hfields}, {one.name for one in spec.textures}, set()
    for geom in spec.geoms:
        mesh = meshes.get(geom.meshname)
        if mesh is not None and not mesh.there and _weighs(geom, compiler) and not _at_rest(geom.parent):
            meshes[mesh.name] = replace(mesh, needed=mesh.needed or geom.parent.name or "without a name")
        fitted = geom.type != mujoco.mjtGeom.mjGEOM_MESH  # a box or ball as large as the mesh
        if mesh is not None and mesh.there and (fitted or _weighs(geom, compiler)):
            kept.add(mesh.name)
        elif mesh is not None or geom.hfieldname in fields:
            geom.type, geom.meshname, geom.hfieldname = mujoco.mjtGeom.mjGEOM_SPHERE, "", ""
            geom.size, geom.mass, geom.typeinertia = [1e-3] * 3, 0.0, mujoco.mjtGeomInertia.mjINERTIA_VOLUME
    for site in spec.sites:
        if getattr(site, "meshname", "") in meshes:
            site.type, site.meshname = mujoco.mjtGeom.mjGEOM_SPHERE, ""
    for mesh in list(spec.meshes):
        if mesh.name not in kept:
            spec.delete(mesh)
        elif mesh.file:
            mesh.file = meshes[mesh.name].file
    for element in (*spec.skins, *spec.hfields, *spec.textures):
        spec.delete(element)
    for material in spec.materials:
        if all(name in ("", *textures) for name in material.textures):
            material.textures = [""] * len(material.textures)
    return meshes


def _mesh(mesh: Spec, folders: Sequence[str]) -> MeshRow:
    """Where the file of a mesh is.  A mesh out of numbers in the file itself is there."""
    compiler = getattr(mesh, "compiler", None)
    inside = getattr(compiler, "meshdir", "")
    places = [os.path.normpath(os.path.join(folder, inside, mesh.file)) for folder in folders]
    file = next((one for one in places if os.path.isfile(one)), places[0]) if mesh.file else ""
    there = not mesh.file or os.path.isfile(file)
    return MeshRow(mesh.name, _line(mesh), file, mesh.file, _numbers(mesh.scale), there, "")


def _weighs(geom: Spec, compiler: Spec) -> bool:
    """Whether the inertia of a body comes from this geom among others."""
    body, (first, last) = geom.parent, compiler.inertiagrouprange
    ways = mujoco.mjtInertiaFromGeom
    asked = compiler.inertiafromgeom == ways.mjINERTIAFROMGEOM_TRUE or (
        compiler.inertiafromgeom == ways.mjINERTIAFROMGEOM_AUTO and not body.explicitinertial
    )
    light = geom.mass == 0.0 or (math.isnan(geom.mass) and geom.density == 0.0)
    return bool(asked and body.name != "world" and first <= geom.group <= last and not light)


def _at_rest(body: Spec) -> bool:
    """Whether no joint moves a body."""
    while body is not None and body.name != "world":
        if len(body.joints):
            return False
        body = body.parent
    return True


# --- what is told ---------------------------------------------------------------------------------------------------


def _bodies(spec: Spec, model: Spec, looks: Sequence[Looks], own: bool) -> tuple[BodyRow, ...]:
    geoms: dict[int, list[GeomRow]] = {}
    for geom, look in sorted(zip(spec.geoms, looks, strict=True), key=lambda pair: int(pair[0].id)):
        geoms.setdefault(int(model.geom_bodyid[geom.id]), []).append(_geom(geom, model, look))
    joints: dict[int, list[JointRow]] = {}
    for joint in sorted(spec.joints, key=lambda one: int(one.id)):
        joints.setdefault(int(model.jnt_bodyid[joint.id]), []).append(_joint(joint, model))
    return tuple(
        BodyRow(
            name=body.name,
            line=_line(body),
            parent=int(model.body_parentid[body.id]),
            position=_numbers(model.body_pos[body.id]),
            quaternion=_numbers(model.body_quat[body.id]),
            inertia=_inertia(body, model, own),
            gravcomp=float(model.body_gravcomp[body.id]),
            mocap=bool(body.mocap),
            joints=tuple(joints.get(body.id, ())),
            geoms=tuple(geoms.get(body.id, ())),
        )
        for body in sorted(spec.bodies, key=lambda one: int(one.id))
    )


def _inertia(body: Spec, model: Spec, own: bool) -> tuple[float, Numbers, Numbers] | None:
    """Mass, centre of mass and moments; as they stand in the file where MuJoCo's mean the same."""
    mass, moments = float(model.body_mass[body.id]), model.body_inertia[body.id]
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[body.id])
    turn = axes.reshape(3, 3)
    tensor = turn @ np.diag(moments) @ turn.T
    found = (mass, _numbers(model.body_ipos[body.id]), _entries(tensor))
    if not body.explicitinertial or math.isnan(body.fullinertia[0]):
        return found if mass > LIFTED or moments.max() > LIFTED else None
    xx, yy, zz, xy, xz, yz = body.fullinertia
    said = (float(body.mass), _numbers(body.ipos), _numbers((xx, yy, zz, xy, xz, yz)))
    return said if own or all(map(_agree, _flat(said), _flat(found))) else found


def _flat(inertia: tuple[float, Numbers, Numbers]) -> tuple[Numbers, Numbers, Numbers]:
    return (inertia[0],), inertia[1], inertia[2]


def _agree(said: Numbers, found: Numbers) -> bool:
    return bool(np.allclose(said, found, rtol=0.0, atol=_CLOSE * max(map(abs, said)) + LIFTED))


def _entries(tensor: Any) -> Numbers:
    """xx, yy, zz, xy, xz, yz."""
    symmetric = 0.5 * (tensor + tensor.T)
    return _numbers(symmetric[at] for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def _joint(joint: Spec, model: Spec) -> JointRow:
    index = int(joint.id)
    kind = mujoco.mjtJoint(int(model.jnt_type[index])).name.removeprefix("mjJNT_").lower()
    dof, address = int(model.jnt_dofadr[index]), int(model.jnt_qposadr[index])
    single = kind in ("hinge", "slide")
    bounds = _range(bool(model.jnt_limited[index]), model.jnt_range[index], joint.range, joint.limited)
    friction = float(model.dof_frictionloss[dof])
    soft = [
        name
        for name, array, usual in _SOFT
        if (friction > 0.0 if array.startswith("dof") else bounds is not None)
        and not np.allclose(getattr(model, array)[dof if array.startswith("dof") else index], usual, 1e-14, 0.0)
    ]
    return JointRow(
        name=joint.name,
        kind=kind,
        line=_line(joint),
        address=address,
        position=_numbers(model.jnt_pos[index]) if kind != "free" else (0.0, 0.0, 0.0),
        axis=_numbers(model.jnt_axis[index]),
        ref=float(model.qpos0[address]) if single else 0.0,
        range=bounds,
        force=_range(
            bool(model.jnt_actfrclimited[index]), model.jnt_actfrcrange[index], joint.actfrcrange, joint.actfrclimited
        ),
        damping=_powers(model.dof_damping[dof], model, "dof_dampingpoly", dof),
        stiffness=_powers(model.jnt_stiffness[index], model, "jnt_stiffnesspoly", index),
        spring=float(model.qpos_spring[address]) if single else 0.0,
        springyield=float(model.jnt_springyield[index]) if hasattr(model, "jnt_springyield") else 0.0,
        friction=friction,
        armature=float(model.dof_armature[dof]),
        soft=tuple(soft),
    )


def _geom(geom: Spec, model: Spec, look: Looks) -> GeomRow:
    """A geom where the file has it: MuJoCo moves meshes to their centres of mass."""
    index = int(geom.id)
    position, quaternion = model.geom_pos[index].copy(), model.geom_quat[index].copy()
    data = int(model.geom_dataid[index])
    if look.kind == "mesh" and data >= 0:
        back, turn = np.zeros(3), np.zeros(4)
        mujoco.mju_negPose(back, turn, model.mesh_pos[data], model.mesh_quat[data])
        mujoco.mju_mulPose(position, quaternion, model.geom_pos[index], model.geom_quat[index], back, turn)
    return GeomRow(
        name=geom.name,
        kind=look.kind,
        line=_line(geom),
        size=_numbers(model.geom_size[index]),
        position=_numbers(position),
        quaternion=_numbers(quaternion),
        colour=look.colour,
        mesh=look.mesh,
        visual=not model.geom_contype[index] and not model.geom_conaffinity[index],
    )


def _sites(spec: Spec, model: Spec) -> tuple[SiteRow, ...]:
    return tuple(
        SiteRow(
            one.name,
            int(model.site_bodyid[one.id]),
            _numbers(model.site_pos[one.id]),
            _numbers(model.site_quat[one.id]),
        )
        for one in sorted(spec.sites, key=lambda one: int(one.id))
    )


def _equalities(spec: Spec, model: Spec) -> tuple[EqualityRow, ...]:
    return tuple(
        EqualityRow(
            name=one.name,
            kind=mujoco.mjtEq(int(model.eq_type[one.id])).name.removeprefix("mjEQ_").lower(),
            line=_line(one),
            active=bool(model.eq_active0[one.id]),
            by_sites=int(model.eq_objtype[one.id]) == int(mujoco.mjtObj.mjOBJ_SITE),
            first=int(model.eq_obj1id[one.id]),
            second=int(model.eq_obj2id[one.id]),
            data=_numbers(model.eq_data[one.id]),
        )
        for one in sorted(spec.equalities, key=lambda one: int(one.id))
    )


def _tendons(spec: Spec, model: Spec) -> tuple[TendonRow, ...]:
    return tuple(_tendon(one, model) for one in sorted(spec.tendons, key=lambda one: int(one.id)))


def _tendon(tendon: Spec, model: Spec) -> TendonRow:
    index = int(tendon.id)
    start, count = int(model.tendon_adr[index]), int(model.tendon_num[index])
    path = tuple(
        (
            mujoco.mjtWrap(int(model.wrap_type[at])).name.removeprefix("mjWRAP_").lower(),
            int(model.wrap_objid[at]),
            float(model.wrap_prm[at]),
        )
        for at in range(start, start + count)
    )
    forced = getattr(model, "tendon_actfrclimited", None)
    return TendonRow(
        name=tendon.name,
        line=_line(tendon),
        path=path,
        length=float(model.tendon_length0[index]),
        rest=_numbers(model.tendon_lengthspring[index]),
        stiffness=_powers(model.tendon_stiffness[index], model, "tendon_stiffnesspoly", index),
        damping=_powers(model.tendon_damping[index], model, "tendon_dampingpoly", index),
        springyield=float(model.tendon_springyield[index]) if hasattr(model, "tendon_springyield") else 0.0,
        friction=float(model.tendon_frictionloss[index]),
        armature=float(model.tendon_armature[index]) if hasattr(model, "tendon_armature") else 0.0,
        range=_range(bool(model.tendon_limited[index]), model.tendon_range[index], tendon.range, tendon.limited),
        force=None
        if forced is None
        else _range(bool(forced[index]), model.tendon_actfrcrange[index], tendon.actfrcrange, tendon.actfrclimited),
    )


def _actuators(spec: Spec, model: Spec) -> tuple[ActuatorRow, ...]:
    return tuple(_actuator(one, model) for one in sorted(spec.actuators, key=lambda one: int(one.id)))


def _actuator(actuator: Spec, model: Spec) -> ActuatorRow:
    index = int(actuator.id)
    on = mujoco.mjtTrn(int(model.actuator_trntype[index])).name.removeprefix("mjTRN_").lower()
    plain = (
        int(model.actuator_gaintype[index]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(model.actuator_biastype[index]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and int(model.actuator_dyntype[index]) == int(mujoco.mjtDyn.mjDYN_NONE)
    )
    control = int(model.actuator_ctrladr[index]) if hasattr(model, "actuator_ctrladr") else index
    return ActuatorRow(
        name=actuator.name,
        line=_line(actuator),
        on="joint" if on == "jointinparent" else on,
        target=int(model.actuator_trnid[index][0]),
        gear=float(model.actuator_gear[index][0]),
        force=_range(
            bool(model.actuator_forcelimited[index]),
            model.actuator_forcerange[index],
            actuator.forcerange,
            actuator.forcelimited,
        ),
        control=_range(
            bool(model.actuator_ctrllimited[control]),
            model.actuator_ctrlrange[control],
            actuator.ctrlrange,
            actuator.ctrllimited,
        )
        if plain
        else None,
        gain=float(model.actuator_gainprm[index][0]),
        armature=float(model.actuator_armature[index]) if hasattr(model, "actuator_armature") else 0.0,
        damping=_powers(model.actuator_damping[index], model, "actuator_dampingpoly", index)
        if hasattr(model, "actuator_damping")
        else (0.0,),
    )
