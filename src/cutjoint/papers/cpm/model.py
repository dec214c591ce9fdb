"""The Cartesian Parallel Manipulator as a `Mechanism`: Lagrange's equations of Elkady et al. 2008, equation (39).

The actuated coordinates are the slider positions, which are the tool position (equation 10), so `close` and `reach` are
the same.  A posture stores (x, y, z, theta_11, theta_21, theta_31); the angles tell the branch.  The checks on values
are here, the equations in `cutjoint.papers.cpm.equations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, sin, sqrt
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.errors import InputError, LimbReachError, SingularError
from cutjoint.mechanism import ActuatedCoordinates, Actuator, JointLimits, Posture, Tool, in_order
from cutjoint.mechanism.interface import are_respected
from cutjoint.papers.cpm import equations, per_limb
from cutjoint.papers.cpm.equations import CpmState
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.papers.scalars import NUMBERS, Functions, Vector3, three, times
from cutjoint.papers.three_limbs import Signs, ThreeLimbModel, Triple
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class LimbEnergies(Frozen):
    """Energies of the limbs and of the tool [J]; their sums are (18) and (19).

    Attributes:
        kinetic: T_1, T_2, T_3 of equations (12), (14), (16) and that of the tool m4, shape (4,).
        potential: V_1, V_2, V_3 of equations (13), (15), (17) and that of the tool m4, shape (4,).
    """

    kinetic: Array
    potential: Array

    __repr__ = line(kinetic="J", potential="J")


class CpmQuantities(ThreeLimbModel[CpmParameters]):
    """The quantities of a posture that stores (x, y, z, theta_11, theta_21, theta_31)."""

    stored = ("x[m]", "y[m]", "z[m]", "theta_11[rad]", "theta_21[rad]", "theta_31[rad]")

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


HOME_TOOL = (0.6, 0.425, 0.3)
"""Tool position of the home posture [m]: where the paper's circle starts (section 5.3)."""

SMALLEST_SINE = 1e-4
"""Smallest |sin(elbow)| that is accepted.  Gamma loses as many digits as the sine's square: eight are left here, and
only the last nanometre of a limb's reach is given up."""

_IDENTITY = np.eye(3)
_STILL = np.zeros(3)


class CpmModel(CpmQuantities, ClosedFormModel[CpmParameters, Signs]):
    """The reduced model of the CPM.

    Args:
        parameters: geometry and masses.
        signs: the elbow branch of each limb at home.  +1 where sin(theta_i1 - theta_i2) > 0, so that the first link
            stands ahead of the line from slider to platform, -1 otherwise.  The default is the branch that the paper's
            own figures need (see docs/errata.md).
    """

    name = "cpm (Lagrange)"
    actuators = tuple(Actuator(f"limb{i}_slide", "translation") for i in (1, 2, 3))
    payload = "m4"
    home_tool = HOME_TOOL

    def __init__(self, parameters: CpmParameters | None = None, signs: Sequence[int] = (1, -1, 1)) -> None:
        super().__init__(parameters if parameters is not None else CpmParameters(), signs)

    @property
    def length(self) -> float:
        """Characteristic length [m]: the mean of the two links of a limb."""
        return 0.5 * (self.parameters.L1 + self.parameters.L2)

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """The posture with the sliders at `q` = (x, y, z) [m], on the elbow branch of `near`.

        Raises:
            InputError: wrong shape or not finite.
            LimbReachError: a limb is too short or too long for it.
            SingularError: a limb is stretched or folded (kind `limb`).
        """
        are_respected(limits)
        sliders = three("q", in_order(q, self.actuators), "m")
        return self._place(sliders, self.signs if near is None else self.branch(near))

    def reach_point(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m]; the same as `close` (equation 10), with the same errors."""
        return self._place(three("target", p, "m"), self.signs if near is None else self.branch(near))

    def branch(self, at: Posture) -> Signs:
        """The elbow signs of a posture."""
        x, y, z, *angles = self.full(at)
        one, two, three_ = equations.limbs(self.parameters, (x, y, z), (angles[0], angles[1], angles[2]))
        return (
            1 if one.denominator > 0 else -1,
            1 if two.denominator > 0 else -1,
            1 if three_.denominator > 0 else -1,
        )

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """The tool follows the sliders: the Jacobian of its point is the identity, the drift zero (equation 10)."""
        speed = None if v is None else np.array(three("v", v, "m/s"))
        return Tool.of_point(np.array(self.full(at)[:3]), _IDENTITY, _STILL, speed)

    def state_at(self, parameters: CpmParameters, q: Vector3, branch: Signs, fn: Functions = NUMBERS) -> CpmState:
        """Equation (39) with the sliders at `q`."""
        angles = equations.limb_angles(parameters, q, branch, fn)
        return CpmState(parameters, self.coefficients(parameters), q, angles, fn)

    def inverse_kinematics(
        self, parameters: CpmParameters, p: Vector3, branch: Signs, fn: Functions = NUMBERS
    ) -> Vector3:
        """The sliders stand where the tool does (equation 10)."""
        return p

    def _place(self, tool: Triple, signs: Signs) -> Posture:
        p = self.parameters
        angles, gap = [], 0.0
        for number, ((u, w), sign) in enumerate(zip(equations.limb_ends(p, tool), signs, strict=True), start=1):
            check_limb(self.name, p, number, (u, w), tool, "limb")
            angle = equations.limb_angle(p, u, w, sign)
            gap = max(gap, abs(hypot(u - p.L1 * cos(angle), w - p.L1 * sin(angle)) - p.L2))
            angles.append(angle)
        return Posture(readonly(tool), readonly((*tool, *angles)), (gap, 0.0), self.layout)


def check_limb(
    name: str,
    p: CpmParameters,
    number: int,
    end: tuple[float, float],
    tool: Triple,
    kind: str,
) -> None:
    """Raise where limb `number` of the model `name` does not reach the tool [m], or only just.

    Args:
        end: (u, w) of the limb in its own plane [m].
        kind: of the singularity, for the error: `limb`, or `type-1` where the first rod is driven.

    Raises:
        LimbReachError: it is too short or too long.
        SingularError: it is stretched or folded.
    """
    bounds = p.reach
    square = end[0] * end[0] + end[1] * end[1]
    reach = sqrt(square)
    if not bounds[0] <= reach <= bounds[1]:
        raise LimbReachError(
            f"limb {number} of {name} would have to span {reach:.6g} m to hold the tool at "
            f"{list(tool)} m; it spans {bounds[0]:.6g} to {bounds[1]:.6g} m",
            limb=number,
            reach=reach,
            bounds=bounds,
            target=readonly(tool),
        )
    cosine = (square - p.L1 * p.L1 - p.L2 * p.L2) / (2.0 * p.L1 * p.L2)
    sine = sqrt(max(0.0, 1.0 - cosine * cosine))
    if sine < SMALLEST_SINE:
        raise SingularError(
            f"limb {number} of {name} is {'stretched' if cosine > 0 else 'folded'} with the tool at "
            f"{list(tool)} m: |sin(elbow)| = {sine:.3g} is below {SMALLEST_SINE:g}; stay away from limb "
            f"reaches of {bounds[0]:.6g} and {bounds[1]:.6g} m",
            kind=kind,
            measure=sine,
            limit=SMALLEST_SINE,
        )


class InferredCpmModel(CpmModel):
    """The model that Table 3 was most likely computed with; it is not the paper's equation (39).

    Equation (39) does not give the figures of Table 3, but for the two errors of computed torque, which cancels its
    model.  A slightly different model gives three more and the gains: the rods count half in the mass matrix (B instead
    of 2 B) but fully in the Coriolis term (2 B), and the sliders m3 are missing in the weight E.  The finding is after
    the fact, so it is evidence and no proof (docs/errata.md).  The model breaks the skew symmetry of dM/dt - 2 G, so it
    does not conserve energy.  Use it to compare with Table 3, for nothing else.
    """

    name = "cpm (inferred code)"

    @staticmethod
    def coefficients(parameters: CpmParameters) -> CpmCoefficients:
        """Inertia 2 A + B Gamma' Gamma, Coriolis 2 B Gamma' dGamma/dt, weight without m3."""
        p = parameters
        return CpmCoefficients(2.0 * p.A, p.B, 2.0 * p.B, p.C, (p.m1 + 2.0 * p.m2 + p.m4) * p.g)

    def limb_energies(self, at: Posture, v: npt.ArrayLike) -> NoReturn:
        """None: it is no mechanism.

        Raises:
            InputError: always.
        """
        raise InputError(f"{self.name} is no mechanism and keeps no energy; ask CpmModel for (12) to (17) of the paper")
