"""Every error survives pickling, copying and a worker process, with its type, its words and its numbers."""

from __future__ import annotations

import copy
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import numpy.typing as npt
import pytest

import cutjoint
from cutjoint.errors import CutjointError, InputError, LimbReachError, Problem, SimulationError, UnreachableError
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import Result
from cutjoint.simulation.result import ARRAYS

ARRAY = npt.NDArray[np.float64]


def result() -> Result:
    widths = {"tool": 3, "tool_velocity": 3, "desired_tool": 3, "desired_tool_velocity": 3, "gap": 2}
    flat = ("time", "kinetic", "potential", "work")
    arrays = {name: np.arange(4.0) if name in flat else np.ones((4, widths.get(name, 2))) for name in ARRAYS}
    return Result(**arrays, about={"law": "PD", "gains": {"kp": [[1.0]]}})


# What an error's constructor may ask for, by the type that it states.
VALUES: dict[Any, Any] = {
    str: "some words",
    str | None: "yaw [deg]",
    int: 3,
    int | None: 137,
    float: 0.1,
    bool: True,
    object: result(),
    ARRAY: np.array([0.1, np.nan, -np.inf]),
    ARRAY | None: np.array([0.1, 0.2]),
    tuple[float, float]: (1e-3, 0.25),
    Sequence[str]: ["one", "two"],
    Sequence[Problem]: [Problem("this", "that", file="robot.urdf", line=7), Problem("more")],
    Mapping[str, tuple[float, float]]: {"mass matrix": (1e-3, 1e-10)},
}


def all_errors() -> list[type[CutjointError]]:
    for module in pkgutil.walk_packages(cutjoint.__path__, "cutjoint."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)

    def below(kind: type[CutjointError]) -> Iterator[type[CutjointError]]:
        yield kind
        for one in kind.__subclasses__():
            yield from below(one)

    found = dict.fromkeys(below(CutjointError))
    return [kind for kind in found if kind.__module__.startswith("cutjoint.")]


ERRORS = all_errors()


def made(kind: type[CutjointError]) -> CutjointError:
    """An error of a class with a value of the stated type for every parameter of its constructor."""
    if not inspect.isfunction(kind.__init__):
        return kind("some words", 7)
    hints = get_type_hints(kind.__init__)
    given: dict[str, Any] = {}
    for name, one in inspect.signature(kind.__init__).parameters.items():
        if name != "self":
            assert hints[name] in VALUES, f"say what {kind.__name__} may be given as {name}: {hints[name]}"
            given[name] = VALUES[hints[name]]
            assert one.kind is not one.VAR_KEYWORD
    positional = [
        given.pop(name)
        for name, one in inspect.signature(kind.__init__).parameters.items()
        if one.kind is one.POSITIONAL_OR_KEYWORD and name in given
    ]
    return kind(*positional, **given)


def same(found: BaseException, wanted: CutjointError, alike: Callable[[Any, Any], None]) -> None:
    assert type(found) is type(wanted)
    assert str(found) == str(wanted)
    assert repr(found) == repr(wanted)
    alike(found.args, wanted.args)
    alike(vars(found), vars(wanted))


def test_there_are_errors_of_every_room() -> None:
    assert len(ERRORS) >= 17
    assert {kind.__module__ for kind in ERRORS} >= {"cutjoint.errors", "cutjoint.simulation.integrators.method"}


@pytest.mark.parametrize("kind", ERRORS, ids=lambda kind: kind.__name__)
def test_errors_pickle_and_copy_whole(kind: type[CutjointError], alike: Callable[[Any, Any], None]) -> None:
    error = made(kind)
    error.add_note("seen on a Tuesday")
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        same(pickle.loads(pickle.dumps(error, protocol)), error, alike)
    same(copy.deepcopy(error), error, alike)
    same(copy.copy(error), error, alike)


def test_a_class_of_ones_own_is_carried_too(alike: Callable[[Any, Any], None]) -> None:
    for kind in (Own, OwnKey):
        error = kind(joint="elbow", poses=np.eye(2))
        error.poses.setflags(write=False)
        same(copy.deepcopy(error), error, alike)


class Own(LimbReachError):
    def __init__(self, *, joint: str, poses: np.ndarray) -> None:
        self.joint, self.poses = joint, poses
        super().__init__(joint, limb=1, reach=2.0, bounds=(0.0, 1.0), target=poses[0])


class OwnKey(InputError, KeyError):
    def __init__(self, *, joint: str, poses: np.ndarray) -> None:
        self.joint, self.poses = joint, poses
        super().__init__(joint)


def test_arrays_of_errors_are_not_those_of_the_caller() -> None:
    target = np.zeros(3)
    for error in (
        UnreachableError("far", target=target, reached=target),
        SimulationError("late", t=0.0, q=target, v=target, result=None),
    ):
        arrays = [one for one in vars(error).values() if isinstance(one, np.ndarray)]
        assert len(arrays) == 2
        assert not any(one.flags.writeable or np.shares_memory(one, target) for one in arrays)
    assert target.flags.writeable


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_workers_hand_over_every_error(
    start: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, alike: Callable[[Any, Any], None]
) -> None:
    """A pool whose worker raises what cannot be unpickled waits for ever; the limit makes a failure of that."""
    if start not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {start} on this system")
    (tmp_path / "worker_that_raises.py").write_text("def work(error):\n    raise error\n")
    monkeypatch.syspath_prepend(tmp_path)
    work = importlib.import_module("worker_that_raises").work
    with multiprocessing.get_context(start).Pool(1) as pool:
        waiting = [(error, pool.apply_async(work, (error,))) for error in map(made, ERRORS)]
        waiting.append((_unreachable(), pool.apply_async(CpmModel().reach, ([9.0, 9.0, 9.0],))))
        for error, answer in waiting:
            with pytest.raises(type(error)) as caught:
                answer.get(timeout=60.0)
            same(caught.value, error, alike)


def _unreachable() -> LimbReachError:
    with pytest.raises(LimbReachError) as caught:
        CpmModel().reach([9.0, 9.0, 9.0])
    return caught.value
