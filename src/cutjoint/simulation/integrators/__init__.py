"""One-step methods for ordinary differential equations, all behind one small interface."""

from cutjoint.simulation.integrators.dormand_prince import DormandPrince
from cutjoint.simulation.integrators.method import Integrator, RungeKutta4, Step, StepError
from cutjoint.simulation.integrators.scipy_methods import Adaptive

__all__ = ["Adaptive", "DormandPrince", "Integrator", "RungeKutta4", "Step", "StepError"]
