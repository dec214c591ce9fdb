"""Laws of motion of every robot under urdf/: forces in the cuts, two ways to solve, power, energy, reduced terms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.shipped import DETERMINED, OTHERS, SHIPPED, VARIANTS

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.description.cuts import HINGE, LOCK, POINT, dot, slide
from cutjoint.description.model import CutJoint, CutType, Frame, Home, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, DynamicsError
from cutjoint.mechanism import Mechanism, Posture, kinetic_energy

H = 1e-4


def test_the_lists_are_not_empty() -> None:
    assert {"cpm", "omega3", "stewart", "fourbar", "fivebar"} <= set(DETERMINED)
    assert {"redundant", "underactuated"} <= set(OTHERS)


# ---- full coordinates ------------------------------------------------------------------------------------------------


def external(chain: ClosedChain, q: np.ndarray, motion: Any) -> tuple[pin.StdVec_Force, np.ndarray]:
    """The forces in cuts as external forces on the open tree (in joint frames), those of couplings as efforts."""
    data = chain.model.createData()
    pin.forwardKinematics(chain.model, data, q)
    forces = pin.StdVec_Force()
    for _ in range(chain.model.njoints):
        forces.append(pin.Force.Zero())
    for cut, (_, _, b) in zip(chain.description.cuts, chain.cut_placements(q), strict=True):
        wrench = motion.loop_forces[cut.name]
        at_b = pin.SE3(np.eye(3), b[:3, 3])
        for link, sign in ((cut.a.link, -1.0), (cut.b.link, 1.0)):
            joint = chain.model.frames[chain.model.getFrameId(link, pin.FrameType.BODY)].parentJoint
            in_world = at_b.act(pin.Force(sign * wrench.force, sign * wrench.moment))
            forces[joint] = forces[joint] + data.oMi[joint].actInv(in_world)
    efforts = np.zeros(chain.nv)
    for coupling in chain.description.couplings:
        force = motion.couplings[coupling.name]
        efforts[chain.model.idx_vs[chain.model.getJointId(coupling.joint)]] += force
        efforts[chain.model.idx_vs[chain.model.getJointId(coupling.gear[0])]] -= coupling.gear[1] * force
    return forces, efforts


def check_forces(chain: ClosedChain, q: np.ndarray, v: np.ndarray, effort: np.ndarray) -> None:
    """Open tree + forces of the cuts = closed robot."""
    motion = chain.full_forward_dynamics(chain.posture(q), v, effort)
    forces, efforts = external(chain, q, motion)
    data = chain.model.createData()
    free = pin.aba(chain.model, data, q, v, effort + efforts, forces)
    size = max(1.0, float(np.abs(motion.acceleration).max()))
    np.testing.assert_allclose(free, motion.acceleration, atol=1e-9 * size)
    moved = chain.constraint_jacobian(q) @ motion.acceleration
    drift = chain._k.moving(q, v).drift
    np.testing.assert_allclose(moved, -drift, atol=1e-9 * max(1.0, float(np.abs(drift).max())))
    without = pin.aba(chain.model, data, q, v, effort)
    assert np.abs(without - motion.acceleration).max() > 1e-3, "the cuts do something"


@pytest.mark.parametrize("name", SHIPPED)
def test_loop_forces_on_the_open_tree_give_the_same_motion(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 4):
        check_forces(chain, np.array(state.at.q_full), state.v_full, chain.full_effort(state.effort))


@pytest.mark.parametrize("kind", [kind.value for kind in CutType])
def test_loop_forces_of_every_cut_type(kind: str, kit: Any) -> None:
    chain = ClosedChain(kit.two_bodies(kind))
    rng = np.random.default_rng(1)
    for _ in range(3):
        start = pin.integrate(chain.model, np.array(chain.home.q_full), rng.normal(size=chain.nv))
        q = np.array(chain.assemble(start, keep_actuators=False).q_full)
        free = kit.motions(chain, q)
        check_forces(chain, q, free @ rng.normal(size=free.shape[1]), rng.normal(size=chain.nv))


TURNS = ((), (LOCK,), (HINGE,), *((dot(i, j, "t"),) for i in range(3) for j in range(3)))


@pytest.mark.parametrize("seed", range(12))
def test_cuts_made_of_any_equations(seed: int, add_row: Callable[..., None], kit: Any) -> None:
    """A type is its equations: random ones in any order stay closed, balance, and are the same compiled."""
    rng = np.random.default_rng(seed)
    slides = [slide(k) for k in rng.permutation(3)[: rng.integers(0, 3)]]
    equations = [*TURNS[seed], *([POINT] if rng.integers(0, 3) == 0 else slides)] or [slide(1)]
    if seed % 4 == 3:
        equations.append(dot(*((seed + k) % 3 for k in (0, 1)), "more"))
    rng.shuffle(equations)
    add_row(CutType, "new", tuple(equations), "", "test")
    chain = ClosedChain(kit.two_bodies("new"))
    assert chain.mobility().mobility == 12 - chain.mobility().rank
    start = pin.integrate(chain.model, np.array(chain.home.q_full), 0.3 * rng.normal(size=chain.nv))
    q = np.array(chain.assemble(start, keep_actuators=False).q_full)
    free = kit.motions(chain, q)
    v, effort = free @ rng.normal(size=free.shape[1]), rng.normal(size=chain.nv)
    check_forces(chain, q, v, effort)
    a = chain.full_forward_dynamics(chain.posture(q), v, effort).acceleration
    gaps = [sum(chain.gap(pin.integrate(chain.model, q, h * v + 0.5 * h**2 * a))) for h in (1e-2, 5e-3)]
    assert gaps[1] < 0.17 * gaps[0] or gaps[0] < 1e-12, "what is left open falls with the third power of time"
    code = compiled(chain, cached=False).kernel("full_forward")(q, v, effort, np.zeros(0))
    np.testing.assert_allclose(code[: chain.nv], a, rtol=0, atol=1e-8 * np.abs(a).max())


@pytest.mark.parametrize("name", SHIPPED)
def test_pinocchios_constraint_dynamics_against_the_equations_in_numpy(name: str, kit: Any) -> None:
    """A revolute cut is two points there and five rows of its own here."""
    chain = kit.robot(name)
    for state in kit.random_states(chain, 4):
        q, v, effort = np.array(state.at.q_full), state.v_full, chain.full_effort(state.effort)
        ours = chain.full_forward_dynamics(state.at, v, effort).acceleration
        theirs = chain._dynamics.rigid.acceleration(q, v, effort)
        assert theirs is not None, "its iteration converges"
        size = max(1.0, float(np.abs(ours).max()))
        np.testing.assert_allclose(theirs, ours, atol=1e-9 * size)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize("name", SHIPPED)
def test_dynamics_do_not_depend_on_the_unit_of_mass(name: str, factor: float, kit: Any) -> None:
    chain = kit.robot(name)
    other = ClosedChain(kit.scaled_masses(chain.description, factor))
    for state in kit.random_states(chain, 2):
        v, effort = state.v_full, chain.full_effort(state.effort)
        wanted = chain.full_forward_dynamics(state.at, v, effort).acceleration
        found = other.full_forward_dynamics(state.at, v, factor * effort).acceleration
        np.testing.assert_allclose(found, wanted, atol=1e-8 * max(1.0, float(np.abs(wanted).max())))


@pytest.mark.parametrize("name", SHIPPED)
def test_power_of_the_efforts_is_the_growth_of_energy(name: str, kit: Any) -> None:
    """In full coordinates; v'a is taken from forward dynamics, energies from Pinocchio's tree."""
    chain = kit.robot(name)
    data = chain.model.createData()

    def energy(q: np.ndarray, v: np.ndarray) -> float:
        kinetic = pin.computeKineticEnergy(chain.model, data, q, v)
        return kinetic + pin.computePotentialEnergy(chain.model, data, q)

    for state in kit.random_states(chain, 3):
        q, v, effort = np.array(state.at.q_full), state.v_full, chain.full_effort(state.effort)
        a = chain.full_forward_dynamics(state.at, v, effort).acceleration
        steps = [
            energy(pin.integrate(chain.model, q, s * H * (v + 0.5 * s * H * a)), v + s * H * a) for s in (1.0, -1.0)
        ]
        power = float(effort @ v)
        size = float(np.abs(effort) @ np.abs(v)) + energy(q, v) ** 2
        assert (steps[0] - steps[1]) / (2 * H) == pytest.approx(power, abs=1e-5 * max(1.0, size))


@pytest.mark.parametrize("name", SHIPPED)
def test_energy_is_kept_without_effort(name: str, kit: Any) -> None:
    """A short run of the classical Runge-Kutta method, projected onto the loops after each step."""
    chain = kit.robot(name)
    data = chain.model.createData()
    state = kit.random_states(chain, 1)[0]
    q, v = np.array(state.at.q_full), 0.3 * state.v_full
    zero = np.zeros(chain.nv)

    def energies() -> tuple[float, float]:
        kinetic = pin.computeKineticEnergy(chain.model, data, q, v)
        return kinetic, kinetic + pin.computePotentialEnergy(chain.model, data, q)

    (first, start), dt = energies(), 1e-3
    moved = 0.0
    for _ in range(40):
        k1 = chain.full_acceleration(q, v, zero)
        v2 = v + 0.5 * dt * k1
        k2 = chain.full_acceleration(chain.integrate(q, 0.5 * dt * v), v2, zero)
        v3 = v + 0.5 * dt * k2
        k3 = chain.full_acceleration(chain.integrate(q, 0.5 * dt * v2), v3, zero)
        v4 = v + dt * k3
        k4 = chain.full_acceleration(chain.integrate(q, dt * v3), v4, zero)
        q = chain.integrate(q, dt / 6 * (v + 2 * v2 + 2 * v3 + v4))
        v = v + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        q, v = chain.project(q, v)
        kinetic, total = energies()
        moved = max(moved, abs(kinetic - first))
        assert max(chain.gap(q)) < 1e-12
        assert np.abs(chain.constraint_jacobian(q) @ v).max() < 1e-9 * max(1.0, float(np.abs(v).max()))
    assert total == pytest.approx(start, abs=1e-6 * max(first, moved))
    if np.abs(chain.model.gravity.linear @ np.ones(3)) > 0 and name != "redundant":
        assert moved > 1e-4 * first, "something happened"


@pytest.mark.parametrize("name", OTHERS)
def test_reduced_coordinates_are_refused_where_they_do_not_exist(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    report = chain.mobility()
    with pytest.raises(ActuationError) as caught:
        chain.terms(chain.home)
    assert (caught.value.mobility, caught.value.actuators) == (report.mobility, report.actuators)
    assert caught.value.free == report.free
    assert str(report.mobility) in str(caught.value)


# ---- reduced coordinates ---------------------------------------------------------------------------------------------


def terms_by_differences(chain: Mechanism, at: Posture, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Matrix C of Christoffel's symbols, dM/dt and the gradient of the potential energy, by central differences."""
    n = chain.n
    slopes, gradient = np.zeros((n, n, n)), np.zeros(n)
    for k, unit in enumerate(np.eye(n)):
        ahead, behind = (chain.close(at.q + s * H * unit, at) for s in (1, -1))
        slopes[k] = (chain.terms(ahead).mass - chain.terms(behind).mass) / (2 * H)
        gradient[k] = (chain.potential_energy(ahead) - chain.potential_energy(behind)) / (2 * H)
    rate = np.einsum("kij,k->ij", slopes, v)
    christoffel = 0.5 * (rate + np.einsum("jik,k->ij", slopes, v) - np.einsum("ijk,k->ij", slopes, v))
    return christoffel, rate, gradient


@pytest.mark.parametrize(("name", "variant"), [*((name, None) for name in DETERMINED), *VARIANTS])
def test_terms_are_those_of_lagrange(name: str, variant: str | None, kit: Any) -> None:
    """M symmetric and positive definite; C v by Christoffel's symbols, so dM/dt - 2C is skew; gravity is a gradient."""
    chain = kit.robot(name, variant)
    for state in kit.random_states(chain, 3, reach=0.2):
        terms = chain.terms(state.at, state.v)
        assert np.array_equal(terms.mass, terms.mass.T)
        assert np.linalg.eigvalsh(terms.mass)[0] > 0.0
        christoffel, rate, gradient = terms_by_differences(chain, state.at, state.v)
        size = float(np.abs(rate).max()) + 1e-9
        skew = rate - 2.0 * christoffel
        np.testing.assert_allclose(skew, -skew.T, atol=1e-12 * size + 1e-15)
        np.testing.assert_allclose(terms.coriolis, christoffel @ state.v, atol=1e-5 * max(size, 1e-3))
        assert state.v @ terms.coriolis == pytest.approx(0.5 * state.v @ rate @ state.v, abs=1e-5 * max(size, 1e-3))
        np.testing.assert_allclose(terms.gravity, gradient, atol=1e-6 * max(1.0, float(np.abs(gradient).max())))
        assert np.array_equal(chain.terms(state.at).coriolis, np.zeros(chain.n))


@pytest.mark.parametrize(("name", "variant"), [*((name, None) for name in DETERMINED), *VARIANTS])
def test_forward_undoes_inverse_dynamics(name: str, variant: str | None, kit: Any) -> None:
    chain = kit.robot(name, variant)
    for state in kit.random_states(chain, 5):
        effort = chain.inverse_dynamics(state.at, state.v, state.a)
        terms = chain.terms(state.at, state.v)
        whole = terms.mass @ state.a + terms.coriolis + terms.gravity
        np.testing.assert_allclose(effort, whole, atol=1e-11 * float(np.abs(whole).max()) + 1e-12)
        back = chain.forward_dynamics(state.at, state.v, effort)
        np.testing.assert_allclose(back, state.a, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", DETERMINED)
def test_kinetic_energy_is_that_of_the_tree(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 3):
        wanted = pin.computeKineticEnergy(
            chain.model, chain.model.createData(), np.array(state.at.q_full), np.array(state.v_full)
        )
        assert kinetic_energy(chain, state.at, state.v) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("name", DETERMINED)
def test_a_payload_is_a_point_mass_at_the_tool(name: str, kit: Any) -> None:
    chain, mass = kit.robot(name), 0.37
    loaded = chain.with_payload(mass)
    assert loaded.name == chain.name
    pull = np.array(chain.description.gravity)
    for state in kit.random_states(chain, 3):
        tool, bare = chain.tool(state.at, state.v), chain.terms(state.at, state.v)
        found = loaded.terms(state.at, state.v)
        jacobian = tool.jacobian
        for name_, value, more in (
            ("mass", bare.mass, mass * jacobian.T @ jacobian),
            ("coriolis", bare.coriolis, mass * jacobian.T @ tool.drift),
            ("gravity", bare.gravity, -mass * jacobian.T @ pull),
        ):
            np.testing.assert_allclose(getattr(found, name_), value + more, atol=1e-11, err_msg=name_)
        energy = loaded.potential_energy(state.at) - chain.potential_energy(state.at)
        assert energy == pytest.approx(-mass * pull @ tool.position, abs=1e-11)


def test_a_payload_keeps_the_home(kit: Any) -> None:
    description = kit.robot("fivebar").description
    mode = kit.robot("fivebar").working_modes()[1]
    values = dict(zip(description.actuators, mode.q, strict=True))
    names = [name for name in kit.robot("fivebar").model.names if name != "universe" and name not in values]
    passive = {name: float(mode.q_full[kit.robot("fivebar").model.getJointId(name) - 1]) for name in names}
    there = replace(description, homes=(*description.homes, Home("other", values, passive)))
    chain = ClosedChain(there, "other")
    np.testing.assert_allclose(chain.home.q_full, mode.q_full, atol=1e-9)
    np.testing.assert_allclose(chain.with_payload(1.0).home.q_full, chain.home.q_full, atol=1e-12)


def test_a_body_without_mass_on_a_free_joint_changes_nothing(kit: Any) -> None:
    """It stays at rest on its joint; a force on it has no answer.  Never a NaN."""
    description = kit.planar_fourbar((0.2, 0.4, 0.3), 0.5, (1.0, -0.5, 1.2))
    links = (*description.links, Link("loose"))
    joints = (*description.joints, Joint("spin", JointType.CONTINUOUS, "C", "loose", axis=readonly([1.0, 0.0, 0.0])))
    chain = ClosedChain(replace(description, links=links, joints=joints))
    zero, push = np.zeros(chain.nv), np.zeros(chain.nv)
    spin = chain.model.idx_vs[chain.model.getJointId("spin")]
    found = chain.full_forward_dynamics(chain.home, zero, zero).acceleration
    bare = ClosedChain(description)
    wanted = bare.full_forward_dynamics(bare.home, zero[1:], zero[1:]).acceleration
    assert found[spin] == 0.0
    np.testing.assert_allclose(np.delete(found, spin), wanted, rtol=1e-11)
    push[spin] = 1e-3
    with pytest.raises(DynamicsError, match="moves no mass, of spin"):
        chain.full_forward_dynamics(chain.home, zero, push)


def test_gravity_of_robots_with_more_or_fewer_motors_is_a_gradient_too(kit: Any) -> None:
    for name in OTHERS:
        chain = kit.robot(name)
        data = chain.model.createData()
        for state in kit.random_states(chain, 2):
            q, free = np.array(state.at.q_full), kit.motions(chain, state.at.q_full)
            weight = free.T @ pin.computeGeneralizedGravity(chain.model, data, q)
            for direction, found in zip(free.T, weight, strict=True):
                ahead, behind = (
                    pin.computePotentialEnergy(chain.model, data, pin.integrate(chain.model, q, s * H * direction))
                    for s in (1, -1)
                )
                assert found == pytest.approx((ahead - behind) / (2 * H), abs=1e-6)


def test_a_universal_cut_turns_a_shaft_unevenly(kit: Any) -> None:
    """Cardan: two shafts at an angle b, joined by a universal cut: tan(out) = tan(in) / cos(b)."""
    bend = 0.5
    along = readonly([0.0, 0.0, 1.0])
    frame_a = placement((0, 0, 0.1))
    links = (Link("base"), Link("in", kit.body()), Link("out", kit.body(0.8, (0, 0, 0.1), 2)))
    joints = (
        Joint("in", JointType.REVOLUTE, "base", "in", axis=along),
        Joint("out", JointType.REVOLUTE, "base", "out", placement((0, 0, 0.1), (0.0, bend, 0.0)), axis=along),
    )
    cut = CutJoint("cross", CutType.UNIVERSAL, Frame("in", frame_a), Frame("out"))
    description = RobotDescription("cardan", links, joints, (cut,), actuators=("in",))
    chain = ClosedChain(replace(description, gravity=readonly([0.0, 0.0, 0.0])))
    report = chain.mobility()
    assert (report.rows, report.rank, report.mobility) == (4, 1, 1)
    for angle in (0.3, 0.8, 1.2, 2.5, 4.0):
        at = chain.close([angle])
        out = at.q_full[1]
        # x of the driving fork against y of the driven one
        assert np.tan(out) == pytest.approx(np.tan(angle) / np.cos(bend), rel=1e-10)
        ratio = chain.tangent(at)[1, 0]
        sine2 = np.sin(angle) ** 2 + np.cos(angle) ** 2 * np.cos(bend) ** 2
        assert ratio == pytest.approx(np.cos(bend) / sine2, rel=1e-10)
        one, two = (chain.description.link(name).inertial for name in ("in", "out"))
        about = [body.inertia[2, 2] + body.mass * (body.com[0] ** 2 + body.com[1] ** 2) for body in (one, two)]
        assert chain.terms(at).mass[0, 0] == pytest.approx(about[0] + ratio**2 * about[1], rel=1e-12)
