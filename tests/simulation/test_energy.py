"""The books of energy with dampers, dry friction, springs, stops and bushings: all plants, ten seconds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.held_up import held_up
from kit.loaded import minimal_of
from kit.physics import with_physics
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.plants import compiled_plant
from cutjoint.description import Joint
from cutjoint.robots import load
from cutjoint.simulation import Adaptive, ConstrainedPlant, MinimalPlant, ReducedPlant, run

ROBOTS = ["fourbar", "fivebar", "stewart", "cpm", "omega3"]
REDUCED = ["fourbar", "fivebar", "stewart", "omega3"]
"""The CPM falls until a limb is straight, where motor coordinates end and the plant says so."""
TIGHT = Adaptive(1e-11, 1e-12)
PLANTS: dict[str, Callable[[ClosedChain], Any]] = {
    "reduced": ReducedPlant,
    "constrained": ConstrainedPlant,
    "minimal": lambda chain: MinimalPlant(minimal_of(chain)),
    "compiled": lambda chain: compiled_plant(compiled(chain)),
    "machine code": lambda chain: compiled_plant(compiled(chain)),
    "compiled minimal": lambda chain: MinimalPlant(compiled(minimal_of(chain))),
}


def real(robot: str, bushings: float = 0.0, near: float = 0.0) -> ClosedChain:
    """A shipped robot with everything that joints do by themselves, its weight in part compensated.

    Args:
        robot: its name.
        bushings: part of the cuts that are bushings.
        near: of the motors' stops to home, [rad] or [m]; none at 0.
    """
    description = load(robot).description
    home = dict(zip(description.actuators, load(robot).home.q, strict=True))
    made = with_physics(description, np.random.default_rng(0), bushings)

    def stopped(joint: Joint) -> Joint:
        if near == 0.0 or joint.name not in home or not joint.type.limited:
            return joint
        physics = replace(joint.physics, stop_stiffness=500.0, stop_damping=5.0)
        at = float(home[joint.name])
        return replace(joint, limits=replace(joint.limits, lower=at - near, upper=at + near), physics=physics)

    return ClosedChain(held_up(replace(made, joints=tuple(map(stopped, made.joints))), np.random.default_rng(1)))


def books(chain: ClosedChain, plant: str, duration: float = 10.0) -> float:
    """Energy that came from nowhere in a free swing, of what was turned over: from rest where the motors do not tell
    how all joints move.  Where efforts are held, a compiled plant integrates in machine code."""
    made, report, held = PLANTS[plant](chain), chain.mobility(), plant == "machine code"
    result = run(
        made,
        integrator=None if held else TIGHT,
        rate=100.0 if held else None,
        duration=duration,
        every=duration / 20,
        start_velocity=np.full(chain.n, 0.3 if report.determined else 0.0),
        joint_limits="ignore",
    )
    assert ("machine code" in str(result.about["integrator"])) == held
    assert result.dissipated[-1] > 0.0
    assert (np.diff(result.dissipated) >= -1e-12).all()
    return float(result.energy_drift())


def cases(robots: list[str], plants: list[str], quick: str = "") -> list[Any]:
    """Robots on plants; one pair is quick."""
    return few([f"{robot}-{plant}" for robot in robots for plant in plants], quick)


@pytest.mark.parametrize(
    "case", [*cases(REDUCED, ["reduced"]), *cases(ROBOTS, ["constrained", "compiled", "machine code"])]
)
def test_ten_seconds(case: str) -> None:
    robot, plant = case.split("-")
    assert books(real(robot), plant) < 1e-8


QUICKER = ["compiled", "machine code"]


@pytest.mark.parametrize("case", [*cases(["fourbar"], list(PLANTS)), *cases(["stewart"], QUICKER)])
def test_against_stops(case: str) -> None:
    """Swings that are wider than its motors' stops are apart."""
    robot, plant = case.split("-")
    chain = real(robot, near=0.01)
    assert chain.description.joint(chain.description.actuators[0]).physics.stop_stiffness > 0.0
    assert books(chain, plant) < 1e-8


FREE = ["constrained", "minimal", "compiled", "compiled minimal", "machine code"]


@pytest.mark.parametrize(
    "case", [*cases(["fourbar"], FREE, "fourbar-machine code"), *cases(["fivebar", "omega3"], QUICKER)]
)
def test_bushings(case: str) -> None:
    """A robot with fewer motors than freedoms then, so nothing is reduced to its motors."""
    robot, plant = case.split("-")
    assert books(real(robot, bushings=1.0), plant) < 1e-8


@pytest.mark.parametrize("plant", PLANTS)
def test_a_moment_of_every_plant(plant: str) -> None:
    assert books(real("fourbar", near=0.01), plant, duration=0.02) < 1e-8
