"""Compiled functions of a closed chain against the chain in numbers (`cutjoint.compile.functions.chain_numbers`)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile.equations.cloud import null_space
from cutjoint.compile.functions.chain_numbers import Reduced
from cutjoint.compile.functions.sample import AGREEMENT, BESIDE, DIFFERENCE, Checker, Compared
from cutjoint.compile.machine.llvm.native import Kernel
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.errors import CutjointError

WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""


class ChainChecker(Checker):
    """A closed chain against `Projection`; `source` is what is traced."""

    def __init__(self, source: ChainSource, values: Array) -> None:
        gravity = float(np.linalg.norm(source.model.gravity.linear))
        super().__init__(values, source.chain.actuators, source.chain.length, gravity)
        self.source = source
        self.mass = sum(float(inertia.mass) for inertia in list(source.model.inertias)[1:])
        self.weight = self.mass * gravity * self.length

    def postures(self) -> list[Array]:
        """Home and a configuration near it; where home is singular, two near it that are not."""
        source = self.source
        home = np.array(source.chain.home.q_full)
        if not self._well_posed(home):
            return [np.array(q) for q in source.cloud[:2]]
        for sign in (1.0, -1.0):
            shift = sign * BESIDE * self.unit * (1.0 + np.abs(source.chain.home.q / self.unit))
            try:
                return [home, np.array(source.chain.close(source.chain.home.q + shift).q_full)]
            except CutjointError:
                continue
        return [home]

    def _well_posed(self, q: Array) -> bool:
        source = self.source
        if source.idle is None:
            return False
        dependent = np.delete(source.numbers.jacobian(q), list(source.actuated_rates), axis=1)
        values = np.linalg.svd(dependent, compute_uv=False)
        rank = dependent.shape[1] - source.idle
        return rank == 0 or bool(rank <= values.size and values[rank - 1] > WELL_POSED * values[0])

    def compare(self, what: str, kernel: Kernel, q: Array, v: Array, a: Array, chance: np.random.Generator) -> str:
        """See `Checker`."""
        source, numbers, unit, values = self.source, self.source.numbers, self.unit, self.values
        if what == "full_forward":
            return self._full(kernel, q, chance)
        here = numbers.at(q, v)
        scale = np.array(source.rate_scale)
        speed = float(np.abs(here.tangent @ v / scale).max()) ** 2
        match what:
            case "forward" | "inverse" | "terms":
                given, expected = self.dynamics(what, v, a, here.mass, here.coriolis, here.gravity, self.weight)
                return self.judge(kernel, (q, *given, values), expected, AGREEMENT)
            case "tool":
                position, jacobian, drift = numbers.tool(q, here.tangent @ v, here.drift)
                length = np.full(3, self.length)
                near = float(np.abs(position / self.length).max()) + 1.0
                found: list[Compared] = [
                    ("position", position, length, near),
                    ("jacobian", jacobian[:3] @ here.tangent, np.outer(length, 1.0 / unit), 1.0),
                    ("drift", drift, length, speed),
                ]
                return self.judge(kernel, (q, v, values), found, AGREEMENT)
            case "energy":
                kinetic = np.array([0.5 * v @ here.mass @ v])
                far = float(np.abs(np.array(source.origin) / self.length).max()) + 1.0
                found = [("kinetic", kinetic, np.ones(1), 0.0)]
                found.append(("potential", np.array([numbers.potential(q)]), np.ones(1), far * self.weight))
                return self.judge(kernel, (q, v, values), found, AGREEMENT)
            case "tangent":
                outer = np.outer(scale, 1.0 / unit)
                return self.judge(kernel, (q, values), [("tangent", here.tangent, outer, 1.0)], AGREEMENT)
            case "drift":
                size = max(speed, self.rate**2 if source.idle else 0.0)
                return self.judge(kernel, (q, v, values), [("drift", here.drift, scale, size)], AGREEMENT)
            case "step":
                target = np.array(source.chain.actuated(q))
                found = [("q_next", q, np.array(source.position_scale), 1.0)]
                return self.judge(kernel, (q, target, values), found, AGREEMENT)
        return self._slopes(what, kernel, q, v, a, here)

    def _slopes(self, what: str, kernel: Kernel, q: Array, v: Array, a: Array, here: Reduced) -> str:
        """Derivatives against central differences, along the tangent of the loops."""
        numbers, n = self.source.numbers, len(self.unit)
        forward = what == "forward_derivatives"
        given, (expected,) = self.dynamics(
            "forward" if forward else "inverse", v, a, here.mass, here.coriolis, here.gravity, self.weight
        )
        x = given[1]

        def at(q: Array, v: Array) -> Array:
            now = numbers.at(q, v)
            bias = now.coriolis + now.gravity
            return np.asarray(np.linalg.solve(now.mass, x - bias) if forward else now.mass @ x + bias)

        columns: dict[str, list[Array]] = {"by_q": [], "by_v": []}
        for k, unit in enumerate(self.unit):
            step = DIFFERENCE * self.rate * unit * np.eye(n)[k]
            columns["by_v"].append((at(q, v + step) - at(q, v - step)) / (2 * step[k]))
            # what a straight step opens the loops by is of second order, the same to both sides: it cancels
            aside = DIFFERENCE * unit * here.tangent[:, k]
            ahead, behind = (pin.integrate(self.source.model, q, sign * aside) for sign in (1.0, -1.0))
            columns["by_q"].append((at(ahead, v) - at(behind, v)) / (2 * DIFFERENCE * unit))
        wanted = {name: np.stack(parts, axis=1) for name, parts in columns.items()}
        wanted["by_effort" if forward else "by_a"] = np.asarray(np.linalg.inv(here.mass)) if forward else here.mass
        found = kernel(q, v, x, self.values)
        return self.slopes(kernel, found, wanted, expected[1], expected[0], expected[3])

    def _full(self, kernel: Kernel, q: Array, chance: np.random.Generator) -> str:
        """Forward dynamics in full coordinates, with a velocity that respects the loops."""
        numbers, scale = self.source.numbers, np.array(self.source.rate_scale)
        motions = null_space(numbers.jacobian(q))
        v = self.rate * scale * (motions @ chance.normal(size=motions.shape[1]))
        effort = self.mass * self.length**2 * self.rate**2 / scale * chance.normal(size=self.source.nv)
        wanted = numbers.full_acceleration(q, v, effort)
        return self.judge(kernel, (q, v, effort, self.values), [("a_full", wanted, scale, self.rate**2)], AGREEMENT)
