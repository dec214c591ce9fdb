"""Dampers, friction, springs, stops, rotors and bushings, compiled: against the chain, and against laws of theirs."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit import mechanisms
from kit.blueprint import random_mounting
from kit.lively import Strength, bushed, lively, states, without_stops
from kit.loops import CUTS, EXTRAS, SPACES, loop
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled, simulate_many
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.control import PD
from cutjoint.description import load_description, value, with_values
from cutjoint.description import paths as known
from cutjoint.description.cuts import CutType
from cutjoint.mechanism import Load
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.motion import Reference
from cutjoint.motion.joint_space import JointSine
from cutjoint.simulation import ReducedPlant, RungeKutta4, run

SHIPPED = ("fourbar", "fivebar", "omega3", "cpm", "stewart")
MADE = ("planar_3rrr", "prs_3", "ups_6", "scotch_yoke", "geared_fivebar", "ball_rod_delta", "ball_rod_slider_crank")
JOINTS = ("revolute", "continuous", "prismatic", "universal", "spherical", "planar", "floating")
DIGITS = 1e-10


def shipped(kit: Any, name: str, seed: int = 0) -> Any:
    """A robot under urdf/ with physics everywhere."""
    return ClosedChain(lively(kit.model(name).description, np.random.default_rng(seed)))


def agrees(chain: Any, rng: np.random.Generator, count: int = 4, digits: float = DIGITS) -> None:
    """Compiled functions in actuated coordinates against the chain, in the robot's own units."""
    machine, size = compiled(chain, cached=False), Strength.of(chain)
    unit = np.array([size.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    for at, v, a, effort in states(chain, rng, count):
        assert machine.kernel("forward")(at.q_full, v, effort, np.zeros(0))[-1] <= STRAIN_LIMIT
        terms, wanted = machine.terms(at, v), chain.terms(at, v)
        scale = sum(float(np.abs(unit * getattr(wanted, part)).max()) for part in ("gravity", "springs", "friction"))
        scale += float(np.abs(unit * wanted.coriolis).max()) + size.energy
        for part in ("coriolis", "gravity", "springs", "friction"):
            off = np.abs(unit * (getattr(terms, part) - getattr(wanted, part))).max()
            assert off < digits * scale, part
        inertia = unit[:, None] * wanted.mass * unit
        assert np.abs(unit[:, None] * terms.mass * unit - inertia).max() < digits * np.abs(inertia).max()
        found, right = machine.inverse_dynamics(at, v, a), chain.inverse_dynamics(at, v, a)
        pushed = scale + np.abs(unit * (wanted.mass @ a)).max()
        assert np.abs(unit * (found - right)).max() < digits * pushed
        found, right = machine.forward_dynamics(at, v, effort), chain.forward_dynamics(at, v, effort)
        quick = float(np.abs(np.linalg.inv(inertia)).max()) * (scale + np.abs(unit * effort).max())
        assert np.abs((found - right) / unit).max() < digits * quick
        if machine.source.idle:
            drift, unit_u = machine.library()["drift"](at.q_full, v, np.zeros(0)), machine.source.rate_scale
            right = chain.drift(at, v) / unit_u
            assert np.abs(drift["drift"] / unit_u - right).max() < 1e-9 * np.abs(right).max()
        potential, right = machine.potential_energy(at), chain.potential_energy(at)
        assert abs(potential - right) < digits * (abs(right) + size.energy)


def agrees_in_full(kit: Any, chain: Any, rng: np.random.Generator, count: int = 4) -> None:
    """Forward dynamics of all joints against the chain."""
    machine, size = compiled(chain, cached=False), Strength.of(chain)
    scale = machine.source.rate_scale
    for _ in range(count):
        q = machine.source.cloud[int(rng.integers(len(machine.source.cloud)))]
        v = 0.3 * size.rate * kit.allowed_velocity(chain, q, rng)
        effort = size.energy / scale * rng.normal(size=chain.nv)
        right = chain.full_acceleration(q, v, effort)
        y = machine.kernel("full_forward")(q, v, effort, np.zeros(0))
        assert y[-1] <= STRAIN_LIMIT
        assert np.abs((y[:-1] - right) / scale).max() < 1e-9 * np.abs(right / scale).max()


@pytest.mark.parametrize("name", few(SHIPPED, "fourbar", "fivebar"))
def test_shipped_robots(kit: Any, name: str) -> None:
    agrees(shipped(kit, name), np.random.default_rng(1))


@pytest.mark.parametrize("cut", few((*CUTS, "distance"), "fixed", "prismatic", "universal"))
def test_every_cut(kit: Any, cut: str) -> None:
    rng = np.random.default_rng(2)
    agrees_in_full(kit, ClosedChain(lively(kit.two_bodies(cut), rng)), rng)


@pytest.mark.parametrize("cut", few((*CUTS, "distance"), "fixed", "distance"))
def test_every_bushing(kit: Any, cut: str) -> None:
    rng = np.random.default_rng(3)
    plain = kit.two_bodies("spherical")
    chain = ClosedChain(plain)
    extra = bushed(chain, "soft", CutType(cut), Strength.of(chain), rng, 0.5)
    agrees_in_full(kit, ClosedChain(replace(plain, cuts=(*plain.cuts, extra))), rng)


@pytest.mark.parametrize("kind", few(JOINTS, "revolute", "spherical", "planar"))
def test_every_joint(kit: Any, kind: str) -> None:
    rng = np.random.default_rng(4)
    agrees_in_full(kit, ClosedChain(lively(kit.limb_and_body(kind), rng)), rng)


@pytest.mark.parametrize(
    "kinds",
    few(
        [(space, cut, extra) for space in SPACES for cut in CUTS for extra in EXTRAS],
        ("planar", "prismatic", "none"),
        ("spatial", "spherical", "universal"),
        ("spherical", "revolute", "coupling"),
    ),
)
def test_loops_of_every_kind(kit: Any, tmp_path: Path, kinds: tuple[str, str, str]) -> None:
    rng = np.random.default_rng(5)
    plan, _ = loop(*kinds, rng)
    description = load_description(plan.write(tmp_path, random_mounting(rng)))
    chain = ClosedChain(lively(description, rng))
    agrees_in_full(kit, chain, rng, 3)
    if compiled(chain, cached=False).source.determined:
        agrees(chain, rng, 3)


@pytest.mark.parametrize("name", few(MADE, "scotch_yoke", "ball_rod_slider_crank"))
@pytest.mark.parametrize("scale", few((1e-3, 1.0, 1e3), 1e-3))
def test_mechanisms_at_scales_and_mountings(tmp_path: Path, name: str, scale: float) -> None:
    rng = np.random.default_rng(6)
    plan = mechanisms.MECHANISMS[name](rng).plan
    description = load_description(plan.write(tmp_path, random_mounting(rng), scale, scale))
    agrees(ClosedChain(lively(description, rng)), rng, 3)


@pytest.mark.parametrize("name", few(("fivebar", "omega3", "cpm", "paper cpm", "paper omega3"), "fivebar", "paper cpm"))
def test_a_wrench_at_the_tool(kit: Any, name: str) -> None:
    rng = np.random.default_rng(13)
    model = kit.model(name) if name.startswith("paper") else shipped(kit, name, 14)
    machine = compiled(model, cached=False)
    at = kit.nearby(model, rng) if name.startswith("paper") else states(model, rng, 1)[0][0]
    v, a, effort, wrench = (rng.normal(size=size) for size in (model.n, model.n, model.n, 6))
    load = Load(wrench[:3], wrench[3:])
    forward, inverse = machine.forward_loaded(at, v, effort, wrench), machine.inverse_loaded(at, v, a, wrench)
    right = model.forward_dynamics(at, v, effort, load)
    assert np.abs(forward.value - right).max() < 1e-11 * np.abs(right).max()
    right = model.inverse_dynamics(at, v, a, load)
    assert np.abs(inverse.value - right).max() < 1e-11 * np.abs(right).max()
    for ask, found in ((machine.forward_loaded, forward), (machine.inverse_loaded, inverse)):
        given = effort if found is forward else a
        for k, one in enumerate(np.eye(6)):
            slope = ask(at, v, given, wrench + one).value - found.value  # linear
            assert np.abs(slope - found.by_wrench[:, k]).max() < 1e-9 * max(np.abs(found.value).max(), 1e-3)
    places = np.stack([machine.positions(at)] * 3)
    many = machine.batch.forward_dynamics(places, v, effort, wrench=np.stack([wrench, 0 * wrench, 2 * wrench]))
    np.testing.assert_allclose(many[0], forward.value, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(many[1], machine.forward_dynamics(at, v, effort), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(many[0] + many[0] - many[1], many[2], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        machine.batch.inverse_dynamics(places, v, a, wrench=wrench)[2], inverse.value, rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("name", few(("paper cpm", "paper omega3"), "paper omega3"))
def test_motors_of_published_models(kit: Any, name: str) -> None:
    rng, plain = np.random.default_rng(15), kit.model(name)
    model = plain.with_motors([JointPhysics(0.7, 0.4, 0.3, 2.0, 0.1, 0.02, 3.0)] * (plain.n - 1) + [JointPhysics()])
    machine = compiled(model, parameters=["payload"], cached=False)
    assert machine.source.content != compiled(plain, parameters=["payload"], cached=False).source.content
    loaded = machine.with_parameters(payload=0.3)
    for _ in range(3):
        at, v, x = kit.nearby(model, rng), 0.5 * rng.normal(size=model.n), rng.normal(size=model.n)
        for one, other in (
            (machine, model),
            (loaded, model.with_payload(0.3)),
            (loaded.plain, model.with_payload(0.3)),
        ):
            for found, right in (
                (one.forward_dynamics(at, v, x), other.forward_dynamics(at, v, x)),
                (one.inverse_dynamics(at, v, x), other.inverse_dynamics(at, v, x)),
                (one.terms(at, v).springs, other.terms(at, v).springs),
                (one.terms(at, v).friction, other.terms(at, v).friction),
                (one.potential_energy(at), other.potential_energy(at)),
            ):
                assert np.abs(found - right).max() < 1e-11 * np.abs(right).max()


def test_coefficients_are_arguments(kit: Any) -> None:
    """Every number of a joint, a cut and a bushing by its path: against the robot built with other values."""
    rng = np.random.default_rng(16)
    robot = lively(kit.model("fivebar").description, rng)
    joint = next(one.name for one in robot.joints if one.physics.stiffness)
    rigid, soft = (next(one.name for one in robot.cuts if (one.bushing is None) is which) for which in (True, False))
    numbers = [one.name for one in fields(JointPhysics)]
    paths = [f"joints.{joint}.{name}" for name in numbers]
    paths += [f"cuts.{rigid}.{name}" for name in ("damping", "friction", "friction_speed", "stiffness", "rest")]
    paths += [
        f"cuts.{soft}.bushing.{name}" for name in ("stiffness", "damping", "turning_stiffness", "turning_damping")
    ]
    paths = [path for path in paths if path in known(robot)]
    chain = ClosedChain(robot)
    machine = compiled(chain, parameters=paths, cached=False)
    for at, v, a, effort in states(chain, rng, 3):
        values = {path: float(value(robot, path)) * rng.uniform(0.5, 2.0) for path in paths}
        other, right = machine.with_parameters(values), ClosedChain(with_values(robot, values))
        here = right.close(at.q, limits="ignore")
        for found, wanted in (
            (other.forward_dynamics(at, v, effort), right.forward_dynamics(here, v, effort)),
            (other.inverse_dynamics(at, v, a), right.inverse_dynamics(here, v, a)),
            (other.potential_energy(at), right.potential_energy(here)),
        ):
            assert np.abs(found - wanted).max() < DIGITS * np.abs(wanted).max()


def test_many_runs_have_the_friction_of_one(kit: Any) -> None:
    chain = ClosedChain(without_stops(lively(kit.model("fivebar").description, np.random.default_rng(18))))
    size = Strength.of(chain)
    law = PD(20.0 * size.energy, 2.0 * size.energy / size.rate)
    reference = Reference(JointSine.from_home(chain, 0.1, 2.0), chain, 0.02)
    many = simulate_many(compiled(chain, cached=False), law, reference, every=0.01)
    single = run(ReducedPlant(chain), law, reference, integrator=RungeKutta4(1e-3))
    assert not many.failed
    assert not many.slow
    np.testing.assert_allclose(many.q[0, -1], single.q[-1], rtol=0, atol=1e-11)
    np.testing.assert_allclose(many.v[0, -1], single.v[-1], rtol=0, atol=1e-10)
