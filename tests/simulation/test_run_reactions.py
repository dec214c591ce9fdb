"""Reactions over a run: the same from every plant, by the state at each sample, as columns, as peaks, and as a file."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from kit.blueprint import Blueprint
from typer.testing import CliRunner

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.commands.simulate import command
from cutjoint.description import load_description
from cutjoint.errors import ActuationError, InputError, UnknownNameError
from cutjoint.mechanism import Load
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import ConstrainedPlant, ReducedPlant, Result, load, reactions_of, run, save
from cutjoint.simulation.result import ARRAYS

app = typer.Typer()
app.command()(command)
go = partial(run, duration=0.1, every=0.02)
Plants = Callable[[ClosedChain], Any]


@pytest.fixture(scope="module")
def chain() -> ClosedChain:
    """The four-bar with a damper, a spring and a rotor."""
    plain = load_description("fourbar")
    physics = {
        "crank": JointPhysics(damping=0.05, rotor=2e-5, gear=30.0),
        "rocker": JointPhysics(stiffness=0.5, rest=1.0),
    }
    joints = tuple(replace(one, physics=physics.get(one.name, one.physics)) for one in plain.joints)
    return ClosedChain(replace(plain, joints=joints))


def pushing(t: float, seen: Any) -> Load:
    """A wall of the state and of time, at the tool."""
    return Load(force=[10.0 * t, 0.0, -50.0 * seen.tool_velocity[2]])


@pytest.mark.parametrize("plant", [ConstrainedPlant, ReducedPlant])
@pytest.mark.parametrize("loads", [None, Load(force=[1.0, 0.0, -3.0]), pushing])
def test_every_sample_is_that_of_its_state(plant: Plants, loads: Any, chain: ClosedChain) -> None:
    result = go(plant(chain), lambda t: [0.5 + t], loads=loads)
    given = {"loads": loads} if callable(loads) else {}
    found = reactions_of(result, chain, **given)
    assert found.names == ("crank", "coupler", "rocker", "tool_mount", "coupler_to_rocker")
    for i in range(len(result)):
        at = chain.posture(result.q_full[i])
        outside = () if loads is None else loads
        if callable(loads):
            outside = Load(force=[10.0 * result.time[i], 0.0, -50.0 * result.tool_velocity[i, 2]])
        now = chain.reactions(at, result.v[i], effort=result.effort[i], loads=outside)
        for k, name in enumerate(found.names):
            np.testing.assert_allclose(found.force[i, k], now[name].force, rtol=0, atol=1e-9)
            np.testing.assert_allclose(found.moment[i, k], now[name].moment, rtol=0, atol=1e-9)
            assert found.unique[k] == now[name].unique


def test_both_plants_agree(chain: ClosedChain) -> None:
    first, second = (
        reactions_of(go(plant(chain), lambda t: [0.5]), chain, axes="own") for plant in (ConstrainedPlant, ReducedPlant)
    )
    np.testing.assert_allclose(first.force, second.force, rtol=0, atol=1e-6 * np.abs(first.force).max())
    assert first.unique == second.unique


def test_the_base_feels_the_change_of_momentum(chain: ClosedChain) -> None:
    """What crank and rocker pass to the base is the weight and the rate of the momentum, by differences of the run."""
    result = run(ConstrainedPlant(chain), lambda t: [0.5], duration=0.02, every=1e-3)
    found = reactions_of(result, chain, ["crank", "rocker"])
    centres = np.array([chain.centre_of_mass(chain.posture(q)) for q in result.q_full])
    mass = float(sum(link.inertial.mass for link in chain.description.links if link.inertial))
    base = chain.description.link(chain.description.root).inertial
    mass -= 0.0 if base is None else base.mass
    change = np.diff(centres, 2, axis=0) / 1e-6
    wanted = mass * (change - chain.description.gravity)
    np.testing.assert_allclose(found.force[1:-1].sum(axis=1), wanted, rtol=0, atol=1e-3 * np.abs(wanted).max())


def test_own_axes_are_those_of_the_link(chain: ClosedChain) -> None:
    result = go(ConstrainedPlant(chain))
    world, own = (reactions_of(result, chain, ["rocker"], axes=axes) for axes in ("world", "own"))
    for i, q in enumerate(result.q_full):
        axes = chain.link_placements(q)["rocker_link"][:3, :3]
        np.testing.assert_allclose(axes @ own.force[i, 0], world.force[i, 0], rtol=0, atol=1e-12)
    assert own.unique[0] == (True, True, False, False, False, True), "a hinge of the plane, its axis across"


def test_unique_means_all_the_time(tmp_path: Path) -> None:
    """A four-bar on a turntable: its plane stands along the world's axes at the last sample alone."""
    plan, x = Blueprint("turntable", np.random.default_rng(1)), np.array([1.0, 0.0, 0.0])
    plan.joint("turn", "continuous", "base", "table", [0, 0, 0], [0, 0, 1], start=0.0)
    points = {"a": [0, 0, 0.1], "b": [0, 0.1, 0.3], "d": [0, 0.5, 0.1]}
    links = {"a": ("table", "crank"), "b": ("crank", "coupler"), "d": ("table", "rocker")}
    for name, at in points.items():
        plan.joint(name, "continuous", *links[name], at, x)
    plan.cut("c", "revolute", "coupler", "rocker", [0, 0.45, 0.4], x)
    plan.actuators, plan.tool = ["turn", "a"], ("coupler", np.zeros(3))
    turntable = ClosedChain(load_description(plan.write(tmp_path)))
    result = run(ConstrainedPlant(turntable), lambda t: [2.0, 0.0], duration=0.05, every=0.025)
    backwards = {name: getattr(result, name)[::-1] for name in ARRAYS if name != "time"}
    found = reactions_of(Result(time=result.time, **backwards, about=result.about), turntable, ["b"])
    assert found.unique[0] == (False, False, True, False, False, False)
    last = turntable.full_reactions(turntable.posture(result.q_full[0]))["b"]
    assert last.unique == (False, True, True, True, False, False)


def test_columns_peaks_and_the_file(chain: ClosedChain, tmp_path: Path) -> None:
    result = go(ConstrainedPlant(chain), lambda t: [0.5])
    found = reactions_of(result, chain, "coupler")
    with found.save(tmp_path / "forces.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == list(found.columns)
    assert rows[0][:2] == ["time [s]", "coupler force x [N]"]
    assert rows[0][-1] == "coupler moment z [N m]"
    np.testing.assert_array_equal(np.array(rows[1:], dtype=float), np.column_stack(list(found.columns.values())))
    (peak,) = found.peaks
    sizes = np.linalg.norm(found.force[:, 0], axis=1)
    assert (peak.name, peak.force, peak.force_time) == ("coupler", sizes.max(), result.time[sizes.argmax()])
    with pytest.raises(InputError, match=r"\.csv"):
        found.save(tmp_path / "forces.npz")


def test_a_saved_run_tells_the_same(chain: ClosedChain, tmp_path: Path) -> None:
    result = go(ConstrainedPlant(chain), loads=Load(force=[0.0, 0.0, -3.0]))
    again = reactions_of(load(save(result, tmp_path / "run.npz")), chain)
    np.testing.assert_array_equal(again.force, reactions_of(result, chain).force)


def test_stiffness_shares_over_a_run_too(chain: ClosedChain) -> None:
    result = go(ConstrainedPlant(chain), loads=Load(force=[0.0, 5.0, 0.0]))
    soft = reactions_of(
        result, chain, stiffness={"crank": 1e4, "rocker": 1e6, "coupler": 1e6, "coupler_to_rocker": 1e6}
    )
    least = reactions_of(result, chain)
    crank = soft.names.index("crank")
    assert np.abs(soft.moment[:, crank]).max() < np.abs(least.moment[:, crank]).max()
    assert all(map(all, soft.unique)), "what was not unique is decided"


def test_more_actuators_than_freedoms() -> None:
    redundant = cutjoint.load("redundant")
    result = go(ConstrainedPlant(redundant), lambda t: [0.4, 0.2, -0.1])
    found = reactions_of(result, redundant, axes="own")
    for i, actuator in enumerate(redundant.actuators):
        moment = found.moment[:, found.names.index(actuator.name), 2]
        np.testing.assert_allclose(moment, result.effort[:, i], rtol=0, atol=1e-9)


def test_what_is_wrong_is_said(chain: ClosedChain, tmp_path: Path) -> None:
    result = go(ConstrainedPlant(chain))
    with pytest.raises(UnknownNameError, match="did you mean 'crank'"):
        reactions_of(result, chain, ["crnk"])
    with pytest.raises(InputError, match="'world' or 'own'"):
        reactions_of(result, chain, axes="joint")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="give it again"):
        reactions_of(go(ConstrainedPlant(chain), loads=pushing), chain)
    with pytest.raises(InputError, match="not of the chain fivebar"):
        reactions_of(result, cutjoint.load("fivebar"))
    paper = go(ReducedPlant(CpmModel()))
    with pytest.raises(InputError, match="simulate the chain"):
        reactions_of(paper, cutjoint.load("cpm"))
    other = Result(**{name: getattr(result, name) for name in ("time", "v", "tool", "tool_velocity", "effort", "gap",
                   "kinetic", "potential", "work", "q_full")}, q=result.q + 0.1)  # fmt: skip
    with pytest.raises(InputError, match="are not those of its configurations"):
        reactions_of(other, chain)
    loose = cutjoint.load("underactuated")
    falling = go(ConstrainedPlant(loose))
    with pytest.raises(ActuationError, match="do not tell how it moves"):
        reactions_of(falling, loose)


@pytest.mark.parametrize("plant", [ConstrainedPlant, ReducedPlant])
def test_what_sticks_is_held(plant: Plants, chain: ClosedChain) -> None:
    """A crank that its friction holds against motor and weights until the motor is stronger."""
    sticking = JointPhysics(friction=1.0, friction_speed=0.0)
    joints = [replace(one, physics=sticking) if one.name == "crank" else one for one in chain.description.joints]
    sticky = ClosedChain(replace(chain.description, joints=tuple(joints)))
    result = run(plant(sticky), lambda t: [20.0 * t], duration=0.2, every=0.01)
    found = reactions_of(result, sticky, axes="own")
    k = found.names.index("crank")
    rests = np.abs(result.v[:, 0]) <= 1e-12 * np.abs(result.v).max()
    assert 3 < rests.sum() < len(result) - 3
    gravity = sticky.terms(sticky.home).holding[0]
    np.testing.assert_allclose(found.moment[rests, k, 2], gravity, rtol=0, atol=1e-8)
    moving = result.effort[~rests, 0] - np.sign(result.v[~rests, 0])
    np.testing.assert_allclose(found.moment[~rests, k, 2], moving, rtol=0, atol=1e-8)


def test_the_command(tmp_path: Path) -> None:
    file, rest = tmp_path / "forces.csv", ["--free", "--duration", "0.03", "--every", "0.01"]
    shown = CliRunner().invoke(app, ["fourbar", "--reactions", str(file), *rest])
    assert shown.exit_code == 0, shown.output
    assert "largest reactions" in shown.output
    assert "coupler_to_rocker" in shown.output
    assert "the least" in shown.output
    figures = json.loads(CliRunner().invoke(app, ["fourbar", "--reactions", str(file), "--json", *rest]).stdout)
    peaks = {one["name"]: one for one in figures["reaction_peaks"]}
    with file.open() as opened:
        rows = list(csv.reader(opened))
    first = rows[0].index("crank force x [N]")
    forces = np.array([row[first : first + 3] for row in rows[1:]], dtype=float)
    assert peaks["crank"]["force_n"] == pytest.approx(np.linalg.norm(forces, axis=1).max())
    refused = CliRunner().invoke(app, ["cpm", "--plant", "paper", "--reactions", str(file), *rest])
    assert isinstance(refused.exception, InputError)
    assert "use --plant chain" in str(refused.exception)
