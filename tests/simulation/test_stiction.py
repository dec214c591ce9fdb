"""Stiction against what can be solved by hand: when a block on a spring stops, sticks and starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kit.quickly import few
from scipy.optimize import linprog

from cutjoint.chain import ClosedChain
from cutjoint.control import NoControl
from cutjoint.description import Frame, Inertial, Joint, JointPhysics, JointType, Link, RobotDescription
from cutjoint.mechanism import Load
from cutjoint.robots import load
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, RungeKutta4, State, run

TIGHT = Adaptive(1e-11, 1e-12)


def block(
    mass: float, stiffness: float, friction: float, axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
) -> ClosedChain:
    """A block that slides on a spring, weightless."""
    physics = JointPhysics(friction=friction, friction_speed=0.0, stiffness=stiffness, rest=0.0)
    slide = Joint("slide", JointType.PRISMATIC, "base", "block", physics=physics)
    links = (Link("base"), Link("block", Inertial(mass, np.zeros(3), 0.01 * np.eye(3))))
    return ClosedChain(
        RobotDescription("block", links, (slide,), actuators=("slide",), tool=Frame("block"), gravity=np.zeros(3))
    )


def swings(x0: float, mass: float, stiffness: float, friction: float) -> tuple[list[float], float]:
    """When a block let go at `x0` stands still, and where it stays: half swings about +-friction / stiffness."""
    half, shift, x, t, stops = np.pi * np.sqrt(mass / stiffness), friction / stiffness, x0, 0.0, []
    while abs(x) > shift:
        x = -x + 2.0 * np.sign(x) * shift
        t += half
        stops.append(t)
    return stops, x


def crossings(result) -> list[float]:
    """When the block came to rest: the ends of steps at which its speed is zero after it was not."""
    v = result.v[:, 0]
    return [float(result.time[i]) for i in range(1, len(v)) if v[i] == 0.0 and v[i - 1] != 0.0]


@pytest.mark.parametrize("seed", few(range(6), 1))
@pytest.mark.parametrize("plant", [ReducedPlant, ConstrainedPlant])
def test_it_stops_turns_round_and_sticks_on_time(seed: int, plant) -> None:
    rng = np.random.default_rng(seed)
    mass, stiffness = rng.uniform(0.1, 10.0), rng.uniform(1.0, 1000.0)
    x0 = rng.uniform(0.05, 0.5) * rng.choice([-1.0, 1.0])
    friction = abs(x0) * stiffness * rng.uniform(0.05, 0.45)
    chain = block(mass, stiffness, friction)
    stops, rest = swings(x0, mass, stiffness, friction)
    result = run(plant(chain), NoControl(), integrator=TIGHT, duration=1.3 * stops[-1], start=chain.close([x0]))
    found = crossings(result)
    assert len(found) == len(stops)
    assert found == pytest.approx(stops, abs=1e-6 * np.sqrt(mass / stiffness))
    assert result.q[-1, 0] == pytest.approx(rest, abs=1e-8)
    assert not result.v[-3:].any()
    assert result.energy_drift() < 1e-8


@pytest.mark.parametrize("slope", [0.5, 3.0, -2.0])
def test_it_starts_when_the_pull_exceeds_the_friction(slope: float) -> None:
    chain = block(2.0, 0.0, 1.5)

    def pull(t: float, seen: object) -> Load:
        return Load(force=[slope * t, 0.0, 0.0])

    starts = 1.5 / abs(slope)
    result = run(ReducedPlant(chain), NoControl(), integrator=TIGHT, duration=2.0 * starts, loads=pull)
    first = float(result.time[np.flatnonzero(result.v[:, 0])[0] - 1])
    assert first == pytest.approx(starts, abs=1e-6)
    # m v' = slope t - friction from then on
    wanted = np.sign(slope) * (0.5 * abs(slope) * starts**2) / 2.0
    assert result.v[-1, 0] == pytest.approx(wanted, rel=1e-8)


@pytest.mark.slow
def test_fixed_steps_find_the_same_instants_to_their_order() -> None:
    chain = block(1.0, 100.0, 3.0)
    stops, rest = swings(0.2, 1.0, 100.0, 3.0)
    result = run(
        ReducedPlant(chain),
        NoControl(),
        integrator=RungeKutta4(1e-3),
        duration=1.2 * stops[-1],
        start=chain.close([0.2]),
    )
    assert crossings(result) == pytest.approx(stops, abs=1e-6)
    assert result.q[-1, 0] == pytest.approx(rest, abs=1e-6)


def rubbing(robot: str, friction: float) -> ClosedChain:
    """A shipped robot whose joints of one coordinate all have stiction."""
    description = load(robot).description
    sticky = JointPhysics(friction=friction, friction_speed=0.0)
    joints = tuple(replace(one, physics=sticky) if one.type.single else one for one in description.joints)
    return ClosedChain(replace(description, joints=joints))


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["fourbar", "fivebar"])
def test_passive_joints_stick_too(robot: str) -> None:
    """More friction than weights: it stays where it is.  Less: it falls, and energy is kept."""
    held = rubbing(robot, 50.0)
    still = run(ReducedPlant(held), NoControl(), duration=0.2, joint_limits="ignore")
    assert np.abs(still.q - still.q[0]).max() < 1e-12
    free = rubbing(robot, 0.02)
    plants = [ReducedPlant(free), ConstrainedPlant(free)]
    span = 1.0 if robot == "fourbar" else 0.15  # before the five-bar falls through a singularity
    falls = [
        run(one, NoControl(), integrator=TIGHT, duration=span, every=0.05, joint_limits="ignore") for one in plants
    ]
    assert np.abs(falls[0].q - falls[0].q[0]).max() > 0.1
    assert np.abs(falls[0].q - falls[1].q).max() < 1e-7
    assert max(one.energy_drift() for one in falls) < 1e-8


def test_a_state_may_start_in_motion() -> None:
    chain = block(1.0, 0.0, 2.0)
    result = run(ReducedPlant(chain), NoControl(), integrator=TIGHT, duration=1.0, start_velocity=[-1.0])
    assert crossings(result) == pytest.approx([0.5], abs=1e-9)
    assert result.q[-1, 0] == pytest.approx(-0.25, abs=1e-9)
    assert isinstance(ReducedPlant(chain).start(chain.home, np.zeros(1)), State)


def test_many_joints_of_one_motion_hold_no_more_than_their_friction() -> None:
    """A Stewart platform with stiction in twelve hinges, pushed to and fro: it rests only where all that rest can hold
    it within their friction, and each joint that slips has its whole friction against it."""
    rng = np.random.default_rng(3)
    description = load("stewart").description
    joints = tuple(
        replace(one, physics=JointPhysics(friction=5.0 * rng.uniform(0.5, 2.0), friction_speed=0.0))
        if one.type.single and rng.uniform() < 0.6
        else one
        for one in description.joints
    )
    plant = ConstrainedPlant(ClosedChain(replace(description, joints=joints)))
    assert len(plant.sticking) > plant.chain.n
    result = run(
        plant, lambda t: 10.0 * np.sin(30.0 * t) * np.ones(6), duration=0.15, every=0.01, joint_limits="ignore"
    )
    assert result.energy_drift() < 1e-7
    stands = np.abs(result.v).max(axis=1) < 1e-9
    assert stands.any()
    assert not stands.all()
    rows, held = plant.chain, plant.chain.sticking
    for k in np.flatnonzero(stands)[1:]:
        at = rows.posture(result.q_full[k])
        free = rows.full_forward_dynamics(at, np.zeros(rows.nv), rows.full_effort(result.effort[k])).acceleration
        pushes = np.eye(rows.nv)[list(held)]
        moved = np.array([rows.full_forward_dynamics(at, np.zeros(rows.nv), one).acceleration for one in pushes])
        weight = rows.full_forward_dynamics(at, np.zeros(rows.nv), np.zeros(rows.nv)).acceleration
        bounds = [(-f, f) for f in held.values()]
        balance = linprog(np.zeros(len(held)), A_eq=(moved - weight).T, b_eq=-free, bounds=bounds)
        assert balance.status == 0, "no forces within the friction hold it"
