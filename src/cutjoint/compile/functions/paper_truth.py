"""A published model as what its compiled functions are compared with: the model itself."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.functions.sample import RobotSample, RobotUnits, drawn, near_home
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.mechanism import Mechanism, Posture, Terms, Tool


class PaperTruth:
    """A published model; see `Truth`."""

    def __init__(self, source: PaperSource, model: Mechanism, parameters: Array) -> None:
        self.units = RobotUnits.of(model.actuators, source.model.length, source.model.parameters.g)
        self.model, self.parameters = model, parameters

    def samples(self, chance: np.random.Generator) -> Sequence[RobotSample]:
        """At home and at a posture near it."""
        near = near_home(self.model.home, self.units.coordinate, self.model.close)
        return [PaperSample(self.units, self.model, at, *drawn(self.units, chance)) for at in near]


class PaperSample(RobotSample):
    """A published model at one state."""

    def __init__(self, units: RobotUnits, model: Mechanism, at: Posture, v: Array, a: Array) -> None:
        super().__init__(units, at.q, at.q, v, a, far=1.0)
        self.model, self.at = model, at
        self.axes["x"] = units.coordinate

    def beside(self, k: int, step: float, v: Array) -> Terms:
        """See `RobotSample`."""
        aside = np.array(self.q)
        aside[k] += step
        return self.model.terms(self.model.close(aside, self.at) if step else self.at, v)

    @cached_property
    def tool(self) -> Tool:
        """See `RobotSample`."""
        return self.model.tool(self.at, self.v)

    @property
    def potential(self) -> float:
        """See `RobotSample`."""
        return self.model.potential_energy(self.at)

    @property
    def weight(self) -> float:
        """See `RobotSample`."""
        return float(np.abs(self.units.coordinate * self.terms.gravity).max())

    @property
    def speed(self) -> float:
        """See `RobotSample`."""
        return float(np.abs(self.tool.jacobian @ self.v / self.units.length).max())
