"""Robots with idle freedoms (rods between two balls), compiled: against variational principles, and known numbers.

What the actuators leave free and nobody sees is carried along without momentum; everything in actuated coordinates
works.  The reference (`Numbers` in conftest.py) does not know what a passive joint is.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, compiled, functions_of
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.control import PD
from cutjoint.description.model import (
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError

ACROSS = np.array([0.0, 1.0, 0.0])


def rod(mass: float, length: float, spin: float, aside: float) -> Inertial:
    """A rod down its z axis; `spin` is the moment about that against the one across, `aside` shifts its centre."""
    across = mass * length**2 / 12.0
    return Inertial(mass, np.array([aside, 0.0, -0.5 * length]), np.diag([across, across, spin * across]))


def at(x: float, y: float, z: float, yaw: float = 0.0) -> np.ndarray:
    return placement((x, y, z), (0.0, 0.0, yaw))


def ankle(spin: float = 0.004, aside: float = 0.0, mass: float = 0.06, tool: bool = True) -> RobotDescription:
    """A foot on a cross, two motors, two rods with balls at both ends."""
    flat = Inertial(0.08, np.array([-0.02, 0.0, 0.0]), np.diag([1e-5, 2e-5, 2e-5]))
    foot = Inertial(0.6, np.array([0.03, 0.0, -0.03]), np.diag([5e-4, 2e-3, 2e-3]))
    links = [Link("shank"), Link("cross", Inertial(0.05, np.zeros(3), 1e-5 * np.eye(3))), Link("foot", foot)]
    joints = [
        Joint("pitch", JointType.REVOLUTE, "shank", "cross", axis=ACROSS),
        Joint("roll", JointType.REVOLUTE, "cross", "foot"),
    ]
    cuts = []
    for side, y in (("l", 0.04), ("r", -0.04)):
        links += [Link(f"crank_{side}", flat), Link(f"rod_{side}", rod(mass, 0.25, spin, aside))]
        joints += [
            Joint(f"motor_{side}", JointType.REVOLUTE, "shank", f"crank_{side}", at(0, y, 0.25), axis=ACROSS),
            Joint(f"ball_{side}", JointType.SPHERICAL, f"crank_{side}", f"rod_{side}", at(-0.04, 0, 0)),
        ]
        ends = Frame(f"rod_{side}", at(0, 0, -0.25)), Frame("foot", at(-0.04, y, 0))
        cuts.append(CutJoint(f"end_{side}", CutType.SPHERICAL, *ends))
    return RobotDescription(
        name="ankle",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        actuators=("motor_l", "motor_r"),
        tool=Frame("foot", at(0.1, 0, -0.05)) if tool else None,
        homes=(Home("default", {"motor_l": 0.0, "motor_r": 0.0}, {"ball_l": (0.0, 0.0, 0.4), "ball_r": (0, 0, -0.2)}),),
    )


def delta(angle: float = 0.4) -> RobotDescription:
    """A Delta whose six rods have balls at both ends; the arms hang `angle` below the horizontal."""
    base, arm, length, plate, half = 0.2, 0.2, 0.4, 0.05, 0.04
    inward = base + arm * np.cos(angle) - plate
    down = np.sqrt(length**2 - inward**2)
    links = [Link("base"), Link("platform", Inertial(0.2, np.zeros(3), np.diag([2e-4, 2e-4, 4e-4])))]
    joints, cuts = [], []
    passive: dict[str, Any] = {"fly": (0.0, 0.0, -arm * np.sin(angle) - down, 0.0, 0.0, 0.0)}
    for k in range(3):
        turn = 2.0 * np.pi * k / 3.0
        c, s = np.cos(turn), np.sin(turn)
        beam = Inertial(0.3, np.array([0.1, 0.0, 0.0]), np.diag([1e-4, 1e-3, 1e-3]))
        links.append(Link(f"arm{k}", beam))
        joints.append(
            Joint(f"motor{k}", JointType.REVOLUTE, "base", f"arm{k}", at(base * c, base * s, 0, turn), axis=ACROSS)
        )
        for side, y in (("a", half), ("b", -half)):
            name = f"{k}{side}"
            links.append(Link(f"rod{name}", rod(0.05, length, 0.003, 0.0)))
            joints.append(Joint(f"elbow{name}", JointType.SPHERICAL, f"arm{k}", f"rod{name}", at(arm, y, 0)))
            passive[f"elbow{name}"] = (0.0, np.arctan2(inward, down) - angle, 0.3)
            ends = (
                Frame(f"rod{name}", at(0, 0, -length)),
                Frame("platform", at(plate * c - y * s, plate * s + y * c, 0)),
            )
            cuts.append(CutJoint(f"wrist{name}", CutType.SPHERICAL, *ends))
    joints.append(Joint("fly", JointType.FLOATING, "base", "platform"))
    return RobotDescription(
        name="ball delta",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        actuators=("motor0", "motor1", "motor2"),
        tool=Frame("platform"),
        homes=(Home("default", dict.fromkeys(("motor0", "motor1", "motor2"), angle), passive),),
    )


ROBOTS: dict[str, Any] = {
    "ankle": ankle,
    "crooked ankle": lambda: ankle(aside=0.01),
    "ankle without a tool": lambda: ankle(tool=False),
    "delta": delta,
}
"""A robot whose rods are not symmetric about their axes has idle freedoms that gravity and every motion push."""
IDLE = {"ankle": 2, "crooked ankle": 2, "ankle without a tool": 2, "delta": 6}


@cache
def machine(name: str) -> Any:
    return compiled(ClosedChain(ROBOTS[name]()), cached=False)


def states(name: str, count: int, seed: int) -> Any:
    """Closed postures with the rods spun at random, velocities, accelerations."""
    robot, rng = machine(name), np.random.default_rng(seed)
    for _ in range(count):
        q = robot.source.cloud[int(rng.integers(len(robot.source.cloud)))]
        near = robot.chain.posture(q)
        here = robot.close(near.q + 0.05 * rng.uniform(-1, 1, robot.n), near)
        yield here, 3.0 * rng.normal(size=robot.n), 20.0 * rng.normal(size=robot.n)


def error_of(found: Any, wanted: Any, size: float = 0.0) -> float:
    return float(np.abs(np.asarray(found) - wanted).max() / max(np.abs(wanted).max(), size))


@pytest.mark.parametrize("name", ["ankle", "crooked ankle", pytest.param("delta", marks=pytest.mark.slow)])
def test_dynamics_are_those_of_the_principles_of_kelvin_and_gauss(kit: Any, name: str) -> None:
    robot, numbers = machine(name), kit.numbers(machine(name).chain)
    assert robot.source.idle == IDLE[name]
    worst: dict[str, float] = {}

    def note(what: str, error: float) -> None:
        worst[what] = max(worst.get(what, 0.0), error)

    for here, v, a in states(name, 12, 0):
        q = here.q_full
        tangent = numbers.tangent(q)
        effort = numbers.effort(q, v, a)
        v_full = tangent @ v
        a_full = numbers.accelerations(q, v_full, effort)
        note("a", error_of(a_full[numbers.driven], a))
        note("tangent", error_of(robot.tangent(here), tangent, 1.0))
        note("inverse", error_of(robot.inverse_dynamics(here, v, a), effort))
        note("forward", error_of(robot.forward_dynamics(here, v, effort), a))
        note("full", error_of(tangent @ a + drift_of(robot, here, v), a_full))
        terms, mass = robot.terms(here, v), numbers.mass(q)
        note("mass", error_of(terms.mass, tangent.T @ mass @ tangent))
        weight = tangent.T @ numbers.forces(q, 0 * v_full, 0 * v_full)
        note("gravity", error_of(terms.gravity, weight))
        note("sum", error_of(terms.mass @ a + terms.coriolis + terms.gravity, effort))
        tool = robot.tool(here, v)
        ahead, behind = (robot.chain.integrate(q, sign * 1e-6 * v_full) for sign in (1.0, -1.0))
        moved = (place(robot.chain, ahead) - place(robot.chain, behind)) / 2e-6
        assert error_of(tool.jacobian @ v, moved) < 1e-8
        kinetic = robot.kernel("energy")(q, v, np.zeros(0))[0]
        note("energy", error_of(kinetic, 0.5 * v_full @ mass @ v_full))
    assert max(worst.values()) < 1e-10, worst


def drift_of(robot: Any, here: Any, v: np.ndarray) -> np.ndarray:
    return np.asarray(robot.kernel("drift")(here.q_full, v, np.zeros(0))[:-1])


def place(chain: ClosedChain, q: np.ndarray) -> np.ndarray:
    tool = chain.description.tool
    assert tool is not None
    return (chain.link_placements(q)[tool.link] @ tool.placement)[:3, 3]


@pytest.mark.parametrize("name", ["crooked ankle", pytest.param("delta", marks=pytest.mark.slow)])
def test_derivatives_follow_the_tangent(kit: Any, name: str) -> None:
    robot, numbers = machine(name), kit.numbers(machine(name).chain)
    for here, v, a in states(name, 2, 1):
        effort = numbers.effort(here.q_full, v, a)
        check_slopes(robot, numbers, here.q_full, (v, a), robot.inverse_derivatives(here, v, a), numbers.effort)
        exact = robot.forward_derivatives(here, v, effort)
        check_slopes(robot, numbers, here.q_full, (v, effort), exact, partial(forward, numbers))


def check_slopes(robot: Any, numbers: Any, q: np.ndarray, at: Any, exact: Any, function: Any) -> None:
    (v, x), tangent = at, numbers.tangent(q)
    assert error_of(exact.value, function(q, v, x)) < 1e-10
    for k, one in enumerate(np.eye(robot.n)):
        along = tangent[:, k]
        for found, way, h, bound in (
            (exact.by_q, lambda s, d=along: function(robot.chain.integrate(q, s * d), v, x), 1e-4, 1e-6),
            (exact.by_v, lambda s, d=one: function(q, v + s * d, x), 1e-2, 1e-9),
            (exact.by_input, lambda s, d=one: function(q, v, x + s * d), 1e-2, 1e-9),
        ):
            assert error_of(found[:, k], difference(way, h), np.abs(found).max()) < bound


def forward(numbers: Any, q: np.ndarray, v: np.ndarray, effort: np.ndarray) -> np.ndarray:
    found: np.ndarray = numbers.accelerations(q, numbers.tangent(q) @ v, effort)[numbers.driven]
    return found


def difference(function: Any, h: float) -> np.ndarray:
    """Derivative at 0; what a straight step opens the loops by is even in it and cancels."""
    one, two = ((function(k * h) - function(-k * h)) / (2 * k * h) for k in (1, 2))
    return np.asarray((4.0 * one - two) / 3.0)


def test_the_holding_torque_is_the_slope_of_the_potential() -> None:
    """The ankle by hand: at rest the foot hangs below its cross and both motors share its moment."""
    robot = machine("ankle")
    zero = np.zeros(2)
    for angles in ((0.0, 0.0), (0.3, 0.1)):
        here = robot.close(angles)
        held = robot.inverse_dynamics(here, zero, zero)
        h = 1e-5
        slope = [
            (
                robot.potential_energy(robot.close(here.q + h * e, here))
                - robot.potential_energy(robot.close(here.q - h * e, here))
            )
            / (2 * h)
            for e in np.eye(2)
        ]
        np.testing.assert_allclose(held, slope, atol=1e-8)
    home = robot.inverse_dynamics(robot.close(zero), zero, zero)
    # a crank carries its own weight and half of a rod; the other half and half of the foot, in front of its axis, act
    # through the rod on the same lever
    gravity, lever = 9.81, 0.04
    cranks = 0.02 * 0.08 + lever * 0.06 / 2.0
    foot = lever * 0.06 / 2.0 - 0.03 * 0.6 / 2.0
    np.testing.assert_allclose(home, np.full(2, gravity * (cranks + foot)), rtol=1e-12)


@pytest.mark.slow
def test_the_delta_by_hand() -> None:
    """All arms move alike, so the platform keeps its height: a robot of one coordinate, by Lagrange."""
    robot, angle = machine("delta"), 0.4
    here, zero = robot.home, np.zeros(3)
    inward, arm, rod_mass, length = 0.15 + 0.2 * np.cos(angle), 0.2, 0.05, 0.4
    down = np.sqrt(length**2 - inward**2)
    # what elbow and platform sink by the angle
    elbow = arm * np.cos(angle)
    platform = elbow + inward * (arm * np.sin(angle)) / down
    potential = -9.81 * (3 * 0.3 * 0.5 * elbow + 6 * rod_mass * 0.5 * (elbow + platform) + 0.2 * platform)
    held = robot.inverse_dynamics(here, zero, zero)
    np.testing.assert_allclose(held, np.full(3, potential / 3.0), rtol=1e-12)
    # kinetic energy at unit rate: arms about their motors, rods by their ends, the platform
    top = arm * np.array([-np.sin(angle), -np.cos(angle)])
    bottom = np.array([0.0, -platform])
    rods = rod_mass / 6.0 * (top @ top + top @ bottom + bottom @ bottom)
    inertia = 3 * (1e-3 + 0.3 * 0.1**2) + 2 * 6 * rods + 0.2 * platform**2
    fall = robot.forward_dynamics(here, zero, zero)
    np.testing.assert_allclose(fall, np.full(3, -potential / inertia), rtol=1e-12)


@pytest.mark.parametrize("how", ["no spin inertia", "no mass"])
def test_rods_that_spin_without_mass(kit: Any, how: str) -> None:
    """A rod whose spin moves no mass is left at the least motion; it is the limit of ever thinner rods."""
    chain = ClosedChain(ankle(spin=0.0) if how == "no spin inertia" else ankle(mass=0.0))
    robot = compiled(chain, cached=False)
    plan = robot.source.plan.idle
    assert (plan.heavy, sorted(plan.weightless)) == ((), [0, 1])
    thin = compiled(ClosedChain(ankle(spin=1e-9) if how == "no spin inertia" else ankle(mass=1e-9)), cached=False)
    rng = np.random.default_rng(2)
    numbers = kit.numbers(chain)
    for _ in range(5):
        here = robot.close(0.2 * rng.uniform(-1, 1, 2))
        same = thin.close(here.q)
        v, a = rng.normal(size=2), rng.normal(size=2)
        effort = robot.inverse_dynamics(here, v, a)
        np.testing.assert_allclose(effort, thin.inverse_dynamics(same, v, a), rtol=0, atol=1e-7)
        np.testing.assert_allclose(robot.forward_dynamics(here, v, effort), a, rtol=0, atol=1e-10)
        # of all motions of the joints with these actuated rates it is the least one
        tangent, basis = robot.tangent(here), numbers.allowed(here.q_full)
        idle = basis @ np.linalg.svd(basis[numbers.driven])[2][2:].T
        assert np.abs(idle.T @ tangent).max() < 1e-12
        assert np.abs(numbers.constraints(here.q_full) @ tangent).max() < 1e-12
        # in full coordinates too, whatever the rods spin by
        v_full, push = tangent @ v + idle @ rng.normal(size=2), chain.full_effort(effort)
        found = robot.kernel("full_forward")(here.q_full, v_full, push, np.zeros(0))
        wanted = chain.full_forward_dynamics(here, v_full, push).acceleration
        assert found[-1] <= STRAIN_LIMIT
        np.testing.assert_allclose(found[:-1], wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


def test_closing_and_reaching_hold_the_idle_rates() -> None:
    robot = machine("ankle")
    rng = np.random.default_rng(3)
    for _ in range(10):
        q = 0.2 * rng.uniform(-1, 1, 2)
        here = robot.close(q)
        assert max(here.gap) < 1e-13
        np.testing.assert_allclose(here.q, q, rtol=0, atol=1e-15)
        # a step and the step back: what is held comes back to where it was
        there = robot.close(q + 0.05, here)
        back = robot.close(q, there)
        np.testing.assert_allclose(back.q_full, here.q_full, rtol=0, atol=5e-3)
        again = robot.reach(robot.tool(here).position)
        np.testing.assert_allclose(again.q, q, rtol=0, atol=1e-12)
    batch = robot.batch.close(0.1 * rng.uniform(-1, 1, (20, 2)))
    assert max(robot.chain.gap(row)[0] for row in batch) < 1e-13


@pytest.mark.slow
def test_a_delta_with_ball_rods_reaches() -> None:
    robot, rng = machine("delta"), np.random.default_rng(4)
    for _ in range(5):
        target = robot.tool(robot.home).position + 0.03 * rng.uniform(-1, 1, 3)
        np.testing.assert_allclose(robot.tool(robot.reach(target)).position, target, rtol=0, atol=1e-14)


def test_without_a_tool_a_rod_between_two_balls_is_still_idle() -> None:
    robot, seen = machine("ankle without a tool"), machine("ankle")
    v, a = np.array([1.0, -2.0]), np.array([3.0, 4.0])
    np.testing.assert_array_equal(robot.inverse_dynamics(robot.home, v, a), seen.inverse_dynamics(seen.home, v, a))


def test_what_moves_the_tool_or_hangs_on_one_joint_is_not_idle() -> None:
    """A pendulum on a ball spins too, but nothing holds its other end; and a tool on the rod is seen to turn."""
    description = ankle(tool=False)
    bob = Link("bob", rod(0.05, 0.1, 0.01, 0.0))
    hung = Joint("hinge", JointType.SPHERICAL, "foot", "bob", at(0, 0, -0.1))
    loose = replace(description, links=(*description.links, bob), joints=(*description.joints, hung))
    on_rod = replace(description, tool=Frame("rod_l", at(0.02, 0, -0.1)))
    for robot in (compiled(ClosedChain(loose), cached=False), compiled(ClosedChain(on_rod), cached=False)):
        assert robot.source.idle is None
        assert functions_of(robot) == ("full_forward", "full_motion")
        with pytest.raises(ActuationError):
            robot.inverse_dynamics(robot.home, np.zeros(2), np.zeros(2))


def test_a_free_swing_keeps_its_energy() -> None:
    """Runs go along T~ with the loops closed after every step: with symmetric rods nothing is lost or won."""
    robot = machine("ankle")
    loop = ClosedLoop(robot, PD(1e-12, 1e-12), robot)
    steps, step = 300, 1e-3
    table = np.zeros((2 * steps + 1, loop.sizes.columns))
    starts = np.array([[0.1, -0.1], [0.2, 0.15], [0.0, 0.1]])
    many = loop.run(table, step=step, every=0.05, start=starts)
    assert not many.failed
    for run in range(3):
        energies = [
            robot.kernel("energy")(q, v, np.zeros(0))[:2].sum()
            for q, v in zip(many.positions[run], many.v[run], strict=True)
        ]
        swing = np.ptp([robot.kernel("energy")(q, np.zeros(2), np.zeros(0))[1] for q in many.positions[run]])
        assert swing > 1e-3
        assert np.ptp(energies) < 1e-6 * swing
        assert max(robot.chain.gap(many.positions[run, -1])) < 1e-12


def test_what_the_idle_freedoms_lose_counts_as_strain() -> None:
    """A rod whose mass is an argument: the less it weighs against the one that was compiled for, the more strain."""
    robot = compiled(ClosedChain(ankle()), parameters=["rod_l"], cached=False)
    home, zero = robot.home.q_full, np.zeros(2)
    strains = [robot.kernel("inverse")(home, zero, zero, np.array([mass]))[-1] for mass in (0.06, 0.06e-2, 0.06e-4)]
    assert strains[0] < 8.0
    np.testing.assert_allclose(strains[1:], 1.0 / np.array([1e-2, 1e-4]), rtol=0.5)
    assert strains[2] > STRAIN_LIMIT
    assert not robot.kernel("inverse")(home, zero, zero, np.zeros(1))[-1] <= STRAIN_LIMIT


def chains() -> dict[str, Any]:
    return {**ROBOTS, "no spin inertia": lambda: ankle(spin=0.0), "no mass": lambda: ankle(mass=0.0)}


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.slow] * (x == "delta")) for x in chains()])
def test_the_chain_says_the_same(name: str) -> None:
    chain = ClosedChain(chains()[name]())
    if not chain.mobility().determined:
        pytest.skip("this chain takes idle freedoms for missing motors")
    robot, rng = compiled(chain), np.random.default_rng(6)
    for _ in range(4):
        here = robot.close(chain.home.q + 0.1 * rng.uniform(-1, 1, chain.n))
        v, a = rng.normal(size=chain.n), 5.0 * rng.normal(size=chain.n)
        assert error_of(robot.tangent(here), chain.tangent(here)) < 1e-10
        # an acceleration about an axis of a 300th of the rod's inertia is a small difference of large moments
        assert error_of(drift_of(robot, here, v), chain.drift(here, v)) < 1e-9
        effort = chain.inverse_dynamics(here, v, a)
        assert error_of(robot.inverse_dynamics(here, v, a), effort) < 1e-10
        assert error_of(robot.forward_dynamics(here, v, effort), chain.forward_dynamics(here, v, effort)) < 1e-10
        terms, wanted = robot.terms(here, v), chain.terms(here, v)
        size = np.abs(wanted.gravity).max() + np.abs(wanted.coriolis).max()
        for part in ("mass", "coriolis", "gravity"):
            assert error_of(getattr(terms, part), getattr(wanted, part), size * (part != "mass")) < 1e-10
        if chain.description.tool is not None:
            assert error_of(robot.tool(here, v).drift, chain.tool(here, v).drift) < 1e-10


def test_runs_whose_idle_freedoms_gain_momentum_are_refused() -> None:
    """A rod that is not round is pushed about its axis: the motors' coordinates do not tell where it has spun to."""
    if not hasattr(machine("ankle").chain, "idle_is_cyclic"):
        pytest.skip("this chain does not say whether its idle freedoms are cyclic")
    assert machine("ankle").idle_is_cyclic
    with pytest.raises(ActuationError, match="momentum"):
        ClosedLoop(machine("crooked ankle"), PD(1.0, 1.0), machine("crooked ankle"))
