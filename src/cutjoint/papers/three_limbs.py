"""Reduced models of robots with three limbs, which move a point in space with three actuators of one kind, and of those
of them whose limbs are rotary, with rods of one length that meet in the tool.

With the tool known each limb of these has two solutions (working modes), with the motors known the tool has several
(assembly modes); between those lie the postures where the rods are parallel to one plane, singular of type 2.  The
algebra of three coordinates is written out (`cutjoint.papers.scalars`): on floats it is several times as quick as
numpy's on such small arrays.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from itertools import product
from math import pi, sqrt
from typing import ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.errors import SingularError
from cutjoint.mechanism import NO_LOADS, Loads, Posture
from cutjoint.papers.reduced_model import EquationState, P, ReducedModel
from cutjoint.papers.scalars import (
    Matrix3,
    Scalar,
    Vector3,
    Vector6,
    check_signs,
    solve_symmetric,
    symmetric,
    three,
    times,
)
from cutjoint.reprs import one_line, quoted, short

Triple = tuple[float, float, float]
Signs = tuple[int, int, int]
"""A working mode: +1 or -1 for each limb."""


class Branch(NamedTuple):
    """The branch of a posture of a robot that has assembly modes too: its working mode, and the sign of the type-2
    measure, which an assembly mode keeps between singularities."""

    signs: Signs
    assembly: int


class ThreeLimbState(EquationState):
    """The equations at one posture, the mass matrix by its six entries."""

    __slots__ = ()

    @abstractmethod
    def entries(self) -> Vector6:
        """Mass matrix as (xx, xy, xz, yy, yz, zz)."""

    def mass(self) -> Matrix3:
        """Mass matrix."""
        return symmetric(self.entries())


class ThreeLimbModel(ReducedModel[P]):
    """A reduced model of a robot with three limbs.

    Args:
        parameters: geometry and masses.
        signs: the working mode at home, +1 or -1 for each limb.
    """

    home_tool: ClassVar[Triple]
    """Tool position of the home posture [m]."""

    def __init__(self, parameters: P, signs: Sequence[int]) -> None:
        super().__init__(parameters)
        self.signs = check_signs(signs)

    def __repr__(self) -> str:
        names = short([f"{one.name} [{one.unit}]" for one in self.actuators])
        return one_line(type(self).__name__, [quoted(self.name), f"actuators={names}", f"signs={self.signs}"])

    @cached_property
    def home(self) -> Posture:
        """The tool at `home_tool`, in the working mode `signs`."""
        return self._place(self.home_tool, self.signs)

    def rebuilt(self, parameters: P) -> Self:
        """The same kind of robot, in the same working mode, with other parameters."""
        return type(self)(parameters, self.signs)

    def on_branch(self, branch: Signs | Branch) -> Self:
        """The same robot, at home in another working mode."""
        return type(self)(self.parameters, branch.signs if isinstance(branch, Branch) else branch)._with(self.motors)

    def working_modes(self, p: npt.ArrayLike) -> tuple[Posture, ...]:
        """All eight postures with the tool at `p` [m], in the order of the signs (+++, ++-, ..., ---).

        Raises:
            LimbReachError: a limb is too short or too long for it.
            SingularError: one of them is singular.
        """
        tool = three("p", p, "m")
        return tuple(self._place(tool, check_signs(signs)) for signs in product((1, -1), repeat=3))

    @abstractmethod
    def state(self, at: Posture) -> ThreeLimbState:
        """The equations at a posture."""

    @abstractmethod
    def _place(self, tool: Triple, signs: Signs) -> Posture:
        """Inverse kinematics with its checks."""

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Effort of the actuators for their acceleration `a`, shape (3,), [N] or [N m]."""
        if self.motors:
            return super().inverse_dynamics(at, v, a, loads)
        state = self.state(at)
        c1, c2, c3 = state.coriolis(three("v", v, self._rate))
        g1, g2, g3 = state.gravity()
        f1, f2, f3 = times(symmetric(state.entries()), three("a", a, self._acceleration))
        return readonly(self._relieved(np.array((f1 + c1 + g1, f2 + c2 + g2, f3 + c3 + g3)), at, loads))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Acceleration of the actuators that `effort` gives, shape (3,), [m/s2] or [rad/s2]."""
        if self.motors:
            return super().forward_dynamics(at, v, effort, loads)
        state = self.state(at)
        c1, c2, c3 = state.coriolis(three("v", v, self._rate))
        g1, g2, g3 = state.gravity()
        given = three("effort", effort, self._effort)
        f1, f2, f3 = given if loads is NO_LOADS else self._aided(np.array(given), at, loads).tolist()
        return readonly(solve_symmetric(state.entries(), (f1 - c1 - g1, f2 - c2 - g2, f3 - c3 - g3)))

    def _numbers(self, name: str, values: npt.ArrayLike, unit: str) -> Triple:
        return three(name, values, unit)


SMALLEST_MEASURE = 1e-4
"""Smallest distance from a singularity that is accepted: near type 2 the volume of the directions of the three rods,
near type 1 the sine between arm and rod.  Both vanish like a root, so answers lose as many digits as the measure's
square: eight are left here."""


class MeetingRods(NamedTuple):
    """The rods at a posture.

    Attributes:
        rows: each rod in space [m].
        modes: positive where a limb is in working mode +1.
        volume: of the three rods [m3]; its sign is the assembly mode.
        length: of a rod [m].
    """

    rows: Matrix3
    modes: Vector3
    volume: Scalar
    length: float


class MeetingRodsModel(ThreeLimbModel[P]):
    """A reduced model of such a robot; a posture stores the angles of the motors and the tool."""

    rod: ClassVar[str]
    """What messages call the rods."""

    @abstractmethod
    def _rods(self, angles: Triple, tool: Triple) -> MeetingRods:
        """The rods with the motors at `angles` [rad] and the tool at a position [m]."""

    @abstractmethod
    def _limb_angle(self, tool: Triple, i: int, sign: int) -> float:
        """Angle of limb i (0, 1, 2) in a working mode [rad]; raises where it does not reach the tool, or only just."""

    def split(self, at: Posture) -> tuple[Triple, Triple]:
        """Angles [rad] and tool [m] of a posture."""
        one, two, three, x, y, z = self.full(at)
        return (one, two, three), (x, y, z)

    def branch(self, at: Posture) -> Branch:
        """Working mode, and side of the type-2 singularities, of a posture."""
        _, (one, two, three), volume, _ = self._rods(*self.split(at))
        return Branch((1 if one > 0 else -1, 1 if two > 0 else -1, 1 if three > 0 else -1), 1 if volume > 0 else -1)

    def _place(
        self, tool: Triple, signs: Signs, around: Triple = (0.0, 0.0, 0.0), assembly: int | None = None
    ) -> Posture:
        """Inverse kinematics with its checks; angles are taken within half a turn of `around`."""
        one, two, three = (
            angle + 2.0 * pi * round((middle - angle) / (2.0 * pi))
            for angle, middle in zip((self._limb_angle(tool, i, signs[i]) for i in range(3)), around, strict=True)
        )
        angles = (one, two, three)
        return self._checked(angles, tool, self._rods(angles, tool), assembly)

    def _checked(self, angles: Triple, tool: Triple, rods: MeetingRods, assembly: int | None = None) -> Posture:
        """The posture with its residual, unless it is singular of type 2 or on the wrong side of a singularity."""
        rows, _, volume, length = rods
        measure = volume / length**3
        if abs(measure) < SMALLEST_MEASURE:
            raise type_2(
                f"the {self.rod} of {self.name} lie parallel to one plane with the tool at {list(tool)} m: the volume "
                f"of their directions is {abs(measure):.3g}, below {SMALLEST_MEASURE:g} (type-2 singularity)",
                abs(measure),
            )
        if assembly is not None and measure * assembly < 0.0:
            raise type_2(
                f"{self.name} comes to {list(tool)} m in this working mode only through a type-2 singularity (volume "
                f"of the {self.rod}' directions {measure:+.3g}, of the other sign before)"
            )
        gap = max(abs(sqrt(x * x + y * y + z * z) - length) for x, y, z in rows)
        return Posture(readonly(angles), readonly((*angles, *tool)), (gap, 0.0), self.layout)


def type_2(message: str, measure: float = 0.0) -> SingularError:
    """The error of a singularity of type 2 at which the rods have this measure, or beyond which they would."""
    return SingularError(message, kind="type-2", measure=measure, limit=SMALLEST_MEASURE)
