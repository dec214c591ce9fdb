"""What Elkady et al. 2008 print for the CPM: the circle (section 5.3), the claims (5.3, 5.4) and table 3, as data."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from cutjoint.papers.publication import PrintedNumber

FORCE_LIMIT = 120.0
"""Largest actuator force [N] (section 5.3)."""

SETTLING_TIME = 0.3
"""Time after which the error bounds of sections 5.4.1 to 5.4.3 hold [s]."""


@dataclass(frozen=True)
class PrintedCircle:
    """The desired path of section 5.3: centre + radius (cos(omega t), sin(omega t), 0).

    Attributes:
        centre: [m].
        radius: [m].
        omega: angular velocity [rad/s].
        duration: one turn [s].
    """

    centre: tuple[float, float, float] = (0.425, 0.425, 0.3)
    radius: float = 0.175
    omega: float = 0.5 * pi
    duration: float = 4.0


CIRCLE = PrintedCircle()


@dataclass(frozen=True)
class Table3Row:
    """A row of table 3, with the error bound that its section asks for.

    Attributes:
        controller: name of the control law here.
        equation: of the control law in the paper.
        k_p: proportional gain [N/m]; for computed torque [1/s2].
        k_d: derivative gain [N s/m]; for computed torque [1/s].
        position_error: printed root of the mean square position error (49) [m].
        velocity_error: the same of the velocity [m/s].
        bound: position error that is not exceeded after `SETTLING_TIME` [m] (sections 5.4.1 to 5.4.3); None where the
            paper states none.
    """

    controller: str
    equation: str
    k_p: float
    k_d: float
    position_error: PrintedNumber
    velocity_error: PrintedNumber
    bound: float | None


TABLE_3 = (
    Table3Row("pd", "(40)", 12691.0, 436.0, PrintedNumber("0.0027"), PrintedNumber("0.0223"), 3e-3),
    Table3Row("pd_gravity", "(41)", 8507.0, 436.0, PrintedNumber("3.4804e-4"), PrintedNumber("0.021"), 3e-4),
    Table3Row("feedforward", "(42)", 7053.0, 436.0, PrintedNumber("3.0256e-4"), PrintedNumber("0.0182"), 1e-5),
    Table3Row("computed_torque", "(43)", 2550.25, 101.0, PrintedNumber("2.3469e-4"), PrintedNumber("0.0161"), None),
)
