"""Minimal coordinates, compiled: the same answers, exact derivatives, and the same runs."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import random_mounting
from kit.built import built
from kit.loaded import minimal_of, random_loads
from kit.mechanisms import MECHANISMS
from kit.quickly import few
from kit.small import write

import cutjoint
from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.chain.minimal import MinimalCoordinates
from cutjoint.compile import CompiledMinimal
from cutjoint.description import load_description
from cutjoint.errors import CompileError, InputError
from cutjoint.simulation import Adaptive, MinimalPlant, run

pytest.importorskip("llvmlite")


def minimal(name: str, folder: Path, scale: float = 1.0) -> tuple[MinimalCoordinates, np.random.Generator]:
    """Of a shipped robot, or of a mechanism with one motor, drawn and mounted anyhow."""
    rng = np.random.default_rng([61, *name.encode()])
    if name not in MECHANISMS:
        return minimal_of(cutjoint.load(name)), rng
    plan = MECHANISMS[name](rng).plan
    plan.actuators = plan.actuators[:1]
    return minimal_of(built(plan, folder, random_mounting(rng), scale)[0]), rng


ROUND = [name for name in MECHANISMS if not name.startswith("ball_rod") and "equal" not in name and "flat" not in name]
QUICK = ("underactuated", "planar_3rrr")


@pytest.mark.parametrize("name", few(["underactuated", "redundant", "fivebar", *ROUND], *QUICK))
@pytest.mark.parametrize("scale", few([1.0, 1e-3, 1e3], 1.0))
def test_compiled_is_the_same(name: str, scale: float, tmp_path: Path) -> None:
    coordinates, rng = minimal(name, tmp_path, scale)
    compiled = cutjoint.compiled(coordinates, cached=False)
    assert isinstance(compiled, CompiledMinimal)
    chain, n = coordinates.chain, coordinates.n
    own = np.where(np.array(coordinates.units) == "m", chain.length, 1.0)
    rate = np.sqrt(9.81 / chain.length)
    at = coordinates.moved(chain.home, 0.03 * own * rng.normal(size=n))
    v, a = rate * own * rng.normal(size=n), rate**2 * own * rng.normal(size=n)
    loads = random_loads(chain, rng, 9.81)
    force = coordinates.inverse_dynamics(at, v, a, loads)
    effort = np.abs(force / own).max() * rng.normal(size=chain.n)

    def same(ask: Any, unit: Any = 1.0, size: float = 0.0) -> None:
        one, two = (np.asarray(ask(robot)) * unit for robot in (coordinates, compiled))
        assert np.abs(one - two).max(initial=0.0) <= 1e-10 * max(np.abs(one).max(initial=0.0), size)

    worst = float(np.abs(own * force).max())
    quick = max(rate**2, float(np.abs(coordinates.forward_dynamics(at, v, effort, loads) / own).max()))
    same(lambda robot: robot.forward_dynamics(at, v, effort, loads), 1.0 / own, quick)
    same(lambda robot: robot.inverse_dynamics(at, v, a, loads), own, worst)
    same(lambda robot: robot.terms(at, v).mass, np.outer(own, own))
    same(lambda robot: robot.terms(at, v).bias, own, worst)
    same(lambda robot: robot.tangent(at) * own)
    same(lambda robot: robot.drift(at, v) / chain._k.column_scale, 1.0, rate**2)
    same(lambda robot: robot.effort_map(at).T * own)
    same(lambda robot: robot.kinetic_energy(at, v))
    same(lambda robot: robot.moved(at, 0.01 * own).q_full)
    assert compiled._call("forward", at, v, a) is not None, "it was the compiled function that answered"


@pytest.mark.parametrize("name", few(["underactuated", "planar_3rrr", "floating_fourbar"], "underactuated"))
def test_derivatives_are_those_along_the_coordinates(name: str, tmp_path: Path) -> None:
    coordinates, rng = minimal(name, tmp_path)
    compiled = cutjoint.compiled(coordinates)
    at, n = coordinates.chain.home, coordinates.n
    v, x = rng.normal(size=n), rng.normal(size=n)
    for what, ask in (("forward", coordinates.accelerated), ("inverse", coordinates.inverse_dynamics)):
        found = getattr(compiled, f"{what}_derivatives")(at, v, x)
        step = 1e-5
        columns = [[], [], []]
        for one in np.eye(n) * step:
            pairs = (
                [(coordinates.moved(at, sign * one), v, x) for sign in (1.0, -1.0)],
                [(at, v + sign * one, x) for sign in (1.0, -1.0)],
                [(at, v, x + sign * one) for sign in (1.0, -1.0)],
            )
            for column, (ahead, behind) in zip(columns, pairs, strict=True):
                column.append((ask(*ahead) - ask(*behind)) / (2.0 * step))
        for name_, wanted in zip(("by_q", "by_v", "by_input"), map(np.transpose, columns), strict=True):
            assert np.abs(getattr(found, name_) - wanted).max() < 1e-6 * np.abs(wanted).max()
        value = ask(at, v, x)
        assert np.abs(found.value - value).max() < 1e-10 * np.abs(value).max()


def test_runs_batches_and_pickles() -> None:
    coordinates = cutjoint.load("underactuated").minimal("left")
    compiled = pickle.loads(pickle.dumps(cutjoint.compiled(coordinates)))
    tight = Adaptive(1e-10, 1e-12)
    start = MinimalPlant(coordinates).state(coordinates.moved(coordinates.chain.home, [0.0, 0.4]), [0.1, 0.0])
    load = Load([2.0, 0.0, 0.0])
    one, two = (
        run(MinimalPlant(robot), lambda t: [1.0], start=start, duration=0.1, integrator=tight, loads=load)
        for robot in (coordinates, compiled)
    )
    assert np.abs(one.q_full[-1] - two.q_full[-1]).max() < 1e-9
    assert two.energy_drift() < 1e-8
    assert two.about["plant"] == "underactuated, compiled, minimal"
    rng = np.random.default_rng(3)
    v, force = rng.normal(size=(2, 50, 2))
    q = np.repeat(coordinates.chain.home.q_full[None], 50, axis=0)
    many = compiled.kernel("forward").batch([q, v, force, np.zeros((50, 0))])[0]
    each = [coordinates.accelerated(coordinates.chain.home, *state) for state in zip(v, force, strict=True)]
    assert np.abs(many - each).max() < 1e-10 * np.abs(each).max()


def test_what_cannot_be_compiled_is_told() -> None:
    coordinates = cutjoint.load("underactuated").minimal("left")
    with pytest.raises(InputError, match="no parameters stay arguments"):
        cutjoint.compiled(coordinates, parameters=["payload"])
    compiled = cutjoint.compiled(coordinates)
    with pytest.raises(InputError, match="no task and no parameters"):
        compiled.kernel("reach_step")
    other = cutjoint.load("fourbar")
    with pytest.raises(InputError, match="this posture has"):
        compiled.terms(other.home)


def test_robots_that_their_loops_hold_have_nothing_to_compile(tmp_path: Path) -> None:
    locked = ClosedChain(load_description(write("locked door", tmp_path)))
    with pytest.raises(CompileError, match="no coordinate"):
        cutjoint.compiled(locked.minimal(), cached=False).forward_dynamics(locked.home, np.zeros(0), np.zeros(0))
