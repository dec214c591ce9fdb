"""Averaged laws of time against numerical averages, and what they keep."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.retiming.time_law import TimeLaw, law_of

GAUSS = np.polynomial.legendre.leggauss(200)


def random_law(seed: int, *, goes_round: bool = False) -> tuple[TimeLaw, np.ndarray]:
    rng = np.random.default_rng(seed)
    s = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, 40))])
    x = 0.5 + rng.uniform(0.0, 3.0, 41)
    if goes_round:
        x[-1] = x[0]
    else:
        x[0] = x[-1] = 0.0
    return law_of(s, x, rng.uniform(0.05, 2.0), goes_round=goes_round), x


def plain(law: TimeLaw, t: np.ndarray) -> np.ndarray:
    """The law before it is averaged, at rest outside, or round and round."""
    laps = np.floor(t / law.shortest) if law.goes_round else np.zeros_like(t)
    t = np.clip(t - laps * law.shortest, 0.0, law.shortest)
    step = np.clip(np.searchsorted(law.times, t, side="right") - 1, 0, len(law.times) - 2)
    since, spans = t - law.times[step], np.diff(law.times)[step]
    u = np.diff(law.speeds)[step] / spans
    return laps * (law.s[-1] - law.s[0]) + law.s[step] + since * (law.speeds[step] + 0.5 * u * since)


@pytest.mark.parametrize("goes_round", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_the_law_is_the_average_with_a_triangle(seed: int, goes_round: bool) -> None:
    law, _ = random_law(seed, goes_round=goes_round)
    nodes, weights = GAUSS
    t = np.linspace(0.0, law.duration, 37)
    middle = t if goes_round else t - law.half
    average = np.zeros_like(t)
    for side in (-1.0, 1.0):  # the triangle is smooth on each side
        r = 0.5 * law.half * (nodes + 1.0)
        share = 0.5 * law.half * weights * (1.0 - r / law.half) / law.half
        average += np.sum(share * plain(law, middle[:, None] + side * r), axis=1)
    assert np.allclose(law.at(t), average, atol=1e-6 * law.s[-1])


@pytest.mark.parametrize("seed", range(3))
def test_the_acceleration_is_continuous_and_no_larger_than_before(seed: int) -> None:
    law, x = random_law(seed)
    largest = np.abs(np.diff(x) / (2.0 * np.diff(law.s))).max()
    step = law.half / 400.0
    t = np.arange(0.0, law.duration, step)
    found = law.at(t)
    u = np.diff(found, 2) / step**2
    assert (np.diff(found) >= -1e-12).all()
    assert found[0] == law.s[0]
    assert law.at(np.array([law.duration]))[0] == law.s[-1]
    assert np.abs(u).max() <= largest * (1.0 + 1e-4)
    assert np.abs(np.diff(u)).max() <= 2.1 * largest * step / law.half
    assert abs(u[0]) <= 0.01 * largest
    assert abs(u[-1]) <= 0.01 * largest


def test_a_law_that_goes_round_goes_on() -> None:
    law, _ = random_law(5, goes_round=True)
    ends = law.at(np.array([0.0, law.duration]))
    assert ends[1] - ends[0] == pytest.approx(law.s[-1] - law.s[0], rel=1e-12)
    step = 1e-5 * law.duration
    rates = [np.diff(law.at(np.array(pair)))[0] for pair in ((0.0, step), (law.duration - step, law.duration))]
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)
