"""What Pinocchio needs of a type of joint: a row each in `JOINTS`.

Velocities of a joint are the rates of its coordinates, in their order, so what is a length and what an angle is in the
type's own row (`cutjoint.description.joints`).  Everything else that is asked of a joint of a model is asked here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.description.model import Joint, JointType
from cutjoint.description.transforms import rpy_from_rotation
from cutjoint.mechanism import Stored
from cutjoint.mechanism.rotations import matrix_of

Anywhere = Callable[[np.random.Generator, Array, float], Array]
"""Draws a configuration with the body within a distance [m] of a point (3,) of the joint's frame."""


@dataclass(frozen=True, eq=False)
class PinocchioJoint:
    """A type of joint in Pinocchio.

    Attributes:
        models: its joint models: about or along x, y, z and any axis, or the only one.
        to_q: coordinates of a home posture as configuration; None where they are the same numbers.
        from_q: the reverse, a function of a module (postures pickle it).
        to_mujoco, from_mujoco: its configuration as MuJoCo has it, and back; None where they are the same numbers.
        anywhere: draws a start for a search; None where every coordinate is drawn within a range of its own.
        about_z: whether the model has its axis along z, so that its frame is turned there.
        first_with_parent: whether its first axis turns with the parent alone, which Pinocchio 4.1 leaves out of the
            rates of the joint Jacobian.
        rates: what its velocities are called, where there are several; of what turns freely, in the axes of its body.
    """

    models: tuple[type[pin.JointModel], ...]
    to_q: Callable[[Array], Array] | None = None
    from_q: Callable[[Array], Array] | None = None
    to_mujoco: Callable[[Array], Array] | None = None
    from_mujoco: Callable[[Array], Array] | None = None
    anywhere: Anywhere | None = None
    about_z: bool = False
    first_with_parent: bool = False
    rates: tuple[str, ...] = ()


def _quaternion(rpy: Array) -> Array:
    return np.asarray(pin.Quaternion(pin.rpy.rpyToMatrix(rpy)).coeffs())


def _rpy(quaternion: Array) -> Array:
    return np.array(rpy_from_rotation(matrix_of(quaternion)))


def _place_and_rpy(q: Array) -> Array:
    return np.concatenate([q[:3], _rpy(q[3:])])


def _from_place_and_angle(at: Array) -> Array:
    return np.array([at[0], at[1], np.cos(at[2]), np.sin(at[2])])


def _place_and_angle(q: Array) -> Array:
    return np.array([q[0], q[1], np.arctan2(q[3], q[2])])


def _scalar_first(q: Array) -> Array:
    return np.array([*q[:-4], q[-1], *q[-4:-1]])


def _scalar_last(qpos: Array) -> Array:
    """The quaternion made of length 1, as MuJoCo does; not a number where it has none."""
    with np.errstate(invalid="ignore"):
        w, *vector = qpos[-4:] / np.linalg.norm(qpos[-4:])
    return np.array([*qpos[:-4], *vector, w])


def _orientation(random: np.random.Generator) -> Array:
    """Uniform on SO(3)."""
    quaternion = random.normal(size=4)
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def _in_plane(random: np.random.Generator, middle: Array, reach: float) -> Array:
    angle = random.uniform(-np.pi, np.pi)
    return np.array([*(middle[:2] + random.uniform(-reach, reach, 2)), np.cos(angle), np.sin(angle)])


_TURNING = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ, pin.JointModelRevoluteUnaligned)
_SLIDING = (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ, pin.JointModelPrismaticUnaligned)

JOINTS: dict[JointType, PinocchioJoint] = {
    JointType.REVOLUTE: PinocchioJoint(_TURNING),
    JointType.CONTINUOUS: PinocchioJoint(_TURNING),
    JointType.PRISMATIC: PinocchioJoint(_SLIDING),
    JointType.UNIVERSAL: PinocchioJoint((pin.JointModelUniversal,), first_with_parent=True, rates=("first", "second")),
    JointType.SPHERICAL: PinocchioJoint(
        (pin.JointModelSpherical,),
        to_q=_quaternion,
        from_q=_rpy,
        to_mujoco=_scalar_first,
        from_mujoco=_scalar_last,
        rates=("wx", "wy", "wz"),
        anywhere=lambda random, middle, reach: _orientation(random),
    ),
    JointType.PLANAR: PinocchioJoint(
        (pin.JointModelPlanar,),
        to_q=_from_place_and_angle,
        from_q=_place_and_angle,
        to_mujoco=_place_and_angle,
        from_mujoco=_from_place_and_angle,
        anywhere=_in_plane,
        about_z=True,
        rates=("vx", "vy", "w"),
    ),
    JointType.FLOATING: PinocchioJoint(
        (pin.JointModelFreeFlyer,),
        to_q=lambda at: np.concatenate([at[:3], _quaternion(at[3:])]),
        from_q=_place_and_rpy,
        to_mujoco=_scalar_first,
        from_mujoco=_scalar_last,
        rates=("vx", "vy", "vz", "wx", "wy", "wz"),
        anywhere=lambda random, middle, reach: np.concatenate(
            [middle + random.uniform(-reach, reach, 3), _orientation(random)]
        ),
    ),
}

_TYPES = {model().shortname(): kind for kind, row in reversed(JOINTS.items()) for model in row.models}


def type_of(model: pin.Model, joint: int) -> JointType:
    """The type of a moving joint of a model; of those that are one in Pinocchio the first."""
    return _TYPES[model.joints[joint].shortname()]


def rates_of(model: pin.Model, joint: Joint) -> slice:
    """Where the velocities of a joint of the description are in those of the model; none of a fixed one."""
    if not joint.type.moves:
        return slice(0, 0)
    index = model.getJointId(joint.name)
    return slice(int(model.idx_vs[index]), int(model.idx_vs[index] + model.nvs[index]))


def is_ball(model: pin.Model, joint: int) -> bool:
    """Whether a joint of a model turns about a point, with velocities that are an angular velocity."""
    return type_of(model, joint) is JointType.SPHERICAL


def joint_model(joint: Joint) -> pin.JointModel:
    """A joint of a description, which moves, as Pinocchio's model of it."""
    row = JOINTS[joint.type]
    if row.about_z:
        return row.models[0]()
    axes = [np.array(joint.axis), np.array(joint.axis2)][: joint.type.axes]
    if len(row.models) > 1 and np.count_nonzero(axes[0]) == 1 and axes[0].max() == 1.0:
        return row.models[int(axes[0].argmax())]()
    return row.models[-1](*axes)


def coordinates_to_q(joint: Joint, value: float | tuple[float, ...]) -> Array:
    """A home value, the coordinates of its type, as Pinocchio's configuration of that joint."""
    numbers, to_q = np.atleast_1d(np.asarray(value, dtype=np.float64)), JOINTS[joint.type].to_q
    return numbers if to_q is None else to_q(numbers)


def stored_of(model: pin.Model, joints: Iterable[Joint]) -> tuple[Stored, ...]:
    """Names of what the configurations of a model have of some moving joints."""
    found = []
    for joint in joints:
        index, units = model.getJointId(joint.name), tuple(one.unit for one in joint.type.coordinates)
        place = int(model.idx_qs[index]), int(model.nqs[index])
        found.append(Stored(joint.name, units, *place, JOINTS[joint.type].from_q))
    return tuple(found)


def angles(model: pin.Model) -> dict[int, int]:
    """Indices in q of the coordinates that are plain angles (a whole turn more places the joint alike), and in v."""
    return {
        model.idx_qs[joint] + index: model.idx_vs[joint] + index
        for joint in range(1, model.njoints)
        if JOINTS[kind := type_of(model, joint)].to_q is None
        for index, is_length in enumerate(kind.lengths)
        if not is_length
    }


def travelling(model: pin.Model) -> Array:
    """Indices in q of the positions of free bodies, which may be anywhere: all lengths of joints with more than one."""
    found: list[int] = []
    for joint in range(1, model.njoints):
        count, start = sum(type_of(model, joint).lengths), model.idx_qs[joint]
        found += range(start, start + count) if count > 1 else ()
    return np.array(found, dtype=int)


def flies(model: pin.Model, joint: int) -> bool:
    """Whether a joint lets a body fly from the base, in all three directions."""
    return bool(model.parents[joint] == 0 and sum(type_of(model, joint).lengths) == 3)


def velocity_scale(model: pin.Model, length: float) -> Array:
    """Factor per velocity coordinate that turns dimensionless rates into [m/s] or [rad/s], shape (nv,)."""
    lengths = [one for joint in range(1, model.njoints) for one in type_of(model, joint).lengths]
    return readonly([length if one else 1.0 for one in lengths])


def support(model: pin.Model, joint: int) -> Array:
    """1 for every velocity coordinate that moves `joint`, else 0; shape (nv,)."""
    mask = np.zeros(model.nv)
    while joint > 0:
        mask[model.idx_vs[joint] : model.idx_vs[joint] + model.nvs[joint]] = 1.0
        joint = model.parents[joint]
    return readonly(mask)


def limit_violations(model: pin.Model, q: Array) -> dict[str, tuple[float, float, float]]:
    """Joints beyond their limits at a configuration (nq,): name -> (value, lower, upper), [m] or [rad]."""
    found: dict[str, tuple[float, float, float]] = {}
    for joint in range(1, model.njoints):
        if model.nqs[joint] == 1:
            i = model.idx_qs[joint]
            lower, upper = float(model.lowerPositionLimit[i]), float(model.upperPositionLimit[i])
            if not lower <= q[i] <= upper:
                found[model.names[joint]] = (float(q[i]), lower, upper)
    return found


def joints_of(model: pin.Model, motions: Array) -> tuple[str, ...]:
    """Names of the joints that take part in any of the dimensionless motions, shape (nv, k)."""
    moving = np.abs(motions).max(axis=1, initial=0.0) > 1e-6
    return tuple(
        model.names[joint]
        for joint in range(1, model.njoints)
        if moving[model.idx_vs[joint] : model.idx_vs[joint] + model.nvs[joint]].any()
    )
