"""One chain used by eight threads at once, and in other processes, gives the bits that it gives alone."""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from kit.rods import ankle
from kit.sharing import alike

from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.description import RobotDescription, load_description
from cutjoint.errors import ClosureError, UnreachableError
from cutjoint.mechanism import Pose

Together = Callable[[Sequence[Callable[[], Any]]], list[Any]]
ROBOTS = ("cpm", "omega3", "stewart", "fivebar", "ankle")
QUICK, ALL = 120, 480
"""Calls of each method; in the hundredth and so on all threads take turns at every line."""


@cache
def description(name: str) -> RobotDescription:
    if name != "ankle":
        return load_description(name)
    with TemporaryDirectory() as folder:
        return load_description(ankle(np.random.default_rng(1)).write(Path(folder)))


@cache
def postures(name: str) -> list[Any]:
    chain, rng = ClosedChain(description(name)), np.random.default_rng(2)
    units = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    return [chain.close(chain.home.q + 0.1 * units * rng.uniform(-1.0, 1.0, chain.n)) for _ in range(24)]


@cache
def tools(name: str) -> list[Pose]:
    chain = ClosedChain(description(name))
    return [chain.tool(at).pose for at in postures(name)]


def v(chain: Any) -> np.ndarray:
    return np.linspace(-0.4, 0.7, chain.n)


def full_v(chain: Any, at: Any) -> np.ndarray:
    return np.array(chain.full_velocity(at, v(chain)))


def effort(chain: Any) -> np.ndarray:
    return np.linspace(-1.0, 2.0, chain.nv)


def allowed(chain: Any, at: Any) -> np.ndarray:
    """An acceleration that the actuators can produce."""
    driven = chain.full_effort(np.linspace(-1.0, 2.0, chain.n))
    return chain.full_forward_dynamics(at, full_v(chain, at), driven).acceleration


# Public method -> a call of it with a posture and the pose of the tool there; `None` is no work of the chain's own.
METHODS: dict[str, Callable[[Any, Any, Pose], Any] | None] = {
    "actuated": None,
    "actuated_velocity": None,
    "actuators": None,
    "actuation": None,
    "assemble": lambda c, at, p: c.assemble(at.q_full + 1e-3 * (c.nq == c.nv)),
    "centre_of_mass": lambda c, at, p: c.centre_of_mass(at),
    "close": lambda c, at, p: c.close(at.q, c.home),
    "collision_model": None,
    "compile": None,
    "constraint_datas": None,
    "constraint_jacobian": lambda c, at, p: c.constraint_jacobian(at),
    "constraint_models": None,
    "constraint_residual": lambda c, at, p: c.constraint_residual(at),
    "cut_placements": lambda c, at, p: c.cut_placements(at),
    "drift": lambda c, at, p: c.drift(at, v(c)),
    "forward_dynamics": lambda c, at, p: c.forward_dynamics(at, v(c), v(c)),
    "full_acceleration": lambda c, at, p: c.full_acceleration(at.q_full, full_v(c, at), effort(c)),
    "full_effort": None,
    "full_forward_dynamics": lambda c, at, p: c.full_forward_dynamics(at, full_v(c, at), effort(c)),
    "full_inverse_dynamics": lambda c, at, p: c.full_inverse_dynamics(at, full_v(c, at), allowed(c, at)),
    "full_motion": lambda c, at, p: c.full_motion(at, c.tool(at).jacobian @ v(c), c.tool(at, v(c)).drift),
    "full_velocity": lambda c, at, p: c.full_velocity(at, v(c)),
    "gap": lambda c, at, p: c.gap(at.q_full),
    "goes_beyond": lambda c, at, p: c.goes_beyond(c.home.q_full, at.q_full),
    "home": lambda c, at, p: c.home,
    "idle_is_cyclic": lambda c, at, p: c.idle_is_cyclic,
    "integrate": lambda c, at, p: c.integrate(at.q_full, effort(c)),
    "inverse_dynamics": lambda c, at, p: c.inverse_dynamics(at, v(c), v(c)),
    "load_effort": lambda c, at, p: c.load_effort(at, Load([1.0, 2.0, 3.0], link=c.description.links[-1].name)),
    "full_load_effort": lambda c, at, p: c.full_load_effort(at, Load([1.0, 2.0, 3.0])),
    "pushes_idle": lambda c, at, p: c.pushes_idle(at, Load([1.0, 2.0, 3.0])),
    "minimal": lambda c, at, p: c.minimal().terms(at, v(c)).coriolis,
    "rebuilt": None,
    "sticking": lambda c, at, p: dict(c.sticking),
    "length": None,
    "limit_violations": lambda c, at, p: c.limit_violations(at),
    "link_placements": lambda c, at, p: c.link_placements(at),
    "mobility": lambda c, at, p: c.mobility(at),
    "n": None,
    "local_model": None,
    "name": None,
    "neutral": lambda c, at, p: c.neutral,
    "nq": None,
    "nv": None,
    "origin": lambda c, at, p: c.origin,
    "posture": lambda c, at, p: c.posture(at),
    "to_mujoco": lambda c, at, p: c.to_mujoco(at),
    "from_mujoco": lambda c, at, p: c.from_mujoco(c.to_mujoco(at)),
    "potential_energy": lambda c, at, p: c.potential_energy(at),
    "dissipates": lambda c, at, p: c.dissipates,
    "spring_energy": lambda c, at, p: c.spring_energy(at),
    "led_velocity": lambda c, at, p: c.led_velocity(at, v(c)),
    "reactions": lambda c, at, p: c.reactions(at, v(c), v(c)),
    "full_reactions": lambda c, at, p: c.full_reactions(at, full_v(c, at), effort_full=effort(c)),
    "dissipation": lambda c, at, p: c.dissipation(at, np.linspace(-1.0, 1.0, c.n)),
    "full_dissipation": lambda c, at, p: c.full_dissipation(at, np.linspace(-1.0, 1.0, c.nv)),
    "project": lambda c, at, p: c.project(c.integrate(at.q_full, 1e-5 * effort(c)), full_v(c, at)),
    "reach": lambda c, at, p: c.reach(p, c.home),
    "tangent": lambda c, at, p: c.tangent(at),
    "task": lambda c, at, p: c.task,
    "terms": lambda c, at, p: c.terms(at, v(c)),
    "tool": lambda c, at, p: c.tool(at, v(c)),
    "with_payload": None,
    "working_modes": None,
    "assembly_modes": None,
    "visual_model": None,
}
"""Modes are searched once below, not 480 times."""


def test_no_method_is_left_out() -> None:
    public = {name for name, _ in inspect.getmembers(ClosedChain) if not name.startswith("_")}
    assert public <= set(METHODS)


def same(found: Any, wanted: Any) -> None:
    """To the last bit; arrays that are made for the caller alone may be written into."""
    assert pickle.dumps(found) == pickle.dumps(wanted)


def in_threads(name: str, method: str, calls: int, together: Together) -> None:
    call = METHODS[method]
    assert call is not None
    states = [(at, p) for at, p in zip(postures(name), tools(name), strict=True)]
    states = [states[i % len(states)] for i in range(calls)]
    # both fresh: whatever is made on first use is made by the threads together
    alone, shared = ClosedChain(description(name)), ClosedChain(description(name))
    wanted = [call(alone, at, p) for at, p in states]
    for found, one in zip(together([partial(call, shared, at, p) for at, p in states]), wanted, strict=True):
        same(found, one)


OWN = [method for method, call in METHODS.items() if call is not None]


@pytest.mark.parametrize("method", OWN)
def test_eight_threads(method: str, together: Together) -> None:
    in_threads("fivebar", method, QUICK, together)


@pytest.mark.slow
@pytest.mark.parametrize("method", OWN)
@pytest.mark.parametrize("name", ROBOTS)
def test_eight_threads_on_every_robot(name: str, method: str, together: Together) -> None:
    in_threads(name, method, ALL, together)


@pytest.mark.slow
def test_modes_searched_by_several_threads(together: Together) -> None:
    alone, shared = ClosedChain(description("fivebar")), ClosedChain(description("fivebar"))
    wanted = alone.working_modes()
    for found in together([shared.working_modes] * 8):
        same(found, wanted)


def copies(value: Any) -> Iterator[Any]:
    yield pickle.loads(pickle.dumps(value))
    yield copy.deepcopy(value)


@pytest.mark.parametrize("name", ROBOTS)
def test_copies_say_the_same(name: str) -> None:
    """Chains give the same numbers; what they hand out is the same, and read-only."""
    chain, at, p = ClosedChain(description(name)), postures(name)[3], tools(name)[3]
    for other in copies(chain):
        for method in OWN:
            call = METHODS[method]
            assert call is not None
            same(call(other, at, p), call(chain, at, p))
    v_full = full_v(chain, at)
    values = [
        at,
        chain.full_forward_dynamics(at, v_full, effort(chain)),
        chain.full_inverse_dynamics(at, v_full, allowed(chain, at)),
        chain.terms(at, v(chain)),
        chain.tool(at, v(chain)),
    ]
    for value in values:
        for other in copies(value):
            alike(other, value)
    report = chain.mobility(at)
    for other in copies(report):
        assert repr(other) == repr(report)


def effort_at(chain: ClosedChain, at: Any) -> np.ndarray:
    """Runs in a worker process."""
    return np.array(chain.inverse_dynamics(at, v(chain), v(chain)))


def too_far(chain: ClosedChain) -> Any:
    return chain.reach([5.0, 0.0, 0.0])


def too_wide(chain: ClosedChain) -> Any:
    return chain.close(chain.home.q + np.array([1.5, -1.5]))


@pytest.mark.slow
def test_a_pool_of_processes() -> None:
    """Chains and postures go there, numbers and errors come back; the pool outlives the errors."""
    chain = ClosedChain(description("fivebar"))
    here = [effort_at(chain, at) for at in postures("fivebar")[:4]]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(UnreachableError) as caught:
            pool.submit(too_far, chain).result(120.0)
        np.testing.assert_array_equal(caught.value.target, [5.0, 0.0, 0.0])
        assert caught.value.reached is not None
        with pytest.raises(ClosureError) as open_loop:
            pool.submit(too_wide, chain).result(120.0)
        assert open_loop.value.cut == "tip"
        there = [pool.submit(effort_at, chain, at).result(120.0) for at in postures("fivebar")[:4]]
    for one, other in zip(here, there, strict=True):
        assert one.tobytes() == other.tobytes()
