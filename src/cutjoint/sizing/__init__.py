"""Sizing: what motors, gears, brakes and bearings of a robot must give along trajectories."""

from cutjoint.sizing.anywhere import Anywhere, size_anywhere
from cutjoint.sizing.bearings import BearingLoad
from cutjoint.sizing.gearing import Gearing
from cutjoint.sizing.matching import MotorFit
from cutjoint.sizing.motor import ServoMotor
from cutjoint.sizing.motor_table import motors_from_file
from cutjoint.sizing.sizing import Sizing, size
from cutjoint.sizing.values import Course, Duty, Extreme, SizedCycle

__all__ = [
    "Anywhere",
    "BearingLoad",
    "Course",
    "Duty",
    "Extreme",
    "Gearing",
    "MotorFit",
    "ServoMotor",
    "SizedCycle",
    "Sizing",
    "motors_from_file",
    "size",
    "size_anywhere",
]
