"""The equations of the Omega-3 (Adetu, Moore, Roberts), on floats, arrays or symbols alike.

Limb i stands in a plane that holds the base normal x and is turned about it by phi_i = 2 pi (i - 1) / 3 (9).  All three
chains are moved inwards by R_B, so that their rods meet in the tool point (3): the elbow of limb i is at
rotation_i [L_A sin theta_i, 0, R + L_A cos theta_i], and the rod u_i = tool - elbow_i has length L_B (13) to (16).
Nothing here looks at a value to decide (see `cutjoint.papers.scalars`).
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from cutjoint.papers.omega3.parameters import Omega3Coefficients, Omega3Parameters
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
    two_link_angle,
)
from cutjoint.papers.three_limbs import ThreeLimbState
from cutjoint.reprs import line

COS_PHI = (1.0, -0.5, -0.5)
"""cos(phi_i) of equation (9)."""
SIN_PHI = (0.0, 0.5 * sqrt(3.0), -0.5 * sqrt(3.0))
"""sin(phi_i) of equation (9)."""


def in_limb_frame(p: Omega3Parameters, tool: Vector3, i: int) -> Vector3:
    """Tool position seen from the motor axis of limb i (0, 1, 2), in the limb's frame [m]: equation (8) turned back."""
    x, y, z = tool
    return (x, COS_PHI[i] * y + SIN_PHI[i] * z, COS_PHI[i] * z - SIN_PHI[i] * y - p.R)


def arm_angle(p: Omega3Parameters, tool: Vector3, i: int, sign: Scalar, fn: Functions = NUMBERS) -> Scalar:
    """Angle theta of arm i [rad]: the root of (4) that `sign` picks, atan2(a_x, a_z) + sign * acos(k / r)."""
    ax, ay, az = in_limb_frame(p, tool, i)
    k = (ax * ax + ay * ay + az * az + p.L_A * p.L_A - p.L_B * p.L_B) / (2.0 * p.L_A)
    return two_link_angle(az, ax, k, sign, fn)


def arm_angles(p: Omega3Parameters, tool: Vector3, signs: Vector3, fn: Functions = NUMBERS) -> Vector3:
    """Angles of the three arms [rad] that hold the tool at a position [m]: inverse kinematics."""
    return (
        arm_angle(p, tool, 0, signs[0], fn),
        arm_angle(p, tool, 1, signs[1], fn),
        arm_angle(p, tool, 2, signs[2], fn),
    )


class Arm(NamedTuple):
    """An arm in the reference frame.

    Attributes:
        out: from motor axis to elbow [m], equation (7).
        b: minus the velocity of the elbow per rate of the arm [m], equation (21); db/dt = out * dtheta/dt.
        elbow: position of the elbow, moved inwards by R_B [m].
        sin: of the arm's angle.
    """

    out: Vector3
    b: Vector3
    elbow: Vector3
    sin: Scalar


def arm(p: Omega3Parameters, i: int, angle: Scalar, fn: Functions = NUMBERS) -> Arm:
    """Arm i at its angle [rad]."""
    s, c = fn.sin(angle), fn.cos(angle)
    along, up = p.L_A * c, p.L_A * s
    cp, sp = COS_PHI[i], SIN_PHI[i]
    radius = p.R + along
    return Arm((up, -sp * along, cp * along), (-along, -sp * up, cp * up), (up, -sp * radius, cp * radius), s)


Arms = tuple[Arm, Arm, Arm]


def arms(p: Omega3Parameters, angles: Vector3, fn: Functions = NUMBERS) -> Arms:
    """The three arms at their angles [rad]."""
    return (arm(p, 0, angles[0], fn), arm(p, 1, angles[1], fn), arm(p, 2, angles[2], fn))


class Spheres(NamedTuple):
    """Where the three spheres of radius L_B about the elbows meet: foot +- sqrt(square) * normal / |normal|.

    Attributes:
        foot: centre of the circle through the elbows [m].
        normal: of the elbows' plane; its length is twice the area of their triangle [m2].
        area2: square of that length [m4].
        square: square of the tool's height above the plane [m2]; negative where the spheres do not meet.
    """

    foot: Vector3
    normal: Vector3
    area2: Scalar
    square: Scalar


def spheres(p: Omega3Parameters, at: Arms) -> Spheres:
    """Forward kinematics, first half."""
    x, y, z = at[0].elbow
    (x2, y2, z2), (x3, y3, z3) = at[1].elbow, at[2].elbow
    a, b = (x2 - x, y2 - y, z2 - z), (x3 - x, y3 - y, z3 - z)
    normal = cross(a, b)
    area2 = dot(normal, normal)
    na, bn = cross(normal, a), cross(b, normal)
    fa, fb = dot(b, b) / (2.0 * area2), dot(a, a) / (2.0 * area2)
    rx, ry, rz = fa * na[0] + fb * bn[0], fa * na[1] + fb * bn[1], fa * na[2] + fb * bn[2]
    return Spheres((x + rx, y + ry, z + rz), normal, area2, p.L_B * p.L_B - (rx * rx + ry * ry + rz * rz))


def tool_position(s: Spheres, assembly: Scalar, fn: Functions = NUMBERS) -> Vector3:
    """Forward kinematics, second half: the tool [m] on the side `assembly` (+1, -1) of the elbows' plane."""
    height = assembly * fn.sqrt(s.square / s.area2)
    (x, y, z), (nx, ny, nz) = s.foot, s.normal
    return (x + height * nx, y + height * ny, z + height * nz)


class Rods(NamedTuple):
    """The rods at a posture.

    Attributes:
        u: the three rods, elbow to tool [m], equation (16); rows of the matrix in (22).
        ub: the three products u_i' b_i [m2], the diagonal in (22).
        volume: u_1' (u_2 x u_3) [m3]; its sign is the side of the elbows' plane that the tool is on.
    """

    u: Matrix3
    ub: Vector3
    volume: Scalar


def rods(at: Arms, tool: Vector3) -> Rods:
    """The rods for the arms and the tool position [m]."""
    x, y, z = tool
    one, two, three = ((x - ex, y - ey, z - ez) for ex, ey, ez in (at[0].elbow, at[1].elbow, at[2].elbow))
    ub = (dot(one, at[0].b), dot(two, at[1].b), dot(three, at[2].b))
    return Rods((one, two, three), ub, dot(one, cross(two, three)))


def jacobian(at: Rods, u_inverse: Matrix3) -> Matrix3:
    """J of equation (23) [m]: tool velocity = J times rates of the arms."""
    one, two, three = at.ub
    a, b, c = ((-row[0] * one, -row[1] * two, -row[2] * three) for row in u_inverse)
    return (a, b, c)


def rod_rates(at: Arms, j: Matrix3, rates: Vector3) -> Matrix3:
    """Time derivatives of the rods [m/s], equation (19) with the limb's own rate."""
    vx, vy, vz = times(j, rates)
    one, two, three = (
        (vx + a.b[0] * rate, vy + a.b[1] * rate, vz + a.b[2] * rate) for a, rate in zip(at, rates, strict=True)
    )
    return (one, two, three)


def jacobian_dot(at: Arms, r: Rods, u_inverse: Matrix3, j: Matrix3, rates: Vector3) -> Matrix3:
    """Exact dJ/dt of equation (27) [m/s] for the rates of the arms [rad/s]."""
    du = rod_rates(at, j, rates)
    k = [dot(r.u[i], at[i].out) * rates[i] + dot(du[i], at[i].b) for i in range(3)]
    columns = list(zip(*j, strict=True))
    inner = [[dot(du[i], columns[m]) + (k[i] if i == m else 0.0) for m in range(3)] for i in range(3)]
    a, b, c = (
        tuple(-(row[0] * inner[0][m] + row[1] * inner[1][m] + row[2] * inner[2][m]) for m in range(3))
        for row in u_inverse
    )
    return (a, b, c)


def drift(at: Arms, r: Rods, u_inverse: Matrix3, j: Matrix3, rates: Vector3) -> Vector3:
    """dJ/dt times the rates [m/s2]: equation (25) with the accelerations of the arms at zero."""
    velocity = times(j, rates)
    one, two, three = (
        dot(du, velocity) + (dot(u, a.out) * rate + dot(du, a.b)) * rate
        for a, u, du, rate in zip(at, r.u, rod_rates(at, j, rates), rates, strict=True)
    )
    x, y, z = times(u_inverse, (one, two, three))
    return (-x, -y, -z)


def mass(k: Omega3Coefficients, j: Matrix3) -> Vector6:
    """Mass matrix I 1 + m_E J' J of equation (42) [kg m2], as (xx, xy, xz, yy, yz, zz)."""
    return inertia_of(k.inertia, k.mass, j)


def coriolis(k: Omega3Coefficients, j: Matrix3, dj_rates: Vector3) -> Vector3:
    """V = m_E J' (dJ/dt rates) of equation (42) [N m]."""
    x, y, z = (k.mass * part for part in dj_rates)
    (a, b, c), (d, e, f), (g, h, i) = j
    return (a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z)


def gravity(k: Omega3Coefficients, at: Arms, j: Matrix3) -> Vector3:
    """G of equation (42) [N m]: the platform's weight through J' and the arms' own, y component of equation (36)."""
    jz = j[2]
    return (
        k.weight * jz[0] - k.arm_weight * COS_PHI[0] * at[0].sin,
        k.weight * jz[1] - k.arm_weight * COS_PHI[1] * at[1].sin,
        k.weight * jz[2] - k.arm_weight * COS_PHI[2] * at[2].sin,
    )


def potential_energy(p: Omega3Parameters, k: Omega3Coefficients, at: Arms, tool: Vector3) -> Scalar:
    """Potential energy of gravity [J]: heights along z of platform and arms.  What R_A and R_B add cancels."""
    return k.weight * tool[2] + k.arm_weight / p.L_A * (at[0].out[2] + at[1].out[2] + at[2].out[2])


class Omega3State(ThreeLimbState):
    """The arms with the tool at a position [m].

    Attributes:
        rods: from the elbows to the tool.
        jacobian: J of equation (23) [m].
    """

    __slots__ = ("_arms", "_inverse", "_k", "_p", "_tool", "jacobian", "rods")

    __repr__ = line("jacobian", jacobian="m")

    def __init__(self, p: Omega3Parameters, arms: Arms, tool: Vector3) -> None:
        self._p, self._k, self._arms, self._tool = p, p.coefficients, arms, tool
        self.rods = rods(arms, tool)
        self._inverse = inverse(self.rods.u)
        self.jacobian = jacobian(self.rods, self._inverse)

    def jacobian_dot(self, v: Vector3) -> Matrix3:
        """Exact dJ/dt of equation (27) [m/s] for the rates `v` of the arms [rad/s]."""
        return jacobian_dot(self._arms, self.rods, self._inverse, self.jacobian, v)

    def _drift(self, v: Vector3) -> Vector3:
        return drift(self._arms, self.rods, self._inverse, self.jacobian, v)

    def entries(self) -> Vector6:
        """M of equation (42) [kg m2]."""
        return mass(self._k, self.jacobian)

    def coriolis(self, v: Vector3) -> Vector3:
        """V of equation (42) [N m]."""
        return coriolis(self._k, self.jacobian, self._drift(v))

    def gravity(self) -> Vector3:
        """G of equation (42) [N m]."""
        return gravity(self._k, self._arms, self.jacobian)

    def potential_energy(self) -> Scalar:
        """Potential energy of gravity [J]."""
        return potential_energy(self._p, self._k, self._arms, self._tool)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """Position, J of equation (23) and dJ/dt v of equation (25)."""
        return self._tool, self.jacobian, (0.0, 0.0, 0.0) if v is None else self._drift(v)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the volume that the directions of the rods span."""
        length = self._p.L_B
        return (length * length * length / self.rods.volume,)
