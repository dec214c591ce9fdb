"""How far a tool gives way, as a value: its compliance, what parts it is made of, and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, as_vector
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.reprs import line

RIGID = 1e-12
"""A compliance below this part of the largest is rounding: the tool is rigid there."""
BALANCE = "weight and loads"
"""What is no spring: weight and standing loads, which move along with what gives way."""


@dataclass(frozen=True, eq=False)
class Principal(Frozen):
    """Stiffness along (about) perpendicular axes that do not mix, the softest first.

    Attributes:
        stiffness: shape (3,), [N/m] or [N m/rad]; infinite where nothing gives way.
        axes: unit vectors as columns, world axes, shape (3, 3).
    """

    stiffness: Array
    axes: Array

    __repr__ = line("softest", "hardest", softest="N/m or N m/rad", hardest="N/m or N m/rad")

    @property
    def softest(self) -> float:
        """The least of them."""
        return float(self.stiffness[0])

    @property
    def hardest(self) -> float:
        """The largest of them."""
        return float(self.stiffness[-1])


@dataclass(frozen=True, eq=False)
class Contribution(Frozen):
    """What one part does to a deflection.

    Attributes:
        name, kind: of the part: an actuator, joint, cut, rod, or what is balanced.
        deflection: of the tool, shape (6,), [m] and [rad], world axes.
        share: of the whole deflection, along it; all shares add up to 1.
    """

    name: str
    kind: str
    deflection: Array
    share: float

    __repr__ = line("name", "kind", "share", "deflection", deflection="m, rad")


@dataclass(frozen=True, eq=False)
class PushedTool(Frozen):
    """What a small load anywhere on a robot does to its tool.

    Attributes:
        deflection: of the tool, shape (6,), [m] and [rad], world axes.
        parts: what each part adds to it, the largest share first.
    """

    deflection: Array
    parts: tuple[Contribution, ...]

    __repr__ = line("deflection", deflection="m, rad")


@dataclass(frozen=True, eq=False)
class ToolStiffness(Frozen):
    """How far the tool of a robot gives way in one posture, at rest under its weight and standing loads.

    Attributes:
        robot: its name.
        at: the posture.
        position: of the tool point, shape (3,) [m].
        compliance: C with deflection = C @ wrench: displacement [m] and small rotation [rad] of the tool by force [N]
            and moment [N m] at the tool point, world axes, shape (6, 6): blocks [m/N], [1/N], [1/N], [rad/(N m)].
        names, kinds: of the parts that give way; the last one is weight and loads.
        parts: what each adds to the compliance, shape (parts, 6, 6).
        stable: whether the robot would come back after a push.
        length: characteristic length of the robot [m], by which rotations and displacements are compared.
    """

    robot: str
    at: Posture
    position: Array
    compliance: Array
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    parts: Array
    stable: bool
    length: float

    __repr__ = line("robot", "position", "softest", "stable", position="m", softest="N/m")

    @property
    def softest(self) -> float:
        """The least stiffness against a force [N/m]."""
        return float(self.translation.stiffness[0])

    @property
    def matrix(self) -> Array:
        """The stiffness K with wrench = K @ deflection, shape (6, 6): blocks [N/m], [N], [N], [N m/rad].

        Raises:
            InputError: the tool is rigid in some direction, so that there is no such matrix.
        """
        scale = np.array([1.0 / self.length] * 3 + [1.0] * 3)
        even = scale[:, None] * self.compliance * scale
        values = np.linalg.svd(even, compute_uv=False)
        rigid = int(np.count_nonzero(values <= RIGID * values[0]))
        if rigid:
            raise InputError(
                f"{self.robot} is rigid in {rigid} of 6 directions with these springs, so its stiffness is infinite "
                "there; `compliance` has no such trouble, or let joints and rods give way too"
            )
        return np.asarray(scale[:, None] * np.linalg.inv(even) * scale)

    @property
    def translation(self) -> Principal:
        """Against forces at the tool point that nothing keeps from turning [N/m]."""
        return self._principal(self.compliance[:3, :3], 1.0)

    @property
    def rotation(self) -> Principal:
        """Against moments [N m/rad]."""
        return self._principal(self.compliance[3:, 3:], self.length**2)

    def _principal(self, block: Array, square: float) -> Principal:
        values, axes = np.linalg.eigh(0.5 * (block + block.T))
        size = float(np.abs(self.compliance[:3, :3]).max() + self.length**2 * np.abs(self.compliance[3:, 3:]).max())
        rigid = np.abs(values) * square <= RIGID * size
        with np.errstate(divide="ignore"):
            stiffness = np.where(rigid, np.inf, 1.0 / np.where(rigid, 1.0, values))
        return Principal(stiffness[::-1], axes[:, ::-1])

    def along(self, direction: npt.ArrayLike) -> float:
        """Stiffness against a force along a direction (3,): force over the displacement along it [N/m].

        Raises:
            InputError: no direction.
        """
        way = as_vector("direction", direction, 3)
        size = float(np.linalg.norm(way))
        if size == 0.0:
            raise InputError("a direction is wanted, found zeros")
        given = float(way @ self.compliance[:3, :3] @ way) / size**2
        largest = float(np.abs(self.compliance[:3, :3]).max())
        return float("inf") if abs(given) <= RIGID * largest else 1.0 / given

    def deflection(self, wrench: npt.ArrayLike) -> Array:
        """Displacement [m] and small rotation [rad] of the tool, shape (6,), by a further small load at the tool point:
        force [N] and moment [N m], shape (6,), world axes; what is rounding is 0."""
        load = as_vector("wrench", wrench, 6)
        found = self.compliance @ load
        units = np.array([self.length] * 3 + [1.0] * 3)
        largest = float(np.abs(self.compliance / units[:, None] / units).max() * np.abs(load * units).max())
        return np.where(np.abs(found) <= RIGID * largest * units, 0.0, found)

    def contributions(self, wrench: npt.ArrayLike) -> tuple[Contribution, ...]:
        """What each part does to that deflection, the largest share first.

        Shares are of the displacement, along it; of the rotation where the tool point stays.
        """
        load = as_vector("wrench", wrench, 6)
        return ranked(self.names, self.kinds, self.deflection(load), self.parts @ load)


def ranked(names: Sequence[str], kinds: Sequence[str], whole: Array, each: Array) -> tuple[Contribution, ...]:
    """Parts by what each (parts, 6) adds to the `whole` deflection (6,), the largest share first."""
    few = slice(0, 3) if whole[:3].any() else slice(3, 6)
    square = float(whole[few] @ whole[few])
    shares = each[:, few] @ whole[few] / square if square else np.zeros(len(each))
    order = np.argsort(-np.abs(shares), kind="stable")
    return tuple(Contribution(names[k], kinds[k], each[k], float(shares[k])) for k in order)
