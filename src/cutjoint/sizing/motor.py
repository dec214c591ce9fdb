"""A motor as its catalogue tells it, and what it can give at a speed and stand in the long run.

The largest effort is `peak` up to the knee, and falls from there along a straight line to `rated` at the largest speed.
The effort that it stands for ever is `rated` up to the rated speed; beyond, its power stays.  A winding at the current
I = effort / constant warms up to

    T = T_a + R_th R (1 + alpha (T - 25 degC)) I^2,    alpha = 0.00393 / K (copper; IEC 60028 at 20 degC)

of which T is the solution; there is none where the winding heats faster than it cools.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cutjoint.arrays import Array, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import line

COPPER, COLD = 0.00393, 25.0
"""[1/K] and [degC]: how the resistance of a winding grows, and at which temperature catalogues tell it."""


@door
@dataclass(frozen=True)
class ServoMotor:
    """A motor: [N m], [rad/s] and [kg m2] of one that turns, [N], [m/s] and [kg] of one that slides.

    Attributes:
        name: of the catalogue.
        kind: whether it turns or slides.
        rated: effort that it stands for ever.
        peak: the largest effort.
        max_speed: the largest speed.
        rotor: inertia of what moves in it; 0 for one that weighs nothing.
        rated_speed: up to which it stands the rated effort; None for the largest.
        knee_speed: up to which it gives the peak effort; None for the largest.
        brake: effort that its brake holds; None without one.
        resistance: of the winding at 25 degC [Ohm].
        constant: effort of an ampere, [N m/A] or [N/A].
        thermal_resistance: from the winding to the surroundings [K/W].
        max_temperature: of the winding [degC].

    Raises:
        InputError: a number that is not > 0, a peak below the rated effort, or a speed beyond the largest.
    """

    name: str
    kind: Literal["rotation", "translation"]
    rated: float
    peak: float
    max_speed: float
    rotor: float
    rated_speed: float | None = None
    knee_speed: float | None = None
    brake: float | None = None
    resistance: float | None = None
    constant: float | None = None
    thermal_resistance: float | None = None
    max_temperature: float | None = None

    __repr__ = line(
        "name", "kind", "rated", "peak", "max_speed", "rotor",
        rated="N or N m", peak="N or N m", max_speed="m/s or rad/s", rotor="kg or kg m2",
    )  # fmt: skip

    def __post_init__(self) -> None:
        for name in ("rated", "peak", "max_speed", "rotor", *_OPTIONAL):
            value = self.__dict__[name]
            if value is None or (name == "rotor" and value == 0.0):
                continue
            positive(f"{name} of motor '{self.name}'", value)
        if self.peak < self.rated:
            raise InputError(f"motor '{self.name}' has a peak effort of {self.peak:g}, below its rated {self.rated:g}")
        for name in ("rated_speed", "knee_speed"):
            value = self.__dict__[name]
            if value is not None and value > self.max_speed * (1.0 + 1e-9):
                raise InputError(
                    f"motor '{self.name}' has a {name} of {value:g}, beyond its largest speed {self.max_speed:g}"
                )

    @property
    def rated_power(self) -> float:
        """What it gives for ever at its rated speed [W]."""
        return self.rated * (self.max_speed if self.rated_speed is None else self.rated_speed)

    def largest(self, speed: Array) -> Array:
        """The largest effort at speeds, whatever their signs."""
        knee = self.max_speed if self.knee_speed is None else min(self.knee_speed, self.max_speed)
        if knee >= self.max_speed:
            return np.full(np.shape(speed), self.peak)
        part = np.clip((np.abs(speed) - knee) / (self.max_speed - knee), 0.0, 1.0)
        return np.asarray(self.peak + part * (self.rated - self.peak))

    def lasting(self, speed: Array) -> Array:
        """The effort that it stands for ever at speeds."""
        rated = self.max_speed if self.rated_speed is None else self.rated_speed
        return np.asarray(self.rated * rated / np.maximum(np.abs(speed), rated))

    def temperature(self, effort: float, ambient: float) -> float | None:
        """Of the winding in the long run, at a root mean square of the effort [degC]; infinite where it heats faster
        than it cools, None where the catalogue does not tell enough."""
        if self.resistance is None or self.constant is None or self.thermal_resistance is None:
            return None
        warms = self.thermal_resistance * self.resistance * (effort / self.constant) ** 2
        left = 1.0 - COPPER * warms
        return (ambient + warms * (1.0 - COPPER * COLD)) / left if left > 0.0 else float("inf")


_OPTIONAL = (
    *("rated_speed", "knee_speed", "brake", "resistance", "constant", "thermal_resistance", "max_temperature"),
)
