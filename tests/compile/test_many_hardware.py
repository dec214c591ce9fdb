"""Many runs behind hardware are the runs one by one, digit for digit but for rounding, with their own chance."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from kit.hardware import PERIOD, some_hardware
from kit.physics import with_physics
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, compiled, simulate_many
from cutjoint.compile.many.instants import Chances
from cutjoint.compile.many.results import SAMPLED
from cutjoint.control import PD, PID, ComputedTorque, Feedforward
from cutjoint.description import JointPhysics
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion import Circle, Hold, Reference
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.robots import load, published
from cutjoint.simulation import Adaptive, ReducedPlant, RungeKutta4, run
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware, Tachometer
from cutjoint.simulation.integrators import FIXED_STEP, fixed_step, steps_within

CLOSE = 1e-12
"""Of the largest number of a column."""
ROBOTS = ("paper cpm", "cpm", "fivebar", "fourbar with physics", "cpm with physics", "omega3", "stewart")


@cache
def robot(name: str) -> Any:
    """Model and compiled model."""
    if name.startswith("paper "):
        made: Any = published(name.removeprefix("paper "))
    elif name == "cpm with friction":
        slides = JointPhysics(damping=3.0, friction=5.0, friction_speed=0.02, rotor=0.3)
        turns = JointPhysics(damping=0.01, friction=0.02, friction_speed=0.1)
        description = load("cpm").description
        joints = [replace(one, physics=slides if one.type == "prismatic" else turns) for one in description.joints]
        made = ClosedChain(replace(description, joints=tuple(joints)))
    elif name.endswith(" with physics"):
        description = load(name.removesuffix(" with physics")).description
        made = ClosedChain(with_physics(description, np.random.default_rng(5)))
    else:
        made = load(name)
    return made, compiled(made)


def sizes(model: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A small length or angle of every actuator, its mass, and a large effort."""
    length = getattr(model, "length", 1.0)
    place = np.array([0.1 * length if one.kind == "translation" else 0.1 for one in model.actuators])
    terms = model.terms(model.home)
    mass = np.abs(np.diag(terms.mass))
    return place, mass, np.abs(terms.gravity) + np.abs(terms.springs) + mass * place * 400.0


def both(plant: Any, law: Any, reference: Any, hardware: Any, method: str, k: int, **options: Any) -> tuple[Any, Any]:
    """Nine runs, and run k alone, every step of them."""
    tick = hardware.ticks.length
    step = tick / steps_within(tick, options.pop("step", 1e-3))
    many = simulate_many(
        plant, law, reference, hardware=hardware, method=method, every=step, step=step, runs=9, **options
    )
    start = options.get("start")
    single = run(
        ReducedPlant(plant),
        law,
        reference,
        integrator=fixed_step(method)(step),
        hardware=hardware,
        run_number=k,
        duration=options["duration"],
        start=None if start is None else plant.close(start),
    )
    return many, single


def agree(many: Any, k: int, single: Any) -> None:
    """Run k of many is the single run, at every step."""
    np.testing.assert_allclose(many.time, single.time, rtol=0, atol=1e-12)
    for name in SAMPLED:
        if name != "positions":
            wanted = getattr(single, name)
            np.testing.assert_allclose(getattr(many, name)[k], wanted, rtol=0, atol=CLOSE * np.abs(wanted).max())
    error, scale = single.desired_q - single.q, CLOSE * np.abs(single.q).max()
    np.testing.assert_allclose(many.error_max[k], np.abs(error).max(axis=0), rtol=0, atol=scale)
    np.testing.assert_allclose(many.error_rms[k], np.sqrt(np.mean(error**2, axis=0)), rtol=0, atol=scale)
    size = np.abs(single.effort).max()
    np.testing.assert_allclose(many.effort_max[k], np.abs(single.effort).max(axis=0), rtol=0, atol=CLOSE * size)


CASES = [f"{name}, {seed}" for name in ROBOTS for seed in range(8)]


@pytest.mark.parametrize("case", few(CASES, "paper cpm, 0", "paper cpm, 5", "fourbar with physics, 2", "cpm, 3"))
def test_any_hardware_on_any_robot(case: str) -> None:
    name, seed = case.split(", ")
    model, plant = robot(name)
    rng = np.random.default_rng([int(seed), len(name)])
    place, mass, effort = sizes(model)
    hardware = some_hardware(rng, place, effort, mass)
    if name.endswith("physics"):
        # its rotors are in the joints
        hardware = replace(hardware, drive=replace(hardware.drive, backlash=None))
    law = PD(0.2 * mass * 20.0**2, 0.2 * mass * 40.0)
    reference = Reference(Hold(model.tool(model.home).position), model, 1.0)
    start = model.home.q + 0.2 * place * rng.uniform(0.5, 1.0, model.n)
    method = str(rng.choice(list(FIXED_STEP)))
    many, single = both(plant, law, reference, hardware, method, 5, start=start, duration=20 * PERIOD)
    assert not many.slow
    assert not many.failed
    agree(many, 5, single)


NOISY = Hardware(
    Clock(1000.0),
    Encoder(resolution=1e-5, noise=2e-6, delay=1e-3),
    Differences(100.0),
    Drive(limits=200.0, resolution=0.1, delay=1e-3),
    seed=3,
)


@pytest.mark.slow
@pytest.mark.parametrize("method", list(FIXED_STEP))
@pytest.mark.parametrize("name", ["paper cpm", "cpm", "cpm with friction"])
def test_a_second_of_the_circle(name: str, method: str) -> None:
    _, plant = robot(name)
    reference = Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), robot("paper cpm")[0], 1.0)
    for hardware in (NOISY, Hardware(Clock(1000.0), Encoder(noise=1e-6), Tachometer(1e-3))):
        many, single = both(plant, PD(9000.0, 300.0), reference, hardware, method, 7, duration=1.0)
        agree(many, 7, single)


def circle(span: float) -> Reference:
    return Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), robot("paper cpm")[0], span)


def test_models_in_laws_see_what_is_measured() -> None:
    paper, plant = robot("paper cpm")
    for law in (ComputedTorque(paper, 2550.25, 101.0), Feedforward(paper, 7053.0, 436.0)):
        many, single = both(plant, law, circle(1.0), NOISY, "rk4", 2, duration=0.03)
        agree(many, 2, single)
    chain, plant = robot("cpm")
    law = ComputedTorque(chain, 2550.25, 101.0)
    with pytest.raises(InputError, match="measured posture"):
        simulate_many(plant, law, circle(0.1), hardware=NOISY)
    many, single = both(plant, law, circle(1.0), Hardware(Clock(1000.0)), "rk4", 2, duration=0.01)
    agree(many, 2, single)


def test_a_model_in_a_law_does_not_know_what_varies() -> None:
    for name in ("paper cpm", "cpm"):
        model, _ = robot(name)
        plant = compiled(model, parameters=["payload"])
        law = ComputedTorque(model, 2550.25, 101.0)
        many = simulate_many(plant, law, circle(0.02), parameters={"payload": [0.0, 2.0]})
        single = run(
            ReducedPlant(plant.with_payload(2.0)), law, circle(1.0), integrator=RungeKutta4(1e-3), duration=0.02
        )
        np.testing.assert_allclose(many.q[1, -1], single.q[-1], rtol=0, atol=1e-12)
        assert (many.error_max[1] > 10.0 * many.error_max[0]).any()


def test_rate_and_limits_are_hardware() -> None:
    _, plant = robot("paper cpm")
    law = PD(12691.0, 436.0)
    short = simulate_many(plant, law, circle(0.05), rate=500.0, limits=[60.0, 50.0, 40.0], every=1e-3)
    whole = Hardware(Clock(500.0), drive=Drive(limits=(60.0, 50.0, 40.0)))
    long = simulate_many(plant, law, circle(0.05), hardware=whole, every=1e-3)
    np.testing.assert_array_equal(short.q, long.q)
    single = run(
        ReducedPlant(plant),
        law,
        circle(0.05),
        rate=500.0,
        limits=[60.0, 50.0, 40.0],
        integrator=RungeKutta4(1e-3),
        duration=0.05,
    )
    np.testing.assert_allclose(short.effort[0], single.effort, rtol=0, atol=1e-10)
    assert short.effort_max[0, 1] == 50.0


def test_an_integral_moves_on_at_each_sample_and_stands_still_at_the_limits() -> None:
    _, plant = robot("paper cpm")
    law = PID(9000.0, 5000.0, 300.0)
    hardware = replace(NOISY, drive=replace(NOISY.drive, limits=(60.0, 50.0, 40.0)))
    start = plant.home.q + 0.02
    many, single = both(plant, law, circle(1.0), hardware, "rk4", 4, start=start, duration=0.05)
    agree(many, 4, single)
    assert many.effort_max[4].max() == 60.0


def test_every_run_has_its_own_chance_and_only_that() -> None:
    _, plant = robot("paper cpm")
    law = PD(9000.0, 300.0)
    few, many = (simulate_many(plant, law, circle(0.02), hardware=NOISY, runs=n, every=1e-3) for n in (3, 20))
    for name in SAMPLED:
        np.testing.assert_allclose(getattr(few, name), getattr(many, name)[:3], rtol=1e-12, atol=1e-14)
    assert len({row.tobytes() for row in many.measured_q[:, 1]}) > 1
    normals = np.random.default_rng([3, 4]).standard_normal((21, 3))
    read = np.rint((many.q[4] + 2e-6 * normals) * (1.0 / np.float64(1e-5))) * 1e-5
    # with a delay of one period the law sees at each sample what was read at the one before
    np.testing.assert_allclose(many.measured_q[4, 1:], read[:-1], rtol=0, atol=1e-12)
    one = simulate_many(plant, law, circle(0.02), hardware=NOISY, runs=1, every=1e-3)
    np.testing.assert_allclose(one.q[0], many.q[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize("seed", range(4))
def test_instants_are_those_of_the_clock(seed: int) -> None:
    from cutjoint.compile.many.grid import time_grid
    from cutjoint.compile.many.instants import together
    from cutjoint.simulation.hardware.noise import Jitter
    from cutjoint.simulation.hardware.schedule import Schedule

    rng = np.random.default_rng(seed)
    hardware = some_hardware(rng, np.ones(2), np.ones(2), np.ones(2))
    ticks = hardware.ticks
    grid = time_grid(25 * PERIOD, ticks.length / 2.0, ticks.length, None)
    found = Chances(hardware, grid, 0).due(7)
    names = together(ticks)
    told = [
        (k, stage) for k, byte in enumerate(found) for b, part in enumerate(names) if byte >> b & 1 for stage in part
    ]
    schedule = Schedule(ticks, Jitter(hardware.seed, 7, ticks.jitter))
    wanted = []
    while (at := round(schedule.next / grid.step)) <= grid.steps:
        wanted += [(at, stage) for stage in schedule.due()]
    assert sorted(told) == sorted(wanted)


def test_a_run_that_leaves_is_done_again_with_its_own_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    from cutjoint.compile.many import blocks

    _, plant = robot("paper cpm")
    quick = simulate_many(plant, PD(9000.0, 300.0), circle(0.02), hardware=NOISY, runs=3, every=1e-3)
    monkeypatch.setattr(blocks, "STRAIN_LIMIT", 0.5)
    slow = simulate_many(plant, PD(9000.0, 300.0), circle(0.02), hardware=NOISY, runs=3, every=1e-3)
    assert slow.slow == (0, 1, 2)
    for name in (*SAMPLED, "error_rms", "error_max", "effort_max"):
        wanted = getattr(quick, name)
        np.testing.assert_allclose(getattr(slow, name), wanted, rtol=0, atol=CLOSE * np.abs(wanted).max())


@pytest.mark.parametrize("name", few(["paper cpm", "fourbar", "cpm"], "paper cpm", "fourbar"))
def test_methods_have_their_order_between_samples(name: str) -> None:
    model, plant = robot(name)
    reference = Reference(Hold(model.tool(model.home).position), model, 0.1)
    place, mass, _ = sizes(model)
    law, start = PD(mass * 30.0**2, mass * 30.0), model.home.q + place
    exact = run(
        ReducedPlant(plant), law, reference, rate=100.0, start=plant.close(start), integrator=Adaptive(1e-12, 1e-14)
    )
    for method, order in (("rk4", 4), ("midpoint", 2)):
        errors = []
        for step in (5e-3, 2.5e-3, 1.25e-3):
            many = simulate_many(plant, law, reference, rate=100.0, start=start, step=step, method=method)
            errors.append(np.abs(many.q[0, -1] - exact.q[-1]).max())
        slopes = np.log2(np.array(errors[:-1]) / errors[1:])
        assert slopes == pytest.approx(order, abs=0.5), (method, errors)


def test_positions_stay_closed() -> None:
    chain, plant = robot("cpm")
    many = simulate_many(plant, PD(9000.0, 300.0), circle(0.1), hardware=NOISY, method="midpoint", every=0.01)
    assert max(max(chain.gap(q)) for q in many.positions[0]) < 1e-12


def test_loops_travel() -> None:
    paper, plant = robot("paper cpm")
    for options in ({"hardware": NOISY}, {"rate": 500.0, "limits": 50.0}, {"limits": 50.0}):
        loop = ClosedLoop(plant, PD(9000.0, 300.0), paper, method="midpoint", **options)
        other = pickle.loads(pickle.dumps(loop))
        np.testing.assert_array_equal(
            loop.run(circle(0.01), runs=3).q,
            other.run(Reference(circle(0.01).trajectory, other.mechanism, 0.01), runs=3).q,
        )


def test_what_cannot_be_done_is_said() -> None:
    _, plant = robot("paper cpm")
    law = PD(9000.0, 300.0)
    with pytest.raises(UnknownNameError, match="midpoint"):
        simulate_many(plant, law, circle(0.1), method="midpiont")
    with pytest.raises(InputError, match="in the hardware"):
        simulate_many(plant, law, circle(0.1), hardware=NOISY, rate=100.0)
    with pytest.raises(InputError, match="whole number of steps"):
        simulate_many(plant, law, circle(0.1), rate=30.0, duration=0.0777)
    with pytest.raises(InputError, match="not shorter than the run"):
        simulate_many(plant, law, circle(0.1), hardware=NOISY, duration=1e-3)
    with pytest.raises(InputError, match="runs must be"):
        simulate_many(plant, law, circle(0.1), hardware=NOISY, runs=0)
    with pytest.raises(InputError, match="agree in the number"):
        simulate_many(plant, law, circle(0.1), runs=3, start=np.tile(plant.home.q, (2, 1)))
    with pytest.raises(InputError, match="one number or 3"):
        simulate_many(plant, law, circle(0.1), hardware=Hardware(Clock(100.0), Encoder(offset=(1.0, 2.0))))
