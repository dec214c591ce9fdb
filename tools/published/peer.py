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
from published.carriers import Carriers

_STEP = 1e-3
"""How far the fastest coordinate moves to either side for J_dot v; of fourth order."""
_RANK = 1e-6
"""Rows that are independent by less are so by the digits of the file: a planar loop that is not quite in its plane."""
_WIDE = {JointType.UNIVERSAL: 2, JointType.PLANAR: 3, JointType.SPHERICAL: 3, JointType.FLOATING: 6}
"""Velocities of joints that have several."""
_TURNING = (JointType.PLANAR, JointType.FLOATING)


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
        self.carriers = Carriers(self.model, chain)
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
            whole, _, part = name.rpartition("/")
            if self.carriers.has(name) or (part.isdecimal() and whole in ours and not ours[whole].type.single):
                continue  # one of several that make a joint
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
            if kind is JointType.FLOATING and self._free(dof):
                body = self.model.body(int(self.model.dof_bodyid[dof])).name
                self.data.qpos[there : there + 3] = placed[body][:3, 3]
                quaternion = np.zeros(4)
                mujoco.mju_mat2Quat(quaternion, placed[body][:3, :3].flatten())
                self.data.qpos[there + 3 : there + 7] = quaternion
            elif kind in (JointType.SPHERICAL, JointType.FLOATING):
                lengths = sum(kind.lengths)
                self.data.qpos[there : there + lengths] = q[own : own + lengths]
                there, own = there + lengths, own + lengths
                self.data.qpos[there : there + 4] = np.roll(q[own : own + 4], 1)
            elif kind is JointType.PLANAR:
                x, y, c, s = q[own : own + 4]
                self.data.qpos[there : there + 3] = x, y, np.arctan2(s, c)
            else:
                self.data.qpos[there : there + _WIDE.get(kind, 1)] = q[own : own + _WIDE.get(kind, 1)]
        self.carriers.place(self.data, q)
        mujoco.mj_fwdPosition(self.model, self.data)

    def _free(self, dof: int) -> bool:
        """Whether a joint is a free one, whose velocity is along the axes of the world."""
        return int(self.model.jnt_type[self.model.dof_jntid[dof]]) == int(mujoco.mjtJoint.mjJNT_FREE)

    def _turned(self, kind: JointType, there: int, dof: int) -> Array:
        """Rotation of what MuJoCo's velocity of a joint is along, seen from the chain's: (2, 2) or (3, 3)."""
        if kind is JointType.PLANAR:
            angle = float(self.data.qpos[there + 2])
            return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        if self._free(dof):
            return np.array(self.data.xmat[self.model.dof_bodyid[dof]]).reshape(3, 3)
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, self.data.qpos[there + 3 : there + 7])
        return matrix.reshape(3, 3)

    def turn(self) -> Array:
        """B of v_mujoco = B v: the order of the joints, and velocities along the axes that do not turn along."""
        matrix = np.zeros((self.model.nv, self.chain.nv))
        for kind, _, v, there, dof in self.rows:
            wide = _WIDE.get(kind, 1)
            block = np.eye(wide)
            if kind in _TURNING:
                turned = self._turned(kind, there, dof)
                block[: len(turned), : len(turned)] = turned
            matrix[dof : dof + wide, v : v + wide] = block
        return self.carriers.follow(matrix, self.jacobian())

    def bend(self, v_full: Array) -> Array:
        """B_dot v: what the turning axes add to the acceleration."""
        extra = np.zeros(self.model.nv)
        for kind, _, v, there, dof in self.rows:
            if kind is JointType.FLOATING:
                turning = np.cross(v_full[v + 3 : v + 6], v_full[v : v + 3])
                extra[dof : dof + 3] = self._turned(kind, there, dof) @ turning
            elif kind is JointType.PLANAR:
                turning = v_full[v + 2] * np.array([-v_full[v + 1], v_full[v]])
                extra[dof : dof + 2] = self._turned(kind, there, dof) @ turning
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
        left, sizes, right = np.linalg.svd(rows)
        rank = int(np.sum(sizes > _RANK * sizes.max(initial=0.0)))
        held, free = right[:rank], right[rank:]
        drifting = -held.T @ ((left[:, :rank].T @ drift) / sizes[:rank])
        force = free @ (data.qfrc_passive - data.qfrc_bias - mass @ drifting)
        return np.asarray(drifting + free.T @ np.linalg.solve(free @ mass @ free.T, force))

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
        theirs = self.hard(turn @ v)[self.carriers.others]
        ours = (turn @ self.chain.full_acceleration(q, v, np.zeros(len(v))) + self.bend(v))[self.carriers.others]
        return float(np.abs(ours - theirs).max(initial=0.0) / max(1.0, np.abs(theirs).max(initial=0.0)))

    def _pose(self, q: Array) -> float:
        placed, worst = self.chain.link_placements(q), 0.0
        for link in self.chain.description.links:
            number = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, link.name)
            if number > 0 and link.inertial is not None:
                centre = placed[link.name] @ np.array([*link.inertial.com, 1.0])
                worst = max(worst, float(np.linalg.norm(centre[:3] - self.data.xipos[number])))
        return worst
