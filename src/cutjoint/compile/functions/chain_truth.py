"""A closed chain as what its compiled functions are compared with: its numbers (`ChainNumbers`)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.rank import null_space
from cutjoint.compile.functions.chain_numbers import ChainNumbers, ChainTerms
from cutjoint.compile.functions.sample import JointSample, RobotSample, RobotUnits, drawn, near_home
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.mechanism import Tool

WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""


class ChainTruth:
    """A closed chain; see `Truth`.  `source` is what is traced."""

    def __init__(self, source: ChainSource, parameters: Array) -> None:
        self.source, self.parameters, self.numbers = source, parameters, ChainNumbers(source)
        self.gravity = float(np.linalg.norm(source.model.gravity.linear))
        self.units = RobotUnits.of(source.chain.actuators, source.chain.length, self.gravity)
        self.mass = sum(float(inertia.mass) for inertia in list(source.model.inertias)[1:])

    def samples(self, chance: np.random.Generator) -> Sequence[RobotSample]:
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


class ChainSample(JointSample):
    """A closed chain at one state."""

    def __init__(self, truth: ChainTruth, q: Array, v: Array, a: Array, chance: np.random.Generator) -> None:
        source = truth.source
        far = float(np.abs(np.array(source.origin) / truth.units.length).max()) + 1.0
        super().__init__(truth.units, q, np.array(source.chain.actuated(q)), v, a, far)
        self.truth, self.numbers, self.chance = truth, truth.numbers, chance
        self.axes.update(x=np.array(source.position_scale), u=np.array(source.rate_scale))

    def beside(self, k: int, step: float, v: Array) -> ChainTerms:
        """See `RobotSample`."""
        # what a straight step opens the loops by is of second order, the same to both sides: it cancels
        aside = pin.integrate(self.truth.source.model, self.q, step * self.here.tangent[:, k]) if step else self.q
        return self.numbers.at(aside, v)

    @cached_property
    def here(self) -> ChainTerms:
        """The chain at this state."""
        return self.numbers.at(self.q, self.v)

    @cached_property
    def terms(self) -> ChainTerms:
        """See `RobotSample`."""
        return self.here

    @cached_property
    def tool(self) -> Tool:
        """See `RobotSample`."""
        here = self.here
        position, jacobian, drift = self.numbers.tool(self.q, here.tangent @ self.v, here.drift)
        return Tool(position, jacobian[:3] @ here.tangent, drift)

    @property
    def potential(self) -> float:
        """See `RobotSample`."""
        return self.numbers.potential(self.q)

    @property
    def weight(self) -> float:
        """See `RobotSample`."""
        return self.truth.mass * self.truth.gravity * self.units.length

    @property
    def speed(self) -> float:
        """See `RobotSample`."""
        return float(np.abs(self.here.tangent @ self.v / self.axes["u"]).max())

    # -- full coordinates --------------------------------------------------------------------------------------------

    @property
    def tangent(self) -> Array:
        """See `RobotSample`."""
        return self.here.tangent

    @property
    def drift(self) -> Array:
        """See `RobotSample`."""
        return self.here.drift

    @property
    def bending(self) -> float:
        """See `RobotSample`."""
        return max(self.speed**2, self.units.rate**2 if self.truth.source.idle else 0.0)

    @cached_property
    def v_full(self) -> Array:
        """A random velocity that respects the loops."""
        motions = null_space(self.numbers.jacobian(self.q))
        return np.asarray(self.units.rate * self.axes["u"] * (motions @ self.chance.normal(size=motions.shape[1])))

    @cached_property
    def effort_full(self) -> Array:
        """Random forces on all joints."""
        energy, nv = self.truth.mass * self.units.length**2 * self.units.rate**2, self.truth.source.nv
        return np.asarray(energy / self.axes["u"] * self.chance.normal(size=nv))

    @property
    def a_full(self) -> Array:
        """See `RobotSample`."""
        return self.numbers.full_acceleration(self.q, self.v_full, self.effort_full)
