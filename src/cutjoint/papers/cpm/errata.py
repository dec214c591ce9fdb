"""What Elkady et al. 2008 misprint, leave open or claim against their own equation (39).

Each row names what the project uses instead.  The tests show every row that can be computed (`tests/papers`).
"""

from __future__ import annotations

from cutjoint.papers.publication import Erratum

ERRATA = (
    Erratum(
        key="gravity_points_along_z",
        equation="(13), (15), (17), (19)",
        printed="potential energy falls as z grows, without a word about it",
        corrected="gravity acts along +z of the paper's frame: z points down; g = 9.81 m/s2",
        shown="K of (39) is the gradient of (19) as printed and of no potential with z up; the tool falls along +z",
    ),
    Erratum(
        key="line_before_39",
        equation="line before (39)",
        printed="the mass matrix multiplies the velocity, the Coriolis matrix the position",
        corrected="they multiply acceleration and velocity, as in (39)",
        shown="Lagrange's equations of (20) by finite differences",
    ),
    Erratum(
        key="coriolis_term",
        equation="(39)",
        printed="Coriolis matrix 2 B Gamma' dGamma/dt",
        corrected="right as printed; dM/dt - 2 G is skew with it",
        shown="dM/dt by finite differences; B Gamma' dGamma/dt fails",
    ),
    Erratum(
        key="decay_rate",
        equation="(47), (50)",
        printed="the error decays with K_P / 2 in (47), with K_D / 2 in (50)",
        corrected="K_D / 2",
        shown="put into (44) at critical damping (46)",
    ),
    Erratum(
        key="numbering",
        equation="(21)-(26)",
        printed="missing: the numbers jump from (20) to (27)",
        corrected="nothing is missing in the derivation",
        shown="by reading",
        computed=False,
    ),
    Erratum(
        key="gamma_elements",
        equation="(27)-(30)",
        printed="elements of Gamma",
        corrected="right as printed in all eight branches where their denominators do not vanish; |denominator| = "
        "L1 L2 |sin(elbow)| vanishes at limb reaches of 0.127 and 0.873 m",
        shown="rates of the closed limbs by finite differences",
    ),
    Erratum(
        key="initial_state",
        equation="table 3, limit of 120 N",
        printed="initial state not given",
        corrected="the robot starts at the first desired position, at rest",
        shown="then K_D = 436 is the largest integer that keeps 120 N for three controllers: 436 x 0.2749 m/s = "
        "119.9 N",
    ),
    Erratum(
        key="elbow_branch",
        equation="table 3",
        printed="elbow branch not given",
        corrected="limb signs (+, -, +)",
        shown="limb 1: the other sign needs more than 120 N; limbs 2 and 3 with the inferred code: the other sign of "
        "limb 2 breaks the PD error bound, that of limb 3 would have needed a much smaller K_P than 8507",
    ),
    Erratum(
        key="sudden_change",
        equation="section 5.3",
        printed="a careful path avoids sudden changes of the commanded force",
        corrected="the path starts with a velocity step of 0.2749 m/s",
        shown="speed of the circle at t = 0 against the start at rest",
    ),
    Erratum(
        key="computed_torque_force",
        equation="table 3, computed torque",
        printed="K_D = 101 stays under 120 N",
        corrected="it needs 132.7 N under (39); K_D = 91 is the largest integer that stays under 120 N",
        shown="force at t = 0",
    ),
    Erratum(
        key="inferred_code",
        equation="table 3",
        printed="figures said to come from (39)",
        corrected="computed torque's two errors do; a different model gives most others: inertia 2 A + B Gamma' Gamma, "
        "Coriolis 2 B Gamma' dGamma/dt, weight without m3 (after the fact: evidence, not proof)",
        shown="it gives all four K_D to the integer, (39) only three; it breaks the skew symmetry that (39) has",
    ),
    Erratum(
        key="limb_energies",
        equation="(12)-(17)",
        printed="energies of the three limbs, (16) called that of the second one",
        corrected="right as printed, (16) is the third limb's; the tool m4 is in none of them, it comes in with (18), "
        "(19)",
        shown="masses in space, limb by limb; Pinocchio's bodies of each limb",
    ),
    Erratum(
        key="constraint_functions",
        equation="(11), (31)-(38)",
        printed="three constraint equations f_i, never named, with derivative 1 in theta_i1 and -Gamma in x, y, z",
        corrected="f_i = theta_i1 less the root of (3), (6), (9) in x, y, z; then lambda_i is a moment about A_i",
        shown="differences of f_i; with (3), (6), (9) themselves for f_i the derivative is twice the denominator of "
        "Gamma, and (31) to (35) fail",
    ),
    Erratum(
        key="names_of_forces",
        equation="after (38)",
        printed="F_x, F_x and F_x",
        corrected="F_x, F_y and F_z",
        shown="by reading",
        computed=False,
    ),
    Erratum(
        key="rotary_polynomial",
        equation="section 1.1",
        printed="rotary actuation: two inverse solutions a limb, an eighth-degree polynomial; reported, not given",
        corrected="right: the polynomial starts with 16 x^8 (in L2) for every posture and size, and has no factor; "
        "none to eight real solutions, an even number, eight with the paper's own sizes",
        shown="the algebra of (3), (6), (9); roots led around loops in the complex numbers become one another",
    ),
    Erratum(
        key="rotary_singularities",
        equation="section 1.1",
        printed="rotary actuation: many singular points within the workspace; no condition",
        corrected="type 2 where the product of cos theta_i2 is that of sin theta_i2, type 1 where a limb is stretched "
        "or folded; type 2 parts the strokes' box in every working mode, 10 to 49 % of it lie on the smaller side, and "
        "the paper's circle crosses it in two of the eight",
        shown="the tool gives way with the motors held; singular values of the closed chain; sampling",
    ),
)
