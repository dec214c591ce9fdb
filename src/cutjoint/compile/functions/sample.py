"""How compiled functions are compared with right values, without any size of its own.

States are drawn in the robot's own units (its length; the rate of a pendulum of that length under its gravity), and
what must agree is compared in them, against the size of the terms it is made of.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.machine.llvm.native import Kernel
from cutjoint.mechanism import Actuator

AGREEMENT = 1e-9
"""Largest relative difference between a compiled function and its model; 1e-13 is typical."""
SLOPE = 1e-5
"""Same for derivatives against central differences."""
DIFFERENCE = 1e-5
"""Step of those differences, in the robot's units."""
BESIDE = 0.02
"""How far from home the second state is, in the robot's units."""

Compared = tuple[str, Array, Array, float]
"""Name of a result, its right value, the units of its entries, and the size of the terms it is made of in them."""


def results(kernel: Kernel, y: Array) -> dict[str, Array]:
    """The results of a call by name."""
    return {name: y[kernel.program.result_slice(name)] for name, _ in kernel.program.results}


class Checker:
    """Compares compiled functions of one robot; what checking a chain and a published model have in common.

    Args:
        values: of the inertial parameters that are arguments.
        actuators: of the robot.
        length: one that tells how large it is [m].
        gravity: [m/s2].

    Called with a function's name and kernel it says what is wrong, or nothing.
    """

    def __init__(self, values: Array, actuators: Sequence[Actuator], length: float, gravity: float) -> None:
        self.values, self.length = values, length
        self._postures: list[Any] | None = None
        self.unit = np.array([length if one.kind == "translation" else 1.0 for one in actuators])
        """Of the actuated coordinates, [m] or [rad]."""
        self.rate = float(np.sqrt(gravity / length)) if gravity > 0.0 else 1.0
        """Of velocities [1/s]."""

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
            wrong = differ(name, found[name] / np.ravel(unit), np.ravel(wanted / unit), size, tolerance)
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
        wrong = differ(name, parts[name] / kind, value / kind, size, AGREEMENT)
        steps = {"by_q": self.unit, "by_v": self.rate * self.unit, "by_effort": inward, "by_a": inward}
        for by, wanted in columns.items():
            scale = np.outer(kind, 1.0 / steps[by])
            floor = size if by in ("by_q", "by_v") else 0.0
            wrong = wrong or differ(by, parts[by] / scale.ravel(), (wanted / scale).ravel(), floor, SLOPE)
        return wrong


def differ(name: str, found: Array, wanted: Array, size: float, tolerance: float) -> str:
    """What is wrong, in words, or nothing; `size` is that of the terms of which `wanted` is the sum."""
    size = max(float(np.abs(wanted).max(initial=0.0)), size)
    worst = float(np.abs(found - wanted).max(initial=0.0))
    if worst <= tolerance * size:
        return ""
    return f"'{name}' is off by {worst:.2g} in {size:.2g}, in the robot's own units"
