"""Many runs at once are the runs one by one, whatever varies, and whatever goes wrong in one of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, compiled, simulate_many
from cutjoint.control import PD, PID, ComputedTorque, Feedforward, PDGravity
from cutjoint.description import load_description
from cutjoint.description.catalogue import path
from cutjoint.errors import ActuationError, InputError
from cutjoint.motion import Circle, Hold, Reference
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.simulation import ReducedPlant, Result, RungeKutta4, run

SPAN, STEP = 0.1, 1e-3


@pytest.fixture(scope="module")
def reference(kit: Any) -> Reference:
    """The first tenth of a second of the paper's circle."""
    return Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), kit.model("paper cpm"), SPAN)


def laws(model: Any) -> dict[str, Any]:
    return {
        "pd": PD(12691.0, [436.0, 400.0, 420.0]),
        "pid": PID(8000.0, 300.0, 436.0),
        "pd_matrix": PD(np.diag([9e3, 8e3, 7e3]) + 100.0, 436.0),
        "pd_gravity": PDGravity(model, 8507.0, 436.0),
        "feedforward": Feedforward(model, 7053.0, 436.0),
        "computed_torque": ComputedTorque(model, 2550.25, 101.0),
    }


def one_by_one(model: Any, law: Any, reference: Reference, **options: Any) -> Result:
    return run(ReducedPlant(model), law, reference, integrator=RungeKutta4(STEP), **options)


def agree(many: Any, k: int, single: Result, tolerance: float = 1e-10) -> None:
    """Run k of many is the single run."""
    np.testing.assert_allclose(many.time, single.time[[0, 50, 100]], atol=1e-12)
    for name in ("q", "v", "effort"):
        wanted = getattr(single, name)[[0, 50, 100]]
        np.testing.assert_allclose(
            getattr(many, name)[k], wanted, rtol=0, atol=tolerance * max(1, np.abs(wanted).max())
        )
    error = single.desired_q - single.q
    np.testing.assert_allclose(many.error_max[k], np.abs(error).max(axis=0), rtol=0, atol=tolerance)
    np.testing.assert_allclose(many.error_rms[k], np.sqrt(np.mean(error**2, axis=0)), rtol=0, atol=tolerance)
    size = np.abs(single.effort).max()
    np.testing.assert_allclose(many.effort_max[k], np.abs(single.effort).max(axis=0), rtol=0, atol=tolerance * size)


@pytest.mark.parametrize("name", ["pd", "pid", "pd_matrix", "pd_gravity", "feedforward", "computed_torque"])
def test_every_law_runs_as_it_does_alone(kit: Any, reference: Reference, name: str) -> None:
    paper = kit.model("paper cpm")
    law = laws(paper)[name]
    single = one_by_one(paper, law, reference)
    for plant in ("paper cpm", "cpm"):
        many = simulate_many(kit.machine(plant), law, reference, every=0.05)
        assert not many.failed
        assert not many.slow
        if plant == "paper cpm":
            agree(many, 0, single)
        else:
            # the chain has uniform rods; on the lumped one the paper's hypothesis holds
            lumped = compiled(ClosedChain(load_description(path("cpm"), "lumped")))
            agree(simulate_many(lumped, law, reference, every=0.05), 0, single)


def test_a_chain_follows_its_own_model(kit: Any) -> None:
    chain = kit.model("cpm")
    reference = Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), chain, 0.1)
    law = ComputedTorque(chain, 2550.25, 101.0)
    many = simulate_many(kit.machine("cpm"), law, reference, every=0.05, duration=0.02)
    single = one_by_one(chain, law, reference, duration=0.02)
    np.testing.assert_allclose(many.q[0, -1], single.q[-1], rtol=0, atol=1e-11)
    np.testing.assert_allclose(many.positions[0, -1], single.q_full[-1], rtol=0, atol=1e-10)


def test_free_bodies_and_quaternions(kit: Any) -> None:
    chain = kit.model("omega3")
    reference = Reference(Hold(chain.tool(chain.home).position + np.array([0.0, 0.01, 0.0])), chain, 0.02)
    law = PDGravity(chain, 5.0, 0.05)
    many = simulate_many(kit.machine("omega3"), law, reference, every=0.01, start=chain.home.q)
    single = one_by_one(chain, law, reference, start=chain.home)
    np.testing.assert_allclose(many.q[0, -1], single.q[-1], rtol=0, atol=1e-10)
    np.testing.assert_allclose(many.v[0, -1], single.v[-1], rtol=0, atol=1e-8)
    assert max(chain.gap(many.positions[0, -1])) < 1e-12


def test_gains_masses_and_starts_vary(kit: Any, reference: Reference) -> None:
    paper = kit.model("paper cpm")
    plant = compiled(paper, parameters=["payload", "m3"])
    count = 19
    rng = np.random.default_rng(0)
    kp, kd = rng.uniform(6e3, 13e3, count), rng.uniform(200, 436, (count, 3))
    payload, slider = rng.uniform(0, 2, count), rng.uniform(0.1, 0.5, count)
    start = reference.at(0.0).q + 0.01 * rng.uniform(-1, 1, (count, 3))
    speed = 0.1 * rng.normal(size=(count, 3))
    done: list[float] = []
    many = simulate_many(
        plant,
        PD(1.0, 1.0),
        reference,
        gains={"kp": kp, "kd": kd},
        parameters={"payload": payload, "m3": slider},
        start=start,
        start_velocity=speed,
        every=0.05,
        progress=done.append,
    )
    assert done[-1] == 1.0
    assert done == sorted(done)
    for k in (0, 7, 8, 18):
        from dataclasses import replace

        model = type(paper)(replace(paper.parameters, m3=slider[k])).with_payload(payload[k])
        single = one_by_one(model, PD(kp[k], kd[k]), reference, start=model.close(start[k]), start_velocity=speed[k])
        agree(many, k, single)
    alone = simulate_many(
        plant,
        PD(kp[7], kd[7]),
        reference,
        parameters={"payload": payload[7], "m3": slider[7]},
        start=start[7],
        start_velocity=speed[7],
        every=0.05,
    )
    np.testing.assert_allclose(alone.q[0], many.q[7], rtol=0, atol=1e-13)
    threads = simulate_many(
        plant,
        PD(1.0, 1.0),
        reference,
        gains={"kp": kp, "kd": kd},
        parameters={"payload": payload, "m3": slider},
        start=start,
        start_velocity=speed,
        every=0.05,
        threads=1,
    )
    np.testing.assert_array_equal(threads.q, many.q)


def test_limits_hold(kit: Any, reference: Reference) -> None:
    paper = kit.model("paper cpm")
    single = one_by_one(paper, PD(12691.0, 436.0), reference, limits=[60.0, 50.0, 40.0])
    many = simulate_many(kit.machine("paper cpm"), PD(12691.0, 436.0), reference, limits=[60.0, 50.0, 40.0], every=0.05)
    agree(many, 0, single)
    assert (many.effort_max <= [60.0, 50.0, 40.0]).all()
    assert many.effort_max[0, 1] == 50.0
    law = PID(12691.0, 300.0, 436.0)
    integral = simulate_many(kit.machine("paper cpm"), law, reference, limits=50.0, every=0.05)
    agree(integral, 0, one_by_one(paper, law, reference, limits=50.0))
    # a law that holds its integral while an effort is at its limit
    pid = PID(8e3, 400.0, 400.0)
    single = one_by_one(paper, pid, reference, limits=[60.0, 50.0, 40.0])
    agree(simulate_many(kit.machine("paper cpm"), pid, reference, limits=[60.0, 50.0, 40.0], every=0.05), 0, single)


@pytest.mark.parametrize("link", ["payload", "limb1_distal"])
def test_masses_of_a_chain_are_arguments(kit: Any, link: str) -> None:
    chain = kit.model("cpm")
    machine = compiled(chain, parameters=[link])
    heavier = machine.with_parameters(**{link: 1.3})
    assert heavier.plain is not chain
    v, x = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, -1.0])
    for one in (machine, heavier):
        wanted = one.plain.forward_dynamics(one.plain.home, v, x)
        np.testing.assert_allclose(one.forward_dynamics(one.home, v, x), wanted, rtol=1e-12)
        np.testing.assert_allclose(one.terms(one.home, v).mass, one.plain.terms(one.plain.home, v).mass, rtol=1e-12)
    found = machine.batch.forward_dynamics(np.tile(chain.home.q_full, (2, 1)), v, x, {link: [1.3, 0.7]})
    np.testing.assert_allclose(found[0], heavier.forward_dynamics(machine.home, v, x), rtol=1e-13)
    if link == "payload":
        np.testing.assert_array_equal(
            machine.with_payload(1.3).forward_dynamics(machine.home, v, x),
            heavier.forward_dynamics(machine.home, v, x),
        )
    with pytest.raises(InputError, match="not an argument"):
        machine.batch.forward_dynamics(chain.home.q[None], v, x, {"other": 1.0})


def test_a_run_beyond_the_limbs_does_not_spoil_the_others(kit: Any, reference: Reference) -> None:
    plant = kit.machine("paper cpm")
    kp = np.array([12691.0, 1e-3, 8000.0])
    # the second run falls freely with a push until its limbs end
    speed = np.array([[0.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 0.0]])
    many = simulate_many(plant, PD(1.0, 0.0), reference, gains={"kp": kp}, start_velocity=speed, every=0.05)
    assert set(many.failed) == {1}
    assert "stopped at t" in many.failed[1]
    assert np.isnan(many.q[1]).all()
    assert np.isnan(many.error_max[1]).all()
    assert np.isfinite(many.q[[0, 2]]).all()
    agree(many, 0, one_by_one(kit.model("paper cpm"), PD(12691.0, 0.0), reference))


def test_a_strained_run_is_done_by_the_model(kit: Any, reference: Reference, monkeypatch: pytest.MonkeyPatch) -> None:
    from cutjoint.compile.many import blocks as module

    monkeypatch.setattr(module, "STRAIN_LIMIT", 0.5)
    found = simulate_many(kit.machine("paper cpm"), PD(12691.0, 436.0), reference, every=0.05)
    assert found.slow == (0,)
    agree(found, 0, one_by_one(kit.model("paper cpm"), PD(12691.0, 436.0), reference))


def test_what_cannot_be_done_is_said(kit: Any, reference: Reference) -> None:
    plant, chain = kit.machine("paper cpm"), kit.model("cpm")
    with pytest.raises(InputError, match="no gain"):
        simulate_many(plant, PD(1.0, 1.0), reference, gains={"ki": [1.0]})
    with pytest.raises(InputError, match="agree in the number"):
        simulate_many(plant, PD(1.0, 1.0), reference, gains={"kp": [1.0, 2.0], "kd": [1.0, 2.0, 3.0]})
    with pytest.raises(InputError, match="argument"):
        simulate_many(plant, PD(1.0, 1.0), reference, parameters={"payload": [1.0]})
    with pytest.raises(InputError, match="plant's own model"):
        simulate_many(plant, ComputedTorque(chain, 1.0, 1.0), reference)
    with pytest.raises(InputError, match="GiB"):
        simulate_many(plant, PD(1.0, 1.0), reference, gains={"kp": np.ones(10**6)}, every=1e-3)
    with pytest.raises(InputError, match="finite"):
        simulate_many(plant, PD(1.0, 1.0), reference, gains={"kp": [np.nan]})
    for limits in (-1.0, [1.0, 2.0], 0.0, np.nan, "much"):
        for rate in (None, 500.0):
            with pytest.raises(InputError, match=r"limits.* must be (one number > 0 or 3 of them|numbers)"):
                simulate_many(plant, PD(1.0, 1.0), reference, limits=limits, rate=rate)
    with pytest.raises(ActuationError):
        ClosedLoop(kit.machine("redundant"), PD(1.0, 1.0), chain)
