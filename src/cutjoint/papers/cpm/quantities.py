"""What Elkady et al. 2008 say of a posture of the CPM: Gamma, angles, energies, multipliers and the terms of (39)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.mechanism import Posture
from cutjoint.papers.cpm import equations, per_limb
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.cpm.state import CpmState
from cutjoint.papers.scalars import three, times
from cutjoint.papers.three_limbs import ThreeLimbModel


@dataclass(frozen=True, eq=False)
class LimbEnergies(Frozen):
    """Energies of the limbs and of the tool [J]; their sums are (18) and (19).

    Attributes:
        kinetic: T_1, T_2, T_3 of equations (12), (14), (16) and that of the tool m4, shape (4,).
        potential: V_1, V_2, V_3 of equations (13), (15), (17) and that of the tool m4, shape (4,).
    """

    kinetic: Array
    potential: Array


class CpmQuantities(ThreeLimbModel[CpmParameters]):
    """The quantities of a posture that stores (x, y, z, theta_11, theta_21, theta_31)."""

    stored = ("x", "y", "z", "theta_11", "theta_21", "theta_31")

    def __init__(self, parameters: CpmParameters, signs: Sequence[int]) -> None:
        super().__init__(parameters, signs)
        self._coefficients = self.coefficients(parameters)

    @staticmethod
    def coefficients(parameters: CpmParameters) -> CpmCoefficients:
        """The constants of the equation of motion."""
        return parameters.coefficients

    def state(self, at: Posture) -> CpmState:
        """Equation (39) at a posture."""
        x, y, z, one, two, three_ = self.full(at)
        return CpmState(self.parameters, self._coefficients, (x, y, z), (one, two, three_))

    def gamma(self, at: Posture) -> Array:
        """Gamma of equation (30): rates of the first links over velocity of the tool, shape (3, 3) [rad/m]."""
        return readonly(self.state(at).gamma)

    def gamma_dot(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Exact time derivative of Gamma for the tool velocity `v` [m/s], shape (3, 3) [rad/(m s)]."""
        return readonly(self.state(at).gamma_dot(three("v", v, "m/s")))

    def coriolis_matrix(self, at: Posture, v: npt.ArrayLike) -> Array:
        """The paper's matrix G of equation (39), shape (3, 3) [kg/s]."""
        state = self.state(at)
        return readonly(
            equations.coriolis_matrix(self._coefficients, state.gamma, state.gamma_dot(three("v", v, "m/s")))
        )

    def angles(self, at: Posture) -> Array:
        """Both angles of every limb, theta_i1 and theta_i2 of equations (1) to (8), shape (3, 2) [rad].

        The second ones come within half a turn.
        """
        second = per_limb.second_angles(self.parameters, self.state(at).limbs)
        return readonly(tuple(zip(self.full(at)[3:], second, strict=True)))

    def angle_rates(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Rates of both angles of every limb for the tool velocity `v` [m/s], shape (3, 2) [rad/s]."""
        state, velocity = self.state(at), three("v", v, "m/s")
        first = times(state.gamma, velocity)
        second = per_limb.second_rates(self.parameters, state.limbs, first, velocity)
        return readonly(tuple(zip(first, second, strict=True)))

    def limb_energies(self, at: Posture, v: npt.ArrayLike) -> LimbEnergies:
        """Energies limb by limb for the tool velocity `v` [m/s], equations (12) to (17), and those of the tool."""
        p, state, velocity = self.parameters, self.state(at), three("v", v, "m/s")
        rates = times(state.gamma, velocity)
        tool = 0.5 * p.m4 * sum(speed * speed for speed in velocity)
        return LimbEnergies(
            readonly((*per_limb.kinetic_energies(p, velocity, rates), tool)),
            readonly((*per_limb.potential_energies(p, state.limbs), -p.m4 * p.g * state.limbs[0].w)),
        )

    def multipliers(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Lagrange's multipliers (35) for velocity `v` [m/s] and acceleration `a` [m/s2] of the tool, shape (3,) [N m].

        lambda_i is the moment about the pivot of the first rod of limb i that its second rod exerts.  By (36) to (38)
        the actuators' forces are what moves with the tool, times its acceleration, less its weight, plus
        Gamma' lambda.
        """
        state, velocity = self.state(at), three("v", v, "m/s")
        rates, acceleration = state.gamma_dot(velocity), three("a", a, "m/s2")
        return readonly(
            per_limb.multipliers(self._coefficients, state.limbs, state.gamma, rates, velocity, acceleration)
        )

    def rod_tensions(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Force along each second rod, multiplier over lever arm, positive where it pulls; shape (3,) [N]."""
        one, two, three_ = self.multipliers(at, v, a).tolist()
        return readonly(per_limb.rod_tensions(self.parameters, self.state(at).limbs, (one, two, three_)))
