"""The loop as it is built: clock, delays, sensors, drives, motors and gears between a control law and the joints."""

from cutjoint.simulation.hardware.parts import hardware_of, parts_of, read_hardware
from cutjoint.simulation.hardware.values import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    Tachometer,
    TorqueSpeed,
)

__all__ = [
    "Backlash",
    "Clock",
    "Differences",
    "Drive",
    "Encoder",
    "Hardware",
    "Tachometer",
    "TorqueSpeed",
    "hardware_of",
    "parts_of",
    "read_hardware",
]
