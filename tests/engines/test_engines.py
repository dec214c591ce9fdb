"""Other engines agree with the closed chain, and notice a robot that is not the one they were given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import State, sample_states
from cutjoint.engines.compare import compare_with_mujoco
from cutjoint.engines.yourdfpy import compare_with_yourdfpy
from cutjoint.errors import InputError
from cutjoint.robots import PUBLISHED

pytest.importorskip("mujoco", reason="MuJoCo is an optional extra")


@pytest.fixture(scope="module", params=list(PUBLISHED))
def published(request: pytest.FixtureRequest) -> tuple[ClosedChain, Sequence[State]]:
    name = request.param
    chain = cutjoint.load(name, PUBLISHED[name].variant)
    return chain, list(sample_states(cutjoint.published(name), 60, 3))


def test_mujoco_agrees_to_its_own_softness(published: tuple[ClosedChain, Sequence[State]]) -> None:
    comparison = compare_with_mujoco(*published)
    assert comparison.samples == 60
    comparison.require()


def test_yourdfpy_puts_every_link_where_pinocchio_has_it(published: tuple[ClosedChain, Sequence[State]]) -> None:
    compare_with_yourdfpy(*published).require()


@pytest.mark.parametrize("name", ["fourbar", "fivebar", "stewart"])
def test_robots_without_a_paper(name: str) -> None:
    chain = cutjoint.load(name)
    states = list(sample_states(chain, 5, 0))
    compare_with_mujoco(chain, states).require()
    compare_with_yourdfpy(chain, states).require()


def test_mujoco_notices_another_mass(monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo is given a robot with one rod heavier by 1 %: masses and dynamics are off, directions are not."""
    from cutjoint.engines import mujoco as engine

    chain = cutjoint.load("cpm", "lumped")
    old = chain.description.link("limb2_distal").inertial
    assert old is not None
    heavier = chain.description.with_inertial("limb2_distal", replace(old, mass=1.01 * old.mass))
    write = engine.write
    monkeypatch.setattr(engine, "write", lambda _, path, to: write(heavier, path, to))
    comparison = compare_with_mujoco(chain, list(sample_states(cutjoint.published("cpm"), 5, 0)))
    failed = {row.quantity for row in comparison.rows if not row.passes}
    assert {"mass matrix of the tree", "bias of the tree", "forward dynamics, hard constraints"} <= failed
    assert "directions of the constraints" not in failed


def test_mujoco_says_which_joint_it_has_no_word_for() -> None:
    from cutjoint.engines.mujoco import MujocoRobot

    description = cutjoint.load("fourbar").description
    joint = next(joint for joint in description.joints if joint.name == "crank")
    universal = replace(joint, type=type(joint.type).UNIVERSAL, axis=np.array([0.0, 1.0, 0.0]))
    joints = tuple(universal if one.name == "crank" else one for one in description.joints)
    chain = ClosedChain(replace(description, joints=joints, actuators=(), cuts=(), homes=()))
    with pytest.raises(InputError, match="crank"):
        MujocoRobot(chain)
