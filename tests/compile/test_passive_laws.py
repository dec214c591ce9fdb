"""Laws of dampers, friction, springs, stops, rotors and bushings, compiled: slopes, power, and what leaves no trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit import mechanisms
from kit.blueprint import random_mounting
from kit.held_up import weighing
from kit.lively import Strength, lively, states, without_stops
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.equations.acting import Coefficients, OnBall, OnCoordinate
from cutjoint.compile.equations.turning import from_quaternion
from cutjoint.compile.expressions.derivative import tangent as along
from cutjoint.compile.expressions.graph import Graph, Number
from cutjoint.compile.expressions.program import interpret
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.functions.table import FUNCTIONS
from cutjoint.compile.functions.tracing import accelerations
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.description import check_description, load_description
from cutjoint.description.model import RobotDescription
from cutjoint.errors import CompileError
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.simulation import Adaptive, ReducedPlant, run

SHIPPED = ("fourbar", "fivebar", "omega3", "cpm", "stewart")
MADE = ("planar_3rrr", "prs_3", "ups_6", "scotch_yoke", "geared_fivebar", "ball_rod_delta")


def shipped(kit: Any, name: str, seed: int = 0) -> Any:
    """A robot under urdf/ with physics everywhere."""
    return ClosedChain(lively(kit.model(name).description, np.random.default_rng(seed)))


@pytest.mark.parametrize("name", few(("fivebar", "omega3", "cpm"), "fivebar"))
def test_derivatives_are_slopes(kit: Any, name: str) -> None:
    chain = shipped(kit, name, 7)
    machine, rng = compiled(chain, cached=False), np.random.default_rng(8)
    at, v, a, effort = states(chain, rng, 1)[0]
    for exact, ask, given in (
        (machine.inverse_derivatives(at, v, a), machine.inverse_dynamics, a),
        (machine.forward_derivatives(at, v, effort), machine.forward_dynamics, effort),
    ):
        step = 1e-5
        for k, one in enumerate(step * np.eye(chain.n)):
            here = [chain.close(at.q + sign * one, at, limits="ignore") for sign in (1.0, -1.0)]
            slope = (ask(here[0], v, given) - ask(here[1], v, given)) / (2 * step)
            assert np.abs(slope - exact.by_q[:, k]).max() < 1e-6 * np.abs(exact.by_q).max()
            slope = (ask(at, v + one, given) - ask(at, v - one, given)) / (2 * step)
            assert np.abs(slope - exact.by_v[:, k]).max() < 1e-6 * np.abs(exact.by_v).max()


def power(source: ChainSource, q: np.ndarray, v: np.ndarray, effort: np.ndarray) -> tuple[float, float]:
    """Rate of the energy along the motion less what the motors give and friction takes, and its size [W]."""
    graph = Graph()
    at = graph.symbols(source.positions)
    speed, push = graph.symbols(source.n), graph.symbols(source.n)
    state = source.state(graph, at, [])
    kinetic: Number = 0.0
    for x, row in zip(speed, state.mass(), strict=True):
        for y, entry in zip(speed, row, strict=True):
            kinetic = kinetic + 0.5 * x * entry * y
    a, _ = accelerations(state, speed, push)
    seed = {abs(x.ref): rate for x, rate in zip(at, state.position_rate(speed), strict=True)}
    seed.update({abs(x.ref): rate for x, rate in zip(speed, a, strict=True)})
    given = [x * y for x, y in zip(speed, push, strict=True)]
    lost = [x * y for x, y in zip(speed, state.friction(speed), strict=True)]
    stored = along(graph, [kinetic, state.potential()], seed)
    program = assemble(graph, "power", {"q": at, "v": speed, "u": push}, {"p": [*stored, *given, *lost]})
    values = np.array(interpret(program, [*q, *v, *effort]), dtype=float)
    n = source.n
    return float(values[: 2 + n].sum() - 2 * values[2 : 2 + n].sum() + values[2 + n :].sum()), float(
        np.abs(values).sum()
    )


@pytest.mark.parametrize("name", few((*SHIPPED, *MADE), "fivebar", "scotch_yoke"))
def test_the_energy_gains_what_motors_give_and_friction_leaves(kit: Any, tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(9)
    if name in MADE:
        plan = mechanisms.MECHANISMS[name](rng).plan
        chain = ClosedChain(lively(load_description(plan.write(tmp_path, random_mounting(rng))), rng))
    else:
        chain = shipped(kit, name, 10)
    if chain.idle_is_cyclic:
        for at, v, _, effort in states(chain, rng, 3):
            off, size = power(ChainSource(chain), at.q_full, v, effort)
            assert abs(off) < 1e-11 * size


@pytest.mark.parametrize("name", few(("fivebar", "omega3", "cpm"), "fivebar"))
def test_what_does_nothing_leaves_no_trace(kit: Any, name: str) -> None:
    """Rests, gears, friction speeds and stop dampers alone make no instruction; nor is anything left of `ideal`."""
    plain = kit.model(name).description
    idle = JointPhysics(friction_speed=0.3, rest=0.2, gear=7.0, stop_damping=0.0)
    resting = replace(
        plain,
        joints=tuple(replace(one, physics=idle) for one in plain.joints),
        cuts=tuple(replace(one, physics=replace(idle, gear=1.0)) for one in plain.cuts),
    )
    ideal = weighing(lively(plain, np.random.default_rng(11), bushings=0).ideal())
    sources = [ChainSource(ClosedChain(one)) for one in (plain, resting, ideal)]
    for what in ("forward", "inverse", "terms", "energy", "full_forward", "drift"):
        made = [FUNCTIONS[what].program(source, fused=True).to_bytes() for source in sources]
        assert made[0] == made[1] == made[2], what


def test_every_number_is_in_the_content(kit: Any) -> None:
    """Two robots that differ in one number have different stored programs."""
    rng = np.random.default_rng(12)
    robot = lively(kit.model("fivebar").description, rng)
    contents = {ChainSource(ClosedChain(robot)).content}
    changed = 0
    for part in ("joints", "cuts"):
        for index, one in enumerate(getattr(robot, part)):
            others = [replace(one, physics=replace(one.physics, **{f.name: 0.123})) for f in fields(JointPhysics)]
            if part == "cuts" and one.bushing is not None:
                others += [replace(one, bushing=replace(one.bushing, **{f.name: 0.123})) for f in fields(one.bushing)]
            if part == "joints" and one.physics.stop_stiffness:
                others += [replace(one, limits=replace(one.limits, **{side: 0.123})) for side in ("lower", "upper")]
            for other in others:
                items = list(getattr(robot, part))
                items[index] = other
                made = replace(robot, **{part: tuple(items)})
                if any(one.severity == "error" for one in check_description(made)):
                    continue
                contents.add(ChainSource(ClosedChain(made)).content)
                changed += 1
    assert len(contents) == changed + 1


def sticking(robot: RobotDescription) -> RobotDescription:
    first, *others = robot.joints
    return replace(robot, joints=(replace(first, physics=JointPhysics(friction=1.0, friction_speed=0.0)), *others))


def test_stiction_is_refused(kit: Any) -> None:
    machine = compiled(ClosedChain(sticking(kit.model("fivebar").description)), cached=False)
    name = machine.chain.description.joints[0].name
    for ask in (
        lambda: machine.forward_dynamics(machine.home, np.zeros(2), np.zeros(2)),
        lambda: machine.terms(machine.home),
        lambda: machine.full_acceleration(machine.home.q_full, np.zeros(4), np.zeros(4)),
    ):
        with pytest.raises(CompileError, match=f"friction of {name} holds what rests.*friction_speed above 0"):
            ask()
    machine.tool(machine.home)
    machine.close(machine.home.q + 0.01)


def test_a_ball_at_rest_and_a_joint_at_its_stop_have_slopes() -> None:
    """Where a size that is divided by is zero, and where a stop begins: finite, and what the free side has."""
    graph = Graph()
    q, u = graph.symbols(4), graph.symbols(3)
    physics = JointPhysics(2.0, 3.0, 0.5, 7.0, 0.0, stop_stiffness=11.0, stop_damping=1.0)
    numbers = Coefficients.of("one", physics, {})
    ball = OnBall({k: (float(k == 0), float(k == 1), float(k == 2)) for k in range(3)}, from_quaternion(*q), numbers)
    joint = OnCoordinate({0: 1.0}, q[0], numbers, -1.0, 0.0)
    outputs = [
        *(x for _, x in ball.springs()),
        *(x for _, x in ball.friction(u)),
        joint.springs()[0][1],
        joint.friction(u)[0][1],
    ]
    found = []
    for symbol in (*q[:3], *u):
        line = assemble(graph, "slopes", {"q": q, "u": u}, {"p": along(graph, outputs, {abs(symbol.ref): 1.0})})
        found.append(interpret(line, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    slopes = np.array(found, dtype=float)
    wanted = np.zeros((6, 8))
    wanted[:3, :3] = 2.0 * 7.0 * np.eye(3)  # a quaternion moves by half the angle
    steep = 2.0 + 3.0 * 15.0 / 8.0 / 0.5
    wanted[3:, 3:6] = steep * np.eye(3)
    wanted[0, 6], wanted[3, 7] = 7.0, steep
    np.testing.assert_allclose(slopes, wanted, rtol=1e-12, atol=1e-12)


def swung(chain: Any) -> Callable[[float], np.ndarray]:
    """Efforts that keep a robot moving."""
    energy, phase = Strength.of(chain).energy, np.arange(chain.n)
    return lambda t: 0.1 * energy * np.sin(1.3 * t + phase)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourbar", "fivebar"])
def test_the_energy_balance_of_ten_seconds(kit: Any, name: str) -> None:
    chain = ClosedChain(without_stops(lively(kit.model(name).description, np.random.default_rng(17))))
    plant = ReducedPlant(compiled(chain))
    start = np.ones(chain.n)
    done = run(plant, swung(chain), duration=10.0, integrator=Adaptive(1e-11, 1e-12), start_velocity=start, every=0.5)
    assert done.more["dissipated"][-1] > 0.1 * done.kinetic.max()
    assert done.energy_drift() < 1e-10
