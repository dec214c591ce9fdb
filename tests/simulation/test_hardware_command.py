"""`cutjoint simulate` with hardware: by options, from a file, and what is wrong with either."""

from __future__ import annotations

import json

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from cutjoint.commands.simulate import command
from cutjoint.errors import DescriptionError, InputError
from cutjoint.simulation import load
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware, Tachometer, hardware_of

app = typer.Typer()
app.command()(command)
RUN = ["cpm", "--plant", "paper", "--controller", "pd", "--kp", "8000", "--kd", "300", "--duration", "0.05"]
OPTIONS = {
    ("--delay", "2e-3"): Hardware(Clock(500.0), Encoder(delay=2e-3)),
    ("--command-delay", "4e-3", "--limit", "90"): Hardware(Clock(500.0), drive=Drive(90.0, delay=4e-3)),
    ("--jitter", "2e-4", "--tick", "1e-4", "--seed", "5"): Hardware(Clock(500.0, 2e-4, 1e-4), seed=5),
    ("--resolution", "1e-4,2e-4,3e-4", "--noise", "1e-5"): Hardware(
        Clock(500.0), Encoder((1e-4, 2e-4, 3e-4), noise=1e-5)
    ),
    ("--filter", "60"): Hardware(Clock(500.0), speed=Differences(60.0)),
}


def simulate(*arguments):
    return CliRunner().invoke(app, [*RUN, *map(str, arguments)])


@pytest.mark.parametrize("options", OPTIONS)
def test_options_are_the_hardware_that_they_say(options, tmp_path):
    done = simulate("--rate", 500, *options, "--json", "--save", tmp_path / "run.npz")
    assert done.exit_code == 0, done.output
    found = load(tmp_path / "run.npz")
    assert hardware_of(found.about["hardware"]) == OPTIONS[options]
    assert json.loads(done.stdout)["hardware"] == found.about["hardware"]


def test_a_file_is_the_hardware_and_the_table_names_it(tmp_path):
    (tmp_path / "hardware.toml").write_text("seed = 2\n[clock]\nrate = 200\n[tachometer]\nnoise = 0.01\n")
    done = simulate("--hardware", tmp_path / "hardware.toml", "--save", tmp_path / "run.npz")
    assert done.exit_code == 0, done.output
    assert "tachometer" in done.output
    assert "noise 0.01" in done.output
    found = load(tmp_path / "run.npz")
    assert hardware_of(found.about["hardware"]) == Hardware(Clock(200.0), speed=Tachometer(0.01), seed=2)
    assert np.abs(found.measured_v - found.v).max() > 1e-3


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--delay", "1e-3"], "give --rate"),
        (["--rate", "500", "--resolution", "0"], "resolution of the encoder must be one number > 0"),
        (["--rate", "500", "--jitter", "1e-4"], "is not a whole number of ticks"),
        (["--rate", "500", "--delay", "1"], "not shorter than the run"),
        (["--rate", "500", "--filter", "-3"], "cutoff of the filter"),
        (["--rate", "500", "--noise", "1,2"], "noise of the encoder must be one number or 3 of them"),
        (["--rate", "500", "--noise", "a"], "--noise"),
        (["--rate", "500", "--seed", "-1"], "a seed is a whole number >= 0"),
        (["--hardware", "FILE", "--delay", "1e-3", "--rate", "3"], "--delay, --rate would stand beside"),
        (["--hardware", "FILE"], "without 'rate'"),
    ],
)
def test_bad_options_are_one_clear_error(options, told, tmp_path):
    (tmp_path / "hardware.toml").write_text("[clock]\ntick = 1e-3\n")
    done = simulate(*[tmp_path / "hardware.toml" if one == "FILE" else one for one in options])
    assert isinstance(done.exception, InputError | DescriptionError)
    assert told in str(done.exception)
