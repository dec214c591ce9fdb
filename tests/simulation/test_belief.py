"""Whether a run can be believed: each sign notices what it is there for, and only that."""

from __future__ import annotations

import numpy as np
import pytest
from kit.runs import made

from cutjoint.errors import InputError
from cutjoint.robots import load
from cutjoint.simulation import ConstrainedPlant, run
from cutjoint.simulation.belief import verdict_of
from cutjoint.simulation.reaction_samples import sampled_reactions
from cutjoint.simulation.result import Result, result_of
from cutjoint.simulation.summary import figures_of, setting_rows
from cutjoint.tolerances import RUN_DRIFT, RUN_GAP, RUN_OPEN, RUN_SATURATED, RUN_STRAYED, RUN_WRONG

LINE = np.linspace(0.0, 1.0, 60)


def grades(result: Result) -> dict[str, str | None]:
    return {one.name: one.grade for one in verdict_of(result).signs}


def test_a_good_run_is_said_to_be_good_and_what_was_not_looked_at_too():
    verdict = verdict_of(made(kinetic=LINE, work=LINE))
    assert verdict.grade == "good"
    assert "can be believed" in verdict.sentence
    assert "limits of the joints" in verdict.sentence


@pytest.mark.parametrize(
    ("size", "grade"), [(0.99 * RUN_GAP.value, "good"), (1.01 * RUN_GAP.value, "half"), (1.01 * RUN_OPEN.value, "bad")]
)
@pytest.mark.parametrize("column", [0, 1])
def test_open_loops_are_noticed_by_the_length_of_the_robot(size, grade, column):
    gap = np.zeros((60, 2))
    tool = np.full((60, 3), 5.0 / np.sqrt(3.0))  # 5 m away from the world's origin
    gap[30, column] = size * (5.0 if column == 0 else 1.0)
    assert grades(made(gap=gap, tool=tool))["loop gap"] == grade


@pytest.mark.parametrize(
    ("drift", "grade"),
    [(0.9 * RUN_DRIFT.value, "good"), (1.1 * RUN_DRIFT.value, "half"), (1.1 * RUN_WRONG.value, "bad")],
)
def test_energy_that_came_from_nowhere_is_noticed(drift, grade):
    result = made(kinetic=(1.0 + drift) * LINE, work=LINE)
    verdict = verdict_of(result)
    assert grades(result)["energy balance"] == verdict.grade == grade
    assert ("cannot be believed" in verdict.sentence) == (grade == "bad")
    assert ("with care" in verdict.sentence) == (grade == "half")


def test_long_steps_are_noticed():
    tool = np.full((60, 3), 1.0 / np.sqrt(3.0))
    for factor, grade in ((0.9, "good"), (1.1, "half")):
        assert grades(made(tool=tool, about={"strayed": factor * RUN_STRAYED.value}))["steps strayed"] == grade
    assert "steps strayed" not in grades(made(tool=tool))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("at", "grade"), [(1, "good"), (30, "half")])
def test_saturation_is_a_share_of_the_time_whichever_way_it_pushes(sign, at, grade):
    time = np.concatenate([[0.0], np.linspace(0.5 * RUN_SATURATED.value, 1.0, 59)])
    effort = np.zeros((60, 3))
    effort[:at, 1] = sign * 8.0
    result = made(time=time, effort=effort, about={"limits": [9.0, 8.0, 9.0]})
    assert grades(result)["actuators at their limits"] == grade
    assert "actuators at their limits" not in grades(made(effort=effort))


def test_of_hardware_the_command_is_looked_at_not_what_gears_leave_of_it():
    command = np.full((60, 3), 8.0)
    found = grades(made(effort=np.zeros((60, 3)), command=command, about={"limits": 8.0}))
    assert found["actuators at their limits"] == "half"


@pytest.fixture(scope="module")
def fall():
    """A four-bar that falls for a moment, and the robot."""
    chain = load("fourbar")
    return run(ConstrainedPlant(chain), duration=0.05, every=0.01), chain


def test_joints_beyond_their_limits_are_noticed(fall):
    result, chain = fall
    assert {one.name: one.grade for one in verdict_of(result, chain).signs}["limits of the joints"] == "good"
    names = [name for name, _ in result.about["joints"]]
    limited = next(one for one in chain.description.joints if one.type.limited and one.limits.upper is not None)
    q_full = np.array(result.q_full)
    q_full[2, names.index(limited.name)] = limited.limits.upper + 0.25
    sign = {
        one.name: one for one in verdict_of(result_of(result.columns | {"q_full": q_full}, result.about), chain).signs
    }
    assert sign["limits of the joints"].grade == "half"
    assert f"{limited.name} by 0.25 rad" in sign["limits of the joints"].found


def test_a_run_names_the_joints_of_its_configurations(fall):
    result, chain = fall
    assert [name for name, _ in result.about["joints"]] == list(chain.model.names)[1:]


def test_reactions_are_not_told_of_a_robot_with_other_masses(fall):
    result, chain = fall
    found = sampled_reactions(result, chain, 3)
    assert len(found.time) <= 3
    with pytest.raises(InputError, match="payload"):
        sampled_reactions(result, chain.with_payload(0.01), 3)


def test_a_result_that_tells_nothing_of_itself_is_still_summed_up():
    bare = result_of(made().columns, {})
    assert figures_of(bare)["samples"] == 60
    assert dict(setting_rows(bare))["gains"] == "none"
    assert list(figures_of(bare)["effort_peak"]) == ["q1", "q2", "q3"]
