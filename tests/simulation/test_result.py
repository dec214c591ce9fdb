"""Results: their checks, their files."""

import csv
import pickle
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from cutjoint.errors import InputError, ResultFileError
from cutjoint.simulation import load, save
from cutjoint.simulation.observables import DESIRED
from cutjoint.simulation.result import ARRAYS, result_of


def made(time=None, error=None, **changes):
    """A result with a given tool error over time."""
    t = np.linspace(0.0, 2.0, 201) if time is None else np.asarray(time, dtype=float)
    m = t.size
    e = np.zeros((m, 3)) if error is None else error(t)
    three = np.zeros((m, 3))
    content = dict.fromkeys((*ARRAYS, *DESIRED[:4]), three) | {
        "time": t,
        "desired_tool": e,
        "gap": np.zeros((m, 2)),
        "kinetic": np.ones(m),
        "potential": np.zeros(m),
        "work": np.zeros(m),
        "about": {"actuators": [["a", "rotation"], ["b", "translation"], ["c", "rotation"]], "law": "PD"},
    }
    content |= changes
    about = content.pop("about")
    return result_of(content, about)


def test_rmse_counts_samples_and_the_other_one_counts_time():
    """error 1 in the first tenth of the time, where nine tenths of the samples lie."""
    time = np.concatenate([np.linspace(0.0, 0.1, 901)[:-1], np.linspace(0.1, 1.0, 101)])
    result = made(time, lambda t: np.column_stack([t < 0.1, 0 * t, 0 * t]).astype(float))
    assert result.rmse().position == pytest.approx(np.sqrt(900 / 1001))
    assert result.rmse_over_time().position == pytest.approx(np.sqrt(0.1), rel=1e-3)


def test_rmse_is_that_of_the_length_of_the_error():
    result = made(error=lambda t: np.column_stack([0 * t + 3, 0 * t + 4, 0 * t]))
    assert result.rmse().position == 5.0
    assert result.rmse_over_time().position == pytest.approx(5.0)
    assert result.worst_error() == 5.0
    assert result.worst_axis_error() == 4.0


def test_worst_error_after_a_time():
    result = made(error=lambda t: np.column_stack([np.exp(-t), 0 * t, 0 * t]))
    assert result.worst_error(0.5) == pytest.approx(np.exp(-0.5))
    with pytest.raises(InputError, match="ends at 2 s"):
        result.worst_error(2.5)


def test_energy_drift_is_what_the_actuators_did_not_do():
    t = np.linspace(0.0, 2.0, 201)
    honest = made(kinetic=1.0 + t, work=t)
    assert honest.energy_drift() < 1e-15
    leaky = made(kinetic=1.0 + t - 0.01 * t, work=t)
    assert leaky.energy_drift() == pytest.approx(0.02 / (3.0 - 0.02))


@pytest.mark.parametrize("level", [-1e6, -3.0, 0.0, 7.0, 1e6])
def test_energy_drift_does_not_know_where_potential_energy_is_zero(level):
    """The heights that count are those between which the robot moved: here 0.2 J, wherever they are measured from."""
    t = np.linspace(0.0, 2.0, 201)
    fall = 0.2 * np.sin(0.25 * np.pi * t) ** 2
    leaky = made(kinetic=0.5 * fall, potential=level - fall, work=np.zeros(201))
    assert leaky.energy_drift() == pytest.approx(0.1 / 0.2, rel=1e-8)


def test_energy_drift_is_relative_to_the_largest_turnover():
    t = np.linspace(0.0, 1.0, 101)
    for kinetic, potential, work in ((3.0, 1.0, 1.0), (1.0, 3.0, 1.0), (1.0, 1.0, 3.0)):
        found = made(t, kinetic=kinetic * t, potential=potential * t, work=work * t)
        assert found.energy_drift() == pytest.approx(abs(kinetic + potential - work) / 3.0)
    assert made(t, kinetic=np.zeros(101), potential=np.full(101, -5.0)).energy_drift() == 0.0


def test_loop_gap_is_the_worst():
    gap = np.zeros((201, 2))
    gap[7] = [1e-9, 0.0]
    gap[9] = [0.0, 1e-8]
    assert made(gap=gap).loop_gap() == (1e-9, 1e-8)


def test_it_is_read_only():
    result = made()
    with pytest.raises(ValueError, match="read-only"):
        result.tool[0, 0] = 1.0
    with pytest.raises(AttributeError):
        result.tool = result.q
    with pytest.raises(TypeError):
        result.about["law"] = "other"


@pytest.mark.parametrize(
    ("changes", "about"),
    [
        ({"time": np.zeros(201)}, "increase"),
        ({"time": np.zeros(0)}, "do not fit"),
        ({"effort": np.zeros((201, 2))}, "effort"),
        ({"tool": np.zeros((200, 3))}, "tool"),
        ({"gap": np.zeros((201, 3))}, "gap"),
        ({"work": np.full(201, np.nan)}, "finite"),
    ],
)
def test_it_checks_itself(changes, about):
    with pytest.raises(InputError, match=about):
        made(**changes)


def test_npz_round_trip(tmp_path):
    result = made(error=lambda t: np.column_stack([np.sin(t), t, t * t]))
    file = save(result, tmp_path / "run.npz")
    again = load(file)
    assert all(np.array_equal(getattr(result, name), getattr(again, name)) for name in ARRAYS)
    assert dict(again.about) == dict(result.about)
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


def test_csv_has_a_column_a_quantity_and_a_row_a_sample(tmp_path):
    result = made(error=lambda t: np.column_stack([np.sin(t), t, t * t]))
    with (save(result, tmp_path / "run.csv")).open(newline="") as file:
        rows = list(csv.reader(file))
    assert len(rows) == 1 + len(result)
    assert {len(row) for row in rows} == {len(rows[0])}
    assert rows[0][:4] == ["time [s]", "a [rad]", "b [m]", "c [rad]"]
    assert "b effort [N]" in rows[0]
    column = rows[0].index("desired tool y [m]")
    assert np.array_equal([float(row[column]) for row in rows[1:]], result.desired_tool[:, 1])


@pytest.mark.parametrize("target", ["run.mat", "run", "nowhere/run.npz", "folder.npz"])
def test_bad_targets_are_refused_and_leave_nothing(tmp_path, target):
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(InputError):
        save(made(), tmp_path / target)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.npz"]


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    file = save(made(), tmp_path / "run.npz")
    before = file.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(InputError, match="No space left"):
        save(made(error=lambda t: np.column_stack([t, t, t])), file)
    assert file.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize("keep", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_file_cut_short_is_one_clear_error(tmp_path, keep):
    file = save(made(), tmp_path / "run.npz")
    content = file.read_bytes()
    file.write_bytes(content[: int(keep * len(content))])
    with pytest.raises(ResultFileError, match="not a whole result file"):
        load(file)


def rewritten(file, **changes):
    """The file with entries replaced (or dropped where None)."""
    with np.load(file) as stored:
        content = {name: stored[name] for name in stored.files}
    content = {name: value for name, value in (content | changes).items() if value is not None}
    np.savez(file, **content)


@pytest.mark.parametrize(
    ("changes", "about"),
    [
        ({"schema": 2}, "schema 2, this version reads 1"),
        ({"schema": None}, "schema none"),
        ({"schema": np.array("one")}, "schema one"),
        ({"effort": None, "gap": None}, "lacks effort, gap"),
        ({"about": np.array("{")}, "does not hold a result"),
        ({"about": np.array("7")}, "does not hold a result"),
        ({"tool": np.zeros((5, 3))}, "do not fit"),
        ({"tool": np.array(["x"] * 201)}, "does not hold a result"),
    ],
)
def test_files_of_another_kind_are_refused(tmp_path, changes, about):
    file = save(made(), tmp_path / "run.npz")
    rewritten(file, **changes)
    with pytest.raises(ResultFileError, match=about) as caught:
        load(file)
    assert caught.value.path == str(file)


def test_files_that_are_no_results(tmp_path):
    with pytest.raises(ResultFileError, match="no such file"):
        load(tmp_path / "none.npz")
    with pytest.raises(ResultFileError, match="directory"):
        load(tmp_path)
    text = tmp_path / "text.npz"
    text.write_text("time,q\n")
    with pytest.raises(ResultFileError):
        load(text)
    array = tmp_path / "array.npy"
    np.save(array, np.zeros(3))
    with pytest.raises(ResultFileError):
        load(array)
    with zipfile.ZipFile(tmp_path / "zip.npz", "w") as archive:
        archive.writestr("schema.npy", "nonsense")
    with pytest.raises(ResultFileError):
        load(tmp_path / "zip.npz")


def test_it_travels_between_processes():
    result = made()
    again = pickle.loads(pickle.dumps(result))
    assert all(np.array_equal(getattr(result, name), getattr(again, name)) for name in ARRAYS)
    assert again.about == result.about


def test_repr_says_what_it_is():
    assert "PD" in repr(made())
    assert "201 samples over 2 s" in repr(made())
    assert len(replace(made(), about={})) == 201
