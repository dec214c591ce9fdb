"""What Adetu, Moore and Roberts print for the Omega-3: the path (43) and the claim of section V, as data."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

ERROR_BOUND = 3e-3
"""Tool position error that is not exceeded after `SETTLING_TIME` [m] (section V)."""

SETTLING_TIME = 0.3
"""Time after which the error is claimed to be below `ERROR_BOUND` [s] (section V, "about")."""


@dataclass(frozen=True)
class PrintedCurve:
    """The desired path (43), a figure of eight in the y-z plane: (x, y cos(omega t), z sin(2 omega t)).

    Attributes:
        x: distance from the base [m].
        y: amplitude along y [m].
        z: amplitude along z [m].
        omega: angular velocity along y [rad/s]; twice that along z.
        duration: one turn [s].
    """

    x: float = 0.1
    y: float = 0.06
    z: float = 0.06
    omega: float = pi
    duration: float = 2.0


CURVE = PrintedCurve()
