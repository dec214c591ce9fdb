"""One-step methods for ordinary differential equations, all behind one small interface."""

from cutjoint.simulation.integrators.dormand_prince import DormandPrince
from cutjoint.simulation.integrators.fixed import FIXED_STEP, FixedStep, Midpoint, RungeKutta4, fixed_step, steps_within
from cutjoint.simulation.integrators.method import Integrator, Step, StepError
from cutjoint.simulation.integrators.scipy_methods import Adaptive

__all__ = [
    "FIXED_STEP",
    "Adaptive",
    "DormandPrince",
    "FixedStep",
    "Integrator",
    "Midpoint",
    "RungeKutta4",
    "Step",
    "StepError",
    "fixed_step",
    "steps_within",
]
