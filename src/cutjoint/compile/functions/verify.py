"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  What is compared, in which units and how closely, stands in the function's row
(`cutjoint.compile.functions.table`).
"""

from __future__ import annotations

import threading

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.chain_sample import ChainSample
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import RobotSample, RobotUnits, nearest_turn
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.errors import CutjointError, DynamicsError, SingularError
from cutjoint.mechanism import Mechanism, Posture

BESIDE = 0.02
"""How far from home the second state is, in the robot's units."""
WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""


class Checker:
    """The check that `Library` asks for: says what is wrong with a function, or nothing.

    Args:
        source: what is traced.
        model: the same robot, not compiled, with the inertial parameters at `parameters`.
        parameters: values of those that are arguments.
    """

    def __init__(self, source: ChainSource | PaperSource, model: Mechanism, parameters: Array) -> None:
        self.source, self.model, self.parameters = source, model, parameters
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        return Checker, (self.source, self.model, self.parameters)

    @once
    def units(self) -> RobotUnits:
        """The robot's own units."""
        source = self.source
        if isinstance(source, PaperSource):
            length, gravity = source.model.length, source.model.parameters.g
        else:
            length, gravity = source.chain.length, float(np.linalg.norm(source.model.gravity.linear))
        turning = tuple(one.kind == "rotation" for one in self.model.actuators)
        rate = float(np.sqrt(gravity / length)) if gravity > 0.0 else 1.0
        return RobotUnits(np.where(turning, 1.0, length), turning, length, rate)

    @once
    def postures(self) -> list[Posture]:
        """Home and a posture beside it, where one can be closed; where home is singular, two near it that are not."""
        source, home, unit = self.source, self.model.home, self.units.coordinate
        if isinstance(source, ChainSource) and not well_posed(source):
            return [source.chain.posture(q) for q in source.cloud[:2]]
        for sign in (1.0, -1.0):
            try:
                return [home, self.model.close(home.q + sign * BESIDE * unit * (1.0 + np.abs(home.q / unit)))]
            except CutjointError:
                continue
        return [home]

    def __call__(self, function: CompiledFunction) -> str:
        chance, source = np.random.default_rng(len(function.row.name)), self.source
        for at in self.postures:
            if isinstance(source, ChainSource):
                sample: RobotSample = ChainSample(source, self.units, at, chance)
            else:
                sample = RobotSample(self.model, self.units, at, chance)
            try:
                wrong = disagreement(function, sample, self.parameters)
            except (np.linalg.LinAlgError, SingularError, DynamicsError):
                wrong = "the robot has a motion that moves no mass, or is singular near home"
            if wrong:
                return wrong
        return ""


def well_posed(source: ChainSource) -> bool:
    """Whether the loops of a chain are far from singular at home."""
    source.need_all_rows()
    if source.idle is None:
        return False
    dependent = np.delete(source.scaled_jacobian(source.chain.home.q_full), list(source.actuated_rates), axis=1)
    values = np.linalg.svd(dependent, compute_uv=False)
    rank = dependent.shape[1] - source.idle
    return rank == 0 or bool(rank <= values.size and values[rank - 1] > WELL_POSED * values[0])


def disagreement(function: CompiledFunction, sample: RobotSample, parameters: Array) -> str:
    """What a function gives at one state against what it must give there: what is wrong, in words, or nothing."""
    arguments = [parameters if name == "parameters" else getattr(sample, name) for name in function.row.arguments]
    y = function.kernel(*arguments)
    if not y[-1] <= STRAIN_LIMIT:
        return f"strain {y[-1]} near home"
    found, known = function.parts(y), function.row.known(sample)
    for part in function.row.parts:
        if part.name not in known:
            continue
        unit = np.ones(())
        for axis in part.units.split(","):
            unit = np.multiply.outer(unit, sample.axes[axis])
        given, wanted = found[part.name], known[part.name]
        if part.periodic:
            given = nearest_turn(given, wanted, sample.units.turning)
        size = max(float(np.abs(wanted / unit).max(initial=0.0)), part.size(sample))
        worst = float(np.abs((given - wanted) / unit).max(initial=0.0))
        if not worst <= part.tolerance * size:
            return f"'{part.name}' is off by {worst:.2g} in {size:.2g}, in the robot's own units"
    return ""
