"""Published models with motors that have dampers, friction, springs and rotors, against the chain with the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import JointPhysics
from cutjoint.errors import InputError
from cutjoint.papers.reduced_model import ReducedModel
from cutjoint.robots import PUBLISHED, load, published

ROBOTS = sorted(PUBLISHED)


def random_motors(n: int, rng: np.random.Generator) -> list[JointPhysics]:
    return [
        JointPhysics(
            damping=rng.uniform(0.0, 5.0),
            friction=rng.uniform(0.0, 5.0),
            friction_speed=rng.uniform(0.01, 1.0),
            stiffness=rng.uniform(0.0, 50.0),
            rest=rng.normal(),
            rotor=rng.uniform(0.0, 0.01),
            gear=rng.uniform(-20.0, 20.0),
        )
        for _ in range(n)
    ]


def pair(robot: str, motors: list[JointPhysics]) -> tuple[ReducedModel, ClosedChain]:
    """The published model and the chain with the same motors."""
    model = published(robot)
    assert isinstance(model, ReducedModel)
    description = load(robot, PUBLISHED[robot].variant).description
    own = dict(zip(description.actuators, motors, strict=True))
    joints = tuple(replace(one, physics=own.get(one.name, one.physics)) for one in description.joints)
    return model.with_motors(motors), ClosedChain(replace(description, joints=joints))


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("seed", range(3))
def test_the_chain_with_the_same_motors_agrees(robot: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model, chain = pair(robot, random_motors(published(robot).n, rng))
    for speed in (0.0, 0.005, 1.0):
        at = chain.home
        there = model.close(at.q)
        v, a = speed * rng.normal(size=chain.n), rng.normal(size=chain.n)
        one, other = model.terms(there, v), chain.terms(at, v)
        for name in ("mass", "coriolis", "gravity", "springs", "friction"):
            wanted = getattr(other, name)
            assert getattr(one, name) == pytest.approx(wanted, abs=1e-10 * (1.0 + np.abs(wanted).max())), name
        effort = model.inverse_dynamics(there, v, a)
        assert effort == pytest.approx(chain.inverse_dynamics(at, v, a), rel=1e-9, abs=1e-9)
        assert model.forward_dynamics(there, v, effort) == pytest.approx(a, rel=1e-9, abs=1e-9)
        assert model.dissipation(there, v) == pytest.approx(one.friction @ v)
        assert model.dissipation(there, v) == pytest.approx(chain.dissipation(at, v), abs=1e-12)


@pytest.mark.parametrize("robot", ROBOTS)
def test_springs_of_motors_have_their_energy(robot: str) -> None:
    model, chain = pair(robot, random_motors(published(robot).n, np.random.default_rng(7)))
    bare = published(robot)
    q = chain.home.q + 0.01
    stored = model.potential_energy(model.close(q)) - bare.potential_energy(bare.close(q))
    assert stored == pytest.approx(chain.spring_energy(chain.close(q)), rel=1e-12)


@pytest.mark.parametrize("robot", ROBOTS)
def test_motors_stay_with_payload_and_branch(robot: str) -> None:
    motors = JointPhysics(friction=3.0)
    model = published(robot)
    assert isinstance(model, ReducedModel)
    loaded = model.with_motors(motors).with_payload(0.1)
    assert loaded.motors == (motors,) * model.n
    assert not model.motors


BAD = {
    "negative damping": (JointPhysics(damping=-1.0), "damping"),
    "no number": (JointPhysics(friction=float("nan")), "friction"),
    "gear 0": (JointPhysics(rotor=1.0, gear=0.0), "gear"),
    "no rest": (JointPhysics(stiffness=1.0), "rest"),
    "stiction": (JointPhysics(friction=1.0, friction_speed=0.0), "stiction"),
    "stops": (JointPhysics(stop_stiffness=1.0), "stops"),
    "damped stops": (JointPhysics(stop_damping=1.0), "stops"),
    "rest that is none": (JointPhysics(stiffness=1.0, rest=float("nan")), "rest"),
    "text": (JointPhysics(stiffness=1.0, rest="middle"), "rest"),  # type: ignore[arg-type]
    "text for a number": (JointPhysics(rotor="heavy"), "rotor"),  # type: ignore[arg-type]
    "one too few": ([JointPhysics()], "2|3"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_motors(name: str) -> None:
    given, words = BAD[name]
    model = published("cpm")
    assert isinstance(model, ReducedModel)
    with pytest.raises(InputError, match=words):
        model.with_motors(given)
