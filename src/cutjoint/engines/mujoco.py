"""MuJoCo's opinion of a closed chain: the robot written as MJCF, loaded by MuJoCo, and asked for its dynamics.

Mass matrix and bias of the tree and the directions of the constraints are exact in MuJoCo and are compared to
rounding.  Its constraints are soft: its solver lets through about 1 - d of the acceleration that they would stop, where
the impedance d is at most 0.9999: each row gives by (1 - d) / d of its inverse inertia, which MuJoCo estimates once.
Solving the same matrices with hard constraints takes the softness away; J_dot v then comes from a central difference of
MuJoCo's own Jacobian.

MuJoCo gets the robot in natural units (`cutjoint.engines.natural`).  What comes back is in SI units.

E. Todorov, Convex and analytically-invertible dynamics with contacts and constraints, ICRA 2014; MuJoCo documentation,
chapter Computation.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array, Values
from cutjoint.chain import ClosedChain
from cutjoint.description.formats import write
from cutjoint.description.formats.mjcf.types import TENDON
from cutjoint.description.model import JointPhysics, JointType, Limits, RobotDescription
from cutjoint.description.transforms import rotation_from_quaternion
from cutjoint.engines.cut_motion import CutMotion, smooth_sign
from cutjoint.engines.natural import natural, units_of
from cutjoint.errors import InputError
from cutjoint.extras import needed

if TYPE_CHECKING:
    import mujoco


IMPEDANCE = 0.9999
"""The largest that MuJoCo accepts."""

_STEP = 1e-5
"""How far the fastest joint moves to either side for J_dot v [rad or lengths]; its square is rounding over it."""


@dataclass(frozen=True, eq=False)
class Opinion(Values):
    """What MuJoCo says at one state, in the chain's own coordinates.

    Attributes:
        mass: mass matrix of the open tree, rotors included, shape (nv, nv).
        bias: Coriolis, centrifugal and gravity forces of the open tree, with its whole weight, shape (nv,).
        passive: effort against springs, dampers, dry friction and what compensates weights, shape (nv,).
        potential: energy of gravity and springs, [J], but for a constant.
        jacobian: constraint Jacobian in MuJoCo's rows, which are dimensionless, shape (rows, nv).
        give: what each row gives at the impedance that was asked for, shape (rows,): its acceleration for a force of 1.
        soft: acceleration of all joints as MuJoCo's solver gives it, shape (nv,).
        softened: what that solver must give by its own regularisation and reference acceleration, shape (nv,).
        hard: the same from MuJoCo's matrices with constraints that do not give, shape (nv,).
    """

    mass: Array
    bias: Array
    passive: Array
    potential: float
    jacobian: Array
    give: Array
    soft: Array
    softened: Array
    hard: Array


@dataclass(frozen=True)
class _Stop:
    """One stop of a joint at `q` and `v` of MuJoCo's vectors; `end` is where it is, seen along `sign`."""

    q: int
    v: int
    sign: float
    end: float
    physics: JointPhysics

    def force(self, data: mujoco.MjData) -> float:
        """How hard it pushes back."""
        deep, speed = self.sign * data.qpos[self.q] - self.end, self.sign * data.qvel[self.v]
        pushed = self.physics.stop_stiffness * deep + self.physics.stop_damping * speed
        return max(0.0, float(pushed)) if deep > 0.0 else 0.0

    def energy(self, data: mujoco.MjData) -> float:
        """What it has stored."""
        return 0.5 * self.physics.stop_stiffness * max(0.0, float(self.sign * data.qpos[self.q] - self.end)) ** 2


class MujocoRobot:
    """A closed chain in MuJoCo.

    MuJoCo's dry friction is a constraint that holds what rests, and its stops are relative to the inertia; here the
    smooth friction and the stops of the description are applied from outside, friction with the sizes that MuJoCo read.
    So are dampers, friction and springs of cuts, in which it has no joint.

    Raises:
        MissingPackageError: MuJoCo is not installed.
        InputError: the robot has joints or cuts that this comparison does not map.
    """

    def __init__(self, chain: ClosedChain) -> None:
        mujoco = needed("mujoco", "MuJoCo as a second opinion")
        self._mujoco: ModuleType = mujoco
        self._scale = units_of(chain.description, chain.length)
        with tempfile.TemporaryDirectory() as folder:
            robot = _without_tendons(natural(chain.description, self._scale))
            path = write(robot, Path(folder) / "robot.xml", "mjcf")[0]
            self._model = mujoco.MjModel.from_xml_path(str(path))
        off = mujoco.mjtDisableBit
        self._model.opt.disableflags |= off.mjDSBL_LIMIT | off.mjDSBL_CONTACT | off.mjDSBL_FRICTIONLOSS
        self._model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        self._model.opt.tolerance, self._model.opt.iterations = 0.0, 200
        self._model.eq_solimp[:] = (IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0)
        self._data = mujoco.MjData(self._model)
        self._map(chain)
        self._prepare(robot, {joint.name: joint.limits for joint in chain.description.joints})

    @property
    def energy(self) -> float:
        """Of its natural units [J]."""
        return self._scale.energy

    def _map(self, chain: ClosedChain) -> None:
        """Where each joint of the chain stands in MuJoCo's vectors, and the units of its coordinates."""
        names, model = self._mujoco.mjtObj.mjOBJ_JOINT, self._model
        self._q_units, self.units = np.ones(chain.nq), np.ones(chain.nv)
        self._single: list[tuple[int, int, int, int]] = []
        self._free: list[tuple[int, int, int, int]] = []
        self._frames: list[Array] = []  # in which MuJoCo counts the place of each free one, in natural units
        for joint in chain.description.joints:
            if not joint.type.moves:
                continue
            index = self._mujoco.mj_name2id(model, names, joint.name)
            free = joint.type is JointType.FLOATING
            if index < 0 or not (free or joint.type.single):
                raise InputError(f"joint '{joint.name}' ({joint.type}) of {chain.name} is not mapped to MuJoCo")
            own = chain.model.getJointId(joint.name)
            row = (
                int(chain.model.idx_qs[own]),
                int(chain.model.idx_vs[own]),
                int(model.jnt_qposadr[index]),
                int(model.jnt_dofadr[index]),
            )
            (self._free if free else self._single).append(row)
            if free:  # MuJoCo's own free joint counts in the world, three slides and a ball from where they stand
                in_world = model.jnt_type[index] == self._mujoco.mjtJoint.mjJNT_FREE
                frame = np.array(joint.placement if in_world else np.eye(4))
                frame[:3, 3] /= chain.length
                self._frames.append(frame)
            lengths = sum(joint.type.lengths)
            self._q_units[row[0] : row[0] + lengths] = chain.length
            self.units[row[1] : row[1] + lengths] = chain.length
        self._nv = chain.nv
        if model.nv > chain.nv:
            raise InputError(f"a cut of {chain.name} has no equality in MuJoCo: its carrier is not mapped")

    def _prepare(self, robot: RobotDescription, limits: Mapping[str, Limits]) -> None:
        """What is applied from outside: stops, and from which speed friction acts fully; dampers of free joints."""
        self._full, self._stops = np.ones(self._model.nv), list[_Stop]()
        moving = [joint for joint in robot.joints if joint.type.single]
        for joint, (_, v, q_there, v_there) in zip(moving, self._single, strict=True):
            self._full[v_there] = joint.physics.speed
            ends, unit = limits[joint.name], self.units[v]
            for sign, end in ((-1.0, ends.lower), (1.0, ends.upper)):
                if end is not None and joint.physics.stop_stiffness > 0.0:
                    self._stops.append(_Stop(q_there, v_there, sign, sign * end / unit, joint.physics))
        for _, _, _, there in self._free:
            self._model.dof_damping[there : there + 3] *= self._scale.length**2  # a metre is not a length
        self._mujoco.mj_setConst(self._model, self._data)
        acting = [cut for cut in robot.cuts if cut.physics.acts or cut.bushing is not None]
        self._cuts = [CutMotion(self._mujoco, self._model, cut) for cut in acting]

    def opinion(self, q_full: Array, v_full: Array, effort_full: Array) -> Opinion:
        """MuJoCo's dynamics at a configuration (nq,), velocity and effort (nv,) of the chain."""
        mujoco, model, data, units = self._mujoco, self._model, self._data, self.units
        inertia, time, energy = self._scale.mass * self._scale.length**2, self._scale.time, self._scale.energy
        q, v = q_full / self._q_units, v_full * time / units
        turn, bend = self._transform(q, v)
        self._place(q)
        data.qvel[:] = turn @ v
        mujoco.mj_fwdPosition(model, data)
        outside = sum((cut.effort(data) for cut in self._cuts), np.zeros(model.nv))
        outside += model.dof_frictionloss * smooth_sign(data.qvel, self._full)
        for stop in self._stops:
            outside[stop.v] += stop.sign * stop.force(data)
        data.qfrc_applied[:] = np.linalg.solve(turn.T, effort_full * units / energy) - outside
        mujoco.mj_forward(model, data)
        passive = outside - data.qfrc_passive
        stored = sum(one.energy(data) for one in self._stops) + sum(one.energy(data) for one in self._cuts)
        held_up = float(model.body_mass * model.body_gravcomp @ data.xipos @ model.opt.gravity)
        potential = energy * (float(data.energy[0]) + stored + held_up)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        bias, jacobian, soft = data.qfrc_bias.copy(), self._constraint_jacobian(), data.qacc.copy()
        slack, aim = data.efc_R[: data.nefc].copy(), data.efc_aref[: data.nefc].copy()
        used = np.array(data.efc_KBIP).reshape(-1, 4)[: data.nefc, 2]
        give = slack * used / (1.0 - used) * (1.0 - IMPEDANCE) / IMPEDANCE
        drift = self._constraint_drift(turn @ v)
        pushed = data.qfrc_applied + data.qfrc_passive - bias
        free = np.linalg.solve(mass, np.column_stack([pushed, jacobian.T]))
        compliance = jacobian @ free[:, 1:]
        forces = np.linalg.lstsq(compliance, -(jacobian @ free[:, 0] + drift), rcond=1e-9)[0]
        hard = free[:, 0] + free[:, 1:] @ forces
        yielding = np.linalg.solve(compliance + np.diag(slack), aim - jacobian @ free[:, 0])
        softened = free[:, 0] + free[:, 1:] @ yielding
        return Opinion(
            inertia * (turn.T @ mass @ turn) / np.outer(units, units),
            energy * (turn.T @ (bias + mass @ bend)) / units,
            energy * (turn.T @ passive) / units,
            potential,
            jacobian @ turn / units,
            give / inertia,
            np.linalg.solve(turn, soft - bend) * units / time**2,
            np.linalg.solve(turn, softened - bend) * units / time**2,
            np.linalg.solve(turn, hard - bend) * units / time**2,
        )

    def _place(self, q_full: Array) -> None:
        for q, _, there, _ in self._single:
            self._data.qpos[there] = q_full[q]
        for frame, (q, _, there, _) in zip(self._frames, self._free, strict=True):
            self._data.qpos[there : there + 3] = frame[:3, :3] @ q_full[q : q + 3] + frame[:3, 3]
            turn = np.zeros(4)
            self._mujoco.mju_mat2Quat(turn, (frame[:3, :3] @ _rotation(q_full[q + 3 : q + 7])).ravel())
            self._data.qpos[there + 3 : there + 7] = turn

    def _transform(self, q_full: Array, v_full: Array) -> tuple[Array, Array]:
        """Matrix B and vector B_dot v of v_mujoco = B v: order of joints, and linear velocity in world axes there."""
        turn, bend = np.zeros((self._model.nv, self._nv)), np.zeros(self._model.nv)
        for _, v, _, there in self._single:
            turn[there, v] = 1.0
        for frame, (q, v, _, there) in zip(self._frames, self._free, strict=True):
            rotation = frame[:3, :3] @ _rotation(q_full[q + 3 : q + 7])
            turn[there : there + 3, v : v + 3] = rotation
            turn[there + 3 : there + 6, v + 3 : v + 6] = np.eye(3)
            bend[there : there + 3] = rotation @ np.cross(v_full[v + 3 : v + 6], v_full[v : v + 3])
        return turn, bend

    def _constraint_jacobian(self) -> Array:
        data = self._data
        return np.array(data.efc_J).reshape(-1)[: data.nefc * self._model.nv].reshape(data.nefc, self._model.nv).copy()

    def _constraint_drift(self, velocity: Array) -> Array:
        """J_dot v by a central difference of MuJoCo's own Jacobian along the velocity."""
        mujoco, model, data = self._mujoco, self._model, self._data
        fastest = float(np.abs(velocity).max(initial=0.0))
        if fastest == 0.0:
            return np.zeros(data.nefc)
        step = _STEP / fastest
        origin = data.qpos.copy()
        sides = []
        for sign in (1.0, -1.0):
            data.qpos[:] = origin
            mujoco.mj_integratePos(model, data.qpos, velocity, sign * step)
            mujoco.mj_fwdPosition(model, data)
            sides.append(self._constraint_jacobian() @ velocity)
        data.qpos[:] = origin
        return np.asarray((sides[0] - sides[1]) / (2.0 * step))


def _rotation(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion x, y, z, w."""
    x, y, z, w = (float(part) for part in quaternion)
    return rotation_from_quaternion((w, x, y, z))


def _without_tendons(robot: RobotDescription) -> RobotDescription:
    """The robot with joints that stand for lengths of tendons as plain joints: all of its coordinates are compared."""
    names = {link.name: link.name.replace(TENDON, "length of ") for link in robot.links}
    links = tuple(replace(link, name=names[link.name]) for link in robot.links)
    return replace(robot, links=links, joints=tuple(replace(one, child=names[one.child]) for one in robot.joints))
