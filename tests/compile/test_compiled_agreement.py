"""Compiled mechanisms give what the models give: every robot under urdf/, every published model, joint and cut."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled, functions_of
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.description import catalogue
from cutjoint.errors import ActuationError, CutjointError, InputError, UnknownNameError
from cutjoint.mechanism import Mechanism

SLOW_STEWART = pytest.param("stewart", marks=pytest.mark.slow)
REDUCED = ("cpm", "cpm_rotary", "omega3", "fourbar", "fivebar", "stewart", "paper cpm", "paper omega3")
UNDETERMINED = ("redundant", "underactuated")
CUTS = ("fixed", "spherical", "revolute", "universal", "prismatic")
WELL_POSED = 8.0
"""Strain up to which the model itself has the twelve digits that are compared."""
AROUND = {"stewart": 0.04}
"""How far from home states are taken [m, rad]; 0.1 where nothing is said."""
JOINTS = ("revolute", "continuous", "prismatic", "universal", "spherical", "planar", "floating")


def error_of(found: Any, wanted: Any, floor: float = 1e-3) -> float:
    """Largest difference against the largest entry."""
    found, wanted = np.asarray(found), np.asarray(wanted)
    return float(np.abs(found - wanted).max() / max(np.abs(wanted).max(), floor))


def test_every_robot_is_looked_at() -> None:
    assert set(catalogue.names()) <= {*REDUCED, *UNDETERMINED}


@pytest.mark.parametrize("name", REDUCED)
def test_a_compiled_mechanism_is_the_mechanism(kit: Any, name: str) -> None:
    model, machine = kit.model(name), kit.machine(name)
    assert isinstance(machine, Mechanism)
    assert (machine.n, machine.actuators) == (model.n, model.actuators)
    rng = np.random.default_rng(0)
    for _ in range(12):
        at = kit.nearby(model, rng)
        own = machine.close(at.q)
        np.testing.assert_allclose(own.q_full, at.q_full, rtol=0, atol=2e-12)
        assert max(own.gap) < 1e-12
        v, x = rng.normal(size=model.n), 5.0 * rng.normal(size=model.n)
        assert error_of(machine.forward_dynamics(own, v, x), model.forward_dynamics(at, v, x)) < 1e-12
        assert error_of(machine.inverse_dynamics(own, v, x), model.inverse_dynamics(at, v, x)) < 1e-12
        terms, wanted = machine.terms(own, v), model.terms(at, v)
        size = np.abs(wanted.gravity).max() + np.abs(wanted.coriolis).max()
        assert error_of(terms.mass, wanted.mass) < 1e-12
        assert error_of(terms.gravity, wanted.gravity, size) < 1e-12
        assert error_of(terms.coriolis, wanted.coriolis, size) < 1e-12
        assert not machine.terms(own).coriolis.any()
        tool, wanted_tool = machine.tool(own, v), model.tool(at, v)
        assert error_of(tool.position, wanted_tool.position) < 1e-12
        assert error_of(tool.rotation, wanted_tool.rotation) < 1e-12
        assert error_of(tool.frame_jacobian, wanted_tool.frame_jacobian) < 1e-12
        assert error_of(tool.frame_drift, wanted_tool.frame_drift, 1.0) < 1e-12
        assert error_of(tool.twist, wanted_tool.twist) < 1e-12
        assert not machine.tool(own).frame_drift.any()
        assert error_of(machine.potential_energy(own), model.potential_energy(at)) < 1e-11
        if name not in ("fourbar", "fivebar", "stewart"):
            back = machine.reach(wanted_tool.position, own)
            np.testing.assert_allclose(machine.tool(back).position, wanted_tool.position, rtol=0, atol=1e-12)
            np.testing.assert_allclose(machine.reach(wanted_tool.position).q, at.q, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["cpm", "stewart"])
def test_tangent_and_full_velocities(kit: Any, name: str) -> None:
    model, machine = kit.model(name), kit.machine(name)
    rng = np.random.default_rng(1)
    at = kit.nearby(model, rng)
    v = rng.normal(size=model.n)
    assert error_of(machine.tangent(at), model.tangent(at)) < 1e-12
    assert error_of(machine.full_velocity(at, v), model.full_velocity(at, v)) < 1e-12


@pytest.mark.parametrize("name", [*UNDETERMINED, "cpm", "omega3"])
def test_full_coordinates_for_any_actuation(kit: Any, name: str) -> None:
    check_full(kit, kit.machine(name), np.random.default_rng(2), 5)


@pytest.mark.parametrize("kind", CUTS)
def test_every_cut(kit: Any, kind: str) -> None:
    machine = compiled(ClosedChain(kit.two_bodies(kind)), cached=False)
    check_full(kit, machine, np.random.default_rng(3), 5)


@pytest.mark.parametrize("kind", JOINTS)
def test_every_joint(kit: Any, kind: str) -> None:
    machine = compiled(ClosedChain(kit.limb_and_body(kind)), cached=False)
    check_full(kit, machine, np.random.default_rng(4), 5)


def check_full(kit: Any, machine: Any, rng: np.random.Generator, count: int) -> None:
    """Forward dynamics of all joints against the chain's, on closed postures away from home."""
    chain = machine.chain
    for _ in range(count):
        q = machine.source.cloud[int(rng.integers(len(machine.source.cloud)))]
        chain.posture(q)  # closed by the chain's own measure
        v, effort = kit.allowed_velocity(chain, q, rng), 5.0 * rng.normal(size=chain.nv)
        wanted = chain.full_acceleration(q, v, effort)
        strain = machine.kernel("full_forward")(q, v, effort, np.zeros(0))[-1]
        assert strain <= STRAIN_LIMIT, "the compiled code itself must answer here, not the chain"
        # two ways of pinocchio and numpy through the same equations differ by about 1e-10 where rows are redundant
        assert error_of(machine.full_acceleration(q, v, effort), wanted) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", UNDETERMINED)
def test_ten_thousand_states_of_all_joints(kit: Any, name: str) -> None:
    """Robots that their actuators do not determine, around home, in full coordinates."""
    chain, machine, rng = kit.model(name), kit.machine(name), np.random.default_rng(8)
    worst = 0.0
    for _ in range(10_000):
        start = chain.integrate(chain.home.q_full, 0.1 * rng.uniform(-1, 1, chain.nv))
        q = chain.assemble(start, keep_actuators=False).q_full
        v, effort = kit.allowed_velocity(chain, q, rng), chain.full_effort(rng.normal(size=chain.n))
        found, wanted = machine.full_acceleration(q, v, effort), chain.full_acceleration(q, v, effort)
        # an acceleration far below that of gravity is a difference of larger ones
        worst = max(worst, error_of(found, wanted, floor=1.0))
    assert worst < 1e-12


@pytest.mark.parametrize("name", UNDETERMINED)
def test_what_the_actuators_do_not_determine_raises_what_the_chain_raises(kit: Any, name: str) -> None:
    machine = kit.machine(name)
    home, zero = machine.home, np.zeros(machine.n)
    for call in (
        lambda: machine.forward_dynamics(home, zero, zero),
        lambda: machine.inverse_dynamics(home, zero, zero),
        lambda: machine.terms(home),
        lambda: machine.tangent(home),
        lambda: machine.forward_derivatives(home, zero, zero),
        lambda: machine.batch.forward_dynamics(zero[None], zero, zero),
    ):
        with pytest.raises(ActuationError):
            call()
    assert functions_of(machine) == ("full_forward", "full_motion")


def test_bad_arguments_raise_what_the_model_raises(kit: Any) -> None:
    machine, other = kit.machine("cpm"), kit.model("fourbar")
    home, zero = machine.home, np.zeros(3)
    for bad in (np.zeros(2), [0.0, np.nan, 0.0], "abc", np.array([np.inf, 0, 0])):
        with pytest.raises(InputError):
            machine.forward_dynamics(home, bad, zero)
        with pytest.raises(InputError):
            machine.inverse_dynamics(home, zero, bad)
        with pytest.raises(InputError):
            machine.close(bad)
    with pytest.raises(InputError, match="posture"):
        machine.forward_dynamics(other.home, zero, zero)
    with pytest.raises(InputError, match="posture"):
        machine.close(home.q, other.home)
    with pytest.raises(InputError, match="closed chains"):
        compiled(object())
    with pytest.raises(UnknownNameError):
        machine.kernel("forwards")
    with pytest.raises(InputError):
        machine.kernel("reach")
    with pytest.raises(InputError):
        kit.machine("paper cpm").kernel("tangent")


@pytest.mark.parametrize("name", ["cpm", "fivebar", SLOW_STEWART, "paper cpm", "paper omega3"])
def test_batches_are_the_same_as_calls(kit: Any, name: str) -> None:
    machine = kit.machine(name)
    rng = np.random.default_rng(5)
    q = machine.home.q + 0.02 * rng.uniform(-1, 1, (30, machine.n))
    v, a = rng.normal(size=q.shape), rng.normal(size=q.shape)
    closed = machine.batch.close(q)
    effort = machine.batch.inverse_dynamics(closed, v, a)
    np.testing.assert_allclose(machine.batch.forward_dynamics(closed, v, effort), a, rtol=0, atol=1e-10)
    np.testing.assert_allclose(machine.batch.inverse_dynamics(q, v, a), effort, rtol=1e-11, atol=1e-11)
    mass, coriolis, gravity, *_ = machine.batch.terms(closed, v)
    tools = machine.batch.tool(closed, v)
    for k in (0, 7, 29):
        at = machine.close(q[k])
        assert error_of(effort[k], machine.inverse_dynamics(at, v[k], a[k])) < 1e-12
        terms, tool = machine.terms(at, v[k]), machine.tool(at, v[k])
        assert error_of(mass[k], terms.mass) < 1e-12
        assert error_of(coriolis[k] + gravity[k], terms.coriolis + terms.gravity) < 1e-12
        for part, found in tools._asdict().items():
            assert error_of(found[k], getattr(tool, part), 1.0) < 1e-12, part
        np.testing.assert_array_equal(tools.jacobian[k], tools.frame_jacobian[k, :3])
        np.testing.assert_array_equal(tools.drift[k], tools.frame_drift[k, :3])
    if name in ("cpm", "paper cpm", "paper omega3"):
        np.testing.assert_allclose(machine.batch.reach(tools.position), closed, rtol=0, atol=1e-10)
    with pytest.raises(InputError, match="shape"):
        machine.batch.inverse_dynamics(closed, v[:3], a)
    with pytest.raises(InputError, match="shape"):
        machine.batch.close(q[:, :1] if machine.n > 1 else q[:, 0])


def test_fast_math_is_asked_for_and_agrees(kit: Any) -> None:
    fast = compiled(kit.model("fivebar"), fast=True)
    at = fast.home
    v, x = np.array([0.3, -0.4]), np.array([1.0, 2.0])
    assert error_of(fast.forward_dynamics(at, v, x), kit.model("fivebar").forward_dynamics(at, v, x)) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", REDUCED)
def test_ten_thousand_states(kit: Any, name: str) -> None:
    model, machine = kit.model(name), kit.machine(name)
    rng = np.random.default_rng(6)
    compared = 0
    while compared < 10_000:
        centre = kit.nearby(model, rng, AROUND.get(name, 0.1))
        for q in centre.q + 0.01 * rng.uniform(-1, 1, (100, model.n)):
            try:
                at = model.close(q, centre)
            except CutjointError:
                continue
            v, x = rng.normal(size=model.n), 5.0 * rng.normal(size=model.n)
            forward = machine.kernel("forward")(machine.positions(at), v, x, np.zeros(0))
            if forward[-1] > WELL_POSED:
                continue
            inverse = machine.kernel("inverse")(machine.positions(at), v, x, np.zeros(0))
            # where effort and load cancel, digits are left of what the effort alone would do
            alone = float(np.abs(np.linalg.solve(model.terms(at).mass, x)).max())
            assert error_of(forward[:-1], model.forward_dynamics(at, v, x), alone) < 1e-12
            assert error_of(inverse[:-1], model.inverse_dynamics(at, v, x)) < 1e-12
            compared += 1


@pytest.mark.slow
@pytest.mark.parametrize("name", UNDETERMINED)
def test_many_states_in_full_coordinates(kit: Any, name: str) -> None:
    check_full(kit, kit.machine(name), np.random.default_rng(7), 1000)
