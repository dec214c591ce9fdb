"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.chain_trace import ChainSource
from cutjoint.compile.native import Kernel
from cutjoint.compile.paper_trace import PaperSource
from cutjoint.compile.reduction import STRAIN_LIMIT
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Mechanism, Posture

AGREEMENT = 1e-9
"""Largest relative difference between a compiled function and its model; 1e-13 is typical."""
SLOPE = 1e-5
"""Same for derivatives against central differences."""


def results(kernel: Kernel, y: Array) -> dict[str, Array]:
    """The results of a call by name."""
    return {name: y[kernel.program.result_slice(name)] for name, _ in kernel.program.results}


def checker(source: ChainSource | PaperSource, model: Mechanism, values: Array) -> Callable[[str, Kernel], str]:
    """The check that `Library` asks for.

    Args:
        source: what is traced.
        model: the same robot, not compiled, with the inertial parameters at `values`.
        values: the parameters' values.
    """
    return _Checker(source, model, values)


class _Checker:
    def __init__(self, source: ChainSource | PaperSource, model: Mechanism, values: Array) -> None:
        self.source, self.model, self.values = source, model, values
        self._postures: list[Posture] | None = None

    def __call__(self, what: str, kernel: Kernel) -> str:
        chance = np.random.default_rng(len(what))
        for at in self.postures:
            n = self.source.n
            x, y = chance.normal(size=n), chance.normal(size=n)
            full = what == "full_forward"
            wrong = self._full(kernel, at, chance) if full else self._compare(what, kernel, at, x, y)
            if wrong:
                return wrong
        return ""

    @property
    def postures(self) -> list[Posture]:
        """Home and a posture near it."""
        if self._postures is None:
            home = self.model.home
            self._postures = [home]
            if not isinstance(self.source, ChainSource) or self.source.determined:
                for shift in (0.02, -0.02):
                    try:
                        self._postures.append(self.model.close(home.q + shift * (1.0 + np.abs(home.q)), home))
                        break
                    except CutjointError:
                        continue
        return self._postures

    def _positions(self, at: Posture) -> Array:
        return at.q_full if isinstance(self.source, ChainSource) else at.q

    def _compare(self, what: str, kernel: Kernel, at: Posture, v: Array, x: Array) -> str:
        """Everything in actuated coordinates."""
        model: Any = self.model
        q = self._positions(at)
        sizes = [size for _, size in kernel.program.arguments]
        n = self.source.n
        expected: list[tuple[str, Array]]
        given: Sequence[Array] = (q, v, x, self.values)
        tolerance = AGREEMENT
        match what:
            case "forward":
                expected = [("a", model.forward_dynamics(at, v, x))]
            case "inverse":
                expected = [("effort", model.inverse_dynamics(at, v, x))]
            case "terms":
                terms, given = model.terms(at, v), (q, v, self.values)
                expected = [("mass", terms.mass), ("coriolis", terms.coriolis), ("gravity", terms.gravity)]
            case "tool":
                tool, given = model.tool(at, v), (q, v, self.values)
                expected = [("position", tool.position), ("jacobian", tool.jacobian), ("drift", tool.drift)]
            case "energy":
                given = (q, v, self.values)
                kinetic = 0.5 * v @ model.terms(at).mass @ v
                expected = [("kinetic", np.array([kinetic]))]
                expected.append(("potential", np.array([model.potential_energy(at)])))
            case "tangent":
                expected, given = [("tangent", model.tangent(at))], (q, self.values)
            case "drift":
                expected, given = [("drift", model.drift(at, v))], (q, v, self.values)
            case "step":
                expected, given = [("q_next", q)], (q, at.q, self.values)
            case "reach":
                position = model.tool(at).position
                turns = 2.0 * np.pi
                reached = kernel(position, self.values)[:n]
                if self.model.actuators[0].kind == "rotation":
                    reached = reached + turns * np.round((at.q - reached) / turns)
                return _differ(what, reached, at.q, AGREEMENT)
            case _:
                return self._slopes(what, kernel, at, v, x)
        if sizes != [part.size for part in given]:
            return f"arguments of sizes {sizes}"
        found = results(kernel, kernel(*given))
        if not found["strain"] <= STRAIN_LIMIT:
            return f"strain {found['strain']} near home"
        for name, wanted in expected:
            if name not in found or found[name].size != np.size(wanted):
                return f"no result {name} of that size"
            wrong = _differ(name, found[name], np.ravel(wanted), tolerance)
            if wrong:
                return wrong
        return ""

    def _slopes(self, what: str, kernel: Kernel, at: Posture, v: Array, x: Array) -> str:
        """Derivatives against central differences of the model."""
        model = self.model
        forward = what == "forward_derivatives"
        function = model.forward_dynamics if forward else model.inverse_dynamics
        found = results(kernel, kernel(self._positions(at), v, x, self.values))
        value, third = ("a", "by_effort") if forward else ("effort", "by_a")
        wrong = _differ(value, found[value], function(at, v, x), AGREEMENT)
        n, h = self.source.n, 1e-5
        columns: dict[str, list[Array]] = {"by_q": [], "by_v": [], third: []}
        for step in h * np.eye(n):
            columns["by_v"].append((function(at, v + step, x) - function(at, v - step, x)) / (2 * h))
            columns[third].append((function(at, v, x + step) - function(at, v, x - step)) / (2 * h))
            before, after = model.close(at.q - step, at), model.close(at.q + step, at)
            columns["by_q"].append((function(after, v, x) - function(before, v, x)) / (2 * h))
        for name, parts in columns.items():
            wrong = wrong or _differ(name, found[name], np.stack(parts, axis=1).ravel(), SLOPE)
        return wrong

    def _full(self, kernel: Kernel, at: Posture, chance: np.random.Generator) -> str:
        """Forward dynamics in full coordinates, with a velocity that respects the loops."""
        assert isinstance(self.source, ChainSource)
        chain: Any = self.model
        jacobian = chain.constraint_jacobian(at.q_full)
        v = chance.normal(size=self.source.nv)
        if len(jacobian):
            v -= np.linalg.lstsq(jacobian, jacobian @ v, rcond=1e-9)[0]
        effort = chance.normal(size=self.source.nv)
        wanted = chain.full_acceleration(at.q_full, v, effort)
        return _differ("a_full", results(kernel, kernel(at.q_full, v, effort, self.values))["a_full"], wanted, 1e-7)


def _differ(name: str, found: Array, wanted: Array, tolerance: float) -> str:
    """What is wrong, in words, or nothing."""
    size = max(float(np.abs(wanted).max(initial=0.0)), 1e-3)
    worst = float(np.abs(found - wanted).max(initial=0.0))
    if worst <= tolerance * size:
        return ""
    return f"'{name}' is off by {worst:.2g} in {size:.2g}"
