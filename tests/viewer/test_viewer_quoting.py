from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.built import built
from kit.mechanisms import MECHANISMS
from kit.random_robots import random_robot
from kit.shipped import SHIPPED

from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import coordinates_to_q, velocity_scale
from cutjoint.description import load_description, write
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Posture
from cutjoint.robots import load
from cutjoint.viewer.hand.coordinates import at_limits, coordinates_of
from cutjoint.viewer.hand.quoting import as_python, as_toml

FAMILY = [*SHIPPED, *MECHANISMS]


def robot_of(name: str, folder: Path) -> ClosedChain:
    if name in MECHANISMS:
        return built(MECHANISMS[name](np.random.default_rng(5)).plan, folder)[0]
    return load(name)


def away_from_home(chain: ClosedChain, rng: np.random.Generator, size: float = 0.15) -> Posture:
    """A closed posture some way off, on home's branch or not: from a shaken configuration."""
    scale = velocity_scale(chain.model, chain.length)
    for _ in range(20):
        shaken = chain.integrate(np.array(chain.home.q_full), size * scale * rng.normal(size=chain.nv))
        try:
            return chain.assemble(shaken, keep_actuators=False)
        except CutjointError:
            size *= 0.5
    return chain.home


def apart(chain: ClosedChain, a: Posture, b: Posture) -> float:
    difference = pin.difference(chain.model, np.array(a.q_full), np.array(b.q_full))
    return float(np.abs(difference).max(initial=0.0))


@pytest.mark.parametrize("name", FAMILY)
def test_the_toml_loads_and_gives_the_posture_back(name: str, tmp_path: Path) -> None:
    chain, rng = robot_of(name, tmp_path / "made"), np.random.default_rng(11)
    write(chain.description, tmp_path / "copy")
    loops = tmp_path / "copy" / "loops.toml"
    before = loops.read_text(encoding="utf-8")
    for _ in range(2):
        at = away_from_home(chain, rng)
        loops.write_text(before + "\n" + as_toml(chain, at), encoding="utf-8")
        again = ClosedChain(load_description(loops), "posture")
        assert apart(chain, at, again.home) < 1e-9
        np.testing.assert_allclose(again.home.q, at.q, rtol=0, atol=1e-15)


def test_the_name_of_the_copy_is_a_new_one(tmp_path: Path) -> None:
    chain, loops = load("fivebar"), tmp_path / "loops.toml"
    write(chain.description, tmp_path)
    for wanted in ("posture", "posture2", "posture3"):
        text = as_toml(chain, chain.home)
        assert list(tomllib.loads(text)["home"]) == [wanted]
        loops.write_text(loops.read_text(encoding="utf-8") + "\n" + text, encoding="utf-8")
        chain = ClosedChain(load_description(loops))


@pytest.mark.parametrize("name", FAMILY)
def test_each_line_of_python_gives_the_posture_by_itself(name: str, tmp_path: Path) -> None:
    chain, rng = robot_of(name, tmp_path), np.random.default_rng(12)
    for size in (0.02, 0.3):
        at = away_from_home(chain, rng, size)
        lines = as_python(chain, at).splitlines()
        assert lines
        for line in lines:
            names: dict[str, Any] = {"robot": chain}
            exec(line, names)
            assert apart(chain, at, names["at"]) < 1e-6


def test_another_branch_is_not_given_by_its_actuators() -> None:
    chain = load("fivebar")
    other = chain.assembly_modes()[1]
    assert apart(chain, other, chain.home) > 0.1
    assert "close" not in as_python(chain, other)
    assert as_python(chain, chain.home).startswith("at = robot.close([")


def test_coordinates_are_those_of_a_home_posture(tmp_path: Path) -> None:
    rng, seen = np.random.default_rng(3), set()
    for number in range(12):
        plan = random_robot(rng, 8, 2, tmp_path / f"try{number}")
        chain = built(plan, tmp_path / f"robot{number}")[0]
        at = away_from_home(chain, rng, 0.4)
        values = coordinates_of(chain, at)
        q = np.array(chain.neutral)
        for joint in chain.description.joints:
            if joint.type.moves:
                seen.add(joint.type.value)
                index = chain.model.getJointId(joint.name)
                start, count = chain.model.idx_qs[index], chain.model.nqs[index]
                q[start : start + count] = coordinates_to_q(joint, values[joint.name])
        assert np.abs(pin.difference(chain.model, q, np.array(at.q_full))).max() < 1e-12
    assert seen >= {"spherical", "planar", "floating", "universal", "prismatic"}


def limited(chain: ClosedChain, name: str, lower: float, upper: float) -> ClosedChain:
    """The robot with other limits of one joint."""
    joints = tuple(
        replace(joint, limits=replace(joint.limits, lower=lower, upper=upper)) if joint.name == name else joint
        for joint in chain.description.joints
    )
    return ClosedChain(replace(chain.description, joints=joints))


@pytest.mark.parametrize("name", ["left_shoulder", "left_elbow"])
def test_joints_at_a_limit_are_named(name: str) -> None:
    chain = load("fivebar")
    (value,) = coordinates_of(chain, chain.home)[name]
    for lower, upper, wanted in ((-0.01, 0.01, []), (-1e-3, 2.0, [name]), (-2.0, 1e-3, [name])):
        tight = limited(chain, name, value + lower, value + upper)
        assert at_limits(tight, coordinates_of(tight, tight.home)) == wanted
