"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  A chain is evaluated in numbers by another way
(`cutjoint.compile.projection`), a published model by itself.

Nothing here has a size of its own.  States are drawn in the robot's own units (its length; the rate of a pendulum of
that length under its gravity), and what must agree is compared in them, against the size of the terms it is made of.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile.chain_trace import ChainSource
from cutjoint.compile.native import Kernel
from cutjoint.compile.paper_trace import PaperSource
from cutjoint.compile.projection import Reduced, null_space
from cutjoint.compile.reduction import STRAIN_LIMIT
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Actuator, Mechanism, Posture

AGREEMENT = 1e-9
"""Largest relative difference between a compiled function and its model; 1e-13 is typical."""
SLOPE = 1e-5
"""Same for derivatives against central differences."""
DIFFERENCE = 1e-5
"""Step of those differences, in the robot's units."""
BESIDE = 0.02
"""How far from home the second state is, in the robot's units."""
WELL_POSED = 1e-3
"""Smallest singular value of the loops, against the largest, where they are compared."""

Compared = tuple[str, Array, Array, float]
"""Name of a result, its right value, the units of its entries, and the size of the terms it is made of in them."""


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
    return _ChainChecker(source, values) if isinstance(source, ChainSource) else _PaperChecker(source, model, values)


class _Checker:
    """What checking a chain and a published model have in common."""

    _made_of: tuple[Any, Any, Array]

    def __init__(self, values: Array, actuators: Sequence[Actuator], length: float, gravity: float) -> None:
        self.values, self.length = values, length
        self._postures: list[Any] | None = None
        self.unit = np.array([length if one.kind == "translation" else 1.0 for one in actuators])
        """Of the actuated coordinates, [m] or [rad]."""
        self.rate = float(np.sqrt(gravity / length)) if gravity > 0.0 else 1.0
        """Of velocities [1/s]."""

    def __reduce__(self) -> Any:
        return checker, self._made_of

    def __call__(self, what: str, kernel: Kernel) -> str:
        chance = np.random.default_rng(len(what))
        if self._postures is None:
            self._postures = self.postures()
        for at in self._postures:
            n = len(self.unit)
            v = self.rate * self.unit * chance.normal(size=n)
            a = self.rate**2 * self.unit * chance.normal(size=n)
            try:
                wrong = self.compare(what, kernel, at, v, a, chance)
            except np.linalg.LinAlgError:
                wrong = "the robot has a motion that moves no mass, or is singular near home"
            if wrong:
                return wrong
        return ""

    def postures(self) -> list[Any]:
        """States to compare at."""
        raise AssertionError

    def compare(self, what: str, kernel: Kernel, at: Any, v: Array, a: Array, chance: np.random.Generator) -> str:
        """What is wrong with a function at one state."""
        raise AssertionError

    def judge(self, kernel: Kernel, given: tuple[Array, ...], expected: list[Compared], tolerance: float) -> str:
        """Results of a call against their right values."""
        sizes = [size for _, size in kernel.program.arguments]
        if sizes != [part.size for part in given]:
            return f"arguments of sizes {sizes}"
        found = results(kernel, kernel(*given))
        if not found["strain"] <= STRAIN_LIMIT:
            return f"strain {found['strain']} near home"
        for name, wanted, unit, size in expected:
            if name not in found or found[name].size != np.size(wanted):
                return f"no result {name} of that size"
            wrong = _differ(name, found[name] / np.ravel(unit), np.ravel(wanted / unit), size, tolerance)
            if wrong:
                return wrong
        return ""

    def dynamics(
        self, what: str, v: Array, a: Array, mass: Array, coriolis: Array, gravity: Array, weight: float
    ) -> tuple[tuple[Array, ...], list[Compared]]:
        """Arguments after the position, and what is expected, of the functions of the equation of motion.

        Args:
            weight: size of the weights that may cancel in `gravity`, as an energy [J].
        """
        unit = self.unit
        pull = mass @ a
        effort = pull + coriolis + gravity
        energy = float(np.abs(unit * pull).max() + np.abs(unit * coriolis).max()) + weight
        moving = float((np.abs(unit[:, None] * mass * unit) @ np.abs(v / unit)).max() * np.abs(v / unit).max())
        compliance = np.abs(np.linalg.inv(unit[:, None] * mass * unit))
        match what:
            case "forward":
                return (v, effort), [("a", a, unit, float(compliance.max() * energy))]
            case "inverse":
                return (v, a), [("effort", effort, 1.0 / unit, energy)]
            case "terms":
                inertia = ("mass", mass, 1.0 / np.outer(unit, unit), 0.0)
                turning = ("coriolis", coriolis, 1.0 / unit, moving)
                return (v,), [inertia, turning, ("gravity", gravity, 1.0 / unit, weight)]
        raise KeyError(what)

    def slopes(
        self, kernel: Kernel, found: Array, columns: dict[str, Array], value: Array, name: str, size: float
    ) -> str:
        """Derivatives against differences; the value against itself."""
        parts = results(kernel, found)
        kind, inward = (self.unit, 1.0 / self.unit) if name == "a" else (1.0 / self.unit, self.unit)
        wrong = _differ(name, parts[name] / kind, value / kind, size, AGREEMENT)
        steps = {"by_q": self.unit, "by_v": self.rate * self.unit, "by_effort": inward, "by_a": inward}
        for by, wanted in columns.items():
            scale = np.outer(kind, 1.0 / steps[by])
            floor = size if by in ("by_q", "by_v") else 0.0
            wrong = wrong or _differ(by, parts[by] / scale.ravel(), (wanted / scale).ravel(), floor, SLOPE)
        return wrong


class _ChainChecker(_Checker):
    """A closed chain against `Projection`."""

    def __init__(self, source: ChainSource, values: Array) -> None:
        self._made_of = source, source.chain, values
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
        """See `_Checker`."""
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


class _PaperChecker(_Checker):
    """A published model against itself."""

    def __init__(self, source: PaperSource, model: Mechanism, values: Array) -> None:
        self._made_of = source, model, values
        super().__init__(values, model.actuators, source.length, source.model.parameters.g)
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
        """See `_Checker`."""
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
                reached = kernel(model.tool(at).position, values)[:3]
                if model.actuators[0].kind == "rotation":
                    reached = reached + 2.0 * np.pi * np.round((q - reached) / (2.0 * np.pi))
                return _differ(what, reached / unit, q / unit, 1.0, AGREEMENT)
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
            step = DIFFERENCE * unit * np.eye(3)[k]
            before, after = model.close(at.q - step, at), model.close(at.q + step, at)
            columns["by_q"].append((function(after, v, x) - function(before, v, x)) / (2 * step[k]))
            step = self.rate * step
            columns["by_v"].append((function(at, v + step, x) - function(at, v - step, x)) / (2 * step[k]))
        wanted = {name: np.stack(parts, axis=1) for name, parts in columns.items()}
        wanted["by_effort" if forward else "by_a"] = np.linalg.inv(terms.mass) if forward else terms.mass
        found = kernel(at.q, v, x, self.values)
        return self.slopes(kernel, found, wanted, expected[1], expected[0], expected[3])


def _differ(name: str, found: Array, wanted: Array, size: float, tolerance: float) -> str:
    """What is wrong, in words, or nothing; `size` is that of the terms of which `wanted` is the sum."""
    size = max(float(np.abs(wanted).max(initial=0.0)), size)
    worst = float(np.abs(found - wanted).max(initial=0.0))
    if worst <= tolerance * size:
        return ""
    return f"'{name}' is off by {worst:.2g} in {size:.2g}, in the robot's own units"
