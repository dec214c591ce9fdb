"""Reduced models of robots with three limbs, which move a point in space with three actuators of one kind.

The algebra of three coordinates is written out (`cutjoint.papers.scalars`): on floats it is several times as quick as
numpy's on such small arrays.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from itertools import product
from typing import ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.mechanism import Posture, Terms
from cutjoint.papers.reduced_model import EquationState, P, ReducedModel
from cutjoint.papers.scalars import (
    Matrix3,
    Vector6,
    check_signs,
    solve_symmetric,
    symmetric,
    three,
    times,
)

Triple = tuple[float, float, float]
Signs = tuple[int, int, int]
"""A working mode: +1 or -1 for each limb."""


class Branch(NamedTuple):
    """The branch of a posture of a robot that has assembly modes too.

    Attributes:
        signs: working mode.
        assembly: sign of the type-2 measure, which an assembly mode keeps between singularities.
    """

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
        unit = self.actuators[0].unit
        self._rate, self._acceleration = f"{unit}/s", f"{unit}/s2"
        self._effort = self.actuators[0].effort_unit

    def __repr__(self) -> str:
        return f"{type(self).__name__}(parameters={self.parameters!r}, signs={self.signs!r})"

    @cached_property
    def home(self) -> Posture:
        """The tool at `home_tool`, in the working mode `signs`."""
        return self._place(self.home_tool, self.signs)

    def rebuilt(self, parameters: P) -> Self:
        """The same kind of robot, in the same working mode, with other parameters."""
        return type(self)(parameters, self.signs)

    def on_branch(self, branch: Signs | Branch) -> Self:
        """The same robot, at home in another working mode."""
        return type(self)(self.parameters, branch.signs if isinstance(branch, Branch) else branch)

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

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix, Coriolis vector and gravity of the paper's equation of motion."""
        state = self.state(at)
        coriolis = (0.0, 0.0, 0.0) if v is None else state.coriolis(three("v", v, self._rate))
        return Terms(np.array(symmetric(state.entries())), np.array(coriolis), np.array(state.gravity()))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Effort of the actuators for their acceleration `a`, shape (3,), [N] or [N m]."""
        state = self.state(at)
        c1, c2, c3 = state.coriolis(three("v", v, self._rate))
        g1, g2, g3 = state.gravity()
        f1, f2, f3 = times(symmetric(state.entries()), three("a", a, self._acceleration))
        return readonly((f1 + c1 + g1, f2 + c2 + g2, f3 + c3 + g3))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration of the actuators that `effort` gives, shape (3,), [m/s2] or [rad/s2]."""
        state = self.state(at)
        c1, c2, c3 = state.coriolis(three("v", v, self._rate))
        g1, g2, g3 = state.gravity()
        f1, f2, f3 = three("effort", effort, self._effort)
        return readonly(solve_symmetric(state.entries(), (f1 - c1 - g1, f2 - c2 - g2, f3 - c3 - g3)))

    def _numbers(self, name: str, values: npt.ArrayLike, per: str) -> Triple:
        return three(name, values, self.actuators[0].unit + per)
