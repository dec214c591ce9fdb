"""A robot in minimal coordinates at one state, by the chain that is not compiled, and the check against it."""

from __future__ import annotations

import threading

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.functions.chain_sample import ChainSample
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import RobotUnits
from cutjoint.compile.functions.verify import BESIDE, judged, units_of_rates, well_posed
from cutjoint.compile.once import once
from cutjoint.compile.sources.minimal import MinimalSource
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Posture, Terms, Tool


class MinimalSample(ChainSample):
    """Arguments and right values of compiled functions in minimal coordinates; `target` is a change of them."""

    def __init__(self, source: MinimalSource, units: RobotUnits, at: Posture, chance: np.random.Generator) -> None:
        super().__init__(source, units, at, chance)
        self.minimal, self.target = source.minimal, np.zeros(source.minimal.n)

    @property
    def terms(self) -> Terms:
        return self.minimal.terms(self.at, self.v)

    @property
    def tool(self) -> Tool:
        return self.minimal.tool(self.at, self.v)

    @property
    def tangent(self) -> Array:
        return self.minimal.tangent(self.at)

    @property
    def drift(self) -> Array:
        return self.minimal.drift(self.at, self.v)

    def aside(self, k: int, step: float) -> Posture:
        return self.minimal.moved(self.at, step * np.eye(self.minimal.n)[k])

    def terms_at(self, at: Posture, v: Array) -> Terms:
        return self.minimal.terms(at, v)


class MinimalChecker:
    """The check that `Library` asks for, see `cutjoint.compile.functions.verify`."""

    def __init__(self, source: MinimalSource) -> None:
        self.source = source
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        return MinimalChecker, (self.source,)

    @once
    def units(self) -> RobotUnits:
        """The robot's own units."""
        gravity = float(np.linalg.norm(self.source.model.gravity.linear))
        turning = tuple(unit == "rad" for unit in self.source.minimal.units)
        return units_of_rates(turning, self.source.chain.length, gravity)

    @once
    def postures(self) -> list[Posture]:
        """Home and a posture beside it, where one can be closed; where home is singular, two near it that are not."""
        source, minimal, home = self.source, self.source.minimal, self.source.chain.home
        if not well_posed(source):
            return [source.chain.posture(q) for q in source.cloud[:2]]
        for sign in (1.0, -1.0):
            try:
                return [home, minimal.moved(home, sign * BESIDE * self.units.coordinate)]
            except CutjointError:
                continue
        return [home]

    def __call__(self, function: CompiledFunction) -> str:
        chance, nothing = np.random.default_rng(len(function.row.name)), np.zeros(0)
        samples = [(MinimalSample(self.source, self.units, at, chance), nothing) for at in self.postures]
        return judged(function, samples)
