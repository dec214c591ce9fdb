"""The tool's frame: six-row Jacobian, drift and twist against differences of poses; the same of papers and compiled.

A motion of the actuators q + v t + a t^2 / 2 is followed in closed postures; poses of the tool on it give its twist,
and twists its acceleration, by central differences of fourth order.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from kit.blueprint import random_mounting
from kit.built import built
from kit.led_robots import LED, somewhere
from kit.mechanisms import MECHANISMS
from kit.quickly import few
from kit.shipped import DETERMINED, VARIANTS

from cutjoint import Mechanism, Posture, compiled, robots
from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError

ACCURACY = 1e-7
"""Of differences: relative to the motion, lengths in robot lengths."""

SAME = 1e-12
"""Of two models of one robot: relative, lengths in robot lengths."""

STEP = 1e-3
"""Of time, for differences; actuators move at about a radian or a robot length in a unit of it."""

Array = np.ndarray
Rng = np.random.Generator

WITH_TOOL = tuple(
    name
    for name, builder in MECHANISMS.items()
    if (drawn := builder(np.random.default_rng(0))).plan.tool is not None and not drawn.at_home
)


def derivative(values: Callable[[float], Array]) -> Array:
    """Of a function of time at 0, by central differences of fourth order."""
    near, far = (values(k * STEP) - values(-k * STEP) for k in (1.0, 2.0))
    return (8.0 * near - far) / (12.0 * STEP)


def units(mechanism: Mechanism, length: float) -> Array:
    """Of the actuated coordinates: robot lengths and radians, shape (n,)."""
    return np.array([1.0 if one.kind == "rotation" else length for one in mechanism.actuators])


def beside(mechanism: Mechanism, rng: Rng, length: float) -> Posture:
    """A posture near home, which a random step of the actuators leads to."""
    for size in (0.2, 0.1, 0.05, 0.02):
        try:
            return mechanism.close(mechanism.home.q + size * units(mechanism, length) * rng.normal(size=mechanism.n))
        except CutjointError:
            continue
    return mechanism.home


def check(mechanism: Mechanism, at: Posture, rng: Rng, length: float) -> None:
    v, a = (units(mechanism, length) * rng.normal(size=mechanism.n) for _ in range(2))
    scale = np.repeat([length, 1.0], 3)

    def posture(t: float) -> Posture:
        return mechanism.close(at.q + v * t + 0.5 * a * t * t, near=at)

    tool, still = mechanism.tool(at, v), mechanism.tool(at)
    size = 1.0 + np.abs(tool.frame_jacobian * units(mechanism, length) / scale[:, None]).max()
    np.testing.assert_allclose(tool.rotation @ tool.rotation.T, np.eye(3), rtol=0.0, atol=1e-14)
    assert np.linalg.det(tool.rotation) > 0.0
    linear = derivative(lambda t: mechanism.tool(posture(t)).position)
    turning = derivative(lambda t: mechanism.tool(posture(t)).rotation) @ tool.rotation.T
    twist = np.array([*linear, turning[2, 1], turning[0, 2], turning[1, 0]])
    assert np.abs((tool.twist - twist) / scale).max() < ACCURACY * size
    assert np.abs(tool.frame_jacobian @ v - tool.twist).max() < 1e-13 * size * scale.max()
    rate = derivative(lambda t: mechanism.tool(posture(t), v + a * t).twist)
    found = tool.frame_jacobian @ a + tool.frame_drift
    assert np.abs((found - rate) / scale).max() < ACCURACY * size**2 * (1.0 + np.abs(rate / scale).max())
    np.testing.assert_array_equal(still.frame_jacobian, tool.frame_jacobian)
    assert not still.twist.any()
    assert not still.frame_drift.any()
    np.testing.assert_array_equal(tool.jacobian, tool.frame_jacobian[:3])
    np.testing.assert_array_equal(tool.drift, tool.frame_drift[:3])
    np.testing.assert_array_equal(tool.pose.matrix[:3], np.column_stack([tool.rotation, tool.position]))


def require_same(one: Mechanism, other: Mechanism, at: Posture, there: Posture, rng: Rng, length: float) -> None:
    """That two models give one tool at postures which have the same actuated coordinates."""
    v = units(one, length) * rng.normal(size=one.n)
    a, b = one.tool(at, v), other.tool(there, v)
    scale = np.repeat([length, 1.0], 3)
    columns = units(one, length) / scale[:, None]
    size = 1.0 + np.abs(a.frame_jacobian * columns).max()
    assert np.abs(a.position - b.position).max() < SAME * length
    assert np.abs(a.rotation - b.rotation).max() < SAME
    assert np.abs((a.frame_jacobian - b.frame_jacobian) * columns).max() < SAME * size
    assert np.abs((a.twist - b.twist) / scale).max() < SAME * size
    drift = 1.0 + np.abs(a.frame_drift / scale).max()
    assert np.abs((a.frame_drift - b.frame_drift) / scale).max() < SAME * size * drift


@pytest.mark.parametrize("name", DETERMINED)
def test_shipped(name: str) -> None:
    chain, rng = robots.load(name), np.random.default_rng(3)
    for at in (chain.home, beside(chain, rng, chain.length)):
        check(chain, at, rng, chain.length)


@pytest.mark.parametrize("name", LED)
def test_led(name: str, tmp_path: Path) -> None:
    for seed in range(2):
        rng = np.random.default_rng([seed, 7, *name.encode()])
        robot = somewhere(name, seed, tmp_path, rng)
        at = robot.chain.close(robot.joints(robot.led.freedoms(rng)))
        check(robot.chain, at, rng, robot.length)


@pytest.mark.parametrize("name", WITH_TOOL)
def test_textbook(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng([8, *name.encode()])
    chain, _ = built(MECHANISMS[name](rng).plan, tmp_path, random_mounting(rng))
    check(chain, beside(chain, rng, chain.length), rng, chain.length)


@pytest.mark.parametrize("name", robots.PUBLISHED)
def test_papers(name: str) -> None:
    paper, rng, length = robots.published(name), np.random.default_rng(9), robots.load(name).length
    for at in (paper.home, beside(paper, rng, length)):
        check(paper, at, rng, length)


@pytest.mark.parametrize(("name", "variant"), VARIANTS)
def test_the_paper_and_the_chain_have_one_tool(name: str, variant: str) -> None:
    paper, chain, rng = robots.published(name), robots.load(name, variant), np.random.default_rng(10)
    for _ in range(5):
        at = beside(paper, rng, chain.length)
        require_same(paper, chain, at, chain.close(at.q), rng, chain.length)
        by_point = chain.reach(paper.tool(at).position)
        require_same(paper, chain, at, by_point, rng, chain.length)


@pytest.mark.parametrize("name", ["cpm", "omega3"])
def test_the_compiled_paper_has_the_same_tool(name: str) -> None:
    pytest.importorskip("llvmlite")
    paper, rng, length = robots.published(name), np.random.default_rng(11), robots.load(name).length
    fast = compiled(paper)
    for _ in range(5):
        at = beside(paper, rng, length)
        require_same(paper, fast, at, fast.close(at.q), rng, length)


def compiled_alike(chain: ClosedChain, rng: Rng, length: float, at: Posture) -> None:
    fast = chain.compile()
    require_same(chain, fast, at, fast.close(at.q), rng, length)
    require_same(chain, fast, at, at, rng, length)


@pytest.mark.parametrize(
    "name",
    [name if name in ("fivebar", "stewart") else pytest.param(name, marks=pytest.mark.slow) for name in DETERMINED],
)
def test_shipped_compiled(name: str) -> None:
    pytest.importorskip("llvmlite")
    chain, rng = robots.load(name), np.random.default_rng(12)
    compiled_alike(chain, rng, chain.length, beside(chain, rng, chain.length))


@pytest.mark.parametrize("name", few(LED, "tripod", "planar_3rrr"))
def test_led_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    for seed in range(2):
        rng = np.random.default_rng([seed, 13, *name.encode()])
        robot = somewhere(name, seed, tmp_path, rng)
        at = robot.chain.close(robot.joints(robot.led.freedoms(rng)))
        compiled_alike(robot.chain, rng, robot.length, at)
