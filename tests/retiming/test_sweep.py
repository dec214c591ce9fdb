"""The reachability passes against closed forms and a linear program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from cutjoint.retiming.rows import LimitRows
from cutjoint.retiming.sweep import Blocked, ceiling, quickest
from cutjoint.retiming.time_law import elapsed

SEEDS = range(5)


def rows_for(a: np.ndarray, b: np.ndarray, g: np.ndarray) -> LimitRows:
    return LimitRows(a, b, g, tuple(("row", k) for k in range(a.shape[1])))


def box(count: int, up: float, down: float, cap: float = np.inf) -> LimitRows:
    """-down <= u <= up, and x <= cap."""
    a, b, g = [1.0, -1.0], [0.0, 0.0], [up, down]
    if np.isfinite(cap):
        a, b, g = [*a, 0.0], [*b, 1.0], [*g, cap]
    return rows_for(*(np.tile(one, (count, 1)) for one in (a, b, g)))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_mass_on_a_line_takes_the_time_of_the_closed_form(seed: int) -> None:
    rng = np.random.default_rng(seed)
    up, down, length = 10.0 ** rng.uniform(-3.0, 3.0, 3)
    s = length * np.linspace(0.0, 1.0, 401)
    x = quickest(box(401, up, down), s)
    wanted = np.sqrt(2.0 * length * (1.0 / up + 1.0 / down))
    step, fastest = s[1], np.sqrt(2.0 * length / (1.0 / up + 1.0 / down))
    assert wanted * (1.0 - 1e-12) <= elapsed(s, x)[-1] <= wanted + 2.0 * step / fastest
    # with a largest speed: ramps up and down, and even between
    top = rng.uniform(0.2, 0.8) * fastest
    x = quickest(box(401, up, down, top**2), s)
    ramps = 0.5 * top**2 * (1.0 / up + 1.0 / down)
    wanted = top * (1.0 / up + 1.0 / down) + (length - ramps) / top
    assert wanted * (1.0 - 1e-12) <= elapsed(s, x)[-1] <= wanted + 2.0 * step / top


def smooth_rows(rng: np.random.Generator, count: int, pairs: int) -> LimitRows:
    """Rows with both signs that leave rest possible everywhere, smooth along the way; some do not depend on u there."""
    t = np.linspace(0.0, 1.0, count)[:, None]
    waves = [rng.normal(size=pairs) + sum(rng.normal(size=pairs) * np.sin(k * t + rng.uniform(0, 6)) for k in (2, 5))
             for _ in range(2)]  # fmt: skip
    hold, limit = 0.6 * np.sin(3.0 * t + rng.uniform(0, 6, pairs)), np.ones((count, pairs))
    a, b = np.hstack([waves[0], -waves[0]]), np.hstack([waves[1], -waves[1]])
    return rows_for(a, b, np.hstack([limit - hold, limit + hold]))


@pytest.mark.parametrize("seed", SEEDS)
def test_rows_are_kept_at_both_ends_of_every_step_and_nothing_is_given_away(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 61
    rows, s = smooth_rows(rng, count, 3), np.linspace(0.0, 1.0, count)
    x = quickest(rows, s)
    assert not isinstance(x, Blocked)
    u = np.diff(x) / (2.0 * np.diff(s))
    for ends in (slice(None, -1), slice(1, None)):
        assert (rows.a[ends] * u[:, None] + rows.b[ends] * x[ends, None] <= rows.g[ends] + 1e-7).all()
    # a linear program with the same unknowns finds no larger sum of x
    step = np.diff(s)[0]
    matrix, right = [], []
    for i in range(count - 1):
        for k, at in ((i, 0), (i + 1, 1)):
            for a, b, g in zip(rows.a[k], rows.b[k], rows.g[k], strict=True):
                row = np.zeros(count)
                row[i], row[i + 1] = -a / (2.0 * step), a / (2.0 * step)
                row[i + at] += b
                matrix.append(row)
                right.append(g)
    bounds = [(0.0, 0.0), *[(0.0, None)] * (count - 2), (0.0, 0.0)]
    best = linprog(-np.ones(count), np.array(matrix), right, bounds=bounds)
    assert best.status == 0
    assert 0.97 * -best.fun <= x.sum() <= -best.fun * (1.0 + 1e-7)
    assert (x <= ceiling(rows) * (1.0 + 1e-9)).all()


def test_it_takes_as_long_there_as_back() -> None:
    rng = np.random.default_rng(3)
    rows, s = smooth_rows(rng, 200, 2), np.linspace(0.0, 1.0, 200)
    back = rows_for(-rows.a[::-1], rows.b[::-1], rows.g[::-1])
    there, again = quickest(rows, s), quickest(back, s)
    assert elapsed(s, there)[-1] == pytest.approx(elapsed(s, again)[-1], rel=0.02)


def test_where_nothing_is_left_is_told() -> None:
    rows, s = box(50, 1.0, 1.0), np.linspace(0.0, 1.0, 50)
    g = rows.g.copy()
    g[30, 1] = -2.0  # u >= 2 and u <= 1
    found = quickest(LimitRows(rows.a, rows.b, g, rows.of), s)
    assert isinstance(found, Blocked)
    assert found.at in (29, 30)
    assert set(found.rows) == {0, 1}
