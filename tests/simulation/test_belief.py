"""Whether a run can be believed: each sign notices what it is there for, and only that."""

from __future__ import annotations

import numpy as np
import pytest
from kit.runs import made

from cutjoint.errors import InputError
from cutjoint.robots import load
from cutjoint.simulation import Adaptive, ConstrainedPlant, Midpoint, RungeKutta4, run
from cutjoint.simulation.belief import verdict_of
from cutjoint.simulation.reaction_samples import sampled_reactions
from cutjoint.simulation.result import Result, result_of
from cutjoint.simulation.summary import figure_rows, figures_of, peaks_of, setting_rows
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


def tampered(result: Result, **columns: object) -> Result:
    return result_of(result.columns | columns, result.about)


@pytest.fixture(scope="module")
def pushed():
    """A four-bar that a clock pushes, and the robot."""
    chain = load("fourbar")
    return run(ConstrainedPlant(chain), lambda t, desired, q, v: [0.4], rate=200.0, duration=0.1), chain


def test_columns_that_are_of_one_run_agree_and_spoiled_ones_do_not(pushed):
    result, chain = pushed
    assert verdict_of(result, chain).grade == "good"
    for name in ("effort", "v", "time", "work", "tool"):
        for part in (0.5, 1.1):
            spoiled = tampered(result, **{name: part * result.columns[name]})
            found = {one.name: one for one in verdict_of(spoiled).signs}["columns agree"]
            assert found.grade == "bad", (name, part)
            assert "differ by" in found.found
    energies = {name: 1.1 * result.columns[name] for name in ("kinetic", "potential", "work")}
    assert grades(tampered(result, **energies))["columns agree"] == "bad"


def test_energies_are_held_against_the_robot_and_a_payload_is_told_but_no_fault(pushed):
    result, chain = pushed
    for robot, grade in ((chain, "good"), (chain.with_payload(0.01), None)):
        found = verdict_of(result, robot)
        assert {one.name: one.grade for one in found.signs}["energies of the robot"] == grade
        assert found.grade == "good"
        assert ("not looked at: energies of the robot" in found.sentence) == (grade is None)


def test_angles_that_start_again_at_a_turn_agree_with_their_speeds(pushed):
    result, _ = pushed
    jump = np.where(np.arange(len(result)) > 5, 2.0 * np.pi, 0.0)[:, None]
    assert grades(tampered(result, q=result.q - jump))["columns agree"] == "good"
    assert grades(tampered(result, q=result.q - 0.5 * jump))["columns agree"] == "bad"


def test_samples_too_few_to_show_the_motion_are_not_held_against_it(pushed):
    result, _ = pushed
    few = result_of({name: column[::4] for name, column in result.columns.items()}, result.about)
    assert grades(few)["columns agree"] is None
    bare = {name: value for name, value in result.about.items() if name != "steps"}
    assert grades(result_of(result.columns, bare))["columns agree"] is None


def test_gaps_are_those_of_the_configurations_whatever_their_column_says(pushed):
    result, chain = pushed
    q_full = np.array(result.q_full)
    q_full[7, -1] += 1e-3
    assert grades(tampered(result, q_full=q_full))["loop gap"] == "good"
    found = verdict_of(tampered(result, q_full=q_full), chain)
    assert {one.name: one.grade for one in found.signs}["loop gap"] == "bad"


def test_one_sample_has_no_balance_and_no_motion():
    found = grades(made(1, about={"steps": 0}))
    assert found["energy balance"] is None
    assert found["columns agree"] is None


def test_a_robot_that_stands_still_has_nothing_to_balance():
    rounded = np.full(60, 2.0)
    rounded[30:] += 1e-14
    assert grades(made(potential=rounded))["energy balance"] == "good"
    rounded[30:] += 1e-9
    assert grades(made(potential=rounded))["energy balance"] == "bad"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourbar", "fivebar", "cpm", "cpm_rotary"])
def test_what_long_steps_spoil_is_not_believed_and_short_ones_are(name):
    chain = load(name)

    def moved(integrator=None):
        return run(
            ConstrainedPlant(chain),
            lambda t: 0.3 * np.sin(5.0 * t + np.arange(chain.n)),
            duration=0.3,
            start_velocity=np.full(chain.n, 0.02),
            integrator=integrator,
            joint_limits="ignore",
        )

    exact = moved()
    size = np.ptp(exact.q, axis=0).max()
    assert verdict_of(exact).grade == "good"
    assert exact.energy_drift() < 1e-8
    for integrator in (
        Adaptive(1e-4, 1e-6),
        Adaptive(1e-2, 1e-3),
        RungeKutta4(1e-3),
        RungeKutta4(1e-2),
        Midpoint(1e-2),
    ):
        found = moved(integrator)
        off = np.abs(found.q[-1] - exact.q[-1]).max() / size
        grade = verdict_of(found).grade
        assert off < 1e-3 or grade != "good", integrator
        assert off > 1e-5 or grade != "bad", integrator
        assert off < 0.1 or grade == "bad", integrator


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


def test_efforts_have_the_units_of_their_actuators_in_words_too():
    result = made(effort=np.tile([3.0, -4.0, 5.0], (60, 1)))
    assert peaks_of(result) == [("motor1", "N m", 3.0), ("motor2", "N", 4.0), ("motor3", "N m", 5.0)]
    assert dict(figure_rows(result, figures_of(result)))["peak effort"] == "motor1 3 N m, motor2 4 N, motor3 5 N m"
