"""The task on other engines, set up as their users would.

MuJoCo: the robot as MJCF, cuts as equality constraints with solref = 2 steps, solimp 0.9999 and `refsafe` off, contacts
off; the PD as position and velocity actuators, so that nothing of the loop is Python: `mujoco.rollout` runs all steps
in C.  Its inputs are held over a step, so they are sampled where that is most accurate: in the middle of each step for
RK4, at its start for implicitfast.

Pinocchio: `pin.constraintDynamics` in full coordinates, Runge-Kutta of order four, in a Python loop.

Those that are not installed are left out.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.task import KD, KP, SAMPLE, Task
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.formats import write


def has_mujoco() -> bool:
    """Whether MuJoCo can be used."""
    try:
        import mujoco.rollout  # noqa: F401
    except ImportError:
        return False
    return True


def mujoco_model(chain: ClosedChain, step: float) -> Any:
    """A chain in MuJoCo with hard-as-possible constraints."""
    import mujoco

    with tempfile.TemporaryDirectory() as folder:
        path = write(chain.description, Path(folder) / "robot.xml", "mjcf")[0]
        spec = mujoco.MjSpec.from_file(str(path))
        for actuator in list(spec.actuators):
            spec.delete(actuator)
        for gain, damping in ((KP, 0.0), (0.0, KD)):
            for name in chain.description.actuators:
                one = spec.add_actuator(target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
                one.gaintype, one.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
                one.gainprm[0] = gain + damping
                one.biasprm[1], one.biasprm[2] = -gain, -damping
        model = spec.compile()
    disable = mujoco.mjtDisableBit
    model.opt.disableflags |= disable.mjDSBL_LIMIT | disable.mjDSBL_CONTACT | disable.mjDSBL_REFSAFE
    model.opt.timestep = step
    model.eq_solref[:] = (2.0 * step, 1.0)
    model.eq_solimp[:] = (0.9999, 0.9999, 1e-3, 0.5, 2.0)
    return model


def mujoco_state(chain: ClosedChain, model: Any) -> Any:
    """Data of a model at the chain's home posture."""
    import mujoco

    data = mujoco.MjData(model)
    for joint in chain.description.joints:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        if index < 0:
            continue
        own = chain.model.getJointId(joint.name)
        start, size = int(chain.model.idx_qs[own]), int(chain.model.nqs[own])
        q = np.array(chain.home.q_full[start : start + size])
        if size == 7:
            q = np.concatenate([q[:3], q[[6, 3, 4, 5]]])
        data.qpos[model.jnt_qposadr[index] : model.jnt_qposadr[index] + size] = q
    mujoco.mj_forward(model, data)
    return data


class MujocoRun:
    """The task in MuJoCo: `runs` copies of it by `mujoco.rollout`."""

    def __init__(self, task: Task, step: float, integrator: str, runs: int = 1, threads: int = 1) -> None:
        import mujoco

        self.task, self.step, self.runs, self.threads = task, step, runs, threads
        self.model = mujoco_model(task.chain, step)
        self.model.opt.integrator = {
            "RK4": mujoco.mjtIntegrator.mjINT_RK4,
            "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
        }[integrator]
        start = task.reference.at(0.0)
        self.data = [mujoco_state(task.chain, self.model) for _ in range(threads)]
        self.state = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(self.model, self.data[0], self.state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        assert np.allclose(task.chain.home.q, start.q), "the home posture is where the circle starts"
        self.steps = round(task.span / step)
        place = 0.5 if integrator == "RK4" else 0.0
        position, velocity = task.path((np.arange(float(self.steps)) + place) * step)
        self.control = np.concatenate([position, velocity], axis=1)
        self._slots = [int(model_slot(self.model, name)) for name in task.chain.description.actuators]

    def run(self) -> Array:
        """Slider positions after every step, shape (steps, 3)."""
        from mujoco import rollout

        state = np.tile(self.state, (self.runs, 1))
        control = np.broadcast_to(self.control, (self.runs, *self.control.shape))
        states, _ = rollout.rollout(self.model, self.data, state, np.ascontiguousarray(control))
        return np.asarray(states[0][:, [1 + slot for slot in self._slots]])

    def error(self) -> float:
        """Error of the task [m]."""
        every = round(SAMPLE / self.step)
        tool = np.concatenate([self.task.reference.at(0.0).q[None], self.run()[every - 1 :: every]])
        return self.task.error(tool)


def model_slot(model: Any, joint: str) -> int:
    """Where a joint's coordinate stands in qpos."""
    import mujoco

    return int(model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)])


class PinocchioRun:
    """The task by `pin.constraintDynamics` in a Python loop, Runge-Kutta of order four, Baumgarte gains 100 and 20."""

    def __init__(self, task: Task, step: float) -> None:
        self.task, self.step = task, step
        self.steps = round(task.span / step)
        position, velocity = task.path(0.5 * step * np.arange(2.0 * self.steps + 1.0))
        self.position, self.velocity = position, velocity
        self._act = task.chain.actuated_velocity(np.arange(float(task.chain.nv))).astype(int)
        self.solve = constraint_dynamics(task.chain, baumgarte=True)

    def run(self) -> Array:
        """Slider positions every SAMPLE seconds, shape (k, 3)."""
        h, act, nv = self.step, self._act, self.task.chain.nv
        q, v = np.array(self.task.chain.home.q_full), np.zeros(nv)
        effort = np.zeros(nv)
        every = round(SAMPLE / h)
        found = [q[act]]

        def slope(q: Array, v: Array, k: int) -> Any:
            effort[act] = KP * (self.position[k] - q[act]) + KD * (self.velocity[k] - v[act])
            return self.solve(q, v, effort)

        for i in range(self.steps):
            a1 = slope(q, v, 2 * i)
            v2 = v + 0.5 * h * a1
            a2 = slope(q + 0.5 * h * v, v2, 2 * i + 1)
            v3 = v + 0.5 * h * a2
            a3 = slope(q + 0.5 * h * v2, v3, 2 * i + 1)
            v4 = v + h * a3
            a4 = slope(q + h * v3, v4, 2 * i + 2)
            q = q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            if (i + 1) % every == 0:
                found.append(q[act])
        return np.array(found)

    def error(self) -> float:
        """Error of the task [m]."""
        return self.task.error(self.run())


def constraint_dynamics(chain: ClosedChain, *, baumgarte: bool = False) -> Any:
    """`pin.constraintDynamics` of a chain as a function of q, v, effort: the call and nothing around it."""
    import pinocchio as pin

    from cutjoint.chain.kinematics import Kinematics
    from cutjoint.chain.rigid import RigidConstraints

    kinematics = Kinematics(chain.description)
    rigid = RigidConstraints(kinematics, np.array(chain.home.q_full))
    if baumgarte:
        for constraint in rigid.models:
            constraint.m_baumgarte_parameters.Kp, constraint.m_baumgarte_parameters.Kd = 100.0, 20.0
    settings = pin.ProximalSettings(1e-12, 1e-8, 1e-6, 5)
    workspace = rigid.workspace
    model, data, models, datas = kinematics.model, workspace.data, rigid.models, workspace.datas
    call = pin.constraintDynamics

    def solve(q: Array, v: Array, effort: Array) -> Any:
        return call(model, data, q, v, effort, models, datas, settings)

    return solve
