"""USD: the same robots as in a loops.toml, Pixar's own reading of the same files, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from kit.usd_robots import UsdRobot, planar, spatial, stewart

from cutjoint.chain import ClosedChain
from cutjoint.description import CutType, JointType, load_description, read_checked, write

pytest.importorskip("pxr", reason="usd-core is not installed")
HERE = Path(__file__).resolve().parent


def loaded(robot: UsdRobot, folder: Path) -> tuple[ClosedChain, ClosedChain]:
    """A robot read out of USD, and the same out of a loops.toml."""
    file = folder / "robot.usda"
    file.write_text(robot.usda, encoding="utf-8")
    plain = load_description(write(robot.description, folder / "plain")[0])
    return ClosedChain(load_description(file)), ClosedChain(plain)


def same_motion(one: ClosedChain, other: ClosedChain, rng: np.random.Generator) -> float:
    """How far accelerations of the same state under the same efforts are apart, relative to the largest."""
    at = one.home
    there = other.posture(_carried(one, other, at.q_full, "q"))
    v = one.project(at.q_full, rng.normal(size=one.nv))[1]
    effort = rng.normal(size=one.nv)
    a = one.full_forward_dynamics(at, v, effort).acceleration
    b = other.full_forward_dynamics(there, _carried(one, other, v, "v"), _carried(one, other, effort, "v")).acceleration
    assert np.abs(a).max() > 0.1
    return float(np.abs(_carried(one, other, a, "v") - b).max() / np.abs(b).max())


def _carried(one: ClosedChain, other: ClosedChain, values: np.ndarray, space: str) -> np.ndarray:
    """Values of all joints in the order of another chain, joints matched by name."""
    found = np.zeros(other.model.nq if space == "q" else other.nv)
    for number, name in enumerate(other.model.names):
        if number:
            index = one.model.getJointId(name)
            start, size = _at(one, index, space)
            to, _ = _at(other, number, space)
            found[to : to + size] = values[start : start + size]
    return found


def _at(chain: ClosedChain, joint: int, space: str) -> tuple[int, int]:
    model = chain.model
    if space == "q":
        return int(model.idx_qs[joint]), int(model.nqs[joint])
    return int(model.idx_vs[joint]), int(model.nvs[joint])


UNITS = ({}, {"length": 0.25, "mass": 0.5}, {"length": 0.0078125, "mass": 2.0})


@pytest.mark.parametrize("bars", [4, 5])
def test_planar_linkages(bars: int, tmp_path: Path) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        usd, plain = loaded(planar(rng, bars, **UNITS[seed % 3]), tmp_path)
        assert usd.mobility().mobility == plain.mobility().mobility == bars - 3
        assert same_motion(usd, plain, rng) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_any_mechanism(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    robot = spatial(rng, **UNITS[seed % 3])
    usd, plain = loaded(robot, tmp_path)
    assert usd.mobility().mobility == plain.mobility().mobility
    assert [(c.name, c.type) for c in usd.description.cuts] == [(c.name, c.type) for c in plain.description.cuts]
    assert same_motion(usd, plain, rng) < 1e-12
