"""MuJoCo's own springs, dampers, rotors and friction agree with those of the chain, and notice another robot's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.held_up import held_up
from kit.physics import with_any_physics
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import Comparison, SampledState, sample_states
from cutjoint.description import Bushing, Joint, JointPhysics, RobotDescription, load_description
from cutjoint.engines import mujoco as engine
from cutjoint.engines.compare import compare_with_mujoco
from cutjoint.engines.natural import natural
from cutjoint.errors import InputError

pytest.importorskip("mujoco", reason="MuJoCo is an optional extra")


def physical(name: str, seed: int, scale: float = 1.0) -> RobotDescription:
    """A shipped robot with random physics, springs and dampers of the size of `scale`.

    Its rotors weigh about as much as its links: where one outweighs all else, states count as singular and are not
    sampled.
    """
    rng = np.random.default_rng(seed)
    robot = with_any_physics(load_description(name), rng, scale, stops=True)
    heaviest = max(link.inertial.mass for link in robot.links if link.inertial)
    length = ClosedChain(load_description(name)).length

    def lighter(joint: Joint) -> Joint:
        size = heaviest * (1.0 if joint.type.slides else length**2) * rng.uniform(0.1, 0.3)
        rotor = size / joint.physics.gear**2 if joint.type.single and joint.physics.rotor else 0.0
        return replace(joint, physics=replace(joint.physics, rotor=rotor))

    return held_up(replace(robot, joints=tuple(map(lighter, robot.joints))), rng)


@pytest.mark.parametrize("seed", few(range(5), 0))
@pytest.mark.parametrize("name", few(["fourbar", "fivebar", "stewart"], "fourbar"))
def test_mujoco_agrees(name: str, seed: int) -> None:
    chain = ClosedChain(physical(name, seed))
    compare_with_mujoco(chain, list(sample_states(chain, 10, seed))).require()


@pytest.fixture(scope="module")
def moving() -> tuple[ClosedChain, Sequence[SampledState]]:
    joints = [
        replace(
            joint,
            physics=JointPhysics(2.0, 3.0, 1.0, 4.0, 0.3, 0.01, 5.0, 30.0, 1.0),
            limits=replace(joint.limits, lower=-0.05, upper=0.05),
        )
        if joint.type.limited
        else joint
        for joint in load_description("fivebar").joints
    ]
    chain = ClosedChain(replace(load_description("fivebar"), joints=tuple(joints)))
    return chain, list(sample_states(chain, 5, 0))


def compared(
    chain: ClosedChain, states: Sequence[SampledState], joints: Sequence[Joint], patch: pytest.MonkeyPatch
) -> Comparison:
    """The comparison where MuJoCo is given other joints than the chain."""
    given = replace(chain.description, joints=tuple(joints))
    patch.setattr(engine, "natural", lambda _, scale: natural(given, scale))
    return compare_with_mujoco(chain, states)


NOTICED = {
    "damping": "springs, dampers and friction of the tree",
    "friction": "springs, dampers and friction of the tree",
    "friction_speed": "springs, dampers and friction of the tree",
    "stiffness": "potential energy",
    "rest": "potential energy",
    "rotor": "mass matrix of the tree",
    "gear": "mass matrix of the tree",
    "stop_stiffness": "potential energy",
    "stop_damping": "springs, dampers and friction of the tree",
}


def test_a_robot_agrees_with_itself(
    moving: tuple[ClosedChain, Sequence[SampledState]], monkeypatch: pytest.MonkeyPatch
) -> None:
    chain, states = moving
    assert compared(chain, states, chain.description.joints, monkeypatch).passes


@pytest.mark.parametrize("key", NOTICED)
def test_a_part_in_a_million_is_noticed(
    key: str, moving: tuple[ClosedChain, Sequence[SampledState]], monkeypatch: pytest.MonkeyPatch
) -> None:
    chain, states = moving
    first = next(one for one in chain.description.joints if one.type.single)
    changed = replace(first, physics=replace(first.physics, **{key: getattr(first.physics, key) * (1.0 + 1e-6)}))
    joints = [changed if one is first else one for one in chain.description.joints]
    rows = {row.quantity: row for row in compared(chain, states, joints, monkeypatch).rows}
    assert not rows[NOTICED[key]].passes


@pytest.mark.parametrize("scale", few([1e-3, 1e3]))
def test_of_any_size(scale: float) -> None:
    chain = ClosedChain(physical("fourbar", 7, scale))
    compare_with_mujoco(chain, list(sample_states(chain, 5, 0))).require()


def with_cut(name: str, **changed: Any) -> RobotDescription:
    """A shipped robot whose first cut does something by itself."""
    robot = load_description(name)
    return replace(robot, cuts=(replace(robot.cuts[0], **changed), *robot.cuts[1:]))


@pytest.mark.parametrize("name", few(["fourbar", "fivebar", "stewart"], "fourbar"))
@pytest.mark.parametrize("friction_speed", few([1e-3, 0.1, 10.0], 10.0))
def test_cuts_do_what_they_do_in_mujoco(name: str, friction_speed: float) -> None:
    """Turns about an axis, and balls; MuJoCo has the frames, the formulas are its comparison's own."""
    rest = 0.0 if name == "stewart" else 0.4
    chain = ClosedChain(with_cut(name, physics=JointPhysics(0.3, 0.2, friction_speed, 5.0, rest)))
    states = list(sample_states(chain, 10, 0))
    compare_with_mujoco(chain, states).require()
    free = chain.description.ideal()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "natural", lambda _, scale: natural(free, scale))
        rows = {row.quantity: row.passes for row in compare_with_mujoco(chain, states).rows}
    assert not rows["springs, dampers and friction of the tree"]
    assert not rows["potential energy"]


def test_bushings_are_refused_by_name() -> None:
    robot = with_cut("fivebar", bushing=Bushing(1e3, 1.0, 1e3, 1.0))
    with pytest.raises(InputError, match=f"cut '{robot.cuts[0].name}' has a bushing"):
        engine.MujocoRobot(ClosedChain(robot))
