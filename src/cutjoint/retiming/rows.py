"""Limits along a way as rows that are linear in u = s_ddot and x = s_dot^2:  A u + B x <= G.

What grows with the speed s_dot itself, damping, and power, |effort| <= P / (|q'| s_dot), is taken along its tangents at
a speed that is known from the round before: 1 / s_dot is convex in x and lies above its tangent, so power stays kept.
The acceleration of the tool is held within a polygon in the plane of its two terms, inside the circle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen
from cutjoint.reprs import line
from cutjoint.retiming.limits import OF_ACTUATORS, OF_TOOL, MotionLimits
from cutjoint.retiming.terms import WayTerms

CORNERS = 64
"""Of the polygon, which is within 0.12 % of the circle."""


@dataclass(frozen=True, eq=False)
class LimitRows(Frozen):
    """m rows at each of k samples.

    Attributes:
        a, b, g: A, B and G, shape (k, m).
        of: quantity and number of the actuator of each row.
    """

    a: Array
    b: Array
    g: Array
    of: tuple[tuple[str, int], ...]

    __repr__ = line("of")


class Margins:
    """How much of each limit is used at each sample: 1 at first, less where a motion between the samples was beyond."""

    def __init__(self, count: int, n: int) -> None:
        self._parts = {one: np.ones((count, n)) for one in OF_ACTUATORS} | {one: np.ones((count, 1)) for one in OF_TOOL}

    def __getitem__(self, quantity: str) -> Array:
        return self._parts[quantity]

    def tighten(self, quantity: str, which: int, near: npt.NDArray[np.intp], by: Array) -> None:
        """Divide at the samples `near` by what is there more than 1."""
        np.divide.at(self._parts[quantity][:, which], near, by)


def rows_of(terms: WayTerms, limits: MotionLimits, margins: Margins, squares: Array) -> LimitRows:
    """The rows, with tangents at x = `squares`, shape (k,)."""
    found = _Rows(len(terms.s))
    x = np.maximum(squares, 1e-6 * squares.max())
    roots = np.sqrt(x)
    effort = (terms.per_acceleration, terms.per_square, terms.holding + terms.dry)
    bounded: dict[str, list[int]] = {
        one: np.flatnonzero(np.isfinite(limits.of(one))).tolist() for one in (*OF_ACTUATORS, *OF_TOOL)
    }
    for j in bounded["speed"]:
        found.add(("speed", j), 0.0, terms.rates[:, j] ** 2, (limits.speed[j] * margins["speed"][:, j]) ** 2)
    for j in bounded["acceleration"]:
        bound = limits.acceleration[j] * margins["acceleration"][:, j]
        for sign in (1.0, -1.0):
            found.add(("acceleration", j), sign * terms.rates[:, j], sign * terms.bends[:, j], bound)
    for quantity in ("effort", "power"):
        for j in bounded[quantity]:
            bound, slope = limits.of(quantity)[j] * margins[quantity][:, j], 0.0
            if quantity == "power":
                spent = bound / np.maximum(np.abs(terms.rates[:, j]), 1e-12 * np.abs(terms.rates).max())
                bound, slope = 1.5 * spent / roots, 0.5 * spent / (x * roots)
            a, b, c = (one[:, j] for one in effort)
            d = terms.damping[:, j]
            for sign in (1.0, -1.0):
                square = sign * (b + 0.5 * d / roots) + slope
                found.add((quantity, j), sign * a, square, bound - sign * (c + 0.5 * d * roots))
    if bounded["tool_speed"]:
        square = np.sum(terms.tool_rates**2, axis=1)
        found.add(("tool_speed", 0), 0.0, square, (limits.tool_speed * margins["tool_speed"][:, 0]) ** 2)
    if bounded["tool_acceleration"]:
        _round(found, terms, limits.tool_acceleration * margins["tool_acceleration"][:, 0])
    return found.all()


class _Rows:
    def __init__(self, count: int) -> None:
        self._count = count
        self._rows: list[tuple[Array, Array, Array]] = []
        self._of: list[tuple[str, int]] = []

    def add(self, of: tuple[str, int], a: Array | float, b: Array | float, g: Array | float) -> None:
        """A row of each sample."""
        own = [np.broadcast_to(np.asarray(one, dtype=np.float64), self._count) for one in (a, b, g)]
        self._rows.append((own[0], own[1], own[2]))
        self._of.append(of)

    def all(self) -> LimitRows:
        """All rows, each with numbers about 1."""
        a, b, g = (np.array(one).T for one in zip(*self._rows, strict=True))
        return LimitRows(a, b, g, tuple(self._of))


def _round(found: _Rows, terms: WayTerms, bound: Array) -> None:
    """The rows of the polygon."""
    along = terms.tool_rates
    size = np.linalg.norm(along, axis=1, keepdims=True)
    first = np.divide(along, size, out=np.zeros_like(along), where=size > 0.0)
    rest = terms.tool_bends - np.sum(terms.tool_bends * first, axis=1, keepdims=True) * first
    size = np.linalg.norm(rest, axis=1, keepdims=True)
    second = np.divide(rest, size, out=np.zeros_like(rest), where=size > 0.0)
    for angle in 2.0 * np.pi * np.arange(CORNERS) / CORNERS:
        towards = np.cos(angle) * first + np.sin(angle) * second
        a, b = np.sum(towards * along, axis=1), np.sum(towards * terms.tool_bends, axis=1)
        found.add(("tool_acceleration", 0), a, b, bound * np.cos(np.pi / CORNERS))


def static_faults(terms: WayTerms, limits: MotionLimits) -> Mapping[int, tuple[float, float]]:
    """Actuators that cannot hold the robot still somewhere: number -> where, and the effort that it would need."""
    found = {}
    for j in np.flatnonzero(np.isfinite(limits.effort)):
        at = int(np.argmax(np.abs(terms.holding[:, j])))
        if abs(terms.holding[at, j]) > limits.effort[j]:
            found[int(j)] = float(terms.s[at]), float(terms.holding[at, j])
    return found
