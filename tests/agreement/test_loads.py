"""Loads from outside and minimal coordinates against the oracle in maximal coordinates: every mechanism, size and
mounting, with all its motors, with some, and with none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import built
from kit.by_joint import by_joint, coordinates, full, placed
from kit.loaded import minimal_of, outside, random_loads
from kit.mechanisms import MECHANISMS
from kit.postures import moving, random_posture, scale_of
from kit.quickly import few

from cutjoint.errors import ActuationError, SingularError

ACCURACY = 1e-10
"""Relative: two formulations in double precision, away from singular postures."""

SIZES = [(1.0, 1.0), (1e-3, 1e-3), (1e3, 1e3), (1e-3, 1e3)]
QUICK = ("floating_fourbar", "hexapod", "spherical_3rrr", "ball_rod_ankle", "geared_fivebar")


def weight_of(length: float, density: float, chain) -> float:
    """A force of the size of the robot's weight [N]."""
    return 9.81 * sum(link.inertial.mass for link in chain.description.links if link.inertial is not None)


@pytest.mark.parametrize("name", few(MECHANISMS, *QUICK))
@pytest.mark.parametrize("size", few(SIZES, SIZES[0]))
def test_accelerations_of_all_joints_under_loads(name: str, size: tuple[float, float], tmp_path: Path) -> None:
    rng = np.random.default_rng([21, *name.encode()])
    mechanism = MECHANISMS[name](rng)
    chain, oracle = built(mechanism.plan, tmp_path, random_mounting(rng), *size)
    at = random_posture(chain, oracle, rng, mobility=mechanism.mobility)
    p = placed(chain, oracle, at.q_full)
    weight, rate = weight_of(*size, chain), np.sqrt(9.81 / chain.length)
    v = rate * moving(chain, p, rng.normal(size=p.mobility))
    effort = weight * chain.length / scale_of(chain, oracle) * rng.normal(size=chain.nv)
    loads = random_loads(chain, rng, weight)
    motion = p.moving(by_joint(chain, v), outside(p, loads)).driven(by_joint(chain, effort))
    found = chain.full_forward_dynamics(at, v, effort, loads)
    judge.require(
        {
            "acceleration": judge.apart(chain, motion, found.acceleration),
            "loop forces": judge.loop_forces(motion, found),
            "unloaded": judge.apart(
                chain, motion, chain.full_acceleration(at.q_full, v, effort + chain.full_load_effort(at, loads))
            ),
        },
        ACCURACY,
        name,
    )


@pytest.mark.parametrize("name", few(MECHANISMS, *QUICK))
@pytest.mark.parametrize("motors", ["all", "some", "none"])
@pytest.mark.parametrize("size", few(SIZES, SIZES[0]))
def test_minimal_coordinates(name: str, motors: str, size: tuple[float, float], tmp_path: Path) -> None:
    """Energies, forward dynamics and efforts are the oracle's, whichever velocities are independent."""
    rng = np.random.default_rng([22, *name.encode()])
    mechanism = MECHANISMS[name](rng)
    plan = mechanism.plan
    plan.actuators = {"all": plan.actuators, "some": plan.actuators[: len(plan.actuators) // 2], "none": []}[motors]
    chain, oracle = built(plan, tmp_path, random_mounting(rng), *size)
    try:
        minimal = minimal_of(chain)
    except ActuationError:
        # a rod that is not round has a spin of its own, which is one of the three velocities of its ball
        assert name.startswith("ball_rod")
        assert motors != "all"
        pytest.skip("no whole joints have the freedoms of this one")
    at = random_posture(chain, oracle, rng, mobility=mechanism.mobility)
    p = placed(chain, oracle, at.q_full)
    try:
        minimal.tangent(at)
    except SingularError:
        assert motors == "all"
        assert p.locked.shape[1] > 0, "the oracle sees a motion with the actuators locked, too"
        return
    weight, rate, scale = weight_of(*size, chain), np.sqrt(9.81 / chain.length), scale_of(chain, oracle)
    own = scale[minimal.v_index]
    v = rate * own * rng.normal(size=minimal.n)
    v_full = minimal.full_velocity(at, v)
    effort = weight * chain.length / chain.actuated_velocity(scale) * rng.normal(size=chain.n)
    loads = random_loads(chain, rng, weight)
    state = p.moving(by_joint(chain, v_full), outside(p, loads))
    assert state.unmet <= 1e-11 * np.abs(v_full / scale).max()
    motion = state.driven(by_joint(chain, chain.full_effort(effort)))
    wanted = minimal.of(full(chain, motion.joints)) / own
    least = 9.81 / chain.length
    a = minimal.forward_dynamics(at, v, effort, loads)
    force = minimal.inverse_dynamics(at, v, a, loads)
    pushed = minimal.effort_map(at) @ effort
    terms = minimal.terms(at, v)
    acting = np.abs(terms.mass @ a) + np.abs(terms.coriolis) + np.abs(terms.gravity)
    worst = float((own * acting).max())
    judge.require(
        {
            "acceleration": judge.relative(a / own, wanted, least),
            "kinetic energy": judge.relative(minimal.kinetic_energy(at, v), state.kinetic_energy),
            "forces": judge.relative(own * force, own * pushed, worst),
            "terms": judge.relative(
                own * (terms.mass @ a + terms.bias - minimal.load_effort(at, loads)), own * pushed, worst
            ),
        },
        ACCURACY,
        f"{name} {minimal}",
    )
    given = minimal.efforts(at, v, a, loads).effort
    assert np.abs(own * (minimal.effort_map(at) @ given - pushed)).max(initial=0.0) <= ACCURACY * worst


@pytest.mark.parametrize("name", few(MECHANISMS, "prs_3", "ups_6", "ball_rod_delta"))
def test_where_the_actuators_do_it_they_are_the_coordinates(name: str, tmp_path: Path) -> None:
    """Terms, tangent and tool are those of the chain, bit for bit."""
    rng = np.random.default_rng([23, *name.encode()])
    chain, _ = built(MECHANISMS[name](rng).plan, tmp_path, random_mounting(rng))
    if not chain.mobility().determined:
        pytest.skip("its actuators do not determine its motion")
    minimal, at, v = chain.minimal(), chain.home, rng.normal(size=chain.n)
    assert minimal.joints == tuple(actuator.name for actuator in chain.actuators)
    assert np.array_equal(minimal.effort_map(at), np.eye(chain.n))
    for found, wanted in (
        (minimal.tangent(at), chain.tangent(at)),
        (minimal.drift(at, v), chain.drift(at, v)),
        (minimal.terms(at, v).mass, chain.terms(at, v).mass),
        (minimal.terms(at, v).bias, chain.terms(at, v).bias),
        (minimal.forward_dynamics(at, v, v), chain.forward_dynamics(at, v, v)),
    ):
        assert np.array_equal(found, wanted)


ROUND = [name for name in MECHANISMS if not name.startswith("ball_rod")]
"""Those without rods that spin, whose spin no coordinate tells."""


@pytest.mark.parametrize("name", few(ROUND, "floating_fourbar", "spherical_3rrr", "planar_3rrr"))
def test_a_motion_of_the_coordinates(name: str, tmp_path: Path) -> None:
    """`moved` moves the coordinates by what is asked, keeps the loops closed, and its derivative is the tangent."""
    rng = np.random.default_rng([24, *name.encode()])
    mechanism = MECHANISMS[name](rng)
    mechanism.plan.actuators = mechanism.plan.actuators[:1]
    chain, oracle = built(mechanism.plan, tmp_path, random_mounting(rng))
    minimal, at = minimal_of(chain), random_posture(chain, oracle, rng, mobility=mechanism.mobility)
    scale = scale_of(chain, oracle)
    change = 0.02 * scale[minimal.v_index] * rng.normal(size=minimal.n)
    there = minimal.moved(at, change)
    assert placed(chain, oracle, there.q_full).gap < 1e-11
    assert np.abs(minimal.change(at, there) - change).max() <= 1e-13 * np.abs(scale).max()
    step = 1e-4
    ahead, behind = (minimal.moved(at, sign * step * change) for sign in (1.0, -1.0))
    slope = chain._k.tree.difference(behind.q_full, ahead.q_full) / (2.0 * step)
    assert np.abs((slope - minimal.tangent(at) @ change) / scale).max() < 1e-7
    assert coordinates(chain, at.q_full).keys() == by_joint(chain, slope).keys()


def test_a_floating_fourbar_needs_more_motors_for_other_motions(tmp_path: Path) -> None:
    rng = np.random.default_rng(25)
    chain, _ = built(MECHANISMS["floating_fourbar"](rng).plan, tmp_path)
    minimal = chain.minimal()
    with pytest.raises(ActuationError, match="degrees of freedom"):
        minimal.efforts(chain.home, np.zeros(minimal.n), np.ones(minimal.n))
