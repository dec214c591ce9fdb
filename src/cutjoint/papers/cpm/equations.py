"""The equations of the Cartesian Parallel Manipulator (Elkady et al. 2008), on floats, arrays or symbols alike.

Each of the three limbs is a planar two-link limb behind a slider.  In its own plane its end is at (u, w), seen from the
slider, and the angle of the first link is measured from u towards w:

    limb 1   u = y - L   w = z           (1), (2)
    limb 2   u = z       w = x - L       (4), (5)
    limb 3   u = x       w = D - L - y   (7), (8)

so all three share one set of equations.  Nothing here looks at a value to decide (see `cutjoint.papers.scalars`).
"""

from __future__ import annotations

from typing import NamedTuple

from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.scalars import (
    NUMBERS,
    Functions,
    Matrix3,
    Scalar,
    Vector3,
    Vector6,
    dot,
    inertia_of,
    times,
    transposed,
    two_link_angle,
)
from cutjoint.papers.three_limbs import ThreeLimbState
from cutjoint.reprs import line


def limb_ends(p: CpmParameters, tool: Vector3) -> tuple[tuple[Scalar, Scalar], ...]:
    """End (u, w) of each limb in its own plane [m], from equations (1), (2), (4), (5), (7), (8)."""
    x, y, z = tool
    return ((y - p.L, z), (z, x - p.L), (x, p.D - p.L - y))


def limb_angles(p: CpmParameters, tool: Vector3, signs: Vector3, fn: Functions = NUMBERS) -> Vector3:
    """Angles theta_11, theta_21, theta_31 of the first links [rad]: the roots of (3), (6), (9) that `signs` picks."""
    (u1, w1), (u2, w2), (u3, w3) = limb_ends(p, tool)
    return (
        limb_angle(p, u1, w1, signs[0], fn),
        limb_angle(p, u2, w2, signs[1], fn),
        limb_angle(p, u3, w3, signs[2], fn),
    )


def limb_angle(p: CpmParameters, u: Scalar, w: Scalar, sign: Scalar, fn: Functions = NUMBERS) -> Scalar:
    """Root of (3), (6) or (9): atan2(w, u) + sign * acos(k / r), in the limb's own plane [rad]."""
    k = (u * u + w * w + p.L1 * p.L1 - p.L2 * p.L2) / (2.0 * p.L1)
    return two_link_angle(u, w, k, sign, fn)


class PlacedLimb(NamedTuple):
    """A limb in its own plane, without the elements of Gamma, which a stretched limb does not have.

    Attributes:
        cos, sin: of the angle of the first link.
        u, w: end of the limb [m].
        denominator: of Gamma, L1 (u sin - w cos) = - L1 L2 sin(elbow) [m2].
    """

    cos: Scalar
    sin: Scalar
    u: Scalar
    w: Scalar
    denominator: Scalar


class Limb(NamedTuple):
    """A limb in its own plane: d(theta)/dt = along_u du/dt + along_w dw/dt.

    Attributes:
        along_u, along_w: the two elements of Gamma [rad/m].
        cos, sin, u, w, denominator: as of a `PlacedLimb`.
    """

    along_u: Scalar
    along_w: Scalar
    cos: Scalar
    sin: Scalar
    u: Scalar
    w: Scalar
    denominator: Scalar


def limb(p: CpmParameters, u: Scalar, w: Scalar, angle: Scalar, fn: Functions = NUMBERS) -> Limb:
    """Equations (27), (28), (29) in the limb's own plane."""
    c, s = fn.cos(angle), fn.sin(angle)
    denominator = p.L1 * (u * s - w * c)
    return Limb((p.L1 * c - u) / denominator, (p.L1 * s - w) / denominator, c, s, u, w, denominator)


def limb_rates(p: CpmParameters, a: Limb, du: Scalar, dw: Scalar) -> tuple[Scalar, Scalar]:
    """Exact time derivative of the limb's two elements of Gamma [rad/(m s)]; its end moves at (du, dw) [m/s]."""
    rate = a.along_u * du + a.along_w * dw
    ddenominator = p.L1 * (du * a.sin - dw * a.cos + (a.u * a.cos + a.w * a.sin) * rate)
    return (
        (-p.L1 * a.sin * rate - du - a.along_u * ddenominator) / a.denominator,
        (p.L1 * a.cos * rate - dw - a.along_w * ddenominator) / a.denominator,
    )


Limbs = tuple[Limb, Limb, Limb]
AnyLimb = Limb | PlacedLimb
PlacedLimbs = tuple[AnyLimb, AnyLimb, AnyLimb]


def limbs(p: CpmParameters, tool: Vector3, angles: Vector3, fn: Functions = NUMBERS) -> Limbs:
    """The three limbs at a tool position [m] with the angles of the first links [rad]."""
    (u1, w1), (u2, w2), (u3, w3) = limb_ends(p, tool)
    return (limb(p, u1, w1, angles[0], fn), limb(p, u2, w2, angles[1], fn), limb(p, u3, w3, angles[2], fn))


def gamma(at: Limbs) -> Matrix3:
    """Gamma of equation (30): rates of the first links = Gamma times velocity of the tool [rad/m]."""
    one, two, three = at
    return (
        (0.0, one.along_u, one.along_w),
        (two.along_w, 0.0, two.along_u),
        (three.along_u, -three.along_w, 0.0),
    )


def gamma_dot(p: CpmParameters, at: Limbs, velocity: Vector3) -> Matrix3:
    """Exact dGamma/dt [rad/(m s)] for the tool velocity [m/s]."""
    dx, dy, dz = velocity
    one = limb_rates(p, at[0], dy, dz)
    two = limb_rates(p, at[1], dz, dx)
    three = limb_rates(p, at[2], dx, -dy)
    return ((0.0, one[0], one[1]), (two[1], 0.0, two[0]), (three[0], -three[1], 0.0))


def mass(k: CpmCoefficients, g: Matrix3) -> Vector6:
    """Mass matrix M of equation (39) [kg], as (xx, xy, xz, yy, yz, zz)."""
    return inertia_of(k.inertia, k.rods, g)


def coriolis_matrix(k: CpmCoefficients, g: Matrix3, dg: Matrix3) -> Matrix3:
    """Matrix G of equation (39) [kg/s], the one that makes dM/dt - 2 G skew."""
    gt, dgt = transposed(g), transposed(dg)
    a, b, c = (tuple(k.coriolis * dot(row, column) for column in dgt) for row in gt)
    return (a, b, c)


def coriolis(k: CpmCoefficients, g: Matrix3, dg: Matrix3, velocity: Vector3) -> Vector3:
    """G times velocity [N]."""
    x, y, z = times(transposed(g), times(dg, velocity))
    return (k.coriolis * x, k.coriolis * y, k.coriolis * z)


def gravity(k: CpmCoefficients, at: Limbs, g: Matrix3) -> Vector3:
    """Vector K of equation (39) [N]: the force that holds the robot at rest."""
    c1, s2 = k.rod_weight * at[0].cos, k.rod_weight * at[1].sin
    return (
        g[1][0] * s2 - g[0][0] * c1,
        g[1][1] * s2 - g[0][1] * c1,
        g[1][2] * s2 - g[0][2] * c1 - k.weight,
    )


def potential_energy(k: CpmCoefficients, at: PlacedLimbs) -> Scalar:
    """Potential energy of equation (19) [J]; z points down.  The z of the tool is the w of the first limb."""
    return -k.rod_weight * (at[0].sin + at[1].cos) - k.weight * at[0].w


class CpmState(ThreeLimbState):
    """Equation (39): tool and sliders at a position [m] (10), the first links at their angles [rad].

    Attributes:
        limbs: in their own planes.
        gamma: equation (30).
    """

    __slots__ = ("_k", "_p", "_tool", "gamma", "limbs")

    __repr__ = line("gamma")

    def __init__(
        self, p: CpmParameters, k: CpmCoefficients, tool: Vector3, angles: Vector3, fn: Functions = NUMBERS
    ) -> None:
        self._p, self._k, self._tool = p, k, tool
        self.limbs = limbs(p, tool, angles, fn)
        self.gamma = gamma(self.limbs)

    def entries(self) -> Vector6:
        """M of equation (39) [kg]."""
        return mass(self._k, self.gamma)

    def gamma_dot(self, v: Vector3) -> Matrix3:
        """Exact time derivative of Gamma for the tool velocity `v` [m/s]."""
        return gamma_dot(self._p, self.limbs, v)

    def coriolis(self, v: Vector3) -> Vector3:
        """G v of equation (39) [N]."""
        return coriolis(self._k, self.gamma, gamma_dot(self._p, self.limbs, v), v)

    def gravity(self) -> Vector3:
        """K of equation (39) [N]."""
        return gravity(self._k, self.limbs, self.gamma)

    def potential_energy(self) -> Scalar:
        """Equation (19) [J]."""
        return potential_energy(self._k, self.limbs)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """The tool follows the sliders: the Jacobian is the identity, the drift zero (10)."""
        return self._tool, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the sine of each elbow."""
        size = self._p.L1 * self._p.L2
        return tuple(size / limb.denominator for limb in self.limbs)
