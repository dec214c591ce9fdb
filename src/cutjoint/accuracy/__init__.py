"""Accuracy: how far off the tool is for tolerances of lengths, backlash and warmth, and what causes how much of it."""

from cutjoint.accuracy.budget import Accuracy, Cause, accuracy
from cutjoint.accuracy.deviations import Deviation, ErrorSource
from cutjoint.accuracy.growth import MATERIALS, Growth, growth
from cutjoint.accuracy.play import ToolPlay, backlash
from cutjoint.accuracy.sensitivity import Sensitivity, sensitivity

__all__ = [
    "MATERIALS",
    "Accuracy",
    "Cause",
    "Deviation",
    "ErrorSource",
    "Growth",
    "Sensitivity",
    "ToolPlay",
    "accuracy",
    "backlash",
    "growth",
    "sensitivity",
]
