"""One model, reference, law, plant or result used by eight threads at once gives the bits that one thread gets."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
import pytest

import cutjoint
from cutjoint.arrays import readonly
from cutjoint.control import LAWS, law
from cutjoint.mechanism import JointPhysics, Load, Mechanism, Posture
from cutjoint.motion import Circle, Desired, Reference
from cutjoint.motion import reference as reference_module
from cutjoint.papers.cpm import CpmModel, CpmRotaryModel
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.papers.scalars import NUMBERS
from cutjoint.simulation import ConstrainedPlant, ReducedPlant, State, run

CALLS = 480
Together = Callable[[Sequence[Callable[[], Any]]], list[Any]]
Alike = Callable[[Any, Any], None]
V, A, TAU = [0.3, -0.2, 0.1], [1.0, -2.0, 0.5], [0.4, 0.5, -0.6]

MODELS = (CpmModel, CpmRotaryModel, Omega3Model)
# Whatever is public: a method that is new is called by the threads without a word here.
NAMES = [
    (kind, name)
    for kind in MODELS
    for name, one in inspect.getmembers(kind)
    if not name.startswith("_") and (inspect.isroutine(one) or isinstance(one, (property, cached_property)))
]


def call(model: Any, name: str, p: np.ndarray, at: Posture) -> Any:
    """A method with arguments by their names, or a property."""
    given = {"at": at, "near": at, "q": at.q, "p": p, "target": p, "v": V, "a": A, "effort": TAU, "mass": 0.1}
    given |= {"parameters": model.parameters, "fn": NUMBERS}
    given |= {"loads": Load([1.0, -2.0, 3.0], [0.1, 0.0, 0.2]), "physics": JointPhysics(damping=0.1, friction=0.2)}
    found = getattr(model, name)
    if not callable(found):
        return found
    wanted = inspect.signature(found).parameters.values()
    if any(one.name == "branch" for one in wanted):
        given["branch"] = model.branch(at)
    return found(*(given[one.name] for one in wanted if one.kind is not one.KEYWORD_ONLY))


def postures(model: Mechanism, count: int = 30) -> list[Posture]:
    middle, random = model.tool(model.home).position, np.random.default_rng(5)
    return [model.reach(middle + random.uniform(0.0, 0.03, 3)) for _ in range(count)]


def test_methods_are_called() -> None:
    every = {"close", "reach", "tool", "terms", "potential_energy", "inverse_dynamics", "forward_dynamics", "home"}
    assert all({name for one, name in NAMES if one is kind} >= every for kind in MODELS)


@pytest.mark.parametrize(("kind", "name"), NAMES, ids=lambda one: getattr(one, "__name__", one))
def test_models(kind: type, name: str, together: Together, alike: Alike) -> None:
    states = [(kind().tool(at).position, at) for at in postures(kind())]
    states = [states[i % len(states)] for i in range(CALLS)]
    alone, shared = kind(), kind()  # both fresh: whatever is made on first use is made by the threads together
    wanted = [call(alone, name, p, at) for p, at in states]
    for found, one in zip(together([partial(call, shared, name, p, at) for p, at in states]), wanted, strict=True):
        alike(found, one)


def through() -> Reference:
    return Reference(Circle([0.425, 0.425, 0.3], 0.175, 0.5 * np.pi), CpmModel())


@pytest.mark.parametrize("memory", [0, 20, None])
def test_references(memory: int | None, together: Together, alike: Alike, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also while the memo is full, so that all threads put in and throw out."""
    if memory is not None:
        monkeypatch.setattr(reference_module, "MEMORY", memory)
    times = [0.01 * (7 * i % 60) for i in range(CALLS)]
    alone, shared = through(), through()
    wanted = [alone.at(t) for t in times]
    found = together([partial(shared.at, t) for t in times])
    for one, other in zip(found, wanted, strict=True):
        for part in ("t", "q", "v", "a", "tool", "posture"):
            alike(getattr(one, part), getattr(other, part))


@pytest.fixture(scope="module")
def desired() -> list[Desired]:
    reference = through()
    return [reference.at(0.01 * (i % 60)) for i in range(CALLS)]


@pytest.mark.parametrize("name", LAWS)
def test_laws(name: str, together: Together, desired: list[Desired]) -> None:
    gains = {one: 100.0 * (i + 1) for i, one in enumerate(LAWS[name].gains)}
    made = law(name, CpmModel(), gains)
    memory = np.full(made.memory(3), 0.1)
    calls = [partial(made.effort, one, one.q + 0.01, one.v + 0.1, memory) for one in desired]
    wanted = [call() for call in calls]
    assert [one.tobytes() for one in together(calls)] == [one.tobytes() for one in wanted]
    calls = [partial(made.memory_rate, one, one.q + 0.01, one.v, one.a, one.a) for one in desired]
    wanted = [call() for call in calls]
    assert [one.tobytes() for one in together(calls)] == [one.tobytes() for one in wanted]


@pytest.mark.parametrize("kind", MODELS)
def test_plants_in_actuated_coordinates(kind: type, together: Together, alike: Alike) -> None:
    model = kind()
    plant = ReducedPlant(model)
    states = [plant.start(at, readonly(V)) for at in postures(model)]

    def calls(state: State) -> list[Callable[[], Any]]:
        return [
            partial(plant.acceleration, state, readonly(TAU)),
            partial(plant.observe, state),
            partial(plant.moved, state, state.q + 1e-3, state.v),
            partial(plant.settled, state),
        ]

    every = [call for state in states for call in calls(state)] * 4
    assert len(every) == CALLS
    for found, one in zip(together(every), [call() for call in every], strict=True):
        if isinstance(one, State):
            assert found.q.tobytes() == one.q.tobytes()
            alike(found.posture, one.posture)
        else:
            alike(found, one)


def test_plants_in_full_coordinates_have_a_workspace_a_thread(
    together: Together, alike: Alike, monkeypatch: pytest.MonkeyPatch
) -> None:
    # nobody asks about the loops: what is left of a plant's observation is the plant's own work
    monkeypatch.setattr(cutjoint.ClosedChain, "gap", lambda chain, q_full: (0.0, 0.0))
    chain = cutjoint.load("fivebar")
    plant = ConstrainedPlant(chain)
    random = np.random.default_rng(2)
    states = [State(random.normal(size=chain.nq), random.normal(size=chain.nv)) for _ in range(CALLS)]
    calls = [partial(plant.observe, state) for state in states]
    wanted = [call() for call in calls]
    for found, one in zip(together(calls), wanted, strict=True):
        alike(found, one)


def test_whole_simulations_that_share_plant_law_and_reference(
    together: Together, alike: Alike, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reference_module, "MEMORY", 30)
    reference = through()
    model = reference.mechanism
    plant, made = ReducedPlant(model), law("computed-torque", model, {"kp": 2550.25, "kd": 101.0})
    runs = [partial(run, plant, made, reference, duration=0.002 + 0.0005 * i, limits=50.0) for i in range(8)]
    wanted = [one() for one in runs]
    for found, one in zip(together(runs), wanted, strict=True):
        alike(found, one)


def test_results(together: Together, alike: Alike) -> None:
    reference = through()
    plant = ReducedPlant(reference.mechanism)
    result = run(plant, law("pd", reference.mechanism, {"kp": 9000.0, "kd": 400.0}), reference, duration=0.005)
    ask: list[Callable[[], Any]] = [
        lambda: tuple(result.rmse()),
        lambda: tuple(result.rmse_over_time()),
        lambda: result.worst_error(0.001),
        lambda: result.worst_axis_error(),
        lambda: result.peak_effort(),
        lambda: result.energy,
        lambda: result.error,
        lambda: result.velocity_error,
        lambda: result.energy_drift(),
        lambda: result.loop_gap(),
    ]
    calls = ask * (CALLS // len(ask))
    for found, one in zip(together(calls), [call() for call in calls], strict=True):
        alike(found, one)
