"""The values that models hand out: posture, terms of the equation of motion, tool kinematics.

All arrays in them are read-only, also after pickling and copying.  SI units and radians throughout.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.errors import InputError
from cutjoint.mechanism.names import Layout
from cutjoint.mechanism.pose import Pose
from cutjoint.reprs import clipped, line, told
from cutjoint.tables import TextTable

_NONE = readonly(np.zeros(0))


@dataclass(frozen=True, eq=False, repr=False)
class Posture(Frozen):
    """A closed configuration.  Only `close()` and `reach()` of a mechanism make one, so it is always closed.

    `posture["arm1"]` is a coordinate by its name, [m] or [rad]: a number, or for joints with several coordinates all of
    them, as a home posture of loops.toml gives them.

    Attributes:
        q: actuated coordinates, shape (n,), [m] or [rad].
        q_full: the owner's own layout, shape (nq,) for a chain.  It also tells the branch (working and assembly mode).
        gap: worst residual over all loops, ([m], [rad]).
        layout: what these numbers are called; None where nobody said.
    """

    q: Array
    q_full: Array
    gap: tuple[float, float] = (0.0, 0.0)
    layout: Layout | None = None

    def __getitem__(self, name: str) -> float | Array:
        """The coordinate called `name`.

        Raises:
            UnknownNameError: there is none.
            InputError: nobody said what the numbers are called.
        """
        if self.layout is None:
            raise InputError(f"this posture has no names, so no {name!r}; make it with close() or reach() of a robot")
        return self.layout.value(name, self.q, self.q_full)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all coordinates, the actuators first."""
        return () if self.layout is None else self.layout.names

    @property
    def actuated(self) -> dict[str, float]:
        """Actuated coordinates by name, which `close` takes, [m] or [rad]."""
        actuators = () if self.layout is None else self.layout.actuators
        return {actuator.name: float(value) for actuator, value in zip(actuators, self.q, strict=False)}

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def table(self) -> TextTable:
        """All coordinates by name, with their units."""
        layout = Layout("a robot", (), ()) if self.layout is None else self.layout
        distance, angle = self.gap
        title = f"posture of {clipped(layout.robot)}, closed to {distance:.2g} m, {angle:.2g} rad"
        return TextTable(title, ("coordinate", "value", ""), layout.rows(self.q, self.q_full))

    def __repr__(self) -> str:
        if self.layout is None:
            return told(self, "q", "q_full", "gap", q="m or rad", gap="m, rad")
        distance, angle = self.gap
        head = f"posture of {clipped(self.layout.robot)}, closed to {distance:.2g} m, {angle:.2g} rad"
        return f"{head}\n{self.layout.words(self.q, self.q_full)}".rstrip()


@dataclass(frozen=True, eq=False)
class Terms(Frozen):
    """The equation of motion in actuated coordinates:
    `mass @ a + coriolis + gravity + springs + friction = effort`.

    Attributes:
        mass: symmetric positive definite, rotors included, shape (n, n), [kg], [kg m] or [kg m2].
        coriolis: the vector C(q, v) v, shape (n,), [N] or [N m].  The vector is unique; the matrix C is not.
        gravity: effort that holds the weights at rest, shape (n,), [N] or [N m].
        springs: effort that holds springs, bushings and stops, shape (n,); zero where there are none.
        friction: effort that overcomes dampers and dry friction at this velocity, shape (n,); zero where there are
            none, and without a velocity.
    """

    mass: Array
    coriolis: Array
    gravity: Array
    springs: Array = field(default_factory=lambda: _NONE)
    friction: Array = field(default_factory=lambda: _NONE)

    __repr__ = line(
        mass="kg, kg m or kg m2", coriolis="N or N m", gravity="N or N m", springs="N or N m", friction="N or N m"
    )

    def __post_init__(self) -> None:
        for name in ("springs", "friction"):
            if self.__dict__[name] is _NONE:
                self.__dict__[name] = np.zeros_like(self.gravity)
        super().__post_init__()

    @property
    def bias(self) -> Array:
        """Effort that keeps the velocity: everything but the mass times the acceleration, shape (n,)."""
        return self.coriolis + self.gravity + self.springs + self.friction

    @property
    def holding(self) -> Array:
        """Effort that holds the posture at rest: gravity and springs, shape (n,)."""
        return self.gravity + self.springs


@dataclass(frozen=True, eq=False)
class Tool(Frozen):
    """Kinematics of the tool: a frame, whose origin is the tool point.

    Attributes:
        position: of the tool point in the world frame, shape (3,), [m].
        rotation: axes of the tool as columns, in the world frame, shape (3, 3).
        frame_jacobian: twist = frame_jacobian @ v: rows of the velocity of the tool point, then of the angular
            velocity, both along the axes of the world, shape (6, n).
        frame_drift: time derivative of the frame Jacobian times v, shape (6,), [m/s2] and [rad/s2]; without v zero.
        twist: velocity of the tool point [m/s] and angular velocity [rad/s], shape (6,); without v zero.
    """

    position: Array
    rotation: Array
    frame_jacobian: Array
    frame_drift: Array
    twist: Array

    __repr__ = line("position", "rotation", "frame_jacobian", "twist", position="m", twist="m/s, rad/s")

    @classmethod
    def of_point(cls, position: Array, jacobian: Array, drift: Array, v: Array | None = None) -> Tool:
        """Of a tool that never turns, from what is known of its point: shapes (3,), (3, n), (3,)."""
        still = np.zeros_like(jacobian)
        twist = np.zeros(6) if v is None else np.concatenate([jacobian @ v, np.zeros(3)])
        frame_drift = np.concatenate([drift, np.zeros(3)])
        return cls(position, _UNTURNED, np.concatenate([jacobian, still]), frame_drift, twist)

    @property
    def jacobian(self) -> Array:
        """Velocity of the tool point = jacobian @ v, shape (3, n)."""
        return self.frame_jacobian[:3]

    @property
    def drift(self) -> Array:
        """Acceleration of the tool point = jacobian @ a + drift, shape (3,), [m/s2]."""
        return self.frame_drift[:3]

    @property
    def pose(self) -> Pose:
        """Position and rotation."""
        return Pose(self.position, self.rotation)


_UNTURNED = readonly(np.eye(3))
