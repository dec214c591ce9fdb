"""Closed chains and published models as what their compiled functions are compared with, at a few states each."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.rank import null_space
from cutjoint.compile.functions.chain_numbers import ChainNumbers
from cutjoint.compile.functions.sample import JointTerms, RobotSample, RobotUnits, drawn, near_home
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.mechanism import Mechanism, Posture, Tool

WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""


class PaperTruth:
    """A published model; see `Truth`.  `model` has the parameters at which the function is asked."""

    def __init__(self, source: PaperSource, model: Mechanism) -> None:
        self.units = RobotUnits.of(model.actuators, source.model.length, source.model.parameters.g)
        self.model = model

    def samples(self, chance: np.random.Generator) -> list[RobotSample]:
        """At home and at a posture near it."""
        near = near_home(self.model.home, self.units.coordinate, self.model.close)
        return [PaperSample(self.units, self.model, at, *drawn(self.units, chance)) for at in near]


class PaperSample(RobotSample):
    """A published model at one state: its own answers."""

    def __init__(self, units: RobotUnits, model: Mechanism, at: Posture, v: Array, a: Array) -> None:
        super().__init__(units, at.q, at.q, v, a, far=1.0)
        self.model, self.at = model, at
        self.axes.update(x=units.coordinate, u=units.coordinate)
        self.potential = model.potential_energy(at)
        self.weight = float(np.abs(units.coordinate * self.terms.gravity).max())

    def beside(self, k: int, step: float, v: Array) -> JointTerms:
        n, aside = len(v), np.array(self.q)
        aside[k] += step
        found = self.model.terms(self.model.close(aside, self.at) if step else self.at, v)
        return JointTerms(found.mass, found.coriolis, found.gravity, np.eye(n), np.zeros(n))

    @cached_property
    def tool(self) -> Tool:
        return self.model.tool(self.at, self.v)


class ChainTruth:
    """A closed chain; see `Truth`.  `source` is what is traced."""

    def __init__(self, source: ChainSource) -> None:
        self.source, self.numbers = source, ChainNumbers(source)
        gravity = float(np.linalg.norm(source.model.gravity.linear))
        self.units = RobotUnits.of(source.chain.actuators, source.chain.length, gravity)
        self.weight = self.numbers.total_mass * gravity * source.chain.length

    def samples(self, chance: np.random.Generator) -> list[RobotSample]:
        """At home and near it."""
        return [ChainSample(self, q, *drawn(self.units, chance), chance) for q in self.configurations]

    @cached_property
    def configurations(self) -> list[Array]:
        """Home and a configuration near it; where home is singular, two near it that are not."""
        chain = self.source.chain
        if not self._well_posed(np.array(chain.home.q_full)):
            return [np.array(q) for q in self.source.cloud[:2]]
        return [np.array(at.q_full) for at in near_home(chain.home, self.units.coordinate, chain.close)]

    def _well_posed(self, q: Array) -> bool:
        source = self.source
        if source.idle is None:
            return False
        dependent = np.delete(self.numbers.jacobian(q), list(source.actuated_rates), axis=1)
        values = np.linalg.svd(dependent, compute_uv=False)
        rank = dependent.shape[1] - source.idle
        return rank == 0 or bool(rank <= values.size and values[rank - 1] > WELL_POSED * values[0])


class ChainSample(RobotSample):
    """A closed chain at one state: its numbers, with a random motion of all joints that the loops allow, and random
    forces on them."""

    def __init__(self, truth: ChainTruth, q: Array, v: Array, a: Array, chance: np.random.Generator) -> None:
        source, units, numbers = truth.source, truth.units, truth.numbers
        far = float(np.abs(np.array(source.origin) / units.length).max()) + 1.0
        super().__init__(units, q, np.array(source.chain.actuated(q)), v, a, far)
        self.source, self.numbers, self.weight = source, numbers, truth.weight
        self.axes.update(x=source.position_scale, u=numbers.scale)
        self.potential = numbers.potential(q)
        motions = null_space(numbers.jacobian(q))
        self.v_full = np.asarray(units.rate * numbers.scale * (motions @ chance.normal(size=motions.shape[1])))
        energy = numbers.total_mass * units.length**2 * units.rate**2
        self.effort_full = np.asarray(energy / numbers.scale * chance.normal(size=source.nv))

    def beside(self, k: int, step: float, v: Array) -> JointTerms:
        # what a straight step opens the loops by is of second order, the same to both sides: it cancels
        aside = pin.integrate(self.source.model, self.q, step * self.terms.tangent[:, k]) if step else self.q
        return self.numbers.at(aside, v)

    @cached_property
    def tool(self) -> Tool:
        tangent, drift = self.terms.tangent, self.terms.drift
        position, jacobian, pull = self.numbers.tool(self.q, tangent @ self.v, drift)
        return Tool(position, jacobian @ tangent, pull)

    @cached_property
    def a_full(self) -> Array:
        return self.numbers.full_acceleration(self.q, self.v_full, self.effort_full)

    @property
    def bending(self) -> float:
        return max(super().bending, self.units.rate**2 if self.source.idle else 0.0)
