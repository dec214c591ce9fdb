"""What the tool is asked for over boxes of its coordinates: numbers and forms for the equations of a led chain.

A goal has the wanted place along the axes of the task, in the chain's model, and the wanted rotation since home in
these axes, exp([r]) with the rotation vector r of the task's coordinates,

    exp([r]) = 1 + S [r] + C (r r' - s),    s = r' r,    S = sum (-s)^k / (2 k + 1)!,    C = sum (-s)^k / (2 k + 2)!

Their third and fourth derivatives by s over factorials are below 3e-4 and 4e-6 for -5 <= s <= 12.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism.rotations import turned
from cutjoint.workspace.certified.enclosing import Slopes, led
from cutjoint.workspace.certified.forms import EPS, Form, add, constant, form, multiply, subtract, terms_of

PLACES, TURNS = 3, 9
TERMS = 16
"""Of the power series."""
LEAST, MOST = -5.0, 12.0
"""Squares of angles for which the bound of the series holds."""
THIRD, FOURTH = 1e-3, 1e-4
"""Bounds of the third and fourth derivatives over factorials of both."""


class BoxGoals:
    """BoxGoals of one chain along some coordinates of its tool.

    Args:
        chain: the robot.
        names: the led coordinates.
        axes: numbers of those that a box is over; the others are held.

    Attributes:
        width: how many numbers a goal has.
    """

    width = PLACES + TURNS

    def __init__(self, chain: ClosedChain, names: tuple[str, ...], axes: tuple[int, ...]) -> None:
        self.task, self.names, self.axes = chain.task, names, axes
        origin, basis = np.asarray(chain.origin), np.asarray(self.task.basis)
        start = np.asarray(self.task.home.position) if self.task.axes == "tool" else np.zeros(3)
        self._away = basis.T @ (origin - start)
        self._rounding = 16.0 * EPS * (np.abs(basis.T) @ (np.abs(origin) + np.abs(start)))

    def numbers(self, at: Array) -> Array:
        """BoxGoals of coordinates (N, led), shape (N, width)."""
        found, turns = np.zeros((len(at), self.width)), np.zeros((len(at), 3))
        for k, name in enumerate(self.names):
            axis = "xyz".index(name[-1])
            if name.startswith("r"):
                turns[:, axis] = at[:, k]
            else:
                found[:, axis] = at[:, k] - self._away[axis]
        found[:, PLACES:] = np.eye(3).ravel()
        turning = np.flatnonzero(turns.any(axis=1))
        for k in turning.tolist():
            found[k, PLACES:] = turned(turns[k]).ravel()
        return found

    def forms(self, middles: Array, halves: Array, order: int = 2) -> list[Form]:
        """Forms of the goals of boxes, from middles and half edges of the led coordinates, (N, led) each; share k runs
        along axis k of the boxes."""
        boxes, terms = len(middles), terms_of(len(self.axes), order)
        zero = constant(0.0, terms)
        places, turns = [zero] * 3, [zero] * 3
        for k, name in enumerate(self.names):
            axis, line = "xyz".index(name[-1]), np.zeros((terms.size, boxes))
            line[0] = middles[:, k]
            if k in self.axes:
                line[1 + self.axes.index(k)] = halves[:, k]
            rest = 2.0 * EPS * (np.abs(middles[:, k]) + np.abs(halves[:, k]))
            if name.startswith("r"):
                turns[axis] = form(terms, line, rest)
            else:
                line[0] -= self._away[axis]
                size = np.abs(line[0]) + np.abs(self._away[axis])
                places[axis] = form(terms, line, rest + self._rounding[axis] + 2.0 * EPS * size)
        return [*places, *_turning(turns, zero, constant(1.0, terms))]


def _turning(r: list[Form], zero: Form, one: Form) -> list[Form]:
    """Entries of exp([r]), row by row."""
    s = add(add(multiply(r[0], r[0]), multiply(r[1], r[1])), multiply(r[2], r[2]))
    across, along = _series(s, 1), _series(s, 2)
    found = []
    for i in range(3):
        for j in range(3):
            entry = multiply(along, multiply(r[i], r[j]))
            if i == j:
                entry = add(subtract(entry, multiply(along, s)), one)
            else:
                axis, sign = 3 - i - j, (j - i) % 3 == 1
                turn = multiply(across, r[axis])
                entry = subtract(entry, turn) if sign else add(entry, turn)
            found.append(entry)
    return found


def _series(s: Form, first: int) -> Form:
    """The sum of (-s)^k / (2 k + first)!."""
    middle = s.line[0]
    usable = (middle - s.radius >= LEAST) & (middle + s.radius <= MOST)
    middle = np.where(usable, middle, np.nan)
    value, slope, bend, third = (np.zeros_like(middle) for _ in range(4))
    for k in reversed(range(TERMS)):
        third = third * middle + bend
        bend = bend * middle + slope
        slope = slope * middle + value
        value = value * middle + (-1.0) ** k / factorial(2 * k + first)
    rounding = 64.0 * EPS * (1.0 + s.radius) ** 3
    return led(s, Slopes(value, slope, bend, third, np.asarray(THIRD), np.asarray(FOURTH), rounding))
