"""Parameters of the Omega-3 (Adetu, Moore, Roberts, tables I and II) and those that the paper leaves open."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

from cutjoint.errors import InputError
from cutjoint.reprs import line, told

_LENGTHS = ("L_A", "L_B", "rod_spacing")


class Omega3Coefficients(NamedTuple):
    """The constants of the equation of motion (42).

    Attributes:
        mass: that moves with the platform, m_E [kg].
        inertia: of an arm about its motor axis, I [kg m2].
        weight: that moves with the platform [N].
        arm_weight: moment of weight of an arm about its motor axis [N m].
    """

    mass: float
    inertia: float
    weight: float
    arm_weight: float

    def __repr__(self) -> str:
        return told(self, mass="kg", inertia="kg m2", weight="N", arm_weight="N m")


@dataclass(frozen=True)
class Omega3Parameters:
    """Geometry and masses in SI units, in the symbols of the paper.

    The last four are open in the paper: it gives no value for them.  The defaults are assumptions of this project
    (docs/models.md).  Other shapes of the arm move the torque along the paper's path by up to 8 % of its peak, an arm
    without mass by 14 %.  The arm's two do not follow when L_A or m_SC is changed.

    Attributes:
        L_A: arm, motor axis to elbow axis [m] (table I).
        L_B: rods [m] (table I).
        R_A: circle of the motor axes on the base [m] (table I).
        R_B: circle of the rod ends on the platform [m] (table I, last row, printed as R).
        m_payload: payload [kg] (table II).
        m_P: travelling plate [kg] (table II).
        m_R: pair of rods, half of it at each end [kg] (table II).
        m_SC: semi-circular arm [kg] (table II).
        arm_com: centre of mass of the semi-circular arm, from its motor axis towards the elbow [m]; d of (37).  Open in
            the paper; default: uniform half-disc of radius L_A about its centre, 4 L_A / (3 pi).
        arm_inertia: inertia of the semi-circular arm about its centre of mass [kg m2]; I_o of (37).  Open in the paper;
            default: the same half-disc, m_SC (L_A^2 / 2 - d^2).
        rod_spacing: distance between the two rods of a pair [m].  Open in the paper; the reduced model does not need
            it, a tree that shows the rods does.
        g: gravity, along -z of the paper's frame [m/s2].  Open in the paper.

    Raises:
        InputError: a parameter is not finite or out of range.
    """

    L_A: float = 0.070
    L_B: float = 0.146
    R_A: float = 0.075
    R_B: float = 0.03525
    m_payload: float = 0.070
    m_P: float = 0.110
    m_R: float = 0.03493
    m_SC: float = 0.100
    arm_com: float = 4.0 * 0.070 / (3.0 * math.pi)
    arm_inertia: float = 0.100 * (0.070**2 / 2.0 - (4.0 * 0.070 / (3.0 * math.pi)) ** 2)
    rod_spacing: float = 0.040
    g: float = 9.81

    __repr__ = line(
        L_A="m",
        L_B="m",
        R_A="m",
        R_B="m",
        m_payload="kg",
        m_P="kg",
        m_R="kg",
        m_SC="kg",
        arm_com="m",
        arm_inertia="kg m2",
        rod_spacing="m",
        g="m/s2",
    )

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = field.name in _LENGTHS
            not_negative = field.name.startswith("m_") or field.name == "arm_inertia"
            if not math.isfinite(value) or (positive and value <= 0) or (not_negative and value < 0):
                expected = "a positive length" if positive else "finite, masses and inertia not negative"
                raise InputError(f"parameter {field.name} of the Omega-3 must be {expected}, found {value!r}")

    @cached_property
    def R(self) -> float:
        """Radius R_A - R_B that is left when each chain is moved to the tool point [m] (after equation 2)."""
        return self.R_A - self.R_B

    @cached_property
    def m_E(self) -> float:
        """Mass that moves with the platform [kg], equation (32)."""
        return self.m_payload + self.m_P + 3.0 * (0.5 * self.m_R)

    @cached_property
    def I_arm(self) -> float:
        """Inertia of an arm with half a pair of rods at its elbow [kg m2], equations (37) and (38)."""
        return self.arm_inertia + self.m_SC * self.arm_com**2 + 0.5 * self.m_R * self.L_A**2

    @cached_property
    def arm_moment(self) -> float:
        """Mass moment of an arm with half a pair of rods at its elbow [kg m]: mass times R_CM of equation (35)."""
        return self.m_SC * self.arm_com + 0.5 * self.m_R * self.L_A

    @cached_property
    def coefficients(self) -> Omega3Coefficients:
        """The constants of equation (42)."""
        return Omega3Coefficients(self.m_E, self.I_arm, self.m_E * self.g, self.arm_moment * self.g)
