"""The quickest motion along a way under limits that are linear in u = s_ddot and x = s_dot^2: one pass back for the
speeds from which the end can be reached, and one ahead that is as quick as they allow (Q.-C. Pham, H. Pham: A new
approach to time-optimal path parameterization based on reachability analysis.  IEEE Trans. Robotics 34(3), 2018,
645-659).  u is constant between two samples, and the limits are kept at both ends of each step.

The largest x for which some u is left is the last zero of a concave function made of straight lines, which Newton's
method finds exactly in a few steps from the right; so places where a limit does not depend on u need no special care.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.retiming.rows import LimitRows

ROUNDS = 200
SLACK = 1e-9
"""What a row may be beyond its bound by rounding, beside it."""
FLAT = 1e-11
"""A row depends on u where its factor is more than that, beside its largest one."""


@dataclass(frozen=True)
class Blocked:
    """Where no motion is left: the number of the sample, and the rows that leave none."""

    at: int
    rows: tuple[int, ...]


@dataclass(frozen=True)
class _Step:
    """The rows of one step, in u and x at its start."""

    a: Array
    b: Array
    g: Array


def quickest(rows: LimitRows, s: Array, *, first: float = 0.0, last: float = 0.0) -> Array | Blocked:
    """x = s_dot^2 at the samples, shape (k,), from x = `first` to at most `last`; or where there is no motion."""
    count = len(s)
    steps = np.diff(s)
    lowest, largest = np.zeros(count), np.zeros(count)
    largest[-1] = last
    flat = np.abs(rows.a) <= FLAT * np.abs(rows.a).max(axis=0)
    for i in range(count - 2, -1, -1):
        found = _range(_step(rows, i, steps[i], (lowest[i + 1], largest[i + 1]), flat))
        if isinstance(found, Blocked):
            own = len(rows.of)
            return Blocked(i, tuple(sorted({one % own for one in found.rows if one < 2 * own})))
        lowest[i], largest[i] = found
    if first < lowest[0] - SLACK * largest.max() or first > largest[0] * (1.0 + SLACK) + 1e-300:
        return Blocked(0, ())
    x = np.empty(count)
    x[0] = first
    for i in range(count - 1):
        step = _step(rows, i, steps[i], (lowest[i + 1], largest[i + 1]), flat)
        room, up = step.g - step.b * x[i], step.a > 0.0
        u = float(np.min(room[up] / step.a[up]))
        x[i + 1] = min(max(x[i] + 2.0 * steps[i] * u, lowest[i + 1]), largest[i + 1])
    return x


def _step(rows: LimitRows, i: int, length: float, after: tuple[float, float], flat: Array) -> _Step:
    own, other = np.where(flat[i], 0.0, rows.a[i]), np.where(flat[i + 1], 0.0, rows.a[i + 1])
    two = 2.0 * length
    a = np.concatenate([own, other + two * rows.b[i + 1], [two, -two]])
    b = np.concatenate([rows.b[i], rows.b[i + 1], [1.0, -1.0]])
    g = np.concatenate([rows.g[i], rows.g[i + 1], [after[1], -after[0]]])
    return _Step(a, b, g)


def _range(step: _Step) -> tuple[float, float] | Blocked:
    """The least and the largest x >= 0 with some u, or the rows that leave none."""
    up, down = np.flatnonzero(step.a > 0.0), np.flatnonzero(step.a < 0.0)
    level = np.flatnonzero(step.a == 0.0)
    most, least, edge = np.inf, 0.0, -1
    for k in level:
        b, g = step.b[k], step.g[k]
        if b > 0.0 and g / b < most:
            most, edge = g / b, int(k)
        elif b < 0.0:
            least = max(least, g / b)
        elif b == 0.0 and g < 0.0:
            return Blocked(0, (int(k),))
    if most < least:
        return Blocked(0, (edge,))
    upper = step.g[up] / step.a[up], step.b[up] / step.a[up]
    lower = step.g[down] / step.a[down], step.b[down] / step.a[down]
    return _zeros(upper, lower, least, most, (up, down))


def _zeros(
    upper: tuple[Array, Array],
    lower: tuple[Array, Array],
    least: float,
    most: float,
    of: tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]],
) -> tuple[float, float] | Blocked:
    """Where the lowest of the lines `upper` is above the highest of `lower`: each g - b x."""
    ends = []
    for begin, towards in ((most, -1.0), (least, 1.0)):
        x = begin
        for _ in range(ROUNDS):
            if np.isinf(x):  # far out the steepest line decides
                i, j = int(np.lexsort((upper[0], -upper[1]))[0]), int(np.lexsort((-lower[0], lower[1]))[0])
            else:
                i, j = int(np.argmin(upper[0] - upper[1] * x)), int(np.argmax(lower[0] - lower[1] * x))
            gap, slope = upper[0][i] - lower[0][j], upper[1][i] - lower[1][j]
            size = abs(upper[0][i]) + abs(lower[0][j]) + (abs(upper[1][i]) + abs(lower[1][j])) * min(abs(x), 1e300)
            if not np.isinf(x) and gap - slope * x >= -1e-13 * size:
                break
            if slope * -towards <= 0.0:  # it gets no better this way
                return Blocked(0, (int(of[0][i]), int(of[1][j])))
            new = gap / slope
            if not np.isinf(x) and abs(new - x) <= 1e-15 * abs(x):
                break
            x = new
            if x < 0.0 and towards < 0.0:
                return Blocked(0, (int(of[0][i]), int(of[1][j])))
        ends.append(x)
    largest, lowest = ends
    if lowest > largest:
        if lowest - largest > SLACK * abs(lowest):
            return Blocked(0, ())
        lowest = largest
    return lowest, largest


def ceiling(rows: LimitRows) -> Array:
    """The largest x at each sample for which some u is left, whatever comes before and after, shape (k,); infinite
    where there is none, and 0 where no x is left."""
    flat = np.abs(rows.a) <= FLAT * np.abs(rows.a).max(axis=0)
    found = np.empty(len(rows.a))
    for i in range(len(found)):
        a = np.where(flat[i], 0.0, rows.a[i])
        if not ((a > 0.0).any() and (a < 0.0).any()):
            bound = rows.g[i] / np.where(rows.b[i] > 0.0, rows.b[i], np.nan)
            found[i] = np.nanmin(np.append(bound[a == 0.0], np.inf))
            continue
        ends = _range(_Step(a, rows.b[i], rows.g[i]))
        found[i] = 0.0 if isinstance(ends, Blocked) else ends[1]
    return found
