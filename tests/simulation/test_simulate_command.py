"""`cutjoint simulate`: what it prints and saves, and bad input: one clear error, nothing left under the asked name."""

import importlib
import json
from typing import Annotated

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from cutjoint.commands import simulate as simulate_command
from cutjoint.commands.options import trajectory_of
from cutjoint.commands.simulate import command
from cutjoint.control import LAWS, PD
from cutjoint.control.catalogue import LawRow
from cutjoint.control.law import Gain, GainHelp
from cutjoint.control.pd import Kd, Kp
from cutjoint.errors import CutjointError, SimulationError
from cutjoint.motion import TRAJECTORIES, Circle, Hold, PointToPoint, Reference
from cutjoint.robots import load
from cutjoint.simulation import load as load_result

app = typer.Typer()
app.command()(command)
QUICK = ["--duration", "0.05", "--every", "0.01"]


def simulate(*arguments):
    return CliRunner().invoke(app, [str(one) for one in arguments])


@pytest.mark.parametrize("robot", ["cpm", "omega3"])
@pytest.mark.parametrize("plant", ["chain", "paper"])
def test_both_plants_of_both_robots(robot, plant):
    done = simulate(robot, "--plant", plant, "--controller", "feedforward", *QUICK)
    assert done.exit_code == 0, done.output
    for what in ("gains", "tool error", "peak effort", "loops", "energy balance"):
        assert what in done.output


def test_json_and_npz_agree(tmp_path):
    file = tmp_path / "run.npz"
    done = simulate("omega3", "--rate", "500", "--payload", "0.014", "--save", file, "--json", *QUICK)
    figures = json.loads(done.stdout)
    result = load_result(file)
    assert figures["samples"] == len(result) == 6
    assert figures["error_rms_m"] == result.rmse().position
    assert figures["rate"] == result.about["rate"] == 500.0
    assert figures["gains"] == {"kp": [[400.0]], "kd": [[40.0]]}
    assert figures["loop_gap_m"] < 1e-9
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


def test_payload_is_the_plants_and_not_the_controllers():
    plain, heavy = (
        json.loads(
            simulate("cpm", "--plant", "paper", "--controller", "feedforward", "--json", "--payload", kg, *QUICK).stdout
        )
        for kg in (0.0, 1.0)
    )
    first = [one["effort_peak"]["limb2_slide"] for one in (plain, heavy)]
    assert first[0] == first[1], "the effort at the start is the controller's alone"
    assert plain["error_last_m"] != heavy["error_last_m"]


def test_a_robot_without_a_paper_needs_no_gains_for_computed_torque(tmp_path):
    done = simulate("fivebar", "--trajectory", "circle:0.02", "--save", tmp_path / "run.csv", *QUICK)
    assert done.exit_code == 0, done.output
    assert (tmp_path / "run.csv").read_text().startswith("time [s],left_shoulder [rad]")


def test_gains_as_list_and_matrix():
    listed = simulate("cpm", "--plant", "paper", "--controller", "pd", "--kp", "1,2,3", "--kd", "4", "--json", *QUICK)
    assert json.loads(listed.stdout)["gains"] == {"kp": [[1.0, 2.0, 3.0]], "kd": [[4.0]]}
    matrix = "[[9,1,0],[1,9,0],[0,0,9]]"
    full = simulate("cpm", "--plant", "paper", "--controller", "pd", "--kp", matrix, "--kd", "4", "--json", *QUICK)
    assert json.loads(full.stdout)["gains"]["kp"] == json.loads(matrix)


@pytest.mark.parametrize(
    ("arguments", "about"),
    [
        (["nosuch"], "unknown robot 'nosuch'"),
        (["cpm", "--controller", "pdd"], "did you mean 'pd'"),
        (["cpm", "--trajectory", "circl:1"], "did you mean 'circle'"),
        (["cpm", "--trajectory", "line:1,2"], "is no trajectory"),
        (["cpm", "--trajectory", "line:a,b,c"], "is no trajectory"),
        (["cpm", "--trajectory", "hold:1,2"], "hold[:SECONDS]"),
        (["cpm", "--trajectory", "paper:1"], "is no trajectory"),
        (["cpm", "--trajectory", "circle:-1"], "radius"),
        (["cpm", "--trajectory", "line:5,0,0"], "leaves the workspace"),
        (["omega3", "--trajectory", "circle:0.5"], "leaves the workspace"),
        (["fivebar", "--trajectory", "paper"], "no published trajectory"),
        (["redundant", "--controller", "pd"], "Without --controller its actuators are led about home"),
        (["redundant", "--trajectory", "about-home:0"], "size"),
        (["redundant", "--trajectory", "hold"], "actuators"),
        (["cpm", "--rate", "-5"], "rate"),
        (["cpm", "--rate", "0"], "rate"),
        (["cpm", "--duration", "0"], "duration"),
        (["cpm", "--every", "0"], "every"),
        (["cpm", "--step", "-1"], "step"),
        (["cpm", "--payload", "-1"], "payload"),
        (["cpm", "--payload", "nan"], "payload"),
        (["cpm", "--plant", "papier"], "did you mean 'paper'"),
        (["fivebar", "--plant", "paper", "--trajectory", "hold"], "published model"),
        (["cpm", "--variant", "lumpd"], "did you mean 'lumped'"),
        (["cpm", "--kp", "1,2", "--kd", "1", "--controller", "pd"], "shape (2,)"),
        (["cpm", "--kp", "1", "--controller", "pd"], "missing --kd"),
        (["cpm", "--kp", "1", "--kd", "1", "--ki", "1", "--controller", "pd"], "not used --ki"),
        (["cpm", "--kp", "stiff", "--kd", "1"], "--kp must be"),
        (["cpm", "--kp", "[[1", "--kd", "1"], "--kp must be"),
        (["cpm", "--limit", "-1"], "limits"),
    ],
)
def test_bad_input_is_one_clear_error_and_leaves_no_file(tmp_path, arguments, about):
    done = simulate(*arguments, "--save", tmp_path / "run.npz")
    assert isinstance(done.exception, CutjointError), done.exception
    assert about in str(done.exception)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["run.mat", "run", "none/run.npz", ""])
def test_a_bad_file_name_is_found_before_anything_runs(tmp_path, name):
    done = simulate("cpm", "--save", tmp_path / name)
    assert isinstance(done.exception, CutjointError)
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_stops_keeps_what_there_was_beside_the_asked_name(tmp_path):
    done = simulate(
        "cpm", "--plant", "paper", "--controller", "none", "--trajectory", "hold:2", "--save", tmp_path / "run.npz"
    )
    assert isinstance(done.exception, SimulationError)
    assert [path.name for path in tmp_path.iterdir()] == ["run.stopped.npz"]
    partial = load_result(tmp_path / "run.stopped.npz")
    assert 0.3 < partial.time[-1] <= done.exception.t < 0.33


@pytest.mark.parametrize(
    ("spec", "kind"),
    [("hold", Hold), ("hold:2", Hold), ("line:-0.05,0.025,0,2", PointToPoint), ("circle:0.05,3", Circle)],
)
def test_trajectories_start_at_home(spec, kind):
    chain = load("cpm")
    trajectory = trajectory_of(chain, spec)
    assert isinstance(trajectory, kind)
    assert np.allclose(trajectory.at(0.0).position, chain.tool(chain.home).position)
    Reference(trajectory, chain)
    if "," in spec or ":" in spec:
        assert trajectory.duration == pytest.approx(float(spec.split(",")[-1].split(":")[-1]))


@pytest.mark.parametrize("robot", ["cpm", "fivebar"])
def test_a_line_goes_so_many_metres_from_home(robot):
    """Its end, not only its start: home and the end point differ by the numbers that were given."""
    chain = load(robot)
    home = chain.tool(chain.home).position
    line = trajectory_of(chain, "line:0.01,-0.02,0,0.5")
    assert np.allclose(line.at(0.5).position - home, [0.01, -0.02, 0.0], rtol=0, atol=1e-15)


def test_help_and_errors_name_every_trajectory_and_its_numbers(monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    shown = " ".join(simulate("--help").output.replace("│", " ").split())
    told = str(simulate("fivebar", "--trajectory", "paper").exception)
    for name, row in TRAJECTORIES.items():
        assert f"{name}{row.form}" in shown
        assert f"{name}{row.form}" in told
        assert all(str(one) in shown for one in row.arguments)


def test_help_says_which_law_takes_which_gain(monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    lines = simulate("--help").output.splitlines()
    for gain in {one for row in LAWS.values() for one in row.gains}:
        shown = next(line for line in lines if f"--{gain} " in line)
        for name, row in LAWS.items():
            assert (f"{name}," in shown or f"{name}:" in shown) == (gain in row.gains), (gain, name)
    assert all(name in " ".join(lines) for name in LAWS)


def test_a_gain_of_a_new_law_is_an_option(monkeypatch):
    """Options are made when the command is: so its module is loaded anew, with one more row."""

    class Damped(PD):
        def __init__(self, kp: Kp, kd: Kd, dry_drag: Annotated[float, GainHelp("against the speed", "N s/m")]) -> None:
            super().__init__(kp, kd)
            self.dry_drag = Gain("dry_drag", dry_drag)

    monkeypatch.setitem(LAWS, "damped", LawRow(Damped, "PD and drag"))
    anew = typer.Typer()
    anew.command()(importlib.reload(simulate_command).command)
    plain = ["fivebar", "--trajectory", "hold", "--controller", "damped", "--json", *QUICK]
    done = CliRunner().invoke(anew, [*plain, "--kp", "40", "--kd", "2", "--dry-drag", "0.1,0.2"])
    assert json.loads(done.stdout)["gains"] == {"kp": [[40.0]], "kd": [[2.0]], "dry_drag": [[0.1, 0.2]]}
    for given, about in (
        (["--kp", "40", "--kd", "2"], "takes --kp, --kd, --dry-drag; missing --dry-drag"),
        ([], "give --kp and --kd and --dry-drag"),
        (["--kp", "1", "--kd", "1", "--ki", "1", "--dry-drag", "1"], "not used --ki"),
    ):
        assert about in str(CliRunner().invoke(anew, [*plain, *given]).exception)
    monkeypatch.undo()
    importlib.reload(simulate_command)


def test_a_gain_that_is_called_like_another_option_is_told(monkeypatch):
    class Limited(PD):
        def __init__(self, kp: Kp, kd: Kd, limit: Annotated[float, GainHelp("largest effort", "N")]) -> None:
            super().__init__(kp, kd)

    monkeypatch.setitem(LAWS, "limited", LawRow(Limited, "PD with an end"))
    with pytest.raises(ValueError, match="names of other options: limit; rename them"):
        importlib.reload(simulate_command)
    monkeypatch.undo()
    importlib.reload(simulate_command)
