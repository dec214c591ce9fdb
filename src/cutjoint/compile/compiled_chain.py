"""Closed chains, compiled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.functions.verify import checker
from cutjoint.compile.mechanism import NEWTON_STEPS, CompiledMechanism, Derivatives, Options, frozen
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import PAYLOAD, ChainSource
from cutjoint.description.model import Inertial
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism, Posture


class CompiledChain(CompiledMechanism):
    """A closed chain, compiled.

    Args:
        chain: the chain (`cutjoint.chain.ClosedChain`).
        options: how to compile.

    Raises:
        InputError, UnknownNameError: parameters that the chain does not have.

    Functions are traced and compiled when first used; `kernel` makes one at once.
    """

    def __init__(self, chain: Any, options: Options | None = None) -> None:
        options = Options() if options is None else options
        self.source = ChainSource(chain, options.parameters)
        nominal = np.array(
            [0.0 if name == PAYLOAD else self._mass(chain, name) for name in options.parameters], dtype=np.float64
        )
        super().__init__(chain, options, nominal, nominal)
        self.chain = chain
        self._library = Library(
            self.source,
            checker(self.source, chain, nominal),
            fast=options.fast,
            cached=options.cached,
            report=options.report,
        )

    @staticmethod
    def _mass(chain: Any, link: str) -> float:
        inertial = chain.description.link(link).inertial
        return float(inertial.mass)

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions; they hold on every branch."""
        return self._library

    def positions(self, at: Posture) -> Array:
        """The full configuration."""
        return at.q_full

    def _rebuilt(self, parameters: Mapping[str, float]) -> Mechanism:
        from cutjoint.chain import ClosedChain

        description = self.chain.description
        for name, mass in parameters.items():
            if name == PAYLOAD:
                continue
            old = description.link(name).inertial
            scaled = Inertial(mass, old.com, old.inertia * (mass / old.mass))
            description = description.with_inertial(name, scaled)
        if PAYLOAD in parameters:
            description = description.with_payload(parameters[PAYLOAD])
        made: Mechanism = ClosedChain(description)
        return made

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

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `ClosedChain.close`.  Steps that are long against the links are left to the chain's own continuation."""
        target = as_vector("q", q, self.n)
        found = self._newton(self._start(near), target) if self.source.determined else None
        return self.chain.close(target, near) if found is None else found

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `ClosedChain.reach`.  Targets that are far away are left to the chain's own continuation."""
        target = as_vector("p", p, 3, "m")
        n = self.n
        if 0 < n <= 3 and self.source.has_tool and self.source.determined:
            at: Posture | None = self.home if near is None else near
            far = np.inf
            # what is left of the digits of a position, where the robot is and in its own size
            rounding = 4e-15 * max(self.chain.length, float(np.abs(target).max()))
            for _ in range(NEWTON_STEPS):
                assert at is not None
                y = self._call("tool", at, np.zeros(n))
                if y is None:
                    break
                miss = target - y[:3]
                size = float(np.abs(miss).max())
                if size < rounding or (size < 100.0 * rounding and size > 0.1 * far):
                    return at
                if size > 0.5 * far or size > 0.2 * self.chain.length:
                    break
                far = size
                jacobian = y[3 : 3 + 3 * n].reshape(3, n)
                try:
                    # with fewer motors than directions a target is on the tool's surface or curve, or is not reached
                    square = n == 3
                    move = np.linalg.solve(jacobian, miss) if square else np.linalg.lstsq(jacobian, miss, rcond=None)[0]
                except np.linalg.LinAlgError:  # the tool cannot move in some direction here
                    break
                at = self._newton(at.q_full, at.q + move)
                if at is None:
                    break
        found: Posture = self.chain.reach(target, near)
        return found

    def _start(self, near: Posture | None) -> Array:
        q = self.home.q_full if near is None else near.q_full
        if q.shape != (self.chain.nq,):
            raise InputError(
                f"this posture has {q.size} coordinates, {self.chain.name} has {self.chain.nq}; make it with this "
                "robot's "
                "close() or reach()"
            )
        return q

    def _newton(self, q: Array, target: Array) -> Posture | None:
        """Newton's method by the compiled step; None where it is not plainly on the same branch."""
        step = self._library["step"]
        rows = step.program.result_slice("residual")
        nq = self.chain.nq
        last, worst = np.inf, np.inf
        for count in range(NEWTON_STEPS):
            y = step(q, target, self._values)
            if not (y[-1] <= STRAIN_LIMIT and np.isfinite(y.sum())):
                return None
            size = float(np.abs((y[:nq] - q) / self._q_scale).max(initial=0.0))
            open_by = float(np.abs(y[rows] * self._row_scale).max(initial=0.0))
            if count and (open_by < 1e-15 or (open_by < tolerances.CLOSURE.value and open_by > 0.1 * worst)):
                gap = np.abs(y[rows])
                lengths = self._is_length
                pair = float(gap[lengths].max(initial=0.0)), float(gap[~lengths].max(initial=0.0))
                return Posture(q[list(self.source.actuated)], q, pair)
            if size > (tolerances.STRIDE.value if count == 0 else 0.5 * last + 1e-9):
                return None
            last, worst = size, open_by
            q = y[:nq]
        return None

    @once
    def _is_length(self) -> npt.NDArray[np.bool_]:
        return np.array(self.source.row_is_length, dtype=bool)

    @once
    def _row_scale(self) -> Array:
        """What makes the loops' rows dimensionless."""
        return np.where(self._is_length, 1.0 / self.chain.length, 1.0)

    @once
    def _q_scale(self) -> Array:
        """Configuration coordinates that are lengths, in robot lengths."""
        return np.array(self.source.position_scale)

    @property
    def idle_is_cyclic(self) -> bool:
        """See `ClosedChain.idle_is_cyclic`: whether the actuated coordinates tell the whole motion."""
        return bool(getattr(self.chain, "idle_is_cyclic", True))

    def mobility(self, at: Posture | None = None) -> Any:
        """See `ClosedChain.mobility`."""
        return self.chain.mobility(at)

    # -- full coordinates --------------------------------------------------------------------------------------------

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n); errors as `ClosedChain.tangent`."""
        y = self._call("tangent", at)
        if y is None or not self.source.determined:
            return np.asarray(self.chain.tangent(at))
        return frozen(y[:-1].reshape(self.chain.nv, self.n))

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.tangent(at) @ as_vector("v", v, self.n)

    def full_acceleration(self, q_full: Array, v_full: Array, effort_full: Array) -> Array:
        """Acceleration of all joints at a closed configuration, for any actuation, shape (nv,); see
        `ClosedChain.full_acceleration`."""
        if not self.source.weightless:
            y = self._library["full_forward"](q_full, v_full, effort_full, self._values)
            if y[-1] <= STRAIN_LIMIT and np.isfinite(y.sum()):
                return y[:-1]
        plain: Any = self.plain
        return np.asarray(plain.full_forward_dynamics(q_full, v_full, effort_full).acceleration)

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> Array | None:
        if not self.source.determined:
            return None
        if at.q_full.shape != (self.chain.nq,):
            self._start(at)
        return super()._call(what, at, *arguments)

    def _derivatives(self, what: str, at: Posture, v: npt.ArrayLike, x: npt.ArrayLike) -> Derivatives:
        self.source.need_actuated()
        return super()._derivatives(what, at, v, x)
