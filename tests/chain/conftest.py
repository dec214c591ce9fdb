"""Robots for the tests of the chain: those under urdf/, and small ones of a few bodies made on the spot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from kit.two_bodies import body, two_bodies

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
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
from cutjoint.errors import ClosureError
from cutjoint.mechanism import Posture
from cutjoint.robots import load


@cache
def robot(name: str, variant: str | None = None) -> ClosedChain:
    """A robot under urdf/, built once."""
    return load(name, variant)


@dataclass(frozen=True)
class State:
    """A closed posture with speeds, accelerations and efforts of the actuators, and a velocity of all joints."""

    at: Posture
    v: np.ndarray
    a: np.ndarray
    effort: np.ndarray
    v_full: np.ndarray


def motions(chain: ClosedChain, q_full: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the velocities that the loops allow, (nv, mobility), found without the chain's own code."""
    jacobian = chain.constraint_jacobian(q_full)
    if not len(jacobian):
        return np.eye(chain.nv)
    _, values, basis = np.linalg.svd(jacobian)
    return basis[int((values > 1e-8 * values[0]).sum()) :].T


def nearby(chain: ClosedChain, rng: np.random.Generator, reach: float = 0.4) -> Posture:
    """A random posture around home; nearer where it cannot be closed."""
    if not chain.mobility().determined:
        step = motions(chain, chain.home.q_full) @ rng.normal(size=chain.mobility().mobility)
        step *= 0.3 * reach / np.abs(step).max()
        return chain.assemble(chain.integrate(chain.home.q_full, step), keep_actuators=False)
    scale = np.array([chain.length if actuator.kind == "translation" else 1.0 for actuator in chain.actuators])
    for _ in range(20):
        try:
            return chain.close(chain.home.q + reach * scale * rng.uniform(-1, 1, chain.n), limits="ignore")
        except ClosureError:
            reach *= 0.8
    raise AssertionError(f"{chain.name} cannot move at all")


def random_states(chain: ClosedChain, count: int, seed: int = 0, reach: float = 0.4) -> list[State]:
    """Random states around home."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        at = nearby(chain, rng, reach)
        v, a = rng.normal(size=chain.n), 5.0 * rng.normal(size=chain.n)
        free = motions(chain, at.q_full)
        v_full = chain.full_velocity(at, v) if chain.mobility().determined else free @ rng.normal(size=free.shape[1])
        made.append(State(at, v, a, 3.0 * rng.normal(size=chain.n), np.array(v_full)))
    return made


def planar_fourbar(
    lengths: tuple[float, float, float], ground: float, home: tuple[float, float, float], cut: str = "revolute"
) -> RobotDescription:
    """A four-bar in the xy plane: crank a, coupler b, rocker c, in the order of `lengths`; tool in the coupler."""
    a, b, c = lengths
    axis = readonly([0.0, 0.0, 1.0])

    def rod(length: float) -> Inertial:
        return Inertial(1.0, np.array([length / 2, 0, 0]), np.diag([1e-3, length**2 / 12, length**2 / 12]))

    return RobotDescription(
        name="planar four-bar",
        links=(Link("base"), Link("A", rod(a)), Link("B", rod(b)), Link("C", rod(c))),
        joints=(
            Joint("a", JointType.CONTINUOUS, "base", "A", axis=axis),
            Joint("b", JointType.CONTINUOUS, "A", "B", placement((a, 0, 0)), axis=axis),
            Joint("c", JointType.CONTINUOUS, "base", "C", placement((ground, 0, 0)), axis=axis),
        ),
        cuts=(CutJoint("tip", CutType(cut), Frame("B", placement((b, 0, 0))), Frame("C", placement((c, 0, 0)))),),
        actuators=("a",),
        tool=Frame("B", placement((b / 2, 0.05, 0))),
        gravity=readonly([0.0, -9.81, 0.0]),
        homes=(Home("default", {"a": home[0]}, {"b": home[1], "c": home[2]}),),
    )


def scaled_masses(description: RobotDescription, factor: float) -> RobotDescription:
    """The same robot of a denser material."""
    links = tuple(
        replace(link, inertial=Inertial(factor * i.mass, i.com, factor * i.inertia)) if (i := link.inertial) else link
        for link in description.links
    )
    return replace(description, links=links)


@dataclass(frozen=True)
class Kit:
    """The functions above, for the tests (test modules cannot import one another)."""

    robot: Callable[..., ClosedChain] = robot
    motions: Callable[..., np.ndarray] = motions
    nearby: Callable[..., Posture] = nearby
    random_states: Callable[..., list[State]] = random_states
    body: Callable[..., Inertial] = body
    planar_fourbar: Callable[..., RobotDescription] = planar_fourbar
    two_bodies: Callable[..., RobotDescription] = two_bodies
    scaled_masses: Callable[..., RobotDescription] = scaled_masses


@pytest.fixture(scope="session")
def kit() -> Kit:
    """Builders of robots and random states."""
    return Kit()


@pytest.fixture
def together() -> Iterator[Callable[[Sequence[Callable[[], object]]], list[object]]]:
    """`together(calls)`: what the calls return, made by eight threads that take turns every tenth of a millisecond."""
    from kit.sharing import together

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield together
    sys.setswitchinterval(before)
