"""Which joints of a robot are actuated, and how their coordinates are prescribed and shown."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import ActuatedDriver
from cutjoint.description.model import RobotDescription
from cutjoint.mechanism import Actuator


class Actuated:
    """The actuated joints of one robot.

    Attributes:
        joints: in the order of the coordinates.
        n: how many.
        q_index, v_index: of them in a configuration and in a velocity, shape (n,).
        passive: indices of all other velocities, shape (nv - n,).
        selection: rows of the unit matrix, shape (n, nv).
        lengths: whether each coordinate is a length, shape (n,).
    """

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        types = {joint.name: joint.type for joint in description.joints}
        self.joints = tuple(
            Actuator(name, "translation" if types[name].slides else "rotation") for name in description.actuators
        )
        self.n = len(self.joints)
        ids = [model.getJointId(name) for name in description.actuators]
        self.q_index = np.array([model.idx_qs[i] for i in ids], dtype=int)
        self.v_index = np.array([model.idx_vs[i] for i in ids], dtype=int)
        self.passive = np.setdiff1d(np.arange(model.nv), self.v_index)
        self.selection = np.eye(model.nv)[self.v_index]
        self.lengths = np.array([actuator.kind == "translation" for actuator in self.joints], dtype=bool)

    def of(self, q: Array) -> Array:
        """Actuated coordinates of a full configuration, shape (n,)."""
        return np.asarray(q[self.q_index])

    def lead(self, origin: Array, goal: Array) -> ActuatedDriver:
        """Leads the actuated coordinates from `origin` to `goal`, shape (n,)."""
        return ActuatedDriver(self.q_index, self.selection, self.lengths, origin, goal)

    def hold(self, q: Array) -> ActuatedDriver:
        """Keeps the actuated coordinates as a configuration (nq,) has them."""
        values = q[self.q_index]
        return self.lead(values, values)

    def show(self, values: Array) -> str:
        """Actuated coordinates (n,) in words."""
        pairs = zip(self.joints, values, strict=True)
        return ", ".join(f"{actuator.name} {value:.6g} {actuator.unit}" for actuator, value in pairs)
