"""A published MJCF as MuJoCo itself reads it, against the chain that cutjoint makes of it.

Unlike `cutjoint.engines`, which gives MuJoCo what cutjoint wrote, this loads the file as it is.  From MuJoCo come the
mass matrix (`mj_fullM`), the bias, the passive forces and the rows of its active equalities (`efc_J`); with them

    M a + J' f = passive - bias,    J a = -J_dot v

is solved for hard constraints.  Dry friction, limits, contacts and actuators are switched off on both sides, because
MuJoCo's are constraints of another kind; springs, dampers and rotors act.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.model import JointType, RobotDescription

_STEP = 1e-3
"""How far the fastest coordinate moves to either side for J_dot v; of fourth order."""
_RANK = 1e-6
"""Rows that are independent by less are so by the digits of the file: a planar loop that is not quite in its plane."""


@dataclass(frozen=True)
class Verdict:
    """What MuJoCo says of a chain at its home.

    Attributes:
        velocities, mobility: of MuJoCo's model; velocities less the rank of the active equalities.
        pose: worst distance of a body's centre of mass [m].
        gap: worst violation of an active equality at the chain's home.
        rest, moving: relative difference of the accelerations, at rest and at a velocity that the loops allow.
        unmapped: joints of MuJoCo that the chain does not have; the accelerations are NaN then.
    """

    velocities: int
    mobility: int
    pose: float
    gap: float
    rest: float
    moving: float
    unmapped: tuple[str, ...]


def without_friction(description: RobotDescription) -> RobotDescription:
    """A copy in which neither joints nor cuts rub, and no stop pushes."""
    joints = tuple(
        replace(
            one, physics=replace(one.physics, friction=0.0, friction_speed=None, stop_stiffness=0.0, stop_damping=0.0)
        )
        for one in description.joints
    )
    return replace(description, joints=joints)


def compare(path: Path, chain: ClosedChain) -> Verdict:
    """The chain of a file of MJCF, made of `without_friction`, against MuJoCo's own reading of the file."""
    return _Peer(path, chain).verdict()


def _compiled(path: Path) -> mujoco.MjModel:
    """MuJoCo's model of a file; where meshes are missing that no inertia comes from, without these.

    Raises:
        ValueError: MuJoCo refuses it.
    """
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        spec = mujoco.MjSpec.from_file(str(path))
        drawn = [one for one in spec.geoms if one.meshname]
        if not drawn or not all(one.parent.explicitinertial or not _moves(one.parent) for one in drawn):
            raise
        for one in drawn:
            spec.delete(one)
        for mesh in list(spec.meshes):
            spec.delete(mesh)
        for texture in [*spec.materials, *spec.textures]:
            spec.delete(texture)
        return spec.compile()


def _moves(body: mujoco.MjsBody | None) -> bool:
    """Whether a joint moves a body, its own or one of a body above it."""
    while body is not None:
        if body.joints:
            return True
        body = body.parent
    return False


class _Peer:
    """The two models, and how the coordinates of the one are those of the other."""

    def __init__(self, path: Path, chain: ClosedChain) -> None:
        self.chain, self.model = chain, _compiled(path)
        off = mujoco.mjtDisableBit
        for bit in (off.mjDSBL_LIMIT, off.mjDSBL_CONTACT, off.mjDSBL_FRICTIONLOSS, off.mjDSBL_ACTUATION):
            self.model.opt.disableflags |= int(bit)
        self.model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
        self.data = mujoco.MjData(self.model)
        self.rows: list[tuple[JointType, int, int, int, int]] = []
        self.unmapped: list[str] = []
        self._map()

    def _map(self) -> None:
        """Type, and places in q and v of the chain and of MuJoCo, of every joint that both have by name and order."""
        model, chain = self.model, self.chain
        ours = {joint.name: joint for joint in chain.description.joints if joint.type.moves}
        for number in range(model.njnt):
            joint = model.joint(number)
            body = model.body(int(model.jnt_bodyid[number])).name
            order = number - int(model.body_jntadr[model.jnt_bodyid[number]])
            free = int(model.jnt_type[number]) == int(mujoco.mjtJoint.mjJNT_FREE)
            unnamed = f"{body}_free" if free else f"{body}_joint" if order == 0 else f"{body}_joint_{order + 1}"
            name = joint.name or unnamed
            if name not in ours:
                self.unmapped.append(name)
                continue
            own = chain.model.getJointId(name)
            q, v = int(chain.model.idx_qs[own]), int(chain.model.idx_vs[own])
            self.rows.append((ours[name].type, q, v, int(joint.qposadr[0]), int(joint.dofadr[0])))

    def place(self, q: Array) -> None:
        """MuJoCo at a configuration of the chain."""
        placed = self.chain.link_placements(q)
        self.data.qpos[:] = self.model.qpos0
        for kind, own, _, there, dof in self.rows:
            if kind is JointType.FLOATING:
                body = self.model.body(int(self.model.dof_bodyid[dof])).name
                self.data.qpos[there : there + 3] = placed[body][:3, 3]
                quaternion = np.zeros(4)
                mujoco.mju_mat2Quat(quaternion, placed[body][:3, :3].flatten())
                self.data.qpos[there + 3 : there + 7] = quaternion
            elif kind is JointType.SPHERICAL:
                self.data.qpos[there : there + 4] = np.roll(q[own : own + 4], 1)
            elif kind.single:
                self.data.qpos[there] = q[own]
        mujoco.mj_fwdPosition(self.model, self.data)

    def turn(self) -> Array:
        """B of v_mujoco = B v: the order of the joints, and for free joints velocities along the world's axes."""
        matrix = np.zeros((self.model.nv, self.chain.nv))
        for kind, _, v, _, dof in self.rows:
            wide = 6 if kind is JointType.FLOATING else 3 if kind is JointType.SPHERICAL else 1
            block = np.eye(wide)
            if kind is JointType.FLOATING:
                block[:3, :3] = self.data.xmat[self.model.dof_bodyid[dof]].reshape(3, 3)
            matrix[dof : dof + wide, v : v + wide] = block
        return matrix

    def bend(self, v_full: Array) -> Array:
        """B_dot v: what the turning axes of free joints add to the acceleration."""
        extra = np.zeros(self.model.nv)
        for kind, _, v, _, dof in self.rows:
            if kind is JointType.FLOATING:
                rotation = self.data.xmat[self.model.dof_bodyid[dof]].reshape(3, 3)
                extra[dof : dof + 3] = rotation @ np.cross(v_full[v + 3 : v + 6], v_full[v : v + 3])
        return extra

    def jacobian(self) -> Array:
        """The rows of the active equalities, shape (rows, nv)."""
        data = self.data
        every = np.array(data.efc_J).reshape(-1)[: data.nefc * self.model.nv].reshape(data.nefc, self.model.nv)
        equal = np.array(data.efc_type[: data.nefc]) == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        return np.asarray(every[equal])

    def drift(self, velocity: Array) -> Array:
        """J_dot v, by differences of MuJoCo's own rows along the velocity."""
        origin, fastest = self.data.qpos.copy(), float(np.abs(velocity).max(initial=0.0))
        if fastest == 0.0:
            return np.zeros(len(self.jacobian()))
        step = _STEP / fastest

        def at(times: float) -> Array:
            self.data.qpos[:] = origin
            mujoco.mj_integratePos(self.model, self.data.qpos, velocity, times * step)
            mujoco.mj_fwdPosition(self.model, self.data)
            return np.asarray(self.jacobian() @ velocity)

        slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step)
        self.data.qpos[:] = origin
        mujoco.mj_fwdPosition(self.model, self.data)
        return np.asarray(slope)

    def hard(self, velocity: Array) -> Array:
        """MuJoCo's acceleration with constraints that do not give, shape (nv,)."""
        model, data = self.model, self.data
        drift = self.drift(velocity)
        data.qvel[:] = velocity
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        rows = self.jacobian()
        left, sizes, right = np.linalg.svd(rows, full_matrices=False)
        kept = sizes > _RANK * sizes.max(initial=0.0)
        rows, drift = right[kept], (left[:, kept].T @ drift) / sizes[kept]
        free = np.linalg.solve(mass, np.column_stack([data.qfrc_passive - data.qfrc_bias, rows.T]))
        forces = np.linalg.solve(rows @ free[:, 1:], -(rows @ free[:, 0] + drift))
        return np.asarray(free[:, 0] + free[:, 1:] @ forces)

    def verdict(self) -> Verdict:
        """Everything at the chain's home."""
        q, nv = self.chain.home.q_full, self.chain.nv
        self.place(q)
        mujoco.mj_forward(self.model, self.data)
        rows, turn = self.jacobian(), self.turn()
        sizes = np.linalg.svd(rows, compute_uv=False)
        rank = int(np.sum(sizes > _RANK * sizes.max(initial=0.0)))
        equal = np.array(self.data.efc_type[: self.data.nefc]) == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        gap = float(np.abs(np.array(self.data.efc_pos[: self.data.nefc])[equal]).max(initial=0.0))
        pose = self._pose(q)
        rest = moving = float("nan")
        if not self.unmapped:
            rest = self._difference(q, turn, np.zeros(nv))
            speed = np.random.default_rng(0).uniform(-1.0, 1.0, nv)
            _, speed = self.chain.project(q, speed)
            moving = self._difference(q, turn, speed)
        mobility = self.model.nv - rank
        return Verdict(self.model.nv, mobility, pose, gap, rest, moving, tuple(self.unmapped))

    def _difference(self, q: Array, turn: Array, v: Array) -> float:
        self.place(q)
        theirs = self.hard(turn @ v)
        ours = turn @ self.chain.full_acceleration(q, v, np.zeros(len(v))) + self.bend(v)
        return float(np.abs(ours - theirs).max(initial=0.0) / max(1.0, np.abs(theirs).max(initial=0.0)))

    def _pose(self, q: Array) -> float:
        placed, worst = self.chain.link_placements(q), 0.0
        for link in self.chain.description.links:
            number = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, link.name)
            if number > 0 and link.inertial is not None:
                centre = placed[link.name] @ np.array([*link.inertial.com, 1.0])
                worst = max(worst, float(np.linalg.norm(centre[:3] - self.data.xipos[number])))
        return worst
