"""What Adetu, Moore and Roberts misprint or leave open for the Omega-3.

Each row names what the project uses instead.  The tests show every row that can be computed (`tests/papers`).
"""

from __future__ import annotations

from cutjoint.papers.publication import Erratum

ERRATA = (
    Erratum(
        key="table_1_last_row",
        equation="table I, last row",
        printed="R = 35.25 mm",
        corrected="R_B = 35.25 mm, so R = R_A - R_B = 39.75 mm as the text defines R",
        shown="with joints at R_A on the base and R_B on the platform the rods have length L_B only for this R",
    ),
    Erratum(
        key="sign_in_17",
        equation="(17)",
        printed="u' du/dt - du/dt' u = 0",
        corrected="plus: the printed difference vanishes for any two vectors and (18) does not follow",
        shown="random vectors; the rods of the moving robot",
    ),
    Erratum(
        key="rate_in_19",
        equation="(19), (20)",
        printed="b_i times the vector of all three rates",
        corrected="b_i times the rate of arm i",
        shown="du_i/dt by finite differences",
    ),
    Erratum(
        key="gravity_in_33",
        equation="(33)",
        printed="weight with two components",
        corrected="m_E (0, 0, -g): gravity along -z, the base normal is x",
        shown="two components do not fit three; the weight along -z is minus the gradient of m_E g z",
    ),
    Erratum(
        key="component_of_36",
        equation="(34), (36)",
        printed="a scalar torque in (34), a vector in (36)",
        corrected="the y component of (36), along the motor axis",
        shown="gradient of the arm's potential energy; the vector has other components as well",
    ),
    Erratum(
        key="dots_in_42",
        equation="(39)-(42)",
        printed="dots and transposes lost, l for I, j for J: (42) reads M times the angles",
        corrected="angular acceleration, I and dJ/dt",
        shown="power balance along a motion",
    ),
    Erratum(
        key="scalar_in_42",
        equation="(42)",
        printed="scalar I added to a matrix",
        corrected="I times the 3 x 3 identity",
        shown="kinetic energy of arms and platform",
    ),
    Erratum(
        key="letter_in_25",
        equation="(25)",
        printed="L names a matrix, L_A and L_B are lengths",
        corrected="the matrix is the diagonal of (22), here `ub`",
        shown="by reading",
        computed=False,
    ),
    Erratum(
        key="units",
        equation="tables I and II, (43)",
        printed="mm and g in the tables, m in the path",
        corrected="SI everywhere",
        shown="with the tables' numbers as they stand no point of the path can be reached",
    ),
    Erratum(
        key="open_arm",
        equation="(35)-(38)",
        printed="no centre of mass and no inertia of the semi-circular arm",
        corrected="parameters `arm_com` and `arm_inertia`; default: uniform half-disc of radius L_A about its centre, "
        "d = 29.71 mm, I_o = 1.567e-4 kg m2, so I = 3.306e-4 kg m2",
        shown="other shapes move the torque along (43) by up to 8 % of its peak, an arm without mass by 14 %",
    ),
    Erratum(
        key="open_rest",
        equation="sections II and V",
        printed="no rod spacing, value of g, controller gains or initial state",
        corrected="parameters `rod_spacing` (40 mm) and `g` (9.81 m/s2); gains and start belong to a simulation",
        shown="by reading",
        computed=False,
    ),
)
