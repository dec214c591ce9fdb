"""Parameters of the Cartesian Parallel Manipulator (Elkady, Elkobrosy, Hanna, Sobh 2008, tables 1 and 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

from cutjoint.errors import InputError
from cutjoint.reprs import line, told


class CpmCoefficients(NamedTuple):
    """The constants of the equation of motion: M = inertia I + rods Gamma' Gamma, Coriolis = coriolis Gamma' dGamma/dt.

    Attributes:
        inertia: mass that moves with the tool [kg]; 2 A in equation (39).
        rods: inertia that turns with the first rods [kg m2]; 2 B.
        coriolis: factor of the Coriolis term [kg m2]; 2 B.
        rod_weight: moment of weight of a first rod [N m]; C.
        weight: weight that moves with the tool [N]; E.
    """

    inertia: float
    rods: float
    coriolis: float
    rod_weight: float
    weight: float

    def __repr__(self) -> str:
        return told(self, inertia="kg", rods="kg m2", coriolis="kg m2", rod_weight="N m", weight="N")


@dataclass(frozen=True)
class CpmParameters:
    """Geometry and masses, in the symbols of the paper.

    Attributes:
        L: half the side of the platform [m] (table 1).
        L1: first link, slider to elbow [m] (table 1).
        L2: second link, elbow to platform [m] (table 1).
        D: distance of the third guide rod from the origin along y [m] (table 1).
        m1: first rod, uniform [kg] (table 2).
        m2: second rod, half of it at each end [kg] (table 2).
        m3: slider of a prismatic joint [kg] (table 2).
        m4: tool [kg] (table 2).
        g: gravity, along +z of the paper's frame [m/s2].  The paper prints no value; 9.81 reproduces its force figures.

    Raises:
        InputError: a length, mass or g is not finite or out of range.
    """

    L: float = 0.105
    L1: float = 0.5
    L2: float = 0.373
    D: float = 0.9144
    m1: float = 1.892994
    m2: float = 0.695528
    m3: float = 0.2
    m4: float = 0.3
    g: float = 9.81

    __repr__ = line(L="m", L1="m", L2="m", D="m", m1="kg", m2="kg", m3="kg", m4="kg", g="m/s2")

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            lengths = field.name in ("L1", "L2")
            if not math.isfinite(value) or (lengths and value <= 0) or (field.name.startswith("m") and value < 0):
                expected = "a positive length" if lengths else "a finite number, masses not negative"
                raise InputError(f"parameter {field.name} of the CPM must be {expected}, found {value!r}")

    @cached_property
    def A(self) -> float:
        """Half the mass that moves with the tool [kg] (after equation 20)."""
        return 0.5 * (self.m1 + 2.0 * self.m2 + self.m3 + self.m4)

    @cached_property
    def B(self) -> float:
        """Half the inertia of a first rod with half a second rod at its end [kg m2] (after equation 20)."""
        return (self.m1 / 6.0 + self.m2 / 4.0) * self.L1**2

    @cached_property
    def C(self) -> float:
        """Moment of weight of a first rod with half a second rod at its end [N m] (after equation 20)."""
        return 0.5 * (self.m1 + self.m2) * self.g * self.L1

    @cached_property
    def E(self) -> float:
        """Weight that moves with the tool [N] (after equation 20)."""
        return (self.m1 + 2.0 * self.m2 + self.m3 + self.m4) * self.g

    @cached_property
    def coefficients(self) -> CpmCoefficients:
        """The constants of equation (39)."""
        return CpmCoefficients(2.0 * self.A, 2.0 * self.B, 2.0 * self.B, self.C, self.E)

    @property
    def reach(self) -> tuple[float, float]:
        """Nearest and farthest distance of a limb's end from its slider [m]: folded and stretched."""
        return abs(self.L1 - self.L2), self.L1 + self.L2
