"""What is between a motor and its actuator: a gear, a screw, a brake."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import positive
from cutjoint.doors import door
from cutjoint.errors import InputError, shown
from cutjoint.mechanism import Actuator
from cutjoint.reprs import line
from cutjoint.sizing.motor import ServoMotor


@door
@dataclass(frozen=True)
class Gearing:
    """What is between motor and actuator.

    Attributes:
        ratios: that may be chosen; empty for any.
        efficiency: of the gear, in (0, 1].
        inertia: of the gear at the motor's shaft, [kg m2] or [kg].
        pitch: of a screw [m] a turn that makes a motor that turns drive an actuator that slides; None without one.
        brake_factor: how many times the largest holding effort a brake must hold.
        ambient: temperature of the surroundings [degC].

    Raises:
        InputError: a ratio, pitch or factor that is not > 0, an efficiency that is none, or a negative inertia.
    """

    ratios: tuple[float, ...] = ()
    efficiency: float = 1.0
    inertia: float = 0.0
    pitch: float | None = None
    brake_factor: float = 1.5
    ambient: float = 40.0

    __repr__ = line(inertia="kg m2", pitch="m", ambient="degC")

    def __post_init__(self) -> None:
        for ratio in self.ratios:
            positive("a gear ratio", ratio)
        positive("the brake factor", self.brake_factor)
        if self.pitch is not None:
            positive("the pitch of the screw", self.pitch, "m")
        if not 0.0 < self.efficiency <= 1.0:
            raise InputError(f"the efficiency of a gear must be in (0, 1], found {self.efficiency:g}")
        if not 0.0 <= self.inertia < float("inf"):
            raise InputError(f"the inertia of a gear must be finite and at least 0 kg m2, found {self.inertia:g}")
        if not -273.15 <= self.ambient < 1000.0:
            raise InputError(f"the temperature of the surroundings must be in degC, found {self.ambient:g}")

    def base(self, actuator: Actuator, motor: ServoMotor) -> float | None:
        """How many times as fast as the actuator the motor moves without a gear, [1] or [rad/m]; None where they do not
        fit together."""
        if actuator.kind == motor.kind:
            return 1.0
        if motor.kind == "rotation" and self.pitch is not None:
            return 2.0 * np.pi / self.pitch
        return None

    def check(self, actuators: Sequence[Actuator], motors: Sequence[ServoMotor]) -> None:
        """That there is a motor for every actuator, if there are any, and every name once.

        Raises:
            InputError: there is none, or two motors have one name.
        """
        names = [one.name for one in motors]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise InputError(f"two motors are called '{shown(twice[0])}'; rename one of them")
        for actuator in actuators if motors else ():
            if not any(self.base(actuator, motor) is not None for motor in motors):
                moves, others = ("slides", "turns") if actuator.kind == "translation" else ("turns", "slides")
                mend = "; give the pitch of the screw between them" if others == "turns" else "; give motors that turn"
                raise InputError(
                    f"actuator '{shown(actuator.name)}' {moves}, and every motor of the table {others}{mend}"
                )
