"""Values, laws, trajectories, plants and models survive pickling and copying: the same bits, read-only, and usable."""

from __future__ import annotations

import copy
import importlib
import pickle
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import FrozenInstanceError, fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

import cutjoint
from cutjoint.arrays import Values, readonly
from cutjoint.compile import compiled
from cutjoint.control import LAWS, law
from cutjoint.crosscheck import compare, effort_along, hypothesis_cost, sample_states, workspace_box
from cutjoint.description import load_description
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Circle, Hold, Lissajous, PointToPoint, Reference
from cutjoint.papers.cpm import CpmModel, CpmRotaryModel
from cutjoint.papers.cpm.model import InferredCpmModel
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, ReducedPlant, RungeKutta4, run

ROOMS = ("mechanism", "motion", "control", "crosscheck", "simulation", "description", "engines")
MODELS: dict[str, Callable[[], Mechanism]] = {
    "cpm": CpmModel,
    "cpm, loaded, other branch": lambda: CpmModel(signs=(1, 1, -1)).with_payload(0.3),
    "cpm, inferred": InferredCpmModel,
    "cpm_rotary": CpmRotaryModel,
    "omega3": Omega3Model,
    "omega3, elbows in": lambda: Omega3Model(signs=(1, 1, 1)),
}
TRAJECTORIES = {
    "hold": lambda: Hold([0.6, 0.425, 0.3]),
    "point to point": lambda: PointToPoint([0.6, 0.425, 0.3], [0.4, 0.4, 0.35], 0.5),
    "circle": lambda: Circle([0.425, 0.425, 0.3], 0.175, 0.5 * np.pi),
    "lissajous": lambda: Lissajous([0.5, 0.4, 0.3], [0.1, 0.05, 0.02], [1.0, 2.0, 3.0], [0.0, 0.1, 0.2], 2.0),
}
INTEGRATORS = [Adaptive(), Adaptive(1e-6, 1e-9, "RK45"), DormandPrince(1e-6, 1e-7), RungeKutta4(2e-3)]
V, A, TAU = readonly([0.3, -0.2, 0.1]), readonly([1.0, -2.0, 0.5]), readonly([4.0, 5.0, -6.0])


def copies(value: Any) -> Iterator[Any]:
    """`value` through every way of copying."""
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        yield pickle.loads(pickle.dumps(value, protocol))
    yield copy.deepcopy(value)
    yield copy.copy(value)


@cache
def reference() -> Reference:
    return Reference(TRAJECTORIES["circle"](), CpmModel(), 0.05)


def gains(name: str) -> dict[str, Any]:
    values = {"kp": 8000.0, "ki": [10.0, 20.0, 30.0], "kd": np.diag([400.0, 410.0, 420.0])}
    return {one: values[one] for one in LAWS[name].gains}


def numbers(model: Mechanism) -> list[Any]:
    """What a model says, method by method, away from home."""
    at = model.close(model.home.q + 0.01)
    tool = model.tool(at, V)
    return [
        model.home,
        at,
        tool,
        model.reach(tool.position + 1e-3, at),
        model.terms(at, V),
        model.potential_energy(at),
        model.inverse_dynamics(at, V, A),
        model.forward_dynamics(at, V, TAU),
        model.actuators,
        model.name,
        model.with_payload(0.1).terms(at, V),
    ]


def _values() -> dict[str, Callable[[], Any]]:
    """Name -> a value of every kind that holds arrays or mappings."""
    model = CpmModel()
    omega = Omega3Model()
    made: dict[str, Callable[[], Any]] = {
        "posture": lambda: omega.home,
        "terms": lambda: omega.terms(omega.home, V),
        "tool": lambda: omega.tool(omega.home, V),
        "tool motion": lambda: TRAJECTORIES["circle"]().at(0.3),
        "desired": lambda: reference().at(0.01),
        "state of a plant": lambda: ReducedPlant(model).start(model.home, V),
        "observation": lambda: ReducedPlant(model).observe(ReducedPlant(model).start(model.home, V)),
        "result": lambda: run(ReducedPlant(model), law("pd", model, gains("pd")), reference(), duration=0.01),
        "workspace": lambda: workspace_box(model),
        "state": lambda: next(iter(sample_states(model, 1, 0))),
        "comparison": lambda: compare(model, CpmModel(), sample_states(model, 2, 0)),
        "cost": lambda: hypothesis_cost(InferredCpmModel(), model, [(readonly([0.5, 0.4, 0.3]), V, A)]),
    }
    made |= {f"parameters of the {name}": lambda m=one: m().parameters for name, one in MODELS.items()}
    made |= {f"robot {name}": lambda n=name: load_description(n) for name in ("cpm", "omega3", "stewart", "fourbar")}
    return made | TRAJECTORIES


VALUES = _values()


@pytest.mark.parametrize("name", VALUES)
def test_values_stay_the_same_and_read_only(name: str, alike: Callable[[Any, Any], None]) -> None:
    value = VALUES[name]()
    for found in copies(value):
        alike(found, value)
        with pytest.raises(FrozenInstanceError):
            setattr(found, fields(found)[0].name, None)


def test_arrays_inside_a_value_cannot_be_written_into_after_any_way_of_copying() -> None:
    """Spelled out once, without the recursion of the other tests."""
    model, description = Omega3Model(), load_description("cpm")
    for at in copies(model.home):
        with pytest.raises(ValueError, match="read-only"):
            at.q[0] = 1.0
    for robot in copies(description):
        for array in (robot.gravity, robot.joints[0].placement, robot.joints[0].axis, robot.cuts[0].a.placement):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0
        with pytest.raises(TypeError):
            robot.homes[0].actuated["limb1_slide"] = 0.0
        with pytest.raises(TypeError):
            robot.places["tool"] = None
        with pytest.raises(TypeError):
            del robot.variants[0].inertials["base"]


def test_copying_does_not_touch_the_arrays_of_the_original() -> None:
    """A state of a plant keeps the caller's arrays, which stay the caller's."""
    q, v = np.zeros(3), np.ones(3)
    state = cutjoint.simulation.State(q, v)
    for found in copies(state):
        assert not found.q.flags.writeable
    assert state.q is q
    assert q.flags.writeable


def test_every_frozen_dataclass_with_arrays_or_mappings_is_a_value() -> None:
    """So that a new one cannot be forgotten.  The readers' own notes on a file are no values that anybody keeps."""
    found, forgotten = set(), []
    for module in pkgutil.walk_packages(cutjoint.__path__, "cutjoint."):
        if module.name.split(".")[1] not in ROOMS or ".formats" in module.name:
            continue
        for one in vars(importlib.import_module(module.name)).values():
            if not (isinstance(one, type) and is_dataclass(one) and one.__module__ == module.name):
                continue
            if any(str(field.type).startswith(("Array", "Mapping")) for field in fields(one)):
                found.add(one.__name__)
                if not issubclass(one, Values):
                    forgotten.append(one.__qualname__)
    assert not forgotten
    assert found >= {"Posture", "Terms", "Tool", "Result", "Desired", "Circle", "RobotDescription", "Home", "Opinion"}


@pytest.mark.parametrize("name", MODELS)
def test_models_give_the_same_bits_after_copying(name: str, alike: Callable[[Any, Any], None]) -> None:
    fresh, used = MODELS[name](), MODELS[name]()
    wanted = numbers(used)
    for model in (fresh, used):
        for found in copies(model):
            alike(numbers(found), wanted)
            assert repr(found) == repr(model)


@pytest.mark.parametrize("name", MODELS)
def test_a_posture_of_one_copy_is_good_for_the_other(name: str, alike: Callable[[Any, Any], None]) -> None:
    model = MODELS[name]()
    at = model.close(model.home.q + 0.01)
    for other, there in copies((model, at)):
        alike(other.terms(at, V), model.terms(at, V))
        alike(model.terms(there, V), model.terms(at, V))
        alike(other.close(at.q + 0.01, there), model.close(at.q + 0.01, at))


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_trajectories_and_references_give_the_same_bits(name: str, alike: Callable[[Any, Any], None]) -> None:
    trajectory, times = TRAJECTORIES[name](), (0.0, 0.123, 0.4)
    through = Reference(trajectory, CpmModel(), 0.4)
    wanted = [through.at(t) for t in times]
    for found, seen in copies((trajectory, through)):
        assert (found.name, found.duration) == (trajectory.name, trajectory.duration)
        for t, desired in zip(times, wanted, strict=True):
            alike(found.at(t), trajectory.at(t))
            again = seen.at(t)
            for part in ("t", "q", "v", "a", "tool", "posture"):
                alike(getattr(again, part), getattr(desired, part))
            assert again.mechanism is seen.mechanism


def test_a_reference_does_not_carry_its_memo_along() -> None:
    through = Reference(TRAJECTORIES["circle"](), CpmModel())
    small = len(pickle.dumps(through))
    for t in np.linspace(0.0, 1.0, 100):
        through.at(float(t))
    assert len(pickle.dumps(through)) == small


@pytest.mark.parametrize("name", LAWS)
def test_laws_give_the_same_bits(name: str, alike: Callable[[Any, Any], None]) -> None:
    through = reference()
    model, desired = through.mechanism, through.at(0.02)
    for inside in (model, CpmModel().with_payload(0.2)):
        made = law(name, inside, gains(name))
        memory = np.full(made.memory(3), 0.1)
        q, v = desired.q + 0.01, desired.v - 0.1
        for found, there in copies((made, desired)):
            assert (found.name, found.gains) == (made.name, made.gains)
            assert found.memory(3) == memory.size
            effort = made.effort(desired, q, v, memory)
            again = found.effort(there, q, v, memory)
            assert again.tobytes() == effort.tobytes()
            clipped = np.clip(effort, -1.0, 1.0)
            rate = found.memory_rate(there, q, v, again, clipped)
            assert rate.tobytes() == made.memory_rate(desired, q, v, effort, clipped).tobytes()
            for gain in (one for one in vars(found).values() if hasattr(one, "listed")):
                assert not gain.value.flags.writeable


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda one: one.name)
def test_a_whole_simulation_gives_the_same_bits(integrator: Any, alike: Callable[[Any, Any], None]) -> None:
    model = CpmModel()
    parts = (ReducedPlant(model), law("computed-torque", model, {"kp": 2550.25, "kd": 101.0}), reference(), integrator)
    wanted = run(*parts[:3], integrator=integrator, duration=0.004, limits=60.0)
    for way in (pickle.loads(pickle.dumps(parts)), copy.deepcopy(parts)):
        plant, made, through, method = way
        alike(run(plant, made, through, integrator=method, duration=0.004, limits=60.0), wanted)


def test_a_plant_in_full_coordinates_is_copied_with_its_settings() -> None:
    """The chain is left as it is here; how chains are copied is a matter of their own room."""
    chain = cutjoint.load("cpm", PUBLISHED["cpm"].variant)
    for project in (True, False):
        plant = ConstrainedPlant(chain, project=project)
        other = copy.deepcopy(plant, {id(chain): chain})
        assert (other.chain is chain, other.project, other.name) == (True, project, plant.name)
        state = plant.start(chain.home, V)
        assert other.observe(state).tool_velocity.tobytes() == plant.observe(state).tool_velocity.tobytes()


def test_efforts_along_a_path_are_not_views_of_anything() -> None:
    efforts, gravity = effort_along(CpmModel(), [(readonly([0.5, 0.4, 0.3]), V, A)])
    assert efforts.base is None
    assert gravity.base is None


def test_a_robot_s_public_attributes_are_given_once() -> None:
    """Compiled or not: what it is cannot be exchanged under those who hold it, nor by assignment to a copy."""
    chain = load("fourbar")
    for robot in (chain, compiled(chain), pickle.loads(pickle.dumps(chain)), copy.deepcopy(chain)):
        for name in ("n", "home", "name", "actuators"):
            with pytest.raises(AttributeError, match=name):
                setattr(robot, name, getattr(robot, name))
