"""Draws depend on the seed and the number of the run alone, and are what their method says."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.studies.ranking import ranked
from cutjoint.studies.sampling import UNIT, drawn, shuffled
from cutjoint.studies.spreads import CUT, Spread

SPREADS = (
    Spread("uniform", (-1.0, 3.0), 4),
    Spread("normal", (2.0, 0.5)),
    Spread("log-uniform", (1e-3, 1e3), 3),
    Spread("values", (5.0, 7.0, 11.0)),
)


@pytest.mark.parametrize("method", UNIT)
def test_a_block_is_a_part_of_the_whole(method: str) -> None:
    samples = 16 * 6 if method == "saltelli" else 100
    whole = drawn(method, SPREADS, samples, 5, 0, samples)
    for begin, end in ((0, 1), (0, 17), (17, 17), (17, 64), (95, 96), (3, samples)):
        assert np.array_equal(drawn(method, SPREADS, samples, 5, begin, end), whole[begin:end])
    assert not np.array_equal(drawn(method, SPREADS, samples, 6, 0, samples), whole)


@pytest.mark.parametrize("method", UNIT)
def test_values_lie_in_their_ranges(method: str) -> None:
    samples = 64 * 6
    values = drawn(method, SPREADS, samples, 1, 0, samples)
    for k, spread in enumerate(SPREADS):
        low, high = spread.bounds
        assert low <= values[:, k].min() <= values[:, k].max() <= high
    assert set(values[:, 3]) == {5.0, 7.0, 11.0}


@pytest.mark.parametrize("count", [1, 2, 3, 7, 8, 100, 1000, 4097])
def test_a_shuffle_is_a_permutation(count: int) -> None:
    numbers = np.arange(count, dtype=np.uint64)
    places = [shuffled(numbers, count, 3, stream) for stream in (0, 1)]
    for found in places:
        assert sorted(found.tolist()) == list(range(count))
    if count > 50:
        assert abs(np.corrcoef(places[0].astype(float), numbers.astype(float))[0, 1]) < 5.0 / np.sqrt(count)
        assert abs(np.corrcoef(places[0].astype(float), places[1].astype(float))[0, 1]) < 5.0 / np.sqrt(count)


def test_a_large_shuffle_stays_within() -> None:
    count = 10**9 + 7
    found = shuffled(np.arange(count - 1000, count, dtype=np.uint64), count, 0, 0)
    assert len(set(found.tolist())) == 1000
    assert found.max() < count
    assert found.max() - found.min() > count // 2


@pytest.mark.parametrize("samples", [10, 257])
def test_every_stratum_of_a_hypercube_has_one_run(samples: int) -> None:
    parts = UNIT["latin-hypercube"](3, samples, 2, 0, samples)
    for k in range(3):
        assert sorted(np.floor(parts[:, k] * samples).astype(int).tolist()) == list(range(samples))


def test_normal_values_are_normal() -> None:
    values = drawn("latin-hypercube", [Spread("normal", (3.0, 0.2))], 4000, 1, 0, 4000)[:, 0]
    assert np.isclose(values.mean(), 3.0, atol=1e-3)
    assert np.isclose(values.std(), 0.2, rtol=5e-3)
    assert np.abs(values - 3.0).max() <= 0.2 * CUT


def test_a_grid_has_every_combination_once() -> None:
    spreads = (SPREADS[0], SPREADS[2], SPREADS[3])
    values = drawn("grid", spreads, 36, 0, 0, 36)
    assert len({tuple(row) for row in values.tolist()}) == 36
    assert np.allclose(sorted(set(values[:, 0])), [-1.0, 1.0 / 3.0, 5.0 / 3.0, 3.0])
    assert np.allclose(sorted(set(values[:, 1])), [1e-3, 1.0, 1e3])
    assert np.array_equal(drawn("grid", spreads, 36, 9, 7, 12), values[7:12])


@pytest.mark.slow
def test_the_rows_of_saltelli_are_those_of_salib() -> None:
    salib_sobol = pytest.importorskip("SALib.sample.sobol")
    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[0.0, 1.0]] * 3}
    theirs = salib_sobol.sample(problem, 16, calc_second_order=False, scramble=True, seed=7)
    assert np.array_equal(UNIT["saltelli"](3, 16 * 5, 7, 0, 16 * 5), theirs)


def ishigami(x: np.ndarray) -> np.ndarray:
    """T. Ishigami, T. Homma, ISUMA 1990, with a = 7 and b = 0.1."""
    return np.asarray(np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))


@pytest.mark.slow
def test_sobol_indices_are_those_that_are_known() -> None:
    spreads, runs = [Spread("uniform", (-np.pi, np.pi))] * 3, 2**12 * 5
    x = drawn("saltelli", spreads, runs, 1, 0, runs)
    found = ranked("saltelli", 0, "y", ["a", "b", "c"], x, ishigami(x))
    assert found is not None
    known = {"a": (0.31391, 0.55759), "b": (0.44241, 0.44241), "c": (0.0, 0.24368)}
    for one in found.effects:
        first, total = known[one.path]
        assert abs((one.first or 0.0) - first) < 0.02
        assert abs((one.total or 0.0) - total) < 0.02
    assert [one.path for one in found.effects] == ["a", "b", "c"]


@pytest.mark.slow
def test_runs_that_failed_leave_the_indices_as_they_are() -> None:
    spreads, runs = [Spread("uniform", (-np.pi, np.pi))] * 3, 2**10 * 5
    x = drawn("saltelli", spreads, runs, 1, 0, runs)
    y = ishigami(x)
    y[[3, 77, 1005]] = np.nan
    found = ranked("saltelli", 0, "y", ["a", "b", "c"], x, y)
    assert found is not None
    assert found.runs == runs - 3 * 5
    assert abs((found.effects[0].total or 0.0) - 0.55759) < 0.06


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol"])
def test_a_linear_quantity_has_its_coefficients(method: str) -> None:
    spreads = [Spread("uniform", (0.0, 1.0)), Spread("uniform", (10.0, 20.0)), Spread("values", (1.0, 2.0))]
    x = drawn(method, spreads, 1024, 4, 0, 1024)
    y = 3.0 * x[:, 0] - 0.1 * x[:, 1]
    found = ranked(method, 0, "y", ["a", "b", "c"], x, y)
    assert found is not None
    assert [one.path for one in found.effects] == ["a", "b", "c"]
    parts = {one.path: one.regression for one in found.effects}
    wanted = np.array([3.0, -0.1, 0.0]) * x.std(axis=0) / y.std()
    assert np.allclose([parts["a"], parts["b"], parts["c"]], wanted, atol=1e-9)
    assert found.explained is not None
    assert np.isclose(found.explained, 1.0)
    by_rank = {one.path: one.rank for one in found.effects}
    assert by_rank["a"] is not None
    assert 0.9 < by_rank["a"] < 1.0


def test_of_too_few_runs_or_a_constant_nothing_is_said() -> None:
    x = drawn("random", SPREADS[:2], 100, 0, 0, 100)
    assert ranked("random", 0, "y", ["a", "b"], x[:15], x[:15, 0]) is None
    assert ranked("random", 0, "y", ["a", "b"], x, np.full(100, 7.0)) is None
    assert ranked("random", 0, "y", ["a", "b"], x, np.full(100, np.nan)) is None
