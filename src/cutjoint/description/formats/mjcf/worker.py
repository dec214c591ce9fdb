"""MuJoCo's side of the reader, for a child process: text in, `compiled.Model` out.

Before it compiles, whatever has no part in the motion is taken out of the model: pictures, skins, height fields, and
the files of meshes whose inertia nobody asks for (a small ball stands where such a geom is).  So a robot whose looks
are missing loads, and none waits for the hulls of its pictures.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from cutjoint.description.formats.mjcf.compiled import KeyRow, MeshRow, Model, Numbers, Refused, Request
from cutjoint.description.formats.mjcf.told import (
    Looks,
    Spec,
    actuators,
    bodies,
    equalities,
    line_of,
    numbers,
    sites,
    tendons,
)

_GREY = (0.5, 0.5, 0.5, 1.0)


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
        posed = [one for one in spec.keys if len(one.qpos)]
        model = spec.compile()
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        return Refused(str(error), schema, tuple(meshes.values()))
    finally:
        os.chdir("/")
    return Model(
        name=spec.modelname,
        gravity=numbers(model.opt.gravity),
        bodies=bodies(spec, model, looks, request.own),
        sites=sites(spec, model),
        meshes=tuple(meshes.values()),
        equalities=equalities(spec, model),
        tendons=tendons(spec, model),
        actuators=actuators(spec, model),
        keys=tuple(KeyRow(one.name, numbers(model.key_qpos[one.id])) for one in posed),
        qpos0=numbers(model.qpos0),
        schema=schema,
    )


# --- what does not matter to the motion -----------------------------------------------------------------------------


def _looks(spec: Spec) -> list[tuple[Spec, Looks]]:
    """Every geom and how it looks, before `_lighten`."""
    materials = {one.name: _colour(one.rgba) for one in spec.materials}
    looks = []
    for geom in spec.geoms:
        colour = _colour(geom.rgba)
        kind = mujoco.mjtGeom(int(geom.type)).name.removeprefix("mjGEOM_").lower()
        own = materials.get(geom.material) if colour == _GREY else colour
        looks.append((geom, Looks(kind, geom.meshname, own)))
    return looks


def _colour(values: Iterable[np.float32]) -> Numbers:
    """Single precision as the shortest decimals that mean it."""
    return tuple(float(str(value)) for value in values)


def _lighten(spec: Spec, folders: Sequence[str]) -> dict[str, MeshRow]:
    """Take out what has no part in the motion; the meshes of the file by name, in their order."""
    compiler = spec.compiler
    compiler.fusestatic, compiler.discardvisual, compiler.LRopt.mode = False, False, 0
    spec.memory, spec.nconmax, spec.njmax, spec.nstack = -1, -1, -1, -1  # for contacts, of which there are none here
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
    return MeshRow(mesh.name, line_of(mesh), file, mesh.file, numbers(mesh.scale), there, "")


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
