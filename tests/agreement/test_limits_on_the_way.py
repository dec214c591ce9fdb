"""Joint limits of `close` and `reach`: which joint, which bound, how far on the way, against closed forms."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from kit.by_joint import coordinates
from kit.led import Standing, with_limits
from kit.led_robots import LED, somewhere
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.errors import ClosureError, InputError, LimitError, UnreachableError

FOUND = 1e-4
"""The place on the way is found by halving, to 2^-16."""

STRAIGHT = tuple(name for name in LED if name != "pan_tilt")
"""Robots whose tool goes a straight way; that of the pan-tilt head stays on its sphere."""

HINGED = ("planar_3rrr", "fivebar", "tripod", "spherical_3rrr")
"""Robots with passive joints of one coordinate, which may have limits."""

Array = np.ndarray


class Limited:
    """A robot, a motion from home, and a chain that a limit stops on the way.

    Attributes:
        joint: name of the joint that is limited.
        part: how far between its places at home and at the end the limit is.
        x: freedoms of the end of the motion.
    """

    def __init__(self, robot: Standing, rng: np.random.Generator, passive: bool = False) -> None:
        self.robot, self.x, free = robot, robot.led.freedoms(rng), robot.chain
        end = self.end = free.reach(self.target(1.0))
        before, after = (coordinates(free, at.q_full) for at in (free.home, end))
        actuators = [one.name for one in free.actuators]
        names = [name for name, value in before.items() if np.ndim(value) == 0 and (name not in actuators) is passive]
        slides = {one.name for one in robot.description.joints if one.type.slides}
        units = {name: robot.length if name in slides else 1.0 for name in names}
        self.joint = max(names, key=lambda name: abs(after[name] - before[name]) / units[name])
        start, stop = before[self.joint], after[self.joint]
        self.part, self.value, self.tolerance = rng.uniform(0.25, 0.75), stop, 1e-9 * units[self.joint]
        bound, far = start + self.part * (stop - start), 10.0 * units[self.joint]
        self.bounds = (start - far, bound) if stop > start else (bound, start + far)
        self.bound, self.change = bound, abs(stop - start)
        self.chain = ClosedChain(with_limits(robot.description, {self.joint: self.bounds}))

    def target(self, part: float) -> dict[str, float]:
        """Of this part of the motion, by name."""
        task = self.robot.chain.task
        return self.robot.named(part * self.x, task.names, task.axes)

    def actuated(self, part: float) -> float:
        """Where the limited actuator is there, as the closed form knows."""
        index = [one.name for one in self.chain.actuators].index(self.joint)
        return float(self.robot.joints(part * self.x)[index])

    def check(self, error: LimitError) -> None:
        """That it names the joint, its value and its bounds."""
        assert isinstance(error, UnreachableError)
        assert isinstance(error, ClosureError)
        assert error.joint == self.joint
        assert error.bounds == self.bounds
        assert error.value == pytest.approx(self.value, abs=self.tolerance)
        assert 0.0 < error.progress < 1.0
        words = str(error)
        assert f"'{self.joint}'" in words
        assert self.robot.led.plan.name in words
        assert 'limits="ignore"' in words
        assert ("upper" if self.bound == self.bounds[1] else "lower") in words
        again = pickle.loads(pickle.dumps(error))
        assert (again.joint, again.value, again.bounds, again.progress) == (
            error.joint, error.value, error.bounds, error.progress
        )  # fmt: skip


def limited(name: str, seed: int, folder: Path, passive: bool = False) -> Limited:
    rng = np.random.default_rng([seed, 21, *name.encode()])
    return Limited(somewhere(name, seed, folder, rng), rng, passive)


@pytest.mark.parametrize("name", LED)
def test_close(name: str, tmp_path: Path) -> None:
    """The actuators go straight, so the limit is met after just the part of the way that it is away."""
    for seed in range(3):
        one = limited(name, seed, tmp_path)
        start, end = one.robot.joints(0.0 * one.x), one.robot.joints(one.x)
        with pytest.raises(LimitError) as caught:
            one.chain.close(end)
        one.check(caught.value)
        assert caught.value.progress == pytest.approx(one.part, abs=FOUND)
        one.chain.close(start + one.part * (end - start))
        one.chain.close(start + (one.part - 0.01) * (end - start))
        with pytest.raises(LimitError):
            one.chain.close(start + (one.part + 1e-4) * (end - start))


@pytest.mark.parametrize("name", LED)
def test_reach(name: str, tmp_path: Path) -> None:
    for seed in range(3):
        one = limited(name, seed, tmp_path)
        with pytest.raises(LimitError) as caught:
            one.chain.reach(one.target(1.0))
        one.check(caught.value)
        met = caught.value.progress
        if name in STRAIGHT:
            assert one.actuated(met) == pytest.approx(one.bound, abs=10.0 * FOUND * one.change)
            one.chain.reach(one.target(met - 0.01))
        with pytest.raises(LimitError):
            one.chain.reach(one.robot.pose(one.x))


@pytest.mark.parametrize("name", HINGED)
def test_passive_joints_too(name: str, tmp_path: Path) -> None:
    for seed in range(2):
        one = limited(name, seed, tmp_path, passive=True)
        with pytest.raises(LimitError) as caught:
            one.chain.reach(one.target(1.0))
        one.check(caught.value)
        met = caught.value.progress
        inside = one.chain.reach(one.target(met - 0.01))
        beyond = one.chain.reach(one.target(met + 0.01), limits="ignore")
        near, far = (coordinates(one.chain, at.q_full)[one.joint] for at in (inside, beyond))
        assert min(near, far) < one.bound < max(near, far)
        with pytest.raises(LimitError) as caught:
            one.chain.close(one.robot.joints(one.x))
        one.check(caught.value)


@pytest.mark.parametrize(
    "name", few(["stewart", "planar_3rrr", "tripod", "spherical_3rrr", "serial_wrist"], "planar_3rrr")
)
def test_compiled(name: str, tmp_path: Path) -> None:
    """The compiled robot stops where the chain does."""
    pytest.importorskip("llvmlite")
    one = limited(name, 1, tmp_path)
    fast, end = one.chain.compile(), one.robot.joints(one.x)
    for go in (lambda robot, **how: robot.reach(one.target(1.0), **how), lambda robot, **how: robot.close(end, **how)):
        met = []
        for robot in (one.chain, fast):
            with pytest.raises(LimitError) as caught:
                go(robot)
            one.check(caught.value)
            met.append(caught.value.progress)
        assert met[0] == pytest.approx(met[1], abs=FOUND)
        assert one.robot.missed(go(fast, limits="ignore").q, one.x) < 1e-12


@pytest.mark.parametrize("name", LED)
def test_ignored(name: str, tmp_path: Path) -> None:
    one = limited(name, 1, tmp_path)
    for at in (
        one.chain.reach(one.target(1.0), limits="ignore"),
        one.chain.reach(one.robot.pose(one.x), limits="ignore"),
        one.chain.close(one.robot.joints(one.x), limits="ignore"),
    ):
        assert one.robot.missed(at.q, one.x) < 1e-12
        assert one.joint in one.chain.limit_violations(at)
    for word in ("no", "", "ignored", None, True):
        with pytest.raises(InputError, match="respect"):
            one.chain.reach(one.target(0.1), limits=word)
        with pytest.raises(InputError, match="respect"):
            one.chain.close(one.robot.joints(0.1 * one.x), limits=word)


@pytest.mark.parametrize("name", LED)
def test_a_joint_that_starts_beyond_its_limit(name: str, tmp_path: Path) -> None:
    """It may stay and come back, but not go further; once back, the limit holds."""
    one = limited(name, 1, tmp_path)
    chain = one.chain
    beyond = chain.reach(one.target(0.98), limits="ignore")
    chain.close(beyond.q, near=beyond)
    chain.reach(one.target(0.98), near=beyond)
    half = chain.reach(one.target(0.98 * 0.9), near=beyond)
    back = chain.reach(one.target(0.0), near=half)
    assert one.robot.missed(back.q, 0.0 * one.x) < 1e-12
    chain.reach(one.target(0.0), near=beyond)
    for further in (one.target(1.0), one.robot.pose(one.x)):
        with pytest.raises(LimitError) as caught:
            chain.reach(further, near=beyond)
        assert caught.value.joint == one.joint
        assert caught.value.value == pytest.approx(one.value, abs=one.tolerance)
    with pytest.raises(LimitError):
        chain.close(one.robot.joints(one.x), near=beyond)
    with pytest.raises(LimitError):
        chain.reach(one.target(0.98), near=back)
