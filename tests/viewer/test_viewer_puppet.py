from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.viewer.hand.live import parse
from cutjoint.viewer.hand.panel import ControlPanel
from cutjoint.viewer.hand.puppet import Puppet
from cutjoint.viewer.hand.walk import NEAR_SINGULAR
from cutjoint.viewer.picture.figure import Figure

STEPS = 3


@pytest.fixture
def puppet(chain: ClosedChain) -> Puppet:
    return Puppet(chain, Figure(chain, chain.home).radius)


def panel_of(puppet: Puppet) -> ControlPanel:
    return ControlPanel(puppet, Figure(puppet.chain, puppet.chain.home))


def elbows(puppet: Puppet) -> list[float]:
    """What tells the working mode: sine of each limb's elbow, 0 where upper arm and rods are in line."""
    model, q = puppet.chain.model, puppet.at.q_full
    name = {"cpm": "limb{}_elbow", "omega3": "bar{}"}[puppet.chain.description.name]
    return [math.sin(q[model.idx_qs[model.getJointId(name.format(i))]]) for i in (1, 2, 3)]


@pytest.mark.slow
def test_no_branch_flips_and_no_loop_opens_over_the_range_of_every_slider(puppet: Puppet) -> None:
    home = puppet.chain.home
    sweeps = [(puppet.actuate, i, s) for i, s in enumerate(panel_of(puppet).actuated_sliders())]
    sweeps += [(puppet.pull, i, s) for i, s in enumerate(panel_of(puppet).tool_sliders())]
    signs, moved = np.sign(elbows(puppet)), 0.0
    for move, index, slider in sweeps:
        puppet.go_home()
        middle = float(home.q[index] if move == puppet.actuate else panel_of(puppet).state()["tool"][index])
        for value in [
            *np.linspace(middle, slider.lower, STEPS),
            *np.linspace(slider.lower, slider.upper, STEPS),
            middle,
        ]:
            move(index, float(value))
            assert max(puppet.at.gap) <= 1e-9
            assert (np.sign(elbows(puppet)) == signs).all()
            moved = max(moved, float(np.abs(puppet.at.q - home.q).max()))
        np.testing.assert_allclose(puppet.at.q_full, home.q_full, atol=1e-7)
    assert moved > 0.2


def test_actuators_and_tool_move_each_other(puppet: Puppet) -> None:
    before = puppet.tool_position(puppet.at)
    puppet.actuate(0, float(puppet.at.q[0]) + 0.05)
    pushed = puppet.tool_position(puppet.at)
    assert before is not None
    assert pushed is not None
    assert np.linalg.norm(pushed - before) > 0.001
    q = puppet.at.q
    puppet.go_home()
    for axis in range(3):
        puppet.pull(axis, float(pushed[axis]))
    np.testing.assert_allclose(puppet.at.q, q, atol=1e-9)


def test_an_actuator_stops_at_its_limit_and_says_so(puppet: Puppet) -> None:
    chain = puppet.chain
    for index, slider in enumerate(panel_of(puppet).actuated_sliders()):
        puppet.go_home()
        for end in (slider.lower, slider.upper):
            puppet.actuate(index, end + math.copysign(5.0, end - float(chain.home.q[index])))
            assert puppet.stop is not None
            assert slider.name in puppet.stop.text
            assert slider.lower - 1e-9 <= puppet.at.q[index] <= slider.upper + 1e-9
            if puppet.stop.kind == "limit" and "joint" not in puppet.stop.text:
                assert puppet.at.q[index] == end


@pytest.mark.slow
def test_a_move_that_ends_early_ends_where_one_step_more_is_refused(puppet: Puppet) -> None:
    for axis in range(3):
        for way in (-1.0, 1.0):
            puppet.go_home()
            puppet.pull(axis, way)
            stop, at = puppet.stop, puppet.tool_position(puppet.at)
            assert stop is not None
            assert stop.kind in ("limit", "workspace", "singularity")
            assert "Stopped at tool" in stop.text
            assert at is not None
            assert not puppet.chain.limit_violations(puppet.at)
            puppet.pull(axis, float(at[axis]) + math.copysign(5e-3, way))
            assert puppet.stop is not None
            after = puppet.tool_position(puppet.at)
            assert after is not None
            assert abs(after[axis] - at[axis]) < 5e-3


def test_it_stops_short_of_a_singularity_and_can_leave_again(puppet: Puppet) -> None:
    sliders = panel_of(puppet).actuated_sliders()
    reached = []
    for pick in [(1, 1, 1), (0, 0, 0), (1, 0, 1)]:
        puppet.go_home()
        for index, (end, slider) in enumerate(zip(pick, sliders, strict=True)):
            puppet.actuate(index, slider.upper if end else slider.lower)
            report = puppet.chain.mobility(puppet.at)
            assert min(report.type1, report.type2) >= 0.9 * NEAR_SINGULAR
            if puppet.stop is not None and puppet.stop.kind != "limit":
                reached.append(puppet.stop.kind)
                stuck = float(puppet.at.q[index])
                puppet.actuate(index, stuck + 0.05 * (float(puppet.chain.home.q[index]) - stuck))
                assert puppet.at.q[index] != stuck
    if puppet.chain.description.name == "cpm":
        assert reached


def test_the_working_modes_are_distinct_hold_the_tool_and_are_kept(puppet: Puppet) -> None:
    puppet.find_modes()
    home = puppet.tool_position(puppet.chain.home)
    names = panel_of(puppet).mode_names()
    assert len(set(names)) == len(names) == len(puppet.modes) > 1
    for index in range(len(puppet.modes)):
        puppet.choose(index)
        assert puppet.mode == index
        np.testing.assert_allclose(puppet.tool_position(puppet.at), home, atol=1e-9)
        assert panel_of(puppet).state()["mode"] == index
        assert max(puppet.at.gap) <= 1e-9
    puppet.go_home()
    assert puppet.mode == 0


def test_the_state_holds_the_chains_own_figures(puppet: Puppet) -> None:
    puppet.actuate(1, float(puppet.at.q[1]) + 0.03)
    state, chain = panel_of(puppet).state(), puppet.chain
    report = chain.mobility(puppet.at)
    assert (state["mobility"], state["rank"], state["rows"]) == (report.mobility, report.rank, report.rows)
    np.testing.assert_allclose(state["effort"], chain.terms(puppet.at).gravity)
    np.testing.assert_allclose(state["tool"], chain.tool(puppet.at).position, atol=1e-12)
    np.testing.assert_allclose([state["type1"], state["type2"]], [report.type1, report.type2])


def test_the_sampled_workspace_grows_around_home(puppet: Puppet) -> None:
    for _ in puppet.sample_workspace(8):
        pass
    home = puppet.tool_position(puppet.chain.home)
    assert puppet.workspace.box is not None
    assert (puppet.workspace.box[0] < home).all()
    assert (home < puppet.workspace.box[1]).all()
    for axis, slider in enumerate(panel_of(puppet).tool_sliders()):
        assert slider.lower < puppet.workspace.box[0][axis] < puppet.workspace.box[1][axis] < slider.upper


@pytest.mark.parametrize(("index", "value"), [(9, 0.0), (-1, 0.0), (0, math.nan), (0, math.inf)])
def test_nonsense_is_refused_and_nothing_moves(puppet: Puppet, index: int, value: float) -> None:
    for move in (puppet.actuate, puppet.pull):
        with pytest.raises(InputError):
            move(index, value)
    assert puppet.at is puppet.chain.home
    with pytest.raises(InputError):
        puppet.choose(99)


@pytest.mark.parametrize(
    "message",
    [
        {},
        {"move": "actuated"},
        {"move": "fly", "number": 1},
        {"move": "actuated", "number": -1},
        {"move": "actuated", "number": 1, "index": 0.5},
        {"move": "actuated", "number": True, "index": 0, "value": 0.1},
        {"move": "actuated", "number": 1, "index": 0, "value": "0.1"},
        {"move": "actuated", "number": 1, "index": 0, "value": math.nan},
        {"move": "actuated", "number": 1, "index": 0, "value": 1e300},
        {"move": "actuated", "number": 1, "index": 0, "value": 0.1, "eval": "alert(1)"},
        {"type": "set_control", "callback": "alert(1)"},
        {"move": ["actuated"], "number": 1},
        {"move": "drag", "number": 1},
        {"move": "drag", "number": 1, "point": [0.0, 0.1]},
        {"move": "drag", "number": 1, "point": [0.0, 0.1, math.nan]},
        {"move": "drag", "number": 1, "point": [0.0, 0.1, 1e300]},
        {"move": "drag", "number": 1, "point": [0.0, 0.1, True]},
        {"move": "drag", "number": 1, "point": "xyz"},
        {"move": "tool", "number": 1, "point": [0.0, 0.1, 0.2]},
    ],
)
def test_messages_that_make_no_sense_are_no_commands(message: dict[str, Any]) -> None:
    assert parse(1, message) is None


def test_a_sensible_message_is_a_command() -> None:
    drag = parse(3, {"move": "drag", "number": 8, "point": [0, 0.1, -0.2]})
    assert drag is not None
    assert (drag.kind, drag.point) == ("drag", (0.0, 0.1, -0.2))
    command = parse(3, {"move": "tool", "number": 7, "index": 2, "value": -0.25})
    assert command is not None
    assert (command.tab, command.number, command.kind, command.index, command.value) == (3, 7, "tool", 2, -0.25)
