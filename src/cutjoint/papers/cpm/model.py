"""The Cartesian Parallel Manipulator as a `Mechanism`: Lagrange's equations of Elkady et al. 2008, equation (39).

The actuated coordinates are the slider positions, which are the tool position (equation 10), so `close` and `reach` are
the same.  A posture stores (x, y, z, theta_11, theta_21, theta_31); the angles tell the branch.  The checks on values
are here, the equations in `cutjoint.papers.cpm.equations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import cos, hypot, sin, sqrt
from typing import Self

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values, readonly
from cutjoint.errors import InputError, LimbReachError, SingularError
from cutjoint.mechanism import Actuator, Posture, Terms, Tool
from cutjoint.papers.cpm import equations, per_limb
from cutjoint.papers.cpm.equations import Limbs
from cutjoint.papers.cpm.parameters import Coefficients, Parameters
from cutjoint.papers.scalars import (
    Vector3,
    Vector6,
    check_payload,
    check_signs,
    solve_symmetric,
    symmetric,
    three,
    times,
)

HOME_TOOL = (0.6, 0.425, 0.3)
"""Tool position of the home posture [m]: where the paper's circle starts (section 5.3)."""

SMALLEST_SINE = 1e-4
"""Smallest |sin(elbow)| that is accepted.  Gamma loses as many digits as the sine's square: eight are left here, and
only the last nanometre of a limb's reach is given up."""

_ACTUATORS = tuple(Actuator(f"limb{i}_slide", "translation") for i in (1, 2, 3))
_IDENTITY = np.eye(3)
_STILL = np.zeros(3)


@dataclass(frozen=True, eq=False)
class LimbEnergies(Values):
    """Energies of the limbs and of the tool [J]; their sums are (18) and (19).

    Attributes:
        kinetic: T_1, T_2, T_3 of equations (12), (14), (16) and that of the tool m4, shape (4,).
        potential: V_1, V_2, V_3 of equations (13), (15), (17) and that of the tool m4, shape (4,).
    """

    kinetic: Array
    potential: Array

    def __post_init__(self) -> None:
        for name in ("kinetic", "potential"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


class CpmModel:
    """The reduced model of the CPM.

    Args:
        parameters: geometry and masses.
        signs: the elbow branch of each limb at home.  +1 where sin(theta_i1 - theta_i2) > 0, so that the first link
            stands ahead of the line from slider to platform, -1 otherwise.  The default is the branch that the paper's
            own figures need (see docs/errata.md).
    """

    name = "cpm (Lagrange)"
    n = 3
    actuators = _ACTUATORS

    def __init__(self, parameters: Parameters | None = None, signs: Sequence[int] = (1, -1, 1)) -> None:
        self.parameters = parameters if parameters is not None else Parameters()
        self.signs = check_signs(signs)
        self._coefficients = self.coefficients(self.parameters)

    @staticmethod
    def coefficients(parameters: Parameters) -> Coefficients:
        """The constants of the equation of motion."""
        return parameters.coefficients

    def __repr__(self) -> str:
        return f"{type(self).__name__}(parameters={self.parameters!r}, signs={self.signs!r})"

    @property
    def length(self) -> float:
        """Characteristic length [m]: the mean of the two links of a limb."""
        return 0.5 * (self.parameters.L1 + self.parameters.L2)

    @cached_property
    def home(self) -> Posture:
        """The start of the paper's circle, on the branch `signs`."""
        return self._place(HOME_TOOL, self.signs)

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the sliders at `q` = (x, y, z) [m], on the elbow branch of `near`.

        Raises:
            InputError: wrong shape or not finite.
            LimbReachError: a limb is too short or too long for it.
            SingularError: a limb is stretched or folded (kind `limb`).
        """
        return self._place(three("q", q, "m"), self.signs if near is None else self.branch(near))

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m]; the same as `close` (equation 10), with the same errors."""
        return self._place(three("p", p, "m"), self.signs if near is None else self.branch(near))

    def branch(self, at: Posture) -> tuple[int, int, int]:
        """The elbow signs of a posture."""
        one, two, three_ = self._limbs(at)
        return (
            1 if one.denominator > 0 else -1,
            1 if two.denominator > 0 else -1,
            1 if three_.denominator > 0 else -1,
        )

    def working_modes(self, p: npt.ArrayLike) -> tuple[Posture, ...]:
        """All eight postures with the tool at `p` [m], in the order of the signs (+++, ++-, ..., ---)."""
        tool = three("p", p, "m")
        return tuple(self._place(tool, check_signs(signs)) for signs in product((1, -1), repeat=3))

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """The tool follows the sliders: the Jacobian is the identity, the drift zero (equation 10)."""
        if v is not None:
            three("v", v, "m/s")
        return Tool(np.array(self._full(at)[:3]), _IDENTITY, _STILL)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """M, G v and K of equation (39)."""
        limbs = self._limbs(at)
        mass, bias_v, bias_0 = self._terms(limbs, None if v is None else three("v", v, "m/s"))
        return Terms(np.array(symmetric(mass)), np.array(bias_v), np.array(bias_0))

    def gamma(self, at: Posture) -> Array:
        """Gamma of equation (30): rates of the first links over velocity of the tool, shape (3, 3) [rad/m]."""
        return readonly(equations.gamma(self._limbs(at)))

    def gamma_dot(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Exact time derivative of Gamma for the tool velocity `v` [m/s], shape (3, 3) [rad/(m s)]."""
        return readonly(equations.gamma_dot(self.parameters, self._limbs(at), three("v", v, "m/s")))

    def coriolis_matrix(self, at: Posture, v: npt.ArrayLike) -> Array:
        """The paper's matrix G of equation (39), shape (3, 3) [kg/s]."""
        limbs = self._limbs(at)
        rates = equations.gamma_dot(self.parameters, limbs, three("v", v, "m/s"))
        return readonly(equations.coriolis_matrix(self._coefficients, equations.gamma(limbs), rates))

    def potential_energy(self, at: Posture) -> float:
        """Potential energy of gravity [J], equation (19)."""
        return float(equations.potential_energy(self._coefficients, self._limbs(at)))

    def angles(self, at: Posture) -> Array:
        """Both angles of every limb, theta_i1 and theta_i2 of equations (1) to (8), shape (3, 2) [rad].

        The second ones come within half a turn.
        """
        limbs = self._limbs(at)
        return readonly(tuple(zip(self._full(at)[3:], per_limb.second_angles(self.parameters, limbs), strict=True)))

    def angle_rates(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Rates of both angles of every limb for the tool velocity `v` [m/s], shape (3, 2) [rad/s]."""
        limbs, velocity = self._limbs(at), three("v", v, "m/s")
        first = times(equations.gamma(limbs), velocity)
        return readonly(tuple(zip(first, per_limb.second_rates(self.parameters, limbs, first, velocity), strict=True)))

    def limb_energies(self, at: Posture, v: npt.ArrayLike) -> LimbEnergies:
        """Energies limb by limb for the tool velocity `v` [m/s], equations (12) to (17), and those of the tool."""
        p, limbs, velocity = self.parameters, self._limbs(at), three("v", v, "m/s")
        rates = times(equations.gamma(limbs), velocity)
        tool = 0.5 * p.m4 * sum(speed * speed for speed in velocity)
        return LimbEnergies(
            readonly((*per_limb.kinetic_energies(p, velocity, rates), tool)),
            readonly((*per_limb.potential_energies(p, limbs), -p.m4 * p.g * limbs[0].w)),
        )

    def multipliers(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Lagrange's multipliers (35) for velocity `v` [m/s] and acceleration `a` [m/s2] of the tool, shape (3,) [N m].

        lambda_i is the moment about the pivot of the first rod of limb i that its second rod exerts.  By (36) to (38)
        the actuators' forces are what moves with the tool, times its acceleration, less its weight, plus
        Gamma' lambda.
        """
        limbs, velocity = self._limbs(at), three("v", v, "m/s")
        gamma = equations.gamma(limbs)
        rates = equations.gamma_dot(self.parameters, limbs, velocity)
        return readonly(per_limb.multipliers(self._coefficients, limbs, gamma, rates, velocity, three("a", a, "m/s2")))

    def rod_tensions(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Force along each second rod, multiplier over lever arm, positive where it pulls; shape (3,) [N]."""
        one, two, three_ = self.multipliers(at, v, a).tolist()
        return readonly(per_limb.rod_tensions(self.parameters, self._limbs(at), (one, two, three_)))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Actuator forces for the acceleration `a` [m/s2], shape (3,) [N]."""
        mass, (cx, cy, cz), (kx, ky, kz) = self._terms(self._limbs(at), three("v", v, "m/s"))
        fx, fy, fz = times(symmetric(mass), three("a", a, "m/s2"))
        return readonly((fx + cx + kx, fy + cy + ky, fz + cz + kz))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration that the actuator forces `effort` [N] give, shape (3,) [m/s2]."""
        mass, (cx, cy, cz), (kx, ky, kz) = self._terms(self._limbs(at), three("v", v, "m/s"))
        fx, fy, fz = three("effort", effort, "N")
        return readonly(solve_symmetric(mass, (fx - cx - kx, fy - cy - ky, fz - cz - kz)))

    def with_payload(self, mass: float) -> Self:
        """The same robot with `mass` [kg] more in the tool m4."""
        loaded = replace(self.parameters, m4=self.parameters.m4 + check_payload(mass))
        return type(self)(loaded, self.signs)

    def _terms(self, limbs: Limbs, velocity: Vector3 | None) -> tuple[Vector6, Vector3, Vector3]:
        k = self._coefficients
        gamma = equations.gamma(limbs)
        drift: Vector3 = (0.0, 0.0, 0.0)
        if velocity is not None:
            drift = equations.coriolis(k, gamma, equations.gamma_dot(self.parameters, limbs, velocity), velocity)
        return equations.mass(k, gamma), drift, equations.gravity(k, limbs, gamma)

    def _full(self, at: Posture) -> tuple[float, float, float, float, float, float]:
        if at.q_full.shape != (6,):
            raise InputError(
                f"a posture of {self.name} holds (x, y, z, theta_11, theta_21, theta_31), shape (6,); found shape "
                f"{at.q_full.shape}: a posture belongs to the mechanism that made it"
            )
        x, y, z, one, two, three_ = at.q_full.tolist()
        return x, y, z, one, two, three_

    def _limbs(self, at: Posture) -> Limbs:
        x, y, z, one, two, three_ = self._full(at)
        return equations.limbs(self.parameters, (x, y, z), (one, two, three_))

    def _place(self, tool: tuple[float, float, float], signs: tuple[int, int, int]) -> Posture:
        p = self.parameters
        angles, gap = [], 0.0
        for number, ((u, w), sign) in enumerate(zip(equations.limb_ends(p, tool), signs, strict=True), start=1):
            check_limb(self.name, p, number, (u, w), tool, "limb")
            angle = equations.limb_angle(p, u, w, sign)
            gap = max(gap, abs(hypot(u - p.L1 * cos(angle), w - p.L1 * sin(angle)) - p.L2))
            angles.append(angle)
        return Posture(readonly(tool), readonly((*tool, *angles)), (gap, 0.0))


def check_limb(
    name: str,
    p: Parameters,
    number: int,
    end: tuple[float, float],
    tool: tuple[float, float, float],
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
