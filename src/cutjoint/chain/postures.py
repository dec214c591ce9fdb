"""Which joints of a robot are actuated, and the postures that users hold: from closed configurations, and back."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import ActuatedDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.joints import stored_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError
from cutjoint.mechanism import Actuator, Layout, Posture


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

    told = "actuators"
    """What messages call them."""

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


class Postures:
    """Postures of one robot, and the tree at them; `home` is the home posture, `at_home` the tree there."""

    def __init__(self, kinematics: Kinematics, actuated: Actuated, at_home: Placed) -> None:
        self.k, self.actuated = kinematics, actuated
        driven = {actuator.name for actuator in actuated.joints}
        rest = [joint for joint in kinematics.description.joints if joint.type.moves and joint.name not in driven]
        self.layout = Layout(kinematics.name, actuated.joints, stored_of(kinematics.model, rest))
        self.home, self.at_home = self.make(at_home), at_home

    def make(self, placed: Placed) -> Posture:
        """A closed configuration as a posture."""
        distance, angle, _ = placed.gap
        posture = Posture(self.actuated.of(placed.q), placed.q, (distance, angle), self.layout)
        self.known = posture, placed
        return posture

    def placed(self, at: Posture | None) -> Placed:
        """The tree at a posture (default home) that this robot, or one of the same geometry, made.

        That of the last posture is kept, since several calls at one posture are the rule.

        Raises:
            InputError: it is no posture, or not closed for this robot.
        """
        if at is None or at is self.home:
            return self.at_home
        known, placed = self.known
        if at is known:
            return placed
        if not isinstance(at, Posture):
            raise InputError(
                f"a posture is wanted, such as {self.k.name} makes by close() or reach(), and by posture() of a closed "
                f"configuration; found {at!r}"
            )
        size = len(self.at_home.q)
        if at.q_full.shape != (size,):
            raise InputError(
                f"this posture has {at.q_full.size} coordinates, {self.k.name} has {size}; make it with this robot's "
                "close() or reach()"
            )
        placed = self.k.at(at.q_full)
        if not System(self.k, None).at(placed).openness < 10.0:
            distance, angle, cut = placed.gap
            raise InputError(
                f"this posture leaves {self.k.closure.told(cut)} of {self.k.name} open by {distance:.3g} m, "
                f"{angle:.3g} rad; make it with this robot's close() or reach()"
            )
        self.known = at, placed
        return placed
