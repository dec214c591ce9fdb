"""Compiled functions of a published model against the model itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.functions.sample import AGREEMENT, BESIDE, DIFFERENCE, Checker, Compared, differ
from cutjoint.compile.machine.llvm.native import Kernel
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Mechanism, Posture


class PaperChecker(Checker):
    """A published model against itself."""

    def __init__(self, source: PaperSource, model: Mechanism, values: Array) -> None:
        super().__init__(values, model.actuators, source.model.length, source.model.parameters.g)
        self.model: Any = model

    def postures(self) -> list[Posture]:
        """Home and a posture near it."""
        home = self.model.home
        for sign in (1.0, -1.0):
            shift = sign * BESIDE * self.unit * (1.0 + np.abs(home.q / self.unit))
            try:
                return [home, self.model.close(home.q + shift, home)]
            except CutjointError:
                continue
        return [home]

    def compare(self, what: str, kernel: Kernel, at: Posture, v: Array, a: Array, chance: np.random.Generator) -> str:
        """See `Checker`."""
        model, q, values, unit = self.model, at.q, self.values, self.unit
        terms = model.terms(at, v)
        weight = float(np.abs(unit * terms.gravity).max())
        match what:
            case "forward" | "inverse" | "terms":
                given, expected = self.dynamics(what, v, a, terms.mass, terms.coriolis, terms.gravity, weight)
                return self.judge(kernel, (q, *given, values), expected, AGREEMENT)
            case "tool":
                tool, length = model.tool(at, v), np.full(3, self.length)
                speed = float(np.abs(tool.jacobian @ v / self.length).max()) ** 2
                found: list[Compared] = [
                    ("position", tool.position, length, 1.0),
                    ("jacobian", tool.jacobian, np.outer(length, 1.0 / unit), 1.0),
                    ("drift", tool.drift, length, speed),
                ]
                return self.judge(kernel, (q, v, values), found, AGREEMENT)
            case "energy":
                potential = np.array([model.potential_energy(at)])
                found = [("kinetic", np.array([0.5 * v @ terms.mass @ v]), np.ones(1), 0.0)]
                found.append(("potential", potential, np.ones(1), weight))
                return self.judge(kernel, (q, v, values), found, AGREEMENT)
            case "step":
                return self.judge(kernel, (q, q, values), [("q_next", q, unit, 1.0)], AGREEMENT)
            case "reach":
                reached = kernel(model.tool(at).position, values)[: model.n]
                if model.actuators[0].kind == "rotation":
                    reached = reached + 2.0 * np.pi * np.round((q - reached) / (2.0 * np.pi))
                return differ(what, reached / unit, q / unit, 1.0, AGREEMENT)
        return self._slopes(what, kernel, at, v, a, terms, weight)

    def _slopes(self, what: str, kernel: Kernel, at: Posture, v: Array, a: Array, terms: Any, weight: float) -> str:
        """Derivatives against central differences of the model."""
        model, forward = self.model, what == "forward_derivatives"
        given, (expected,) = self.dynamics(
            "forward" if forward else "inverse", v, a, terms.mass, terms.coriolis, terms.gravity, weight
        )
        x = given[1]
        function = model.forward_dynamics if forward else model.inverse_dynamics
        columns: dict[str, list[Array]] = {"by_q": [], "by_v": []}
        for k, unit in enumerate(self.unit):
            step = DIFFERENCE * unit * np.eye(model.n)[k]
            before, after = model.close(at.q - step, at), model.close(at.q + step, at)
            columns["by_q"].append((function(after, v, x) - function(before, v, x)) / (2 * step[k]))
            step = self.rate * step
            columns["by_v"].append((function(at, v + step, x) - function(at, v - step, x)) / (2 * step[k]))
        wanted = {name: np.stack(parts, axis=1) for name, parts in columns.items()}
        wanted["by_effort" if forward else "by_a"] = np.linalg.inv(terms.mass) if forward else terms.mass
        found = kernel(at.q, v, x, self.values)
        return self.slopes(kernel, found, wanted, expected[1], expected[0], expected[3])
