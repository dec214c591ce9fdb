"""A study file: what is right is read, and all that is wrong is told at once, before anything starts."""

from __future__ import annotations

import socket
import threading
from pathlib import Path

import pytest

from cutjoint.errors import CutjointError, DescriptionError, InputError, UnknownNameError
from cutjoint.studies import Study, begun, read_study
from cutjoint.studies.cases import recipe_of
from cutjoint.studies.cluster import DaskCluster

WHOLE = """
robot = "fivebar"
runs = 100
[controller]
name = "pd"
gains = { kp = 30.0, kd = [1.0, 2.0] }
"""


def written(folder: Path, text: str) -> Path:
    file = folder / "wear.toml"
    file.write_text(text)
    return file


def test_what_is_not_said_has_its_default(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, WHOLE))
    assert (study.name, study.robot, study.method, study.samples, study.cases) == ("wear", "fivebar", "random", 100, 1)
    assert study.keep == ("error_rms", "error_max", "effort_max")
    assert study.laws[0].gains["kd"] == [1.0, 2.0]
    assert (study.seed, study.model, study.hardware, study.varied) == (0, "chain", (("", None),), ())


def test_the_digest_is_of_what_is_said(tmp_path: Path) -> None:
    one = read_study(written(tmp_path, WHOLE)).digest
    assert read_study(written(tmp_path, f"# a remark\n{WHOLE}")).digest == one
    assert read_study(written(tmp_path, WHOLE.replace("30.0", "31.0"))).digest != one


def test_cases_are_crossed(tmp_path: Path) -> None:
    text = """
robot = "cpm"
variants = ["lumped", "distributed"]
method = "grid"
trajectories = ["paper", "hold:0.5"]
[[controller]]
name = "pd"
[[controller]]
name = "pd-gravity"
[[hardware]]
name = "slow"
rate = 100.0
[[hardware]]
name = "quick"
rate = 1000.0
[[vary]]
path = "payload"
uniform = [0.0, 1.0]
steps = 3
[[vary]]
path = "gains.kp"
relative = 0.1
steps = 2
"""
    study = read_study(written(tmp_path, text))
    assert (study.cases, study.samples, study.total) == (16, 6, 96)
    recipe = recipe_of(study)
    names = [one.name for one in recipe.cases]
    assert len(set(names)) == 16
    assert names[0] == "lumped, paper, pd, slow"
    assert all(one.spreads[0].bounds == (0.0, 1.0) for one in recipe.cases)
    assert recipe.cases[0].spreads[1].bounds == (0.9, 1.1)
    assert "gains for 20 rad/s" in recipe.told[0]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("runs = 100", "runs = 100\nmethd = 'grid'", "did you mean 'method'?"),
        ("runs = 100", "runs = 1_000_000_000_000", "1e+12 runs are more than a study has"),
        ("runs = 100", "runs = -3", "a whole number from 1"),
        ("runs = 100", "runs = 2.5", "a whole number from 1"),
        ("runs = 100", "runs = true", "a whole number from 1"),
        ("runs = 100", "", "no runs"),
        ("runs = 100", "runs = 100\nmethod = 'randm'", "did you mean 'random'?"),
        ("runs = 100", "runs = 100\nduration = 0.0", "a number > 0"),
        ("runs = 100", "runs = 100\nmethod = 'sobol'", "without [[vary]]"),
        ("runs = 100", "runs = 100\ntrajectories = []", "a list that is not empty"),
        ('name = "pd"', "", "without 'name'"),
        ("kp = 30.0", "kp = 'x'", "a number, a list"),
        ("[controller]", "[keep]\ncolumns = ['eror_rms']\n[controller]", "did you mean 'error_rms'?"),
        ("[controller]", "[keep]\nevery = -1\n[controller]", "a number > 0"),
        ("[controller]", "[hardware]\ndelay = 0.1\n[controller]", "without a rate"),
        ("[controller]", "[hardware]\nrate = 1000\nnoise = -1.0\n[controller]", "noise"),
        ("[controller]", "[[vary]]\npath = 'payload'\nuniform = [1.0, 1.0]\n[controller]", "empty or upside down"),
        ("[controller]", "[[vary]]\npath = 'payload'\nuniform = [2.0, 1.0]\n[controller]", "empty or upside down"),
        ("[controller]", "[[vary]]\npath = 'payload'\nnormal = [2.0, -1.0]\n[controller]", "standard deviation > 0"),
        ("[controller]", "[[vary]]\npath = 'payload'\nvalues = []\n[controller]", "an empty list"),
        ("[controller]", "[[vary]]\npath = 'payload'\n[controller]", "no values for 'payload'"),
        ("[controller]", "[[vary]]\npath = 'payload'\nunifrm = [0.0, 1.0]\n[controller]", "did you mean 'uniform'?"),
        ("[controller]", "[[vary]]\npath = 'payload'\nrelative = 3.0\n[controller]", "between 0 and 1"),
        ("[controller]", "[[vary]]\npath = 'payload'\nuniform = [0.0, inf]\n[controller]", "uniform"),
        ("runs = 100", "runs = 100\nmethod = 'grid'", "a grid has all combinations"),
        ("robot = ", "robot == ", "does not parse"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(old: str, new: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError) as found:
        read_study(written(tmp_path, WHOLE.replace(old, new)))
    assert told in str(found.value)
    assert "wear.toml" in str(found.value)


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    text = WHOLE.replace("runs = 100", "runs = 0\nstep = -1\nextra = 3")
    with pytest.raises(DescriptionError) as found:
        read_study(written(tmp_path, text))
    assert len(found.value.problems) == 3
    assert {one.line for one in found.value.problems} == {3, 4, 5}


@pytest.mark.parametrize(("runs", "base"), [(5, 8), (100, 128), (24, 32)])
def test_saltelli_takes_whole_groups(runs: int, base: int, tmp_path: Path) -> None:
    text = WHOLE.replace("runs = 100", f"runs = {runs}\nmethod = 'saltelli'")
    vary = "[[vary]]\npath = 'payload'\nuniform = [0.0, 1.0]\n[[vary]]\npath = 'gains.kp'\nrelative = 0.1\n"
    if runs % 4 == 0 and (runs // 4) & (runs // 4 - 1) == 0:
        assert read_study(written(tmp_path, text + vary)).samples == runs
        return
    with pytest.raises(DescriptionError, match=rf"such as {base}|such as \d+") as found:
        read_study(written(tmp_path, text + vary))
    said = int(str(found.value).split("such as ")[1].split(";")[0])
    assert said >= runs
    assert read_study(written(tmp_path, text.replace(f"runs = {runs}", f"runs = {said}") + vary)).samples == said


def varied(path: str, spread: str) -> str:
    return f"{WHOLE}[[vary]]\npath = '{path}'\n{spread}\n"


def built(path: str, spread: str) -> str:
    """The same behind hardware."""
    return f"{varied(path, spread)}[hardware]\nrate = 500.0\nnoise = 1e-5\nlimits = [3.0, 4.0]\n"


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        (WHOLE.replace("fivebar", "fivbar"), UnknownNameError, "did you mean 'fivebar'?"),
        (WHOLE.replace('"pd"', '"pdd"'), UnknownNameError, "did you mean 'pd'?"),
        (WHOLE.replace("kp = 30.0", "kpp = 30.0"), UnknownNameError, "did you mean 'kp'?"),
        (WHOLE.replace("kp = 30.0, ", ""), InputError, "needs kp"),
        (WHOLE.replace("runs", "trajectory = 'circel:1'\nruns"), UnknownNameError, "circle"),
        (varied("links.left_distal.mas", "relative = 0.1"), UnknownNameError, "links.left_distal.mass"),
        (varied("links.left_distal.mass", "uniform = [-0.1, 0.2]"), InputError, "must be >= 0, found -0.1"),
        (varied("links.left_distal.mass", "normal = [0.2, 0.1]"), InputError, "four standard deviations"),
        (varied("links.left_distal.inertia", "relative = 0.1"), InputError, "is 6 numbers; vary one"),
        (varied("payload", "relative = 0.1"), InputError, "is 0 in"),
        (varied("gains.ki", "relative = 0.1"), UnknownNameError, "kp"),
        (varied("gains.kp", "uniform = [-1.0, 1.0]"), InputError, "must be >= 0"),
        (varied("hardware.noise", "uniform = [1e-6, 1e-5]"), InputError, "has no [hardware]"),
        (built("hardware.delay", "uniform = [1e-3, 2e-3]"), InputError, "several [[hardware]]"),
        (built("hardware.clock.rate", "uniform = [500, 600]"), InputError, "several [[hardware]]"),
        (built("hardware.nois", "relative = 0.1"), UnknownNameError, "hardware.noise"),
        (built("hardware.filter", "uniform = [50, 60]"), InputError, "has no [differences]"),
        (built("hardware.noise", "uniform = [-1e-6, 1e-6]"), InputError, "at the end of its range"),
        (built("hardware.encoder.offset", "relative = 0.1"), InputError, "is 0 in the study"),
        (varied("load.fx", "uniform = [0, 1]"), InputError, "'payload'"),
        (
            varied("gains.kp", "relative = 0.1").replace("kp = 30.0", "kp = [[30.0, 0.0], [0.0, 30.0]]"),
            InputError,
            "is a matrix",
        ),
        (varied("start.left_sholder", "uniform = [-0.1, 0.1]"), UnknownNameError, "left_shoulder"),
    ],
)
def test_what_does_not_fit_the_robot_is_told(text: str, kind: type[CutjointError], told: str, tmp_path: Path) -> None:
    study = read_study(written(tmp_path, text))
    with pytest.raises(kind) as found:
        recipe_of(study)
    assert told in str(found.value)


@pytest.mark.parametrize("address", ["", "here", "http://1.2.3.4:80", "tcp://127.0.0.1:0", "tcp://127.0.0.1:99999"])
def test_a_scheduler_that_is_none_is_refused(address: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="address"):
        begun(written(tmp_path, WHOLE), tmp_path / "runs", scheduler=address)
    assert not (tmp_path / "runs").exists()


def test_a_scheduler_that_does_not_answer_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        begun(written(tmp_path, WHOLE), tmp_path / "runs", scheduler="tcp://127.0.0.1:1")


@pytest.mark.parametrize("speaks", [False, True])
def test_a_port_of_something_else_is_told(speaks: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("cutjoint.studies.cluster.ANSWER", 0.1)
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def greet() -> None:
            while True:
                try:
                    other, _ = listening.accept()
                except OSError:
                    return
                kept.append(other)
                if speaks:
                    other.sendall(b"\x01")

        kept: list[socket.socket] = []
        threading.Thread(target=greet, daemon=True).start()
        with pytest.raises(InputError, match="something listens there that is no Dask scheduler"):
            DaskCluster(f"tcp://127.0.0.1:{listening.getsockname()[1]}")
        for one in kept:
            one.close()


def test_numbers_of_hardware_vary_and_noise_has_the_seed(tmp_path: Path) -> None:
    text = (
        built("hardware.noise", "log-uniform = [1e-6, 1e-4]")
        + varied("hardware.limits", "relative = 0.5")[len(WHOLE) :]
    )
    study = read_study(written(tmp_path, "seed = 7\n" + text))
    assert study.hardware[0][1] is not None
    assert study.hardware[0][1].seed == 7
    assert [one.bounds for one in recipe_of(study).cases[0].spreads] == [(1e-6, 1e-4), (0.5, 1.5)]


def test_a_study_is_a_value(tmp_path: Path) -> None:
    import pickle

    study = read_study(written(tmp_path, WHOLE))
    other = pickle.loads(pickle.dumps(study))
    assert isinstance(other, Study)
    assert other.digest == study.digest
