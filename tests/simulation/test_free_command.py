"""`cutjoint simulate` without a trajectory, with brakes, with joint limits, and with parts from outside."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import typer
from kit.quickly import few
from typer.testing import CliRunner, Result

from cutjoint.commands.play import command as play_command
from cutjoint.commands.simulate import command
from cutjoint.control import efforts_from_csv
from cutjoint.errors import CutjointError, InputError, SimulationError, UnknownNameError
from cutjoint.robots import load
from cutjoint.simulation import load as load_result

app, player = typer.Typer(), typer.Typer()
app.command()(command)
player.command()(play_command)
QUICK = ["--duration", "0.05", "--every", "0.01"]
LAWS = """
import numpy as np

def damper(t, desired, q, v):
    return -0.1 * v

class Spring:
    def __init__(self, stiffness, drag=1.0):
        self.stiffness, self.drag = stiffness, drag

    def __call__(self, t, desired, q, v):
        return self.stiffness * (desired.q - q) - self.drag * v

class Sway:
    duration = 2.0

    def __init__(self, mechanism, size=0.005):
        self.home, self.size = mechanism.tool(mechanism.home).position, size

    def at(self, t):
        way = self.size * np.array([1.0, 0.0, 0.0])
        s, c = np.sin(np.pi * t), np.cos(np.pi * t)
        return self.home + (1.0 - c) * way, np.pi * s * way, np.pi**2 * c * way
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(LAWS)
    return tmp_path


def simulate(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(one) for one in arguments])


def figures(*arguments: object) -> dict[str, object]:
    done = simulate(*arguments, "--json")
    assert done.exit_code == 0, (done.output, done.exception)
    found: dict[str, object] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize(
    "robot", few(["fivebar", "cpm", "stewart", "redundant", "underactuated"], "fivebar", "underactuated")
)
def test_any_robot_falls(robot: str) -> None:
    found = figures(robot, "--free", *QUICK)
    assert found["law"] == "none"
    assert "trajectory" not in found
    assert "error_rms_m" not in found
    assert float(str(found["energy_drift"])) < 1e-5
    shown = simulate(robot, "--free", *QUICK).output
    assert "free motion" in shown
    assert "tool error" not in shown


def test_the_published_model_falls_too() -> None:
    assert figures("cpm", "--free", "--plant", "paper", *QUICK)["plant"] == "cpm (Lagrange), compiled"


def test_brakes_hold_and_are_shown(folder: Path) -> None:
    found = figures("fivebar", "--free", "--lock", "left_shoulder", "--save", "run.npz", *QUICK)
    assert found["locked"] == ["left_shoulder"]
    result = load_result(folder / "run.npz")
    assert (result.q[:, 0] == result.q[0, 0]).all()
    assert result.effort[:, 0].all()
    led = simulate("fivebar", "--trajectory", "hold", "--lock", "left_shoulder", "--lock", "right_shoulder", *QUICK)
    assert "left_shoulder, right_shoulder" in led.output


def test_efforts_of_a_file_move_the_robot_as_the_same_efforts_do(folder: Path) -> None:
    """The file is read as it is written: columns in any order, remarks, units or not."""
    (folder / "push.csv").write_text(
        "# a push\nright_shoulder, t [s], left_shoulder [N m]\n0,0,0\n\n0.1,0.02,0.4\n0,0.05,0\n"
    )
    figures("fivebar", "--efforts", "push.csv", "--save", "run.npz", "--every", "0.01")
    result = load_result(folder / "run.npz")
    wanted = [np.interp(result.time, [0.0, 0.02, 0.05], one) for one in ([0.0, 0.4, 0.0], [0.0, 0.1, 0.0])]
    assert np.allclose(result.effort, np.transpose(wanted), rtol=0.0, atol=1e-12)
    assert result.time[-1] == 0.05
    (folder / "one.csv").write_text("t,right_shoulder\n0,0\n1,0\n")
    figures("fivebar", "--efforts", "one.csv", "--lock", "left_shoulder", *QUICK)


def test_what_follows_nothing_can_be_played(folder: Path) -> None:
    figures("fivebar", "--free", "--save", "run.npz", *QUICK)
    done = CliRunner().invoke(player, ["run.npz", "--html", "run.html"])
    assert done.exit_code == 0, done.output
    assert (folder / "run.html").stat().st_size > 100_000


def test_a_run_stops_at_a_limit_unless_it_is_ignored(folder: Path) -> None:
    stopped = simulate("omega3", "--free", "--duration", "0.25", "--every", "0.01", "--save", "run.npz")
    assert isinstance(stopped.exception, SimulationError)
    assert "' passes its " in str(stopped.exception)
    assert "1.48353 rad" in str(stopped.exception)
    assert load_result(folder / "run.stopped.npz").time[-1] == stopped.exception.t
    assert figures("omega3", "--free", "--duration", "0.25", "--every", "0.01", "--ignore-limits")["duration_s"] == 0.25


def test_limits_on_the_way_of_a_trajectory_are_ignored_too() -> None:
    far = ["cpm", "--trajectory", "line:0,0,0.7,0.2", "--every", "0.05"]
    assert isinstance(simulate(*far).exception, CutjointError)


def test_parts_from_outside(folder: Path) -> None:
    free = figures("fivebar", "--free", "--controller", "mine.py:damper", *QUICK)
    assert free["law"] == "damper"
    led = figures(
        "fivebar", "--controller", "mine.py:Spring", "--gain", "stiffness=40,30", "--trajectory", "mine.py:Sway", *QUICK
    )
    assert (led["gains"], led["trajectory"]) == ({"stiffness": [[40.0, 30.0]]}, "Sway")
    pd = figures("fivebar", "--controller", "pd", "--gain", "kp=40", "--kd", "2", "--trajectory", "hold", *QUICK)
    assert pd["gains"] == {"kp": [[40.0]], "kd": [[2.0]]}


@pytest.mark.parametrize(
    ("arguments", "about"),
    [
        (["--free", "--trajectory", "hold"], "with --free nothing is followed; leave out --trajectory"),
        (["--efforts", "good.csv", "--trajectory", "hold"], "with --efforts nothing is followed"),
        (["--efforts", "good.csv", "--controller", "pd"], "there is no controller; leave out --controller"),
        (["--efforts", "good.csv", "--kp", "1"], "leave out --controller and gains"),
        (["--efforts", "good.csv", "--duration", "2"], "given until 1 s"),
        (["--efforts", "none.csv"], "there is no file none.csv"),
        (["--efforts", "good.csv", "--lock", "left_shoulder"], "'left_shoulder' is locked"),
        (["--free", "--controller", "pd", "--kp", "1", "--kd", "1"], "asks for 'q' of the desired motion"),
        (["--free", "--controller", "computed-torque"], "'computed torque' asks for 'mechanism' of the desired"),
        (["--free", "--lock", "left_sholder"], "did you mean 'left_shoulder'"),
        (["--free", "--load", "elbow:1,0,0"], "unknown link of fivebar 'elbow'"),
        (["--free", "--load", "tool:1,2"], "--load wants LINK:FX,FY,FZ or LINK:FX,FY,FZ,MX,MY,MZ"),
        (["--free", "--load", "5,0,0"], "--load wants LINK:FX,FY,FZ"),
        (["--free", "--load", "tool:a,b,c"], "--load wants LINK:FX,FY,FZ"),
        (["--free", "--lock", "left_shoulder", "--lock", "left_shoulder"], "locked twice"),
        (["--free", "--controller", "mine.py:Spring"], "takes --gain stiffness=K, --gain drag=K; missing --gain stiff"),
        (["--free", "--controller", "mine.py:Spring", "--gain", "stiffness"], "--gain NAME=K, found 'stiffness'"),
        (["--free", "--controller", "mine.py:Spring", "--gain", "stiffness=soft"], "must be a number"),
        (["--free", "--controller", "mine.py:Spring", "--gain", "k=1", "--gain", "stiffness=1"], "not used --gain k=K"),
        (["--free", "--controller", "pd", "--kp", "1", "--gain", "kp=1"], "gain kp is given twice"),
        (["--free", "--controller", "mine.py:Damper"], "did you mean 'damper'"),
        (["--free", "--controller", "mines.py:damper"], "did you mean 'mine.py'"),
        (["--trajectory", "mine.py:damper"], "does not take what it is given"),
        (["--trajectory", "nosuch.module:Rose"], "no module nosuch"),
    ],
)
def test_bad_input_is_one_clear_error(folder: Path, arguments: list[str], about: str) -> None:
    (folder / "good.csv").write_text("t,left_shoulder,right_shoulder\n0,0,0\n1,0,0\n")
    done = simulate("fivebar", *arguments, "--save", "run.npz")
    assert isinstance(done.exception, CutjointError), (done.exception, done.output)
    assert any(one in str(done.exception) for one in about.split("|")), done.exception
    assert not (folder / "run.npz").exists()


@pytest.mark.parametrize(
    ("text", "about"),
    [
        ("", "is empty; its first line names the columns: t [s], left_shoulder [N m], right_shoulder [N m]"),
        ("t,left_shoulder,right_shoulder\n0,0,0\n", "has 1 rows of numbers"),
        ("t,left_shoulder\n0,0\n1,0\n", "bad.csv:1: no column right_shoulder"),
        ("left_shoulder,right_shoulder\n0,0\n1,0\n", "bad.csv:1: no column t"),
        ("t,left_sholder,right_shoulder\n0,0,0\n", "bad.csv:1: unknown column 'left_sholder'; did you mean"),
        ("t,left_shoulder [rad],right_shoulder\n0,0,0\n", "column 'left_shoulder' is in [rad], expected [N m]"),
        ("t [ms],left_shoulder,right_shoulder\n0,0,0\n", "column 't' is in [ms], expected [s]"),
        ("t,t,left_shoulder,right_shoulder\n0,0,0,0\n", "column 't' is there twice"),
        ("t,left_shoulder,right_shoulder\n0,0,0\n1,0\n", "bad.csv:3: 2 cells, expected 3"),
        ("t,left_shoulder,right_shoulder\n0,0,0\n\n1,,0\n", "bad.csv:4: column 'left_shoulder' has '', expected a"),
        ("t,left_shoulder,right_shoulder\n0,0,x\n", "bad.csv:2: column 'right_shoulder' has 'x'"),
        (
            "t,left_shoulder,right_shoulder\n0,0,nan\n",
            "bad.csv:2: column 'right_shoulder' has 'nan', expected a finite",
        ),
        ("t,left_shoulder,right_shoulder\n0,0,0\n0,0,0\n", "must increase: sample 2"),
        ("t,left_shoulder,right_shoulder\n1,0,0\n2,0,0\n", "begins at 0"),
        ("t;left_shoulder;right_shoulder\n0;0;0\n", "unknown column 't;left_shoulder;right_shoulder'"),
        ('t,left_shoulder,right_shoulder\n0,"0,0\n', "cannot be read as CSV"),
        ("t,left_shoulder,right_shoulder\n0,\xff,0\n", "cannot be read as CSV text in UTF-8"),
    ],
)
def test_a_file_of_efforts_that_is_none_is_told_with_its_line(tmp_path: Path, text: str, about: str) -> None:
    file = tmp_path / "bad.csv"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError) as caught:
        efforts_from_csv(file, load("fivebar").actuators)
    assert about in str(caught.value)


def test_a_folder_and_a_huge_file_are_no_files_of_efforts(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        efforts_from_csv(tmp_path, load("fivebar").actuators)
    huge = tmp_path / "huge.csv"
    with huge.open("wb") as file:
        file.truncate(10_000_000_000)
    with pytest.raises(InputError, match="10000 MB, at most 200 MB"):
        efforts_from_csv(huge, load("fivebar").actuators)


def test_help_says_how_to_bring_ones_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    shown = " ".join(simulate("--help").output.replace("│", " ").split())
    for one in ("--free", "--efforts", "--lock", "--gain", "--ignore-limits"):
        assert one in shown
    assert shown.count("FILE.py:NAME or PACKAGE.MODULE:NAME") == 2
    assert UnknownNameError.__name__ not in shown


def test_loads_from_outside() -> None:
    """What is pushed is said, is done, and is in the balance."""
    found = figures("fivebar", "--free", "--load", "tool:5,0,0", "--load", "left_distal:0,1,0,0,0,0.1", *QUICK)
    assert [one["link"] for one in found["loads"]] == [None, "left_distal"]
    assert found["loads"][1]["moment"] == [0.0, 0.0, 0.1]
    assert found["energy_drift"] < 1e-6
    assert "loads" not in figures("fivebar", "--free", *QUICK)
