"""Curves of runs: what is drawn, told apart, thinned, cut, overlaid, and refused."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from kit.runs import made

import cutjoint
from cutjoint.errors import CutjointError, InputError, MissingPackageError, UnknownNameError
from cutjoint.report import COLOURS, DASHES, plot
from cutjoint.report.figures import ON_DARK
from cutjoint.report.named_runs import runs_of_files
from cutjoint.robots import load
from cutjoint.simulation import ConstrainedPlant, charts, reactions_of, run, save
from cutjoint.simulation.charts import charts_json, look, overlaid, thinned
from cutjoint.simulation.panels import PANELS, Panel, all_panels, between, panels_of

# ---- panels


def test_sliding_and_turning_actuators_have_panels_of_their_own_units():
    panels = panels_of(made(n=4), ["effort", "joints", "velocity", "power"])
    assert [(one.title, one.unit, tuple(one.names)) for one in panels[:2]] == [
        ("Efforts of the actuators", "N", ("motor2", "motor4")),
        ("Efforts of the actuators", "N m", ("motor1", "motor3")),
    ]
    assert [one.unit for one in panels[2:]] == ["m", "rad", "m/s", "rad/s", "W", "W"]


def test_power_is_effort_times_speed():
    run = made(kinds="r")
    (power,) = panels_of(run, ["power"])
    np.testing.assert_array_equal(power.values, run.effort * run.v)


@pytest.mark.parametrize("limits", [7.0, [7.0, 8.0, 9.0]])
def test_effort_limits_are_drawn_where_the_run_had_them(limits):
    (effort,) = panels_of(made(kinds="r", about={"limits": limits}), ["effort"])
    top = np.broadcast_to(limits, 3)
    np.testing.assert_array_equal(effort.limits, np.column_stack([-top, top]))
    assert panels_of(made(), ["effort"])[0].limits is None


@pytest.fixture(scope="module")
def swing():
    """A five-bar under a law that changes smoothly, and the robot."""
    chain = load("fivebar")
    return run(ConstrainedPlant(chain), lambda t: [0.3 * np.sin(9.0 * t), -0.2], duration=0.1, every=0.002), chain


def test_power_sums_up_to_the_work_and_energies_to_what_is_left(swing):
    result, _ = swing
    (power,), (parts, lost) = panels_of(result, ["power"]), panels_of(result, ["energy"])
    done = np.trapezoid(power.values.sum(axis=1), power.time)
    curves = dict(zip(parts.names, parts.values.T, strict=True))
    assert curves["work of actuators"][-1] == pytest.approx(done, rel=1e-4)
    stored = curves["kinetic"] + curves["change of potential"] - curves["kinetic"][0]
    np.testing.assert_allclose(stored - curves["work of actuators"], lost.values[:, 0], atol=1e-12)
    assert np.abs(lost.values).max() < 1e-6 * np.abs(stored).max()


def test_reactions_are_the_sizes_of_those_of_the_run_sample_by_sample(swing):
    result, chain = swing
    force, moment = panels_of(result, ["reactions"], chain)
    found = reactions_of(result, chain)
    np.testing.assert_array_equal(force.time, result.time)
    np.testing.assert_allclose(force.values, np.linalg.norm(found.force, axis=2), rtol=1e-9)
    np.testing.assert_allclose(moment.values, np.linalg.norm(found.moment, axis=2), rtol=1e-9)
    assert (force.unit, moment.unit, tuple(force.names)) == ("N", "N m", found.names)


def test_passive_joints_are_read_from_the_configurations_by_their_types():
    angle = np.linspace(0.0, 9.0, 60)  # beyond a turn
    half = angle / 2.0
    ball = np.column_stack([np.zeros((60, 2)), np.sin(half), np.cos(half)])  # a turn about z
    flat = np.column_stack([angle, -angle, np.cos(angle), np.sin(angle)])
    joints = [["motor1", "revolute"], ["rod", "prismatic"], ["ball", "spherical"], ["plate", "planar"]]
    q_full = np.column_stack([angle, 0.1 * angle, ball, flat])
    run = made(n=1, kinds="r", q_full=q_full, about={"joints": joints})
    lengths, angles = panels_of(run, ["passive"])
    assert (lengths.unit, angles.unit) == ("m", "rad")
    assert list(lengths.names) == ["rod", "plate x", "plate y"]
    assert list(angles.names) == ["ball roll", "ball pitch", "ball yaw", "plate angle"]
    np.testing.assert_allclose(lengths.values, np.column_stack([0.1 * angle, angle, -angle]), atol=1e-12)
    np.testing.assert_allclose(angles.values[:, 2], angle, atol=1e-12)
    np.testing.assert_allclose(angles.values[:, 3], angle, atol=1e-12)


@pytest.mark.parametrize("joints", [[["a", "revolute"]], [["a", "revolute"]] * 3, [["a", "wheel"], ["b", "revolute"]]])
def test_joints_that_do_not_fit_the_configurations_are_refused(joints):
    run = made(n=1, q_full=np.zeros((60, 2)), about={"joints": joints})
    with pytest.raises(InputError, match=r"coordinates|no type of joint"):
        panels_of(run, ["passive"])


def test_what_came_from_nowhere_is_what_the_works_leave_over():
    kinetic, work, load, taken = (np.linspace(0.0, top, 60) for top in (5.0, 4.0, 3.0, 1.5))
    run = made(kinetic=kinetic, work=work, load_work=load, dissipated=taken)
    parts, lost = panels_of(run, ["energy"])
    assert list(parts.names)[2:] == ["work of actuators", "work of loads", "taken by friction"]
    np.testing.assert_allclose(lost.values[:, 0], kinetic - work - load + taken, atol=1e-12)
    assert run.energy_drift() == pytest.approx(0.5 / 5.0)


@pytest.mark.parametrize("name", ["error", "orientation", "command", "measured", "passive", "reactions"])
def test_what_a_run_does_not_have_is_said_where_it_is_asked_for(name):
    with pytest.raises(InputError, match=f"no {name} to show: "):
        panels_of(made(), [name])
    found, left = all_panels(made())
    assert name in left
    assert set(found) | set(left) == set(PANELS)


def test_a_name_that_is_nearly_right_is_suggested():
    with pytest.raises(UnknownNameError, match="did you mean 'effort'"):
        plot(made(), "efort")


def test_every_run_has_something_to_show_even_without_actuators():
    found = plot(made(n=0))
    assert [chart.title for chart in found.charts] == ["Tool"]


# ---- told apart


def test_many_curves_all_look_different_or_are_split():
    assert len({look(i) for i in range(48)}) == 48
    for n in (3, 6, 12, 13, 30):
        found = overlaid({"": panels_of(made(n=n, kinds="r"), ["effort"])})
        assert sum(len(chart.curves) for chart in found) == n
        for chart in found:
            assert len({(curve.colour, curve.dash) for curve in chart.curves}) == len(chart.curves) <= charts.MOST
        assert len({chart.title for chart in found}) == len(found)


def test_python_and_pages_have_the_same_tables_of_looks():
    from importlib import resources

    script = (resources.files("cutjoint") / "viewer/page/curves.js").read_text()
    light = re.search(r"colours: \[(.*?)\]", script).group(1)
    assert tuple(re.findall(r'"(#\w+)"', light)) == COLOURS
    dark = re.findall(r"colours: \[(.*?)\]", script)[1]
    assert re.findall(r'"(#\w+)"', dark) == [ON_DARK[colour] for colour in COLOURS]
    dashes = re.search(r"const DASHES = (\[.*?\]);", script).group(1)
    assert len(json.loads(dashes)) == len(DASHES) == charts.DASHES
    assert len(COLOURS) == charts.COLOURS


@pytest.mark.parametrize(("runs", "frames"), [(1, 1), (2, 1), (4, 1), (5, 3), (9, 3)])
def test_runs_over_each_other_share_colours_and_differ_in_dash(runs, frames):
    named = {f"run{i}": made(kinds="r") for i in range(runs)}
    found = plot(named, "effort").charts
    assert len(found) == frames
    for chart in found:
        looks = [(curve.colour, curve.dash) for curve in chart.curves]
        assert len(set(looks)) == len(looks)
        assert len({curve.name for curve in chart.curves}) == len(looks)
    if 1 < runs < 5:
        assert [curve.colour for curve in found[0].curves[:runs]] == [0] * runs
        assert found[0].curves[1].name == "motor1, run1"


def test_runs_with_other_curves_in_a_panel_are_laid_over_each_other_by_name():
    loaded = made(load_work=np.ones(60))
    energy = plot({"a": made(), "b": loaded}, "energy").charts[0]
    assert [one.name for one in energy.curves if "loads" in one.name] == ["work of loads, b"]


@pytest.mark.parametrize("other", [made(n=2), made(kinds="t"), made(about={"robot": "another"})])
def test_runs_of_different_robots_are_refused(other):
    with pytest.raises(InputError, match="different robots"):
        plot([made(), other])


def test_the_same_robot_in_another_variant_is_the_same_robot():
    assert plot([made(), made(about={"robot": "made (lumped)"})], "effort")


@pytest.mark.parametrize("wrong", [[], {}, [1], 5, "run.npz"])
def test_what_is_no_run_is_refused_at_the_door(wrong):
    with pytest.raises(InputError, match=r"give at least one|expected a result"):
        plot(wrong)


# ---- long runs


@pytest.mark.parametrize("points", [10, 101, 2000])
def test_thinning_keeps_samples_ends_and_every_peak(points):
    random = np.random.default_rng(points)
    time = np.cumsum(random.uniform(1e-6, 1.0, 50_000))
    values = random.normal(size=time.size)
    t, v = thinned(time, values, points)
    assert len(t) <= points
    assert (t[0], t[-1], v.min(), v.max()) == (time[0], time[-1], values.min(), values.max())
    assert (np.diff(t) > 0).all()
    np.testing.assert_array_equal(values[np.searchsorted(time, t)], v)


def test_no_peak_of_a_long_run_is_lost_and_pages_stay_small():
    effort = np.zeros((200_000, 3))
    effort[123_457, 1], effort[77_777, 2] = 1234.5, -987.25
    page = plot(made(200_000, effort=effort), "effort").html
    assert "1234.5" in page
    assert "-987.25" in page
    assert len(page) < 300_000


def test_a_page_of_many_curves_stays_small():
    assert len(plot(made(4000, n=80), "effort,joints,velocity,power").html) < 6_000_000


def test_a_short_run_is_shown_sample_for_sample_in_a_handy_unit():
    run = made(tool=np.full((60, 3), 2.5e-5))
    (chart,) = charts_json(overlaid({"": panels_of(run, ["tool"])}))
    assert chart["unit"] == "µm"
    assert chart["curves"][0]["values"] == [25.0] * 60
    np.testing.assert_allclose(chart["time"], run.time, rtol=1e-8)


# ---- stretches of time


def test_a_stretch_of_time_is_cut_from_all_runs():
    found = plot([made(), made(31)], "tool", start=0.5, end=1.0).charts[0]
    assert all(curve.time[0] >= 0.5 and curve.time[-1] <= 1.0 for curve in found.curves)


def test_ends_of_a_stretch_count_whatever_their_sums_round_to():
    time = np.array([0.0, 0.1, 0.1 + 0.2, 0.7])  # 0.1 + 0.2 is more than 0.3
    panels = panels_of(made(4, time=time), ["tool"])
    assert between(panels, 0.1, 0.3)[0].time.tolist() == time[1:3].tolist()
    assert between(panels_of(made(2, time=np.array([0.0, 0.3])), ["tool"]), 0.1 + 0.2, None)[0].time.tolist() == [0.3]
    assert between(panels, 0.7, None)[0].time.tolist() == between(panels, 0.7, 9.0)[0].time.tolist() == [0.7]
    assert between(panels, None, 0.0)[0].time.tolist() == [0.0]


@pytest.mark.parametrize(
    ("start", "end"), [(1.0, 1.0), (2.0, 1.0), (5.0, None), (None, -1.0), (0.5, 0.5001), (float("nan"), None)]
)
def test_stretches_with_nothing_in_them_are_refused(start, end):
    with pytest.raises(InputError, match=r"time|samples"):
        between(panels_of(made(), ["tool"]), start, end)


# ---- files


def test_plots_are_written_as_picture_and_page(tmp_path):
    found = made(about={"limits": 5.0, "law": "<b>"}).plot("effort", tmp_path / "run.svg")
    assert ElementTree.parse(tmp_path / "run.svg").getroot().tag.endswith("svg")
    assert found.save(tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    page = found.save(tmp_path / "run.html").read_text()
    assert "<b>" not in page
    assert not re.search(r'(?:src|href)="(?!#)', page)
    assert found._repr_svg_().startswith("<svg")


def test_a_run_of_one_sample_can_be_drawn(tmp_path):
    one = made(1).plot("effort", tmp_path / "one.svg")
    assert all(len(curve.time) == 1 for chart in one.charts for curve in chart.curves)
    assert one.save(tmp_path / "one.html").exists()


@pytest.mark.parametrize("name", ["run.pdf", "run", "missing/run.svg", "."])
def test_places_where_no_plot_can_be_written_are_refused(tmp_path, name):
    with pytest.raises(InputError, match=r"written as|does not exist|is a folder"):
        made().plot("effort", tmp_path / name)


def test_files_are_named_in_legends_by_as_much_as_tells_them_apart(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        save(made(), tmp_path / folder / "run.npz")
    save(made(), tmp_path / "other.npz")
    assert list(runs_of_files([tmp_path / "a/run.npz", tmp_path / "other.npz"])) == ["run", "other"]
    both = list(runs_of_files([tmp_path / "a/run.npz", tmp_path / "b/run.npz"]))
    assert both == [str(tmp_path / "a/run"), str(tmp_path / "b/run")]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["x.csv"], r"give the \.npz"),
        (["x.txt"], "no result file"),
        (["none.npz"], "no such file"),
        (["ok.npz", "ok.npz"], "given twice"),
        (["spoiled.npz"], "not a whole result file"),
    ],
)
def test_files_that_hold_no_run_are_refused(tmp_path, names, words):
    save(made(), tmp_path / "ok.npz")
    (tmp_path / "spoiled.npz").write_bytes(b"PK nothing")
    with pytest.raises(CutjointError, match=words):
        runs_of_files([tmp_path / name for name in names])


def test_a_page_needs_no_matplotlib_and_a_picture_says_that_it_does(monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    found = cutjoint.plot(made(), "effort", file=tmp_path / "run.html")
    with pytest.raises(MissingPackageError, match=r"cutjoint\[report\]"):
        found.save(tmp_path / "run.svg")
    assert not (tmp_path / "run.svg").exists()


def test_panels_keep_what_they_are_given_as_it_is():
    values = np.zeros((2, 1))
    panel = Panel("a", np.arange(2.0), values, "m", "b", ("c",), limits=np.array([[-1.0, 1.0]]))
    with pytest.raises(ValueError, match="read-only"):
        panel.limits[0, 0] = 0.0
