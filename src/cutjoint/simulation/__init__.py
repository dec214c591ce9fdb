"""Simulation: plants, integrators, the loop that runs them, and the result."""

from cutjoint.simulation.constrained import ConstrainedPlant
from cutjoint.simulation.integrators import Adaptive, DormandPrince, Integrator, Midpoint, RungeKutta4
from cutjoint.simulation.loop import run
from cutjoint.simulation.minimal import MinimalPlant
from cutjoint.simulation.plant import Observation, Plant, ReducedPlant, State
from cutjoint.simulation.reactions import ReactionHistory, reactions_of
from cutjoint.simulation.result import Result, Rmse
from cutjoint.simulation.result_file import load, save

__all__ = [
    "Adaptive",
    "ConstrainedPlant",
    "DormandPrince",
    "Integrator",
    "Midpoint",
    "MinimalPlant",
    "Observation",
    "Plant",
    "ReactionHistory",
    "ReducedPlant",
    "Result",
    "Rmse",
    "RungeKutta4",
    "State",
    "load",
    "reactions_of",
    "run",
    "save",
]
