"""Robots as a CAD program exports them, lengths rounded: nearly dependent rows must not lock them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, RobotDescription, load_description


def rounded(name: str, error: float, seed: int = 0) -> RobotDescription:
    """The shipped robot with every cut frame off by up to `error` in metres."""
    robot, random = load_description(name), np.random.default_rng(seed)

    def moved(frame: Frame) -> Frame:
        placement = np.array(frame.placement)
        placement[:3, 3] += random.uniform(-error, error, 3)
        return Frame(frame.link, placement)

    return replace(robot, cuts=tuple(replace(cut, a=moved(cut.a), b=moved(cut.b)) for cut in robot.cuts))


@pytest.mark.parametrize("error", [1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("name", ["omega3", "fivebar", "fourbar"])
def test_rounding_does_not_take_the_mobility(name: str, error: float) -> None:
    exact, chain = cutjoint.load(name), ClosedChain(rounded(name, error))
    right, found = exact.mobility(), chain.mobility()
    assert (found.mobility, found.rank, found.rows) == (right.mobility, right.rank, right.rows)
    assert len(found.redundant_rows) == len(right.redundant_rows)
    assert found.determined
    # the rows that were left out are open by about the rounding, and the posture says so
    assert 0.0 < max(found.gap) < 200.0 * error / chain.length


@pytest.mark.parametrize("name", ["omega3", "fivebar"])
def test_a_rounded_robot_moves_and_weighs_like_the_exact_one(name: str) -> None:
    exact, chain = cutjoint.load(name), ClosedChain(rounded(name, 1e-6))
    random = np.random.default_rng(1)
    for _ in range(5):
        q = exact.home.q + random.uniform(-0.1, 0.1, exact.n)
        right, at = exact.close(q), chain.close(q)
        np.testing.assert_allclose(chain.tool(at).position, exact.tool(right).position, rtol=0, atol=1e-4)
        v, effort = random.normal(size=chain.n), random.normal(size=chain.n)
        a = chain.forward_dynamics(at, v, effort)
        wanted = exact.forward_dynamics(right, v, effort)
        np.testing.assert_allclose(a, wanted, rtol=0, atol=1e-3 * np.abs(wanted).max())
        np.testing.assert_allclose(chain.inverse_dynamics(at, v, a), effort, rtol=0, atol=1e-10)


def test_exact_robots_keep_all_their_rows() -> None:
    for name in ("omega3", "cpm", "fivebar", "stewart", "redundant"):
        chain = cutjoint.load(name)
        assert chain._k.closure.left_out == ()
