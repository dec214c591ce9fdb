"""Friction of joints at rest, all at once, against the law that it solves, over random responses."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.errors import InputError
from cutjoint.simulation.bounded_friction import bounded


@pytest.mark.parametrize("seed", range(200))
def test_what_rests_is_held_and_what_accelerates_is_rubbed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count, rank = int(rng.integers(1, 12)), int(rng.integers(1, 7))
    rows = rng.normal(size=(count, rank)) * 10.0 ** rng.uniform(-2, 2, (count, 1))
    response, free = rows @ rows.T, rows @ (10.0 ** rng.uniform(-2, 2) * rng.normal(size=rank))
    friction = 10.0 ** rng.uniform(-2, 2, count)
    forces, left = bounded(response, free, friction)
    assert (np.abs(forces) <= friction * (1.0 + 1e-9)).all()
    sizes = np.abs(response) @ friction + np.abs(free)
    assert left == pytest.approx(free + response @ forces, abs=1e-10 * sizes.max())
    moves = np.abs(left) > 1e-9 * sizes
    assert forces[moves] == pytest.approx(-np.sign(left[moves]) * friction[moves], rel=1e-9)


def test_a_joint_that_nothing_can_hold_has_all_its_friction_against_it() -> None:
    forces, left = bounded(np.diag([0.0, 1.0]), np.array([3.0, 0.5]), np.array([2.0, 2.0]))
    assert forces == pytest.approx([-2.0, -0.5])
    assert left == pytest.approx([3.0, 0.0], abs=1e-9)


def test_nothing_acts() -> None:
    forces, left = bounded(np.zeros((2, 2)), np.zeros(2), np.ones(2))
    assert not forces.any()
    assert not left.any()


def test_numbers_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match="singular"):
        bounded(np.array([[np.nan]]), np.array([1.0]), np.array([1.0]))
