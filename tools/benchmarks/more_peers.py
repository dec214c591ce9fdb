"""The task on PyBullet and Drake, where they are installed (extra `bench`).

Both read the tree as URDF and get the cuts as weld constraints.  The PD is computed, or its target set, once a step
from Python: that is how they are used.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from benchmarks.task import KD, KP, SAMPLE, Task
from cutjoint.arrays import Array
from cutjoint.description.formats import write
from cutjoint.description.model import Frame


def tree_as_urdf(task: Task, folder: str) -> str:
    """The open tree of the task's robot as a file."""
    for path in write(task.chain.description, Path(folder) / "robot.urdf", "urdf"):
        if path.suffix == ".urdf":
            return str(path)
    raise RuntimeError("no URDF was written")


class PyBulletRun:
    """The task in PyBullet: torque control from Python, fixed constraints, its own integrator."""

    def __init__(self, task: Task, step: float) -> None:
        pybullet: Any = import_module("pybullet")
        self.task, self.step = task, step
        self.steps = round(task.span / step)
        self.position, self.velocity = task.path(np.arange(float(self.steps)) * step)
        self._bullet: Any = pybullet
        self.client = pybullet.connect(pybullet.DIRECT)
        with tempfile.TemporaryDirectory() as folder:
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            self.body = pybullet.loadURDF(
                tree_as_urdf(task, folder), useFixedBase=True, flags=flags, physicsClientId=self.client
            )
        count = pybullet.getNumJoints(self.body, physicsClientId=self.client)
        infos = [pybullet.getJointInfo(self.body, k, physicsClientId=self.client) for k in range(count)]
        self.joints = {info[1].decode(): int(info[0]) for info in infos}
        self.links = {info[12].decode(): int(info[0]) for info in infos}
        names = list(self.joints)
        pybullet.setJointMotorControlArray(
            self.body,
            [self.joints[name] for name in names],
            pybullet.VELOCITY_CONTROL,
            forces=[0.0] * len(names),
            physicsClientId=self.client,
        )
        for k in range(-1, count):
            pybullet.changeDynamics(
                self.body,
                k,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                collisionMargin=0.0,
                physicsClientId=self.client,
            )
            for other in range(k):
                pybullet.setCollisionFilterPair(self.body, self.body, k, other, 0, physicsClientId=self.client)
        massive = {link.name for link in task.chain.description.links if link.inertial is not None}
        for name, k in self.links.items():
            if name not in massive:
                # PyBullet gives links without inertia a kilogram
                pybullet.changeDynamics(
                    self.body, k, mass=1e-9, localInertiaDiagonal=[1e-12] * 3, physicsClientId=self.client
                )
        pybullet.setPhysicsEngineParameter(fixedTimeStep=step, physicsClientId=self.client)
        pybullet.setGravity(*task.chain.description.gravity.tolist(), physicsClientId=self.client)
        self._place()
        for cut in task.chain.description.cuts:
            self._weld(cut.a, cut.b)
        self.act = [self.joints[name] for name in task.chain.description.actuators]

    def _place(self) -> None:
        """Every joint to the home posture, at rest."""
        chain = self.task.chain
        for name, index in self.joints.items():
            if chain.model.existJointName(name):
                value = float(chain.home.q_full[chain.model.idx_qs[chain.model.getJointId(name)]])
                self._bullet.resetJointState(self.body, index, value, 0.0, physicsClientId=self.client)

    def _weld(self, a: Frame, b: Frame) -> None:
        """A fixed cut; positions are from the links' centres of mass, as PyBullet wants them."""
        bullet = self._bullet
        arguments: list[Any] = []
        for frame in (a, b):
            inertial = self.task.chain.description.link(frame.link).inertial
            com = np.zeros(3) if inertial is None else inertial.com
            arguments.append((frame.placement[:3, 3] - com).tolist())
        made = bullet.createConstraint(
            self.body,
            self.links[a.link],
            self.body,
            self.links[b.link],
            bullet.JOINT_FIXED,
            [0.0, 0.0, 0.0],
            arguments[0],
            arguments[1],
            physicsClientId=self.client,
        )
        bullet.changeConstraint(made, maxForce=1e6, erp=0.8, physicsClientId=self.client)

    def run(self) -> Array:
        """Slider positions every SAMPLE seconds."""
        bullet, every = self._bullet, round(SAMPLE / self.step)
        self._place()
        found = []
        for k in range(self.steps + 1):
            states = bullet.getJointStates(self.body, self.act, physicsClientId=self.client)
            q, v = np.array([one[0] for one in states]), np.array([one[1] for one in states])
            if k % every == 0:
                found.append(q)
            if k < self.steps:
                effort = KP * (self.position[k] - q) + KD * (self.velocity[k] - v)
                bullet.setJointMotorControlArray(
                    self.body, self.act, bullet.TORQUE_CONTROL, forces=effort.tolist(), physicsClientId=self.client
                )
                bullet.stepSimulation(physicsClientId=self.client)
        return np.array(found)

    def error(self) -> float:
        """Error of the task [m]."""
        return self.task.error(self.run())


class DrakeRun:
    """The task in Drake: discrete `MultibodyPlant`, SAP solver, weld constraints, implicit PD on the actuators."""

    def __init__(self, task: Task, step: float) -> None:
        transform: Any = import_module("pydrake.math").RigidTransform
        parser: Any = import_module("pydrake.multibody.parsing").Parser
        plants: Any = import_module("pydrake.multibody.plant")
        gains: Any = import_module("pydrake.multibody.tree").PdControllerGains
        simulator: Any = import_module("pydrake.systems.analysis").Simulator
        self.task, self.step = task, step
        self.steps = round(task.span / step)
        self.position, self.velocity = task.path(np.arange(float(self.steps)) * step)
        plant = plants.MultibodyPlant(step)
        plant.set_discrete_contact_approximation(plants.DiscreteContactApproximation.kSap)
        with tempfile.TemporaryDirectory() as folder:
            (self.model,) = parser(plant).AddModels(tree_as_urdf(task, folder))
        description = task.chain.description
        plant.WeldFrames(plant.world_frame(), plant.GetBodyByName(description.root).body_frame())
        plant.mutable_gravity_field().set_gravity_vector(description.gravity)
        for cut in description.cuts:
            one, two = (plant.GetBodyByName(frame.link) for frame in (cut.a, cut.b))
            plant.AddWeldConstraint(one, transform(cut.a.placement), two, transform(cut.b.placement))
        for k, name in enumerate(description.actuators):
            joint = plant.GetJointByName(name)
            motor = plant.AddJointActuator(f"motor{k}", joint)
            motor.set_controller_gains(gains(p=KP, d=KD))
        plant.Finalize()
        self.plant = plant
        self.simulator = simulator(plant)
        self.context = self.simulator.get_mutable_context()
        self.slots = [plant.GetJointByName(name).position_start() for name in description.actuators]
        self.desired = plant.get_desired_state_input_port(self.model)
        self.actuation = plant.get_actuation_input_port(self.model)

    def _place(self) -> None:
        chain, plant = self.task.chain, self.plant
        q = np.zeros(plant.num_positions())
        for joint in range(1, chain.model.njoints):
            start = plant.GetJointByName(chain.model.names[joint]).position_start()
            q[start] = chain.home.q_full[chain.model.idx_qs[joint]]
        self.context.SetTime(0.0)
        plant.SetPositions(self.context, q)
        plant.SetVelocities(self.context, np.zeros(plant.num_velocities()))
        self.actuation.FixValue(self.context, np.zeros(3))
        self.desired.FixValue(self.context, np.concatenate([self.position[0], self.velocity[0]]))
        self.simulator.Initialize()

    def run(self) -> Array:
        """Slider positions every SAMPLE seconds."""
        every = round(SAMPLE / self.step)
        self._place()
        found = []
        for k in range(self.steps + 1):
            if k % every == 0:
                found.append(self.plant.GetPositions(self.context)[self.slots])
            if k < self.steps:
                # implicit in time: the target is that of the end of the step
                target = min(k + 1, self.steps - 1)
                self.desired.FixValue(self.context, np.concatenate([self.position[target], self.velocity[target]]))
                self.simulator.AdvanceTo((k + 1) * self.step)
        return np.array(found)

    def error(self) -> float:
        """Error of the task [m]."""
        return self.task.error(self.run())


class Run(Protocol):
    """The task on an engine."""

    def run(self) -> Array:
        """Slider positions every SAMPLE seconds."""
        ...

    def error(self) -> float:
        """Error of the task [m]."""
        ...


RUNS: dict[str, tuple[str, Callable[[Task, float], Run]]] = {
    "PyBullet": ("pybullet", PyBulletRun),
    "Drake": ("pydrake", DrakeRun),
}
"""Engine -> the module that must be there, and what runs the task."""
