"""The table of what is recorded: a row is an attribute, an array in npz, and headed columns in CSV."""

import copy
import csv
import pickle
from dataclasses import replace

import numpy as np
import pytest

from cutjoint.control import PD
from cutjoint.errors import InputError, ResultFileError
from cutjoint.motion import Reference
from cutjoint.simulation import ReducedPlant, Result, load, run, save
from cutjoint.simulation.observables import OBSERVABLES, Observable
from cutjoint.simulation.result import ARRAYS

HARDWARE = ("measured_q", "measured_v", "asked", "command", "rotor_q", "rotor_v")
"""The columns of runs with hardware; the rotors' only where gears have play."""
LEFT_OUT = ("orientation", "angular_velocity", "desired_orientation", "orientation_error", "load_work", "dissipated")
POWER = Observable("n", "power", ("W",), lambda at: at.effort * at.seen.v, "power of the actuators")


@pytest.fixture
def simulated(cpm):
    paper = cpm.paper
    return lambda: run(
        ReducedPlant(paper), PD(12691, 436), Reference(cpm.trajectory, paper), duration=0.01, every=0.002
    )


@pytest.fixture
def with_power(monkeypatch, simulated):
    monkeypatch.setitem(OBSERVABLES, "power", POWER)
    return simulated()


def test_every_row_says_what_it_is():
    assert set(ARRAYS) <= set(OBSERVABLES)
    for name, row in OBSERVABLES.items():
        assert row.about
        assert f"{name}: {row}" in Result.__doc__
        assert len(row.units) == (0 if row.size == "nq" else 2 if row.size == 2 else 1) or row.size == "n"


def test_headings_differ_and_have_units():
    actuators = [["a", "rotation"], ["b", "translation"]]
    headings = [title for row in OBSERVABLES.values() if row.size != "nq" for title in row.titles(actuators)]
    assert len(set(headings)) == len(headings)
    assert all(one.endswith("]") and "[]" not in one for one in headings)
    assert {"a [rad]", "b [m]", "a speed [rad/s]", "b effort [N]", "loop gap [rad]", "tool z [m]"} <= set(headings)


def test_a_row_is_recorded_and_becomes_an_attribute(with_power):
    assert np.array_equal(with_power.power, with_power.effort * with_power.v)
    assert np.abs(with_power.power).max() > 0.0
    assert list(with_power.columns) == [name for name in OBSERVABLES if name not in (*LEFT_OUT, *HARDWARE)]
    with pytest.raises(ValueError, match="read-only"):
        with_power.power[0, 0] = 1.0


def test_a_row_reaches_both_kinds_of_file(with_power, tmp_path):
    again = load(save(with_power, tmp_path / "run.npz"))
    assert np.array_equal(again.power, with_power.power)
    with save(with_power, tmp_path / "run.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    first = rows[0].index("limb1_slide power [W]")
    assert np.array_equal(np.array(rows[1:], dtype=float)[:, first : first + 3], with_power.power)


def test_files_from_before_a_row_can_be_read(monkeypatch, simulated, tmp_path):
    file = save(simulated(), tmp_path / "run.npz")
    monkeypatch.setitem(OBSERVABLES, "power", POWER)
    old = load(file)
    assert old.rmse() == simulated().rmse()
    with pytest.raises(AttributeError, match="no column 'power'; it has time, q"):
        _ = old.power


def test_a_column_that_is_in_the_file_and_in_no_row_is_told(monkeypatch, with_power, tmp_path):
    file = save(with_power, tmp_path / "run.npz")
    monkeypatch.delitem(OBSERVABLES, "power")
    with pytest.warns(UserWarning, match=r"result file also holds power, for which OBSERVABLES has no row"):
        assert np.array_equal(load(file).effort, with_power.effort)


def test_a_file_whose_further_column_does_not_fit_is_refused(with_power, tmp_path):
    file = save(with_power, tmp_path / "run.npz")
    with np.load(file) as stored:
        np.savez(file, **{**stored, "power": np.zeros((6, 2))})
    with pytest.raises(ResultFileError, match="power"):
        load(file)


@pytest.mark.parametrize("again", [lambda one: pickle.loads(pickle.dumps(one)), copy.deepcopy, copy.copy, replace])
def test_further_columns_travel_along(with_power, again):
    other = again(with_power)
    assert np.array_equal(other.power, with_power.power)
    with pytest.raises(ValueError, match="read-only"):
        other.power[0, 0] = 1.0


@pytest.mark.parametrize(
    ("more", "about"),
    [({"powre": 1.0}, "no further column powre"), ({"tool": 1.0}, "no further column tool"), ({"power": 1.0}, "fit")],
)
def test_further_columns_are_checked(with_power, more, about):
    with pytest.raises(InputError, match=about):
        replace(with_power, more={name: np.full((6, 4), value) for name, value in more.items()})
    with pytest.raises(InputError, match="finite"):
        replace(with_power, more={"power": np.full((6, 3), np.nan)})
