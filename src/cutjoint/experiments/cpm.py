"""The experiments of Elkady et al. 2008: four controllers on the circle, by four models, and the rule for K_P."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.control import Law, law
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Reference
from cutjoint.papers.cpm import CpmModel, InferredCpmModel
from cutjoint.papers.cpm.published import SETTLING_TIME, TABLE_3, Table3Row
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation import (
    ConstrainedPlant,
    DormandPrince,
    Integrator,
    Plant,
    ReducedPlant,
    Result,
    RungeKutta4,
    run,
)
from cutjoint.tuning.known import GAINS
from cutjoint.tuning.smallest import SmallestGain, smallest_gain

ROBOT = "cpm"
ROWS: dict[str, Table3Row] = {row.controller.replace("_", "-"): row for row in TABLE_3}
COLUMNS = {
    "inferred": "inferred code, solver's steps",
    "steps": "equation (39), solver's steps",
    "equation": "equation (39), uniform 1 ms",
    "lumped": "Pinocchio, lumped rods, uniform 1 ms",
    "distributed": "Pinocchio, distributed rods, uniform 1 ms",
}
SOLVER_STEPS = ("inferred", "steps")
STEP = 1e-3


@lru_cache(maxsize=2)
def _believed(inferred: bool) -> Mechanism:
    return InferredCpmModel() if inferred else CpmModel()


def model(column: str) -> Mechanism:
    """What the controller of a column believes: the inferred code or equation (39)."""
    return _believed(column == "inferred")


@lru_cache(maxsize=4)
def chain(variant: str) -> ClosedChain:
    """The closed chain with lumped or distributed rods."""
    return load(ROBOT, variant, dynamics="ideal")


@lru_cache(maxsize=2)
def _circle(inferred: bool) -> Reference:
    return Reference(PUBLISHED[ROBOT].trajectory(), _believed(inferred))


def reference(column: str) -> Reference:
    """The circle, through the controller's model."""
    return _circle(column == "inferred")


def plant(column: str) -> Plant:
    """The robot of a column."""
    if column not in COLUMNS:
        raise UnknownNameError("column", column, list(COLUMNS))
    if column in ("lumped", "distributed"):
        return ConstrainedPlant(chain(column))
    return ReducedPlant(model(column))


def controller(name: str, column: str) -> Law:
    """A law with the gains of table 3."""
    return law(name, model(column), GAINS[ROBOT][name])


def table_3_run(name: str, column: str) -> Result:
    """One run of table 3: from the first desired position at rest, once around the circle, controlled continuously.

    The inferred code and the column `steps` are sampled at the steps of the adaptive solver that the paper's own
    figures seem to come from; all others every millisecond.
    """
    if column in SOLVER_STEPS:
        return run(plant(column), controller(name, column), reference(column), integrator=DormandPrince(1e-9, 1e-10))
    integrator: Integrator = RungeKutta4(STEP)
    return run(plant(column), controller(name, column), reference(column), integrator=integrator, every=STEP)


def bound(name: str) -> float:
    """Error bound of a controller after the settling time [m].

    Raises:
        InputError: the paper states none (computed torque is tuned by the limit of force).
    """
    found = ROWS[name].bound
    if found is None:
        raise InputError(f"the paper states no error bound for {name}")
    return found


def settled_error(name: str, column: str, k_p: float, k_d: float) -> float:
    """Largest error along any axis after the settling time [m], with other gains; every 2 ms."""
    made = law(name, model(column), {"kp": k_p, "kd": k_d})
    result = run(plant(column), made, reference(column), integrator=RungeKutta4(2 * STEP))
    return result.worst_axis_error(SETTLING_TIME)


def gain_rule(name: str, column: str) -> SmallestGain:
    """The smallest integer K_P that keeps the bound of its section, with K_D as printed."""
    row = ROWS[name]
    return smallest_gain(lambda k_p: settled_error(name, column, k_p, row.k_d), bound(name), round(row.k_p))


def first_force(column: str, name: str, k_d: float) -> float:
    """Largest actuator force at the start [N]: the robot is at rest and the path already moves."""
    desired = reference(column).at(0.0)
    k_p = k_d * k_d / 4.0 if name == "computed-torque" else ROWS[name].k_p
    made = law(name, model(column), {"kp": k_p, "kd": k_d})
    return float(np.abs(made.effort(desired, desired.q, np.zeros(3), np.zeros(0))).max())


def largest_k_d(column: str, name: str, limit: float) -> int:
    """Largest integer K_D whose first force stays within the limit [N]; the force grows with K_D."""
    k_d = 1
    while first_force(column, name, k_d + 1) <= limit:
        k_d += 1
    return k_d
