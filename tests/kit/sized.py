"""The same robot built larger, heavier, turned or somewhere else, and its numbers made dimensionless again.

With lengths times s, masses times m and gravity times g, times go by sqrt(s / g): an angle is the same angle, an energy
m s g times as large.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cutjoint.description.model import (
    Coupling,
    CutJoint,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    RobotDescription,
)

Array = np.ndarray
UPRIGHT = np.eye(3)
LENGTHS = {JointType.PRISMATIC: 1, JointType.PLANAR: 2, JointType.FLOATING: 3}


@dataclass(frozen=True)
class Size:
    """Lengths, masses and gravity times these; the base turned by `rotation` (gravity with it) and put at `offset`."""

    length: float = 1.0
    mass: float = 1.0
    gravity: float = 1.0
    rotation: Array = field(default_factory=lambda: UPRIGHT)
    offset: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def time(self) -> float:
        """Unit of time."""
        return float(np.sqrt(self.length / self.gravity))

    @property
    def energy(self) -> float:
        """Unit of energies and torques."""
        return self.mass * self.length * self.gravity

    def of(self, robot: RobotDescription) -> RobotDescription:
        """`robot` of this size, on a link called `ground`."""
        kinds = {joint.name: joint.type for joint in robot.joints}
        mount = np.eye(4)
        mount[:3, :3], mount[:3, 3] = self.rotation, self.offset
        return replace(
            robot,
            links=(Link("ground"), *(replace(link, inertial=self._body(link.inertial)) for link in robot.links)),
            joints=(
                Joint("mount", JointType.FIXED, "ground", robot.root, mount),
                *(self._joint(joint) for joint in robot.joints),
            ),
            cuts=tuple(self._cut(cut) for cut in robot.cuts),
            couplings=tuple(self._coupling(one, kinds) for one in robot.couplings),
            tool=None if robot.tool is None else self._frame(robot.tool),
            gravity=self.gravity * self.rotation @ robot.gravity,
            homes=tuple(self._home(home, kinds) for home in robot.homes),
            variants=(),
        )

    def place(self, point: Array) -> Array:
        """A point of the robot at size 1 as it is in the world now, (3,) [m]."""
        return self.length * self.rotation @ point + self.offset

    def _placement(self, placement: Array) -> Array:
        moved = np.array(placement)
        moved[:3, 3] *= self.length
        return moved

    def _frame(self, frame: Frame) -> Frame:
        return Frame(frame.link, self._placement(frame.placement))

    def _cut(self, cut: CutJoint) -> CutJoint:
        return replace(cut, a=self._frame(cut.a), b=self._frame(cut.b))

    def _body(self, body: Inertial | None) -> Inertial | None:
        if body is None:
            return None
        return Inertial(self.mass * body.mass, self.length * body.com, self.mass * self.length**2 * body.inertia)

    def _joint(self, joint: Joint) -> Joint:
        limits = joint.limits
        if joint.type is JointType.PRISMATIC:
            lower, upper = (None if x is None else self.length * x for x in (limits.lower, limits.upper))
            limits = Limits(lower, upper)
        return replace(joint, placement=self._placement(joint.placement), limits=limits)

    def _coupling(self, one: Coupling, kinds: dict[str, JointType]) -> Coupling:
        units = {name: self.length if kind is JointType.PRISMATIC else 1.0 for name, kind in kinds.items()}
        here = units[one.joint]
        drives = tuple(replace(own, curve=own.curve.scaled(1.0 / units[own.driver], 1.0 / here)) for own in one.drives)
        return replace(one, drives=drives, offset=one.offset * here)

    def _home(self, home: Home, kinds: dict[str, JointType]) -> Home:
        def value(name: str, numbers: Any) -> Any:
            scaled = np.atleast_1d(np.array(numbers, dtype=float))
            scaled[: LENGTHS.get(kinds[name], 0)] *= self.length
            return float(scaled[0]) if np.ndim(numbers) == 0 else tuple(scaled.tolist())

        actuated, passive = ({k: value(k, v) for k, v in part.items()} for part in (home.actuated, home.passive))
        return Home(home.name, actuated, passive)


def coordinate_units(chain: Any, size: Size) -> Array:
    """What a unit of each velocity coordinate of the tree is at this size, over time's, shape (nv,)."""
    units, model = np.ones(chain.nv), chain.model
    kinds = {joint.name: joint.type for joint in chain.description.joints}
    for index in range(1, model.njoints):
        units[model.idx_vs[index] :][: LENGTHS.get(kinds[model.names[index]], 0)] = size.length
    return units


def configuration(chain: Any, size: Size, q_full: Array) -> Array:
    """A configuration of the robot at size 1 as one of `chain` at `size`, shape (nq,)."""
    q, model = np.array(q_full), chain.model
    kinds = {joint.name: joint.type for joint in chain.description.joints}
    for index in range(1, model.njoints):
        q[model.idx_qs[index] :][: LENGTHS.get(kinds[model.names[index]], 0)] *= size.length
    return q
