"""A compiled model of MuJoCo as rows of plain values, for the child process that compiled it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cutjoint.description.formats.mjcf.compiled import (
    ActuatorRow,
    BodyRow,
    EqualityRow,
    GeomRow,
    JointRow,
    Numbers,
    SiteRow,
    TendonRow,
)

Spec = Any
"""`mujoco.MjSpec`, its elements, and `mujoco.MjModel`: MuJoCo ships no types for them."""

_CLOSE = 1e-9
"""Explicit moments are taken where MuJoCo's own agree so well: those have gone through a search for principal axes."""
LIFTED = 2e-12
"""Masses and moments below this are those that cutjoint's writer lets MuJoCo lift from zero."""
_SOFT = (
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
    ("margin", "jnt_margin", (0.0,)),
    ("solreffriction", "dof_solref", (0.02, 1.0)),
    ("solimpfriction", "dof_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)


@dataclass(frozen=True)
class Looks:
    """A geom as the file has it: its type, its mesh, and its colour, its own or that of its material, if any."""

    kind: str
    mesh: str
    colour: Numbers | None


def line_of(element: Spec) -> int | None:
    """The line of the text that an element stands on, where MuJoCo knows it."""
    found = re.search(r"line (\d+)", str(element.info))
    return int(found[1]) if found else None


def numbers(values: Iterable[float]) -> Numbers:
    """As plain numbers."""
    return tuple(float(value) for value in values)


def _ordered(elements: Iterable[Spec]) -> list[Spec]:
    """As the compiled model has them."""
    return sorted(elements, key=lambda one: int(one.id))


def _word(enumeration: Spec, value: object) -> str:
    """A value of one of MuJoCo's enumerations, such as mjJNT_HINGE, as in `hinge`."""
    return str(enumeration(int(value)).name).partition("_")[2].lower()  # type: ignore[call-overload]


def _range(model: Spec, what: str, index: int, said: Iterable[float], wish: object) -> Numbers | None:
    """The range of what is limited; that of the file where MuJoCo silently takes none because it is upside down."""
    lower, upper = said
    limited = bool(getattr(model, f"{what}limited")[index])
    if not limited and lower > upper and int(wish) != int(mujoco.mjtLimited.mjLIMITED_FALSE):  # type: ignore[call-overload]
        return (float(lower), float(upper))
    return numbers(getattr(model, f"{what}range")[index]) if limited else None


def _newer(model: Spec, name: str, index: int) -> float:
    """A number that older versions of MuJoCo do not have."""
    array = getattr(model, name, None)
    return 0.0 if array is None else float(array[index])


def _powers(model: Spec, name: str, index: int) -> Numbers:
    """The coefficients of powers 1, 2, 3; MuJoCo has the higher ones in an array of their own, if at all."""
    higher = getattr(model, f"{name}poly", None)
    return (_newer(model, name, index), *(() if higher is None else numbers(np.atleast_1d(higher[index]))))


def bodies(spec: Spec, model: Spec, looks: Sequence[tuple[Spec, Looks]], own: bool) -> tuple[BodyRow, ...]:
    """All bodies in the order of the model; of a file that is `own`, moments are those of the file."""
    geoms: dict[int, list[GeomRow]] = {}
    for geom, look in sorted(looks, key=lambda pair: int(pair[0].id)):
        geoms.setdefault(int(model.geom_bodyid[geom.id]), []).append(_geom(geom, model, look))
    joints: dict[int, list[JointRow]] = {}
    for joint in _ordered(spec.joints):
        joints.setdefault(int(model.jnt_bodyid[joint.id]), []).append(_joint(joint, model))
    return tuple(
        BodyRow(
            name=body.name,
            line=line_of(body),
            parent=int(model.body_parentid[body.id]),
            position=numbers(model.body_pos[body.id]),
            quaternion=numbers(model.body_quat[body.id]),
            inertia=_inertia(body, model, spec.compiler, own),
            gravcomp=float(model.body_gravcomp[body.id]),
            mocap=bool(body.mocap),
            joints=tuple(joints.get(body.id, ())),
            geoms=tuple(geoms.get(body.id, ())),
        )
        for body in _ordered(spec.bodies)
    )


def _inertia(body: Spec, model: Spec, compiler: Spec, own: bool) -> tuple[float, Numbers, Numbers] | None:
    """Mass, centre of mass and moments; as they stand in the file where MuJoCo's mean the same."""
    mass, moments = float(model.body_mass[body.id]), model.body_inertia[body.id]
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[body.id])
    turn = axes.reshape(3, 3)
    tensor = turn @ np.diag(moments) @ turn.T
    found = (mass, numbers(model.body_ipos[body.id]), _entries(tensor))
    if not body.explicitinertial or math.isnan(body.fullinertia[0]):
        nothing = mass == 0.0 or (own and max(mass, moments.max()) <= LIFTED)
        return None if nothing else found
    xx, yy, zz, xy, xz, yz = body.fullinertia
    said = (float(body.mass), numbers(body.ipos), numbers((xx, yy, zz, xy, xz, yz)))
    smallest = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])[0]
    lifted = body.mass < compiler.boundmass or smallest < compiler.boundinertia
    agrees = not lifted and all(map(_agree, _flat(said), _flat(found)))
    return said if own or agrees else found


def _flat(inertia: tuple[float, Numbers, Numbers]) -> tuple[Numbers, Numbers, Numbers]:
    return (inertia[0],), inertia[1], inertia[2]


def _agree(said: Numbers, found: Numbers) -> bool:
    return bool(np.allclose(said, found, rtol=0.0, atol=_CLOSE * max(map(abs, said)) + LIFTED))


def _entries(tensor: Any) -> Numbers:
    """xx, yy, zz, xy, xz, yz."""
    symmetric = 0.5 * (tensor + tensor.T)
    return numbers(symmetric[at] for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def _joint(joint: Spec, model: Spec) -> JointRow:
    index = int(joint.id)
    kind = _word(mujoco.mjtJoint, model.jnt_type[index])
    dof, address = int(model.jnt_dofadr[index]), int(model.jnt_qposadr[index])
    single = kind in ("hinge", "slide")
    bounds = _range(model, "jnt_", index, joint.range, joint.limited)
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
        line=line_of(joint),
        address=address,
        position=numbers(model.jnt_pos[index]) if kind != "free" else (0.0, 0.0, 0.0),
        axis=numbers(model.jnt_axis[index]),
        ref=float(model.qpos0[address]) if single else 0.0,
        range=bounds,
        force=_range(model, "jnt_actfrc", index, joint.actfrcrange, joint.actfrclimited),
        damping=_powers(model, "dof_damping", dof),
        stiffness=_powers(model, "jnt_stiffness", index),
        spring=float(model.qpos_spring[address]) if single else 0.0,
        springyield=_newer(model, "jnt_springyield", index),
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
        line=line_of(geom),
        size=numbers(model.geom_size[index]),
        position=numbers(position),
        quaternion=numbers(quaternion),
        colour=look.colour,
        mesh=look.mesh,
        visual=not model.geom_contype[index] and not model.geom_conaffinity[index],
    )


def sites(spec: Spec, model: Spec) -> tuple[SiteRow, ...]:
    """All sites."""
    at, turn = model.site_pos, model.site_quat
    return tuple(
        SiteRow(one.name, int(model.site_bodyid[one.id]), numbers(at[one.id]), numbers(turn[one.id]))
        for one in _ordered(spec.sites)
    )


def equalities(spec: Spec, model: Spec) -> tuple[EqualityRow, ...]:
    """All equalities."""
    return tuple(
        EqualityRow(
            name=one.name,
            kind=_word(mujoco.mjtEq, model.eq_type[one.id]),
            line=line_of(one),
            active=bool(model.eq_active0[one.id]),
            by_sites=int(model.eq_objtype[one.id]) == int(mujoco.mjtObj.mjOBJ_SITE),
            first=int(model.eq_obj1id[one.id]),
            second=int(model.eq_obj2id[one.id]),
            data=numbers(model.eq_data[one.id]),
        )
        for one in _ordered(spec.equalities)
    )


def tendons(spec: Spec, model: Spec) -> tuple[TendonRow, ...]:
    """All tendons."""
    return tuple(_tendon(one, model) for one in _ordered(spec.tendons))


def _tendon(tendon: Spec, model: Spec) -> TendonRow:
    index = int(tendon.id)
    start, count = int(model.tendon_adr[index]), int(model.tendon_num[index])
    path = tuple(
        (_word(mujoco.mjtWrap, model.wrap_type[at]), int(model.wrap_objid[at]), float(model.wrap_prm[at]))
        for at in range(start, start + count)
    )
    return TendonRow(
        name=tendon.name,
        line=line_of(tendon),
        path=path,
        length=float(model.tendon_length0[index]),
        rest=numbers(model.tendon_lengthspring[index]),
        stiffness=_powers(model, "tendon_stiffness", index),
        damping=_powers(model, "tendon_damping", index),
        springyield=_newer(model, "tendon_springyield", index),
        friction=float(model.tendon_frictionloss[index]),
        armature=float(model.tendon_armature[index]),
        range=_range(model, "tendon_", index, tendon.range, tendon.limited),
        force=_range(model, "tendon_actfrc", index, tendon.actfrcrange, tendon.actfrclimited),
    )


def actuators(spec: Spec, model: Spec) -> tuple[ActuatorRow, ...]:
    """All actuators."""
    return tuple(_actuator(one, model) for one in _ordered(spec.actuators))


def _actuator(actuator: Spec, model: Spec) -> ActuatorRow:
    index = int(actuator.id)
    on = _word(mujoco.mjtTrn, model.actuator_trntype[index])
    kinds = (
        _word(mujoco.mjtGain, model.actuator_gaintype[index]),
        _word(mujoco.mjtBias, model.actuator_biastype[index]),
        _word(mujoco.mjtDyn, model.actuator_dyntype[index]),
    )
    at = int(model.actuator_ctrladr[index]) if hasattr(model, "actuator_ctrladr") else index
    control = _range(model, "actuator_ctrl", at, actuator.ctrlrange, actuator.ctrllimited)
    return ActuatorRow(
        name=actuator.name,
        line=line_of(actuator),
        on="joint" if on == "jointinparent" else on,
        target=int(model.actuator_trnid[index][0]),
        gear=float(model.actuator_gear[index][0]),
        force=_range(model, "actuator_force", index, actuator.forcerange, actuator.forcelimited),
        control=control if kinds == ("fixed", "none", "none") else None,
        gain=float(model.actuator_gainprm[index][0]),
        armature=_newer(model, "actuator_armature", index),
        damping=_powers(model, "actuator_damping", index),
    )
