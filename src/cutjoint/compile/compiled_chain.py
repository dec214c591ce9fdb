"""Closed chains, compiled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, sized
from cutjoint.chain import ClosedChain, MobilityReport
from cutjoint.chain.closing.ways import Near
from cutjoint.compile.chain_batch import ChainBatch
from cutjoint.compile.closing import ChainClosing
from cutjoint.compile.functions.library import Library, Options
from cutjoint.compile.functions.verify import Checker
from cutjoint.compile.mechanism import CompiledMechanism
from cutjoint.compile.once import once
from cutjoint.compile.reaching import ChainReaching
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.doors import door
from cutjoint.mechanism import ActuatedCoordinates, JointLimits, Posture, TargetLike, actuated_values
from cutjoint.mechanism.interface import are_respected


# long: the public face of a compiled robot, a line or two of code a method
class CompiledChain(CompiledMechanism[ClosedChain]):
    """A closed chain, compiled.

    Args:
        chain: the chain (`cutjoint.chain.ClosedChain`).
        options: how to compile.

    Raises:
        InputError, UnknownNameError: parameters that the chain does not have.

    Functions are traced and compiled when first used; `kernel` makes one at once.
    """

    _forgotten = (*CompiledMechanism._forgotten, "_closing", "_reaching", "_checked")
    _checked: Posture | None = None

    def __init__(self, chain: ClosedChain, options: Options | None = None) -> None:
        options = Options() if options is None else options
        self.source = ChainSource(chain, options.parameters, options.ranges)
        super().__init__(chain, replace(options, parameters=self.source.parameters), self.source.nominal)
        self.chain, self._layout = chain, chain.home.layout
        self._library = Library(self.source, Checker(self.source, chain, self._nominal), options)

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions; they hold on every branch."""
        return self._library

    def positions(self, at: Posture) -> Array:
        """The full configuration."""
        return at.q_full

    @once
    def batch(self) -> ChainBatch:
        """The same on many states at once."""
        return ChainBatch(self, self._closing)

    @once
    def _closing(self) -> ChainClosing:
        return ChainClosing(self.source, self._library, self._values)

    @once
    def _reaching(self) -> ChainReaching | None:
        return ChainReaching.where_led(self.source, self._library, self._values)

    @once
    def home(self) -> Posture:
        """See `ClosedChain.home`; with other places of joints and cuts the chain's own, closed anew with its actuators
        where they are."""
        if not self.source.displaced(self._values):
            return self.chain.home
        start, target = self.chain.home.q_full[None], self.chain.home.q[None]
        found, done = self._closing.walk(start, target, 1, self._nominal)
        return self.plain.posture(found[0]) if done[0] else self.plain.home

    @property
    def geometry(self) -> ClosedChain:
        """The chain with the present places of joints and cuts."""
        return self.plain if self.source.displaced(self._values) else self.chain

    def columns(self, values: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
        return self.source.arguments.columns(values)

    def _rebuilt(self, parameters: Mapping[str, float]) -> ClosedChain:
        return self.chain.rebuilt(self.source.arguments.rebuilt(parameters))

    @door
    def with_payload(self, mass: float) -> CompiledChain:
        """The same robot with a further point mass [kg] at the tool point.  Compiled anew unless `payload` is an
        argument.

        Raises:
            InputError: no tool, or not a mass.
        """
        if PAYLOAD in self.options.parameters:
            self.chain.description.with_payload(mass)
            return self.with_parameters(**{PAYLOAD: self.parameters[PAYLOAD] + mass})
        return CompiledChain(self.chain.with_payload(mass), self.options)

    def close(self, q: ActuatedCoordinates, near: Near = None, *, limits: JointLimits = "respect") -> Posture:
        """See `ClosedChain.close`.  Steps that are long against the links, start at a home by its name, or go beyond a
        joint's limits, are left to the chain's own continuation."""
        target, respected = actuated_values(q, self.actuators), are_respected(limits)
        if isinstance(near, str):
            return self.geometry.close(target, near, limits=limits)
        start = self._closing.start(self.home if near is None else near)
        found = self._closing.to(start, target) if self.source.determined else None
        if found is None or (respected and self.chain.goes_beyond(start, found.q_full)):
            return self.geometry.close(target, near, limits=limits)
        return found

    def reach(
        self, target: TargetLike, near: Near = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """See `ClosedChain.reach`.  Targets that are far away, from a home by its name, or beyond a joint's limits, are
        left to the chain's own continuation."""
        respected = are_respected(limits)
        if isinstance(near, str):
            return self.geometry.reach(target, near, free=free, limits=limits)
        start = self._closing.start(self.home if near is None else near)
        found = None if self._reaching is None else self._reaching.to(start, target, free)
        if found is None or (respected and self.chain.goes_beyond(start, found.q_full)):
            return self.geometry.reach(target, near, free=free, limits=limits)
        return found

    @property
    def idle_is_cyclic(self) -> bool:
        """See `ClosedChain.idle_is_cyclic`: whether the actuated coordinates tell the whole motion."""
        return bool(getattr(self.chain, "idle_is_cyclic", True))

    def mobility(self, at: Posture | None = None) -> MobilityReport:
        """See `ClosedChain.mobility`."""
        return self.geometry.mobility(at)

    # -- full coordinates --------------------------------------------------------------------------------------------

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n); errors as `ClosedChain.tangent`."""
        parts = self._call("tangent", at)
        return self.plain.tangent(at) if parts is None else parts["tangent"]

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.tangent(at) @ as_vector("v", v, self.n)

    def full_acceleration(self, q_full: Array, v_full: Array, effort_full: Array) -> Array:
        """Acceleration of all joints at a closed configuration, for any actuation, shape (nv,); see
        `ClosedChain.full_acceleration`."""
        q, v = sized("q_full", q_full, self.chain.nq), sized("v_full", v_full, self.chain.nv)
        effort = sized("effort_full", effort_full, self.chain.nv)
        parts = self._library["full_forward"](q, v, effort, self._values)
        if parts is not None:
            return parts["a_full"]
        return self.plain.full_acceleration(q_full, v_full, effort_full)

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> dict[str, Array] | None:
        if not self.source.determined:
            return None
        if not hasattr(at, "q_full") or at.q_full.shape != (self.chain.nq,):
            self._closing.start(at)
        if (self.source.placing or at.layout is not self._layout) and at is not self._checked:
            self._closing.check(at.q_full)
            self._checked = at
        return super()._call(what, at, *arguments)
