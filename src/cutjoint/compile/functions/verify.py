"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  A chain is evaluated in numbers by another way
(`cutjoint.compile.functions.chain_numbers`), a published model by itself; what is compared, in which units and how
closely, stands in the function's row (`cutjoint.compile.functions.table`).
"""

from __future__ import annotations

import threading

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import RobotSample, Truth, nearest_turn
from cutjoint.compile.functions.truth import ChainTruth, PaperTruth
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.mechanism import Mechanism


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
    def truth(self) -> Truth:
        """The robot, known by another way than the compiled one."""
        if isinstance(self.source, ChainSource):
            return ChainTruth(self.source)
        return PaperTruth(self.source, self.model)

    def __call__(self, function: CompiledFunction) -> str:
        for sample in self.truth.samples(np.random.default_rng(len(function.row.name))):
            try:
                wrong = disagreement(function, sample, self.parameters)
            except np.linalg.LinAlgError:
                wrong = "the robot has a motion that moves no mass, or is singular near home"
            if wrong:
                return wrong
        return ""


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
