"""The CPM with its first revolute joints driven instead of its sliders: the rotary actuation of section 1.1.

Elkady et al. 2008 only report it, after Kim and Tsai 2002: two inverse solutions a limb, an eighth-degree polynomial,
many singular points.  All of it follows from the paper's own equations (1) to (9).  With e_i the second rod of limb i
from M_i to B_i, differentiating (3), (6), (9) gives

    E v = n * rates,   rows of E: e_i in space,   n_i = L1 L2 sin(theta_i2 - theta_i1) = -denominator (27) to (29)

so the tool's Jacobian is E^-1 diag(n), the inverse of Gamma (30), but also holds where Gamma has none:

    type 1   sin(theta_i2 - theta_i1) = 0: limb i is stretched or folded, its motor does not move the tool
    type 2   det E = L2^3 (cos theta_12 cos theta_22 cos theta_32 - sin theta_12 sin theta_22 sin theta_32) = 0:
             the tool moves across all three second rods with the motors held

and Lagrange's equations (31) to (38), with the motors' torques for Q_1 to Q_3 and no force for Q_4 to Q_6, give

    torque = 2B a_theta + C (-cos theta_11, sin theta_21, 0) + J' (2A a - (0, 0, E))

On floats, arrays or symbols alike.  The eighth-degree polynomial is in `cutjoint.papers.cpm.forward`.
"""

from __future__ import annotations

from typing import NamedTuple

from cutjoint.papers.cpm import equations, per_limb
from cutjoint.papers.cpm.equations import PlacedLimb, PlacedLimbs
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.scalars import (
    NUMBERS,
    Functions,
    Matrix3,
    Scalar,
    Vector3,
    Vector6,
    cross,
    dot,
    inertia_of,
    inverse,
    times,
    transposed,
)
from cutjoint.papers.three_limbs import ThreeLimbState
from cutjoint.reprs import line


def inverse_kinematics(p: CpmParameters, tool: Vector3, fn: Functions = NUMBERS) -> tuple[tuple[Scalar, Scalar], ...]:
    """Both motor angles of each limb for a tool position [rad]: the roots of (3), (6), (9), elbow sign +1 first.

    One choice a limb makes eight working modes.  Where a limb does not reach the tool the functions of `fn` decide
    (math raises ValueError, numpy gives NaN).
    """
    plus = equations.limb_angles(p, tool, (1, 1, 1), fn)
    minus = equations.limb_angles(p, tool, (-1, -1, -1), fn)
    return ((plus[0], minus[0]), (plus[1], minus[1]), (plus[2], minus[2]))


def limbs(p: CpmParameters, tool: Vector3, angles: Vector3, fn: Functions = NUMBERS) -> PlacedLimbs:
    """The three limbs at a tool position [m] with the motors' angles [rad]."""
    one, two, three = (
        _limb(p, u, w, fn.cos(angle), fn.sin(angle))
        for (u, w), angle in zip(equations.limb_ends(p, tool), angles, strict=True)
    )
    return (one, two, three)


def _limb(p: CpmParameters, u: Scalar, w: Scalar, c: Scalar, s: Scalar) -> PlacedLimb:
    return PlacedLimb(c, s, u, w, p.L1 * (u * s - w * c))


class SecondRods(NamedTuple):
    """The second rods at a posture.

    Attributes:
        e: rows e_1, e_2, e_3, from M_i to B_i in space [m].
        drive: n_1, n_2, n_3, what a motor's rate adds to e_i' v [m2].
        volume: det E [m3]; over L2^3 the sine-like measure of type 2.
    """

    e: Matrix3
    drive: Vector3
    volume: Scalar


def rods(p: CpmParameters, at: PlacedLimbs) -> SecondRods:
    """Second rods in space, from those in the limbs' planes (1) to (8), and the two sides of (27) to (29)."""
    (u1, w1), (u2, w2), (u3, w3) = per_limb.second_rods(p, at)
    e = ((0.0, u1, w1), (w2, 0.0, u2), (u3, -w3, 0.0))
    return SecondRods(e, (-at[0].denominator, -at[1].denominator, -at[2].denominator), dot(e[0], cross(e[1], e[2])))


def type_1(p: CpmParameters, r: SecondRods) -> Vector3:
    """sin(theta_i2 - theta_i1) of each limb: zero where the limb is stretched or folded, a singularity of type 1."""
    size = p.L1 * p.L2
    one, two, three = r.drive
    return (one / size, two / size, three / size)


def type_2(second_angles: Vector3, fn: Functions = NUMBERS) -> Scalar:
    """cos cos cos - sin sin sin of theta_12, theta_22, theta_32: zero at a singularity of type 2.

    This is the volume that the directions of the second rods span, det E / L2^3.
    """
    one, two, three = second_angles
    return fn.cos(one) * fn.cos(two) * fn.cos(three) - fn.sin(one) * fn.sin(two) * fn.sin(three)


def jacobian(r: SecondRods) -> Matrix3:
    """J = E^-1 diag(n): velocity of the tool over the rates of the motors [m]; the inverse of Gamma (30)."""
    (a, b, c), (n1, n2, n3) = inverse(r.e), r.drive
    return ((a[0] * n1, a[1] * n2, a[2] * n3), (b[0] * n1, b[1] * n2, b[2] * n3), (c[0] * n1, c[1] * n2, c[2] * n3))


def drift(p: CpmParameters, at: PlacedLimbs, r: SecondRods, velocity: Vector3, rates: Vector3) -> Vector3:
    """dJ/dt times the rates [m/s2]: (27) to (29) differentiated once more, the second rods kept at their length.

    Args:
        velocity: of the tool [m/s], J times `rates`.
        rates: of the motors [rad/s].
    """
    dx, dy, dz = velocity
    moves = ((dy, dz), (dz, dx), (dx, -dy))
    one, two, three = (
        -p.L1 * rate * rate * (a.u * a.cos + a.w * a.sin - p.L1)
        - (du + p.L1 * a.sin * rate) * (du + p.L1 * a.sin * rate)
        - (dw - p.L1 * a.cos * rate) * (dw - p.L1 * a.cos * rate)
        for a, (du, dw), rate in zip(at, moves, rates, strict=True)
    )
    return times(inverse(r.e), (one, two, three))


def mass(k: CpmCoefficients, j: Matrix3) -> Vector6:
    """Mass matrix 2A J'J + 2B 1 [kg m2] of the kinetic energy (18), as (xx, xy, xz, yy, yz, zz)."""
    return inertia_of(k.rods, k.inertia, j)


def coriolis(k: CpmCoefficients, j: Matrix3, drift_: Vector3) -> Vector3:
    """2A J' dJ/dt times the rates [N m]; `drift_` is dJ/dt times the rates."""
    x, y, z = times(transposed(j), drift_)
    return (k.inertia * x, k.inertia * y, k.inertia * z)


def gravity(k: CpmCoefficients, at: PlacedLimbs, j: Matrix3) -> Vector3:
    """Torques that hold the robot at rest [N m]: the terms with C and E of (31) to (33) and (38)."""
    x, y, z = per_limb.moments_of_weight(k, at)
    down = j[2]
    return (x - k.weight * down[0], y - k.weight * down[1], z - k.weight * down[2])


class CpmRotaryState(ThreeLimbState):
    """The motors at their angles [rad] with the tool at a position [m].

    Attributes:
        limbs: in their own planes.
        rods: the second rods in space.
        jacobian: of the tool [m].
    """

    __slots__ = ("_k", "_p", "_tool", "jacobian", "limbs", "rods")

    __repr__ = line("jacobian", jacobian="m")

    def __init__(self, p: CpmParameters, angles: Vector3, tool: Vector3, fn: Functions = NUMBERS) -> None:
        self._p, self._k, self._tool = p, p.coefficients, tool
        self.limbs = limbs(p, tool, angles, fn)
        self.rods = rods(p, self.limbs)
        self.jacobian = jacobian(self.rods)

    def _drift(self, v: Vector3) -> Vector3:
        return drift(self._p, self.limbs, self.rods, times(self.jacobian, v), v)

    def entries(self) -> Vector6:
        """Mass matrix [kg m2]."""
        return mass(self._k, self.jacobian)

    def coriolis(self, v: Vector3) -> Vector3:
        """Coriolis vector [N m] for the rates `v` of the motors [rad/s]."""
        return coriolis(self._k, self.jacobian, self._drift(v))

    def gravity(self) -> Vector3:
        """Torques that hold the robot [N m]."""
        return gravity(self._k, self.limbs, self.jacobian)

    def potential_energy(self) -> Scalar:
        """Equation (19) [J]."""
        return equations.potential_energy(self._k, self.limbs)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """Position, Jacobian and drift."""
        return self._tool, self.jacobian, (0.0, 0.0, 0.0) if v is None else self._drift(v)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the type-2 measure."""
        return (self._p.L2 * self._p.L2 * self._p.L2 / self.rods.volume,)
