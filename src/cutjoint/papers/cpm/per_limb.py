"""What Elkady et al. 2008 say of a single limb: both its angles, its energies, and the multiplier of its constraint.

Equations (1) to (8), (12) to (17) and (31) to (38), on floats, arrays or symbols alike.  The constraint of limb i is
theta_i1 - theta_i1(x, y, z) = 0, whose derivatives are 1 and -Gamma (27) to (30).  So lambda_i is the moment about the
pivot A_i that the second rod exerts on the first one, and -Gamma' lambda the force that the second rods exert on what
moves with the tool.  With the masses lumped at its ends the second rod carries a force along itself only.
"""

from __future__ import annotations

from cutjoint.papers.cpm.equations import AnyLimb, Limbs, PlacedLimbs
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.scalars import NUMBERS, Functions, Matrix3, Scalar, Vector3, times, transposed


def second_rods(p: CpmParameters, at: PlacedLimbs) -> tuple[tuple[Scalar, Scalar], ...]:
    """Second rod of each limb in its own plane, from M_i to B_i [m]: (1) to (8) less the first rod."""
    one, two, three = at
    return (_second_rod(p, one), _second_rod(p, two), _second_rod(p, three))


def _second_rod(p: CpmParameters, a: AnyLimb) -> tuple[Scalar, Scalar]:
    return (a.u - p.L1 * a.cos, a.w - p.L1 * a.sin)


def second_angles(p: CpmParameters, at: PlacedLimbs, fn: Functions = NUMBERS) -> Vector3:
    """Angles theta_12, theta_22, theta_32 of the second rods [rad], measured like those of the first (1) to (8)."""
    (u1, w1), (u2, w2), (u3, w3) = second_rods(p, at)
    return (fn.atan2(w1, u1), fn.atan2(w2, u2), fn.atan2(w3, u3))


def second_rates(p: CpmParameters, at: PlacedLimbs, rates: Vector3, velocity: Vector3) -> Vector3:
    """Rates of theta_12, theta_22, theta_32 [rad/s]: the derivatives of (1) to (8), solved across the second rod.

    Args:
        rates: of theta_11, theta_21, theta_31 [rad/s], equation (30).
        velocity: of the tool [m/s].
    """
    dx, dy, dz = velocity
    moves = ((dy, dz), (dz, dx), (dx, -dy))
    one, two, three = (
        (u * (dw - p.L1 * a.cos * rate) - w * (du + p.L1 * a.sin * rate)) / (p.L2 * p.L2)
        for a, (u, w), (du, dw), rate in zip(at, second_rods(p, at), moves, rates, strict=True)
    )
    return (one, two, three)


def kinetic_energies(p: CpmParameters, velocity: Vector3, rates: Vector3) -> Vector3:
    """Kinetic energies T_1, T_2, T_3 of the limbs [J], equations (12), (14), (16); without the tool m4.

    Args:
        velocity: of the tool [m/s].
        rates: of theta_11, theta_21, theta_31 [rad/s].
    """
    x, y, z = (v * v for v in velocity)
    along, end = 0.5 * (p.m1 + p.m2 + p.m3), 0.25 * p.m2
    turn1, turn2, turn3 = (p.B * rate * rate for rate in rates)
    return (
        along * x + end * (y + z) + turn1,
        along * y + end * (z + x) + turn2,
        along * z + end * (x + y) + turn3,
    )


def potential_energies(p: CpmParameters, at: PlacedLimbs) -> Vector3:
    """Potential energies V_1, V_2, V_3 of the limbs [J], equations (13), (15), (17); z points down, without m4."""
    z = at[0].w
    end = 0.5 * p.m2 * p.g * z
    return (-p.C * at[0].sin - end, -p.C * at[1].cos - end, -(p.m1 + p.m2 + p.m3) * p.g * z)


def moments_of_weight(k: CpmCoefficients, at: PlacedLimbs) -> Vector3:
    """What the first rods' weight asks for about their pivots [N m]: the terms with C in (31), (32), (33)."""
    return (-k.rod_weight * at[0].cos, k.rod_weight * at[1].sin, 0.0)


def multipliers(
    k: CpmCoefficients, at: Limbs, g: Matrix3, dg: Matrix3, velocity: Vector3, acceleration: Vector3
) -> Vector3:
    """Multipliers lambda_1, lambda_2, lambda_3 of equation (35) [N m], that is of (31), (32), (33).

    Args:
        g, dg: Gamma and dGamma/dt.
        velocity, acceleration: of the tool [m/s], [m/s2].
    """
    one, two, three = (
        k.rods * push + k.coriolis * drift + weight
        for push, drift, weight in zip(
            times(g, acceleration), times(dg, velocity), moments_of_weight(k, at), strict=True
        )
    )
    return (one, two, three)


def constraint_force(g: Matrix3, multiplier: Vector3) -> Vector3:
    """-Gamma' lambda [N]: what the second rods do to all that moves with the tool, the last terms of (36) to (38)."""
    x, y, z = times(transposed(g), multiplier)
    return (-x, -y, -z)


def rod_tensions(p: CpmParameters, at: PlacedLimbs, multiplier: Vector3) -> Vector3:
    """Force along each second rod [N], positive where it pulls: lambda_i over its lever arm.

    The lever arm about the pivot is L1 sin(theta_i2 - theta_i1), which is -denominator / L2 with the denominator of
    Gamma (27) to (29); it vanishes where a limb is stretched or folded.
    """
    one, two, three = (-p.L2 * moment / a.denominator for moment, a in zip(multiplier, at, strict=True))
    return (one, two, three)
