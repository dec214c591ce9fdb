"""The puppet led by its tool: rotations, dragging and limits, over robots of any size, standing anywhere."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.led import with_limits
from kit.led_robots import LED, somewhere
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.mechanism.task import NAMES
from cutjoint.robots import load
from cutjoint.viewer.hand.lead import POINT, tool_pose
from cutjoint.viewer.hand.panel import ControlPanel
from cutjoint.viewer.hand.puppet import Puppet
from cutjoint.viewer.hand.sampling import FURTHEST_TURN
from cutjoint.viewer.picture.figure import Figure

STANDING = [(name, seed) for name in LED for seed in (0, 1)]


def puppet_of(chain: ClosedChain) -> Puppet:
    return Puppet(chain, Figure(chain, chain.home).radius)


def panel_of(puppet: Puppet) -> ControlPanel:
    return ControlPanel(puppet, Figure(puppet.chain, puppet.chain.home))


@pytest.fixture
def puppet(request: pytest.FixtureRequest, tmp_path: Path) -> Puppet:
    name, seed = request.param
    return puppet_of(somewhere(name, seed, tmp_path, np.random.default_rng(seed)).chain)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(2)


def sizes(puppet: Puppet) -> np.ndarray:
    """What the six coordinates of a tool are measured by."""
    return np.array([puppet.chain.length] * 3 + [1.0] * 3)


def misses(puppet: Puppet, wanted: dict[int, float]) -> float:
    found, size = puppet.lead.coordinates(puppet.at), sizes(puppet)
    assert set(found) == set(wanted)
    return max(abs(found[row] - value) / size[row] for row, value in wanted.items())


@pytest.mark.parametrize("puppet", STANDING, indirect=True)
def test_a_coordinate_of_the_task_is_led_and_the_others_stay(puppet: Puppet, rng: np.random.Generator) -> None:
    task = puppet.lead.task
    assert task is not None
    assert puppet.lead.rows == ([] if puppet.chain.name.startswith("pan_tilt") else list(task.rows))
    wanted = puppet.lead.coordinates(puppet.at)
    for row in puppet.lead.rows:
        wanted[row] += 0.08 * sizes(puppet)[row] * rng.choice([-1.0, 1.0])
        puppet.pull(row, wanted[row])
        assert puppet.stop is None
        assert misses(puppet, wanted) < 1e-9
        assert not puppet.chain.limit_violations(puppet.at)
    there = puppet.at
    home = puppet.lead.coordinates(puppet.chain.home)
    for row in puppet.lead.rows:
        puppet.pull(row, home[row])
    np.testing.assert_allclose(puppet.at.q, puppet.chain.home.q, atol=1e-7 * max(puppet.chain.length, 1.0))
    assert not puppet.lead.rows or np.abs(there.q - puppet.at.q).max() > 1e-3 * min(puppet.chain.length, 1.0)


@pytest.mark.parametrize("puppet", few([(name, 1) for name in LED], ("planar_3rrr", 1), ("tripod", 1)), indirect=True)
def test_the_panel_has_a_slider_for_each_of_them(puppet: Puppet) -> None:
    panel = panel_of(puppet)
    for _ in range(2):
        sliders = panel.tool_sliders()
        assert [slider.index for slider in sliders] == puppet.lead.rows
        for slider in sliders:
            assert (slider.name, slider.unit) == (NAMES[slider.index], "m" if slider.index in POINT else "rad")
            assert slider.lower < puppet.lead.coordinates(puppet.at)[slider.index] < slider.upper
            if slider.unit == "rad":
                assert -FURTHEST_TURN <= slider.lower < slider.upper <= FURTHEST_TURN
            low, high = puppet.workspace.ranges.get(slider.index, (slider.lower, slider.upper))
            assert slider.lower <= low < high <= slider.upper
        for _ in puppet.sample_workspace(1):
            pass
    axes = panel.controls()["tool_axes"]
    assert puppet.lead.task is not None
    assert bool(axes) == (puppet.lead.task.axes == "tool")


@pytest.mark.parametrize("puppet", STANDING, indirect=True)
def test_dragging_brings_the_point_there_and_turns_nothing_that_is_led(
    puppet: Puppet, rng: np.random.Generator
) -> None:
    chain, task = puppet.chain, puppet.lead.task
    assert task is not None
    if not puppet.lead.draggable:
        assert np.abs(chain.tool(chain.home).jacobian).max() < 1e-9
        with pytest.raises(InputError, match="cannot be dragged"):
            puppet.drag(np.zeros(3))
        return
    start, before = tool_pose(chain, chain.home), puppet.lead.coordinates(chain.home)
    assert start is not None
    for _ in range(3):
        point = start.position + 0.06 * chain.length * rng.normal(size=3)
        puppet.drag(point)
        assert puppet.stop is None
        at = tool_pose(chain, puppet.at)
        assert at is not None
        left = point - at.position
        if puppet.lead.rows and puppet.lead.rows[0] in POINT:
            led = [row for row in puppet.lead.rows if row in POINT]
            assert np.abs((task.basis.T @ left)[led]).max() < 1e-9 * chain.length
            assert misses(puppet, {**before, **{row: puppet.lead.coordinates(puppet.at)[row] for row in led}}) < 1e-9
        else:  # on its surface: nowhere nearer
            across = chain.tool(puppet.at).jacobian
            assert np.abs(across.T @ left).max() < 1e-3 * np.linalg.norm(across) * puppet.radius
            assert np.linalg.norm(left) < np.linalg.norm(point - start.position) + 1e-9 * chain.length


@pytest.mark.parametrize("name", ["fourbar", "pan_tilt"])
def test_a_point_on_a_curve_or_a_surface_comes_round_to_the_far_side(name: str, tmp_path: Path) -> None:
    chain = load(name) if name == "fourbar" else somewhere(name, 0, tmp_path, np.random.default_rng(0)).chain
    puppet = puppet_of(chain)
    start = puppet.tool_position(puppet.at)
    goal = puppet.tool_position(chain.close(chain.home.q + 0.9))
    assert start is not None
    assert goal is not None
    for share in np.linspace(0.0, 1.0, 12):
        puppet.drag(start + share * (goal - start))
    at = puppet.tool_position(puppet.at)
    assert np.linalg.norm(goal - at) < 2e-3 * puppet.radius


@pytest.mark.parametrize(
    "puppet",
    few([(name, 1) for name in LED if name not in ("pan_tilt", "stewart")], ("delta", 1), ("tripod", 1)),
    indirect=True,
)
def test_pulled_too_far_it_stops_inside_and_says_why(puppet: Puppet) -> None:
    for row in puppet.lead.rows[::2]:
        puppet.go_home()
        puppet.pull(row, 3.0 * puppet.radius if row in POINT else FURTHEST_TURN)
        assert max(puppet.at.gap) <= 1e-9 * max(puppet.chain.length, 1.0)
        if puppet.stop is None:  # legs that are as long as you like
            assert misses(puppet, {**puppet.lead.coordinates(puppet.at), row: 3.0 * puppet.radius}) < 1e-9 or row > 2
            continue
        assert puppet.stop.kind in ("workspace", "singularity")
        assert f"Stopped at tool {NAMES[row]} " in puppet.stop.text
        assert ("°" in puppet.stop.text.split(":")[0]) == (row not in POINT)


@pytest.mark.parametrize("name", ["stewart", "tripod", "planar_3rrr", "serial_wrist"])
def test_a_turn_stops_at_the_limit_of_a_joint_and_can_come_back(name: str, tmp_path: Path) -> None:
    standing = somewhere(name, 0, tmp_path, np.random.default_rng(0))
    row = standing.chain.task.rows[-1]
    free = puppet_of(standing.chain)
    free.pull(row, 0.2)
    assert free.stop is None
    moved = np.abs(free.at.q - standing.chain.home.q)
    index = int(moved.argmax())
    joint, home = standing.chain.actuators[index].name, float(standing.chain.home.q[index])
    half = 0.5 * float(moved[index])
    chain = ClosedChain(with_limits(standing.description, {joint: (home - half, home + half)}))
    puppet = puppet_of(chain)
    puppet.pull(row, 0.2)
    assert puppet.stop is not None
    assert puppet.stop.kind == "limit"
    assert joint in puppet.stop.text
    assert 0.0 < puppet.lead.coordinates(puppet.at)[row] < 0.2
    assert abs(abs(puppet.at.q[index] - home) - half) < 2e-3 * max(chain.length, 1.0)
    assert joint in panel_of(puppet).state()["at_limit"]
    puppet.pull(row, 0.0)
    assert puppet.stop is None
    np.testing.assert_allclose(puppet.at.q, chain.home.q, atol=1e-8)


def test_a_joint_that_starts_beyond_its_limit_may_come_back_but_not_go_further() -> None:
    chain = load("fivebar")
    home = float(chain.home.q[0])
    beyond = ClosedChain(with_limits(chain.description, {"left_shoulder": (home - 1.0, home - 0.1)}))
    puppet = puppet_of(beyond)
    assert panel_of(puppet).state()["at_limit"] == ["left_shoulder"]
    puppet.pull(2, puppet.lead.coordinates(puppet.at)[2] - 0.02)
    assert (puppet.stop is None) == (beyond.close(puppet.at.q).q[0] < home)
    puppet.go_home()
    moves = []
    for way in (-0.02, 0.02):
        puppet.go_home()
        puppet.pull(0, puppet.lead.coordinates(puppet.at)[0] + way)
        moves.append((puppet.stop is None, float(puppet.at.q[0]) - home))
    assert all(change <= 1e-6 for _, change in moves)
    assert {free for free, _ in moves} == {True, False}


def test_a_robot_whose_task_cannot_be_told_is_pulled_by_its_point(tmp_path: Path) -> None:
    from kit.built import built
    from kit.mechanisms import MECHANISMS

    chain = built(MECHANISMS["planar_3rrr"](np.random.default_rng(5)).plan, tmp_path)[0]
    with pytest.raises(InputError, match="cannot be told"):
        _ = chain.task
    puppet = puppet_of(chain)
    assert puppet.lead.task is not None
    assert puppet.lead.task.names == ("x", "y", "z")
    assert puppet.lead.draggable
    puppet.drag(np.asarray(puppet.tool_position(puppet.at)) + 0.01)
    assert max(puppet.at.gap) <= 1e-9


def test_a_robot_without_a_tool_has_nothing_to_pull() -> None:
    chain = ClosedChain(replace(load("fivebar").description, tool=None))
    puppet = puppet_of(chain)
    panel = panel_of(puppet)
    assert panel.tool_sliders() == []
    assert not puppet.lead.draggable
    assert panel.state()["coordinates"] == {}
    with pytest.raises(InputError, match="want of a tool"):
        puppet.pull(0, 0.1)


@pytest.mark.parametrize("puppet", [("fivebar", 0), ("planar_3rrr", 1)], indirect=True)
def test_a_working_mode_is_chosen_with_all_that_is_led_held(puppet: Puppet) -> None:
    for row in puppet.lead.rows:
        puppet.pull(row, puppet.lead.coordinates(puppet.at)[row] + 0.05 * sizes(puppet)[row])
    wanted = puppet.lead.coordinates(puppet.at)
    puppet.find_modes()
    for index in range(len(puppet.modes)):
        puppet.choose(index)
        assert puppet.stop is None
        assert misses(puppet, wanted) < 1e-9


def test_the_passive_joints_are_listed_with_their_values(tmp_path: Path) -> None:
    for name in ("stewart", "omega3", "cpm", "fivebar"):
        chain = load(name)
        panel = panel_of(puppet_of(chain))
        listed, state = panel.controls()["passive"], panel.state()
        assert len(listed) == len(state["passive"]) > 0
        for one, value in zip(listed, state["passive"], strict=True):
            joint = chain.description.joint(one["joint"])
            assert joint.name not in chain.description.actuators
            if joint.type.single:
                index = chain.model.idx_qs[chain.model.getJointId(joint.name)]
                assert (one["name"], value) == (joint.name, chain.home.q_full[index])
                assert one["unit"] == ("m" if joint.type.slides else "rad")
