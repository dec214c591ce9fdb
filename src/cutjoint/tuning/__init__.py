"""Tuning: gains of control laws by the CPM paper's rule, by poles and by optimisation, and margins of loops."""

from cutjoint.tuning.linear import LinearLaw, LinearPlant, at_rest, linear_law, linear_plant
from cutjoint.tuning.loop import LinearLoop, Timing, timing_of
from cutjoint.tuning.margins import ActuatorMargins, LoopMargins, margins_of
from cutjoint.tuning.poles import PolePlacement
from cutjoint.tuning.rule import PaperRule
from cutjoint.tuning.search import GainSearch
from cutjoint.tuning.steps import StepResponse
from cutjoint.tuning.tune import tune
from cutjoint.tuning.values import JudgedGains, Tuning

__all__ = [
    "ActuatorMargins",
    "GainSearch",
    "JudgedGains",
    "LinearLaw",
    "LinearLoop",
    "LinearPlant",
    "LoopMargins",
    "PaperRule",
    "PolePlacement",
    "StepResponse",
    "Timing",
    "Tuning",
    "at_rest",
    "linear_law",
    "linear_plant",
    "margins_of",
    "timing_of",
    "tune",
]
