"""Coordinates by name: read from any posture, printed, and given back as a home or to `close`."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.shipped import DETERMINED, SHIPPED

from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import JOINTS, coordinates_to_q
from cutjoint.description import Frame, Home, Joint, JointType, Link, RobotDescription
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Actuator, Layout, Posture, actuated_values

ONE_OF_EACH = [kind for kind in JointType if kind.moves]


@pytest.mark.parametrize("kind", ONE_OF_EACH)
def test_what_is_stored_gives_the_coordinates_back(kind: JointType) -> None:
    """Also where pitch is a quarter of a turn: the coordinates may be others there, not where they put the body."""
    rng, row = np.random.default_rng(0), JOINTS[kind]
    assert (row.to_q is None) == (row.from_q is None)
    joint = Joint("j", kind, "a", "b")
    for trial in range(50):
        given = rng.uniform(-1.5, 1.5, kind.dof)
        if trial % 5 == 4 and kind.dof > 1:
            given[-2] = np.pi / 2 * rng.choice([-1.0, 1.0])
        q = coordinates_to_q(joint, tuple(given))
        found = q if row.from_q is None else row.from_q(q)
        if trial % 5 != 4:
            np.testing.assert_allclose(found, given, atol=1e-14)
        again = coordinates_to_q(joint, tuple(found))
        np.testing.assert_allclose(again * np.sign(again[-1] or 1.0), q * np.sign(q[-1] or 1.0), atol=1e-14)


@pytest.mark.parametrize("name", SHIPPED)
def test_every_joint_has_its_value_by_name(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    moving = {joint.name: joint for joint in chain.description.joints if joint.type.moves}
    for state in kit.random_states(chain, 3):
        at = state.at
        assert at.names[: chain.n] == chain.description.actuators
        assert set(at.names) == set(at) == set(moving)
        assert len(at.names) == len(moving)
        assert at.actuated == dict(zip(chain.description.actuators, at.q.tolist(), strict=True))
        for joint in at:
            value, kind = at[joint], moving[joint].type
            index = chain.model.getJointId(joint)
            own = at.q_full[chain.model.idx_qs[index] :][: chain.model.nqs[index]]
            if kind.single:
                assert type(value) is float
                assert value == own[0]
            else:
                assert value.shape == (kind.dof,)
                assert not value.flags.writeable
            back = coordinates_to_q(moving[joint], value if kind.single else tuple(value))
            np.testing.assert_allclose(back * np.sign(back[-1] * own[-1] or 1.0), own, atol=1e-14)


@pytest.mark.parametrize("name", DETERMINED)
def test_the_values_are_a_home_posture(name: str, kit: Any) -> None:
    """What is read by name, put under [home.NAME], closes to the same posture."""
    chain = kit.robot(name)
    for state in kit.random_states(chain, 2, seed=7):
        passive = {one: v if type(v := state.at[one]) is float else tuple(v) for one in state.at.names[chain.n :]}
        there = replace(chain.description, homes=(Home("there", state.at.actuated, passive),))
        found = ClosedChain(there).home
        np.testing.assert_allclose(found.q_full, state.at.q_full, atol=1e-11)


def test_unknown_names_suggest_the_nearest(kit: Any) -> None:
    home = kit.robot("stewart").home
    with pytest.raises(UnknownNameError, match="coordinate of stewart 'leg1_slid'; did you mean 'leg1_slide'"):
        home["leg1_slid"]
    with pytest.raises(InputError, match="a coordinate of stewart has a name, found the number 0"):
        home[0]
    nameless = Posture(home.q, home.q_full)
    assert nameless.names == ()
    assert repr(nameless).startswith("Posture(q=(0.52")
    with pytest.raises(InputError, match="no names"):
        nameless["leg1_slide"]


@pytest.mark.parametrize("name", SHIPPED)
def test_postures_of_one_robot_share_their_layout(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    at = kit.random_states(chain, 1)[0].at
    made = [at, chain.posture(at), chain.assemble(at)]
    made += chain.assembly_modes(starts=2) if name in DETERMINED else ()
    assert all(one.layout is chain.home.layout for one in made)


@pytest.mark.parametrize("name", SHIPPED)
def test_copies_keep_the_names(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    at = kit.random_states(chain, 1)[0].at
    at.names  # noqa: B018  (what is found once and kept must not hinder a copy)
    several = pickle.loads(pickle.dumps([at, chain.home]))
    assert several[0].layout is several[1].layout
    for other in (several[0], copy.copy(at), copy.deepcopy(at)):
        assert other.layout == at.layout
        assert repr(other) == repr(at)
        assert all(np.array_equal(other[one], at[one]) for one in at)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_posture_prints_every_name_value_and_unit(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 2):
        head, *lines = str(state.at).splitlines()
        assert head.startswith(f"posture of {chain.name}, closed to ")
        assert max(map(len, [head, *lines])) <= 80
        begins = [number for number, line in enumerate(lines) if not line.startswith("   ")]
        whole = [" ".join(lines[a:b]).split() for a, b in zip(begins, [*begins[1:], len(lines)], strict=True)]
        assert tuple(words[0] for words in whole) == state.at.names
        for words in whole:
            joint = chain.description.joint(words[0])
            assert ("actuated" in words) == (joint.name in chain.description.actuators)
            numbers = [float(word.strip(",")) for word in words[1:] if word[0] in "-0123456789"]
            np.testing.assert_allclose(numbers, np.atleast_1d(state.at[joint.name]), rtol=1e-5, atol=1e-12)
            units = {one.unit for one in joint.type.coordinates}
            assert {word.strip(",") for word in words[1:]} & {"m", "rad"} == units


@pytest.mark.parametrize("seed", range(5))
def test_long_names_are_printed_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = ["".join(rng.choice(list("abc-_ é"), rng.integers(1, 120))).strip() or "x" for _ in range(4)]
    names = [f"{number}{name}" for number, name in enumerate(names)]
    kinds = rng.permutation(ONE_OF_EACH)[:4]
    links = [Link("base"), *(Link(f"link{number}") for number in range(4))]
    joints = [
        Joint(name, JointType(kind), "base", f"link{number}")
        for number, (name, kind) in enumerate(zip(names, kinds, strict=True))
    ]
    at = ClosedChain(RobotDescription("long", tuple(links), tuple(joints), tool=Frame("link1"))).home
    text = str(at)
    assert all(f"  {name if len(name) <= 32 else name[:12]}" in text for name in names)
    assert all(len(line) <= 80 or any(name in line and len(name) > 20 for name in names) for line in text.splitlines())


@pytest.mark.parametrize("name", DETERMINED)
def test_closing_by_name_is_closing(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(1)
    for state in kit.random_states(chain, 3):
        given = dict(rng.permutation(list(state.at.actuated.items())).tolist())
        given = {joint: float(value) for joint, value in given.items()}
        np.testing.assert_array_equal(chain.close(given).q_full, chain.close(state.at.q).q_full)


@pytest.mark.parametrize("seed", range(20))
def test_values_by_name_are_in_order_or_refused(seed: int) -> None:
    rng = np.random.default_rng(seed)
    actuators = tuple(Actuator(f"motor{k}", ("rotation", "translation")[k % 2]) for k in range(rng.integers(1, 8)))
    values = rng.normal(size=len(actuators))
    pairs = [(one.name, value) for one, value in zip(actuators, values, strict=True)]
    rng.shuffle(pairs)
    np.testing.assert_array_equal(actuated_values(dict(pairs), actuators), values)
    np.testing.assert_array_equal(actuated_values(values, actuators), values)
    (left, _), *rest = pairs
    with pytest.raises(InputError, match=f"lacks {left}; to move only some, take the others from a posture"):
        actuated_values(dict(rest), actuators)
    with pytest.raises(UnknownNameError, match="unknown actuator 'motr0'; did you mean 'motor0'"):
        actuated_values({**dict(pairs), "motr0": 1.0}, actuators)
    for wrong in (np.nan, None, "far", [1.0, 2.0]):
        with pytest.raises(InputError, match=r"^q must"):
            actuated_values({**dict(pairs), left: wrong}, actuators)


def test_numbers_have_their_names_and_units() -> None:
    motor = Actuator("motor", "rotation")
    layout = Layout.of_numbers("toy", (motor,), ("x[m]", "side", "motor[rad]"))
    at = Posture(np.array([0.25]), np.array([1.0, -1.0, 0.25]), (0.0, 0.0), layout)
    assert at.names == ("motor", "x", "side")
    assert [at[name] for name in at] == [0.25, 1.0, -1.0]
    assert [line.split() for line in str(at).splitlines()[1:]] == [
        ["motor", "0.25", "rad", "actuated"],
        ["x", "1", "m"],
        ["side", "-1"],
    ]
