"""One compiled robot in many threads gives what it gives in one, to the bit; and it can be pickled and copied."""

from __future__ import annotations

import copy
import pickle
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import ClosedLoop, Made, compiled
from cutjoint.compile.machine.llvm.native import NativeKernel
from cutjoint.compile.once import once
from cutjoint.control import PD

THREADS, CALLS = 8, 480
NOTHING = np.zeros(0)


@pytest.fixture
def restless() -> Iterator[None]:
    """Threads that take turns ten thousand times a second."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield
    sys.setswitchinterval(before)


def numbers_in(value: Any) -> list[np.ndarray]:
    """All arrays of a result."""
    if isinstance(value, np.ndarray):
        return [value]
    if isinstance(value, float):
        return [np.array(value)]
    if isinstance(value, (tuple, list)):
        return [x for one in value for x in numbers_in(one)]
    return [
        x
        for name in vars(value)
        if name not in ("failed", "slow", "gap", "layout")
        for x in numbers_in(getattr(value, name))
    ]


def all_at_once(jobs: list[Callable[[], Any]]) -> list[Any]:
    """Results of jobs that eight threads start together."""
    ready = threading.Barrier(THREADS)

    def work(first: int) -> list[Any]:
        ready.wait()
        return [jobs[k]() for k in range(first, len(jobs), THREADS)]

    with ThreadPoolExecutor(THREADS) as pool:
        shares = list(pool.map(work, range(THREADS)))
    return [shares[k % THREADS][k // THREADS] for k in range(len(jobs))]


def jobs_of(machine: Any, count: int) -> list[Callable[[], Any]]:
    """Calls of every method, at states of their own, that the compiled code answers itself."""
    rng, home = np.random.default_rng(0), machine.home
    jobs: list[Callable[[], Any]] = []
    for k in range(count):
        q = home.q + 0.01 * rng.uniform(-1, 1, machine.n)
        at = machine.close(q)
        v, x = rng.normal(size=machine.n), rng.normal(size=machine.n)
        rows = np.tile(machine.positions(at), (5, 1))
        jobs.append(
            [
                lambda at=at, v=v, x=x: machine.inverse_dynamics(at, v, x),
                lambda at=at, v=v, x=x: machine.forward_dynamics(at, v, x),
                lambda at=at, v=v: machine.terms(at, v),
                lambda at=at, v=v: machine.tool(at, v),
                lambda at=at: machine.potential_energy(at),
                lambda at=at, v=v, x=x: machine.inverse_derivatives(at, v, x),
                lambda q=q: machine.close(q),
                lambda rows=rows, v=v, x=x: machine.batch.forward_dynamics(rows, v, x),
            ][k % 8]
        )
    # every thread does all of them
    return [jobs[k] for k in rng.permutation(count)]


@pytest.mark.parametrize("name", ["fivebar", "paper omega3"])
def test_threads_share_a_compiled_robot(kit: Any, restless: None, name: str) -> None:
    machine = compiled(kit.model(name))
    jobs = jobs_of(machine, CALLS)
    wanted = [numbers_in(job()) for job in jobs]
    found = [numbers_in(one) for one in all_at_once(jobs)]
    for one, other in zip(found, wanted, strict=True):
        assert len(one) == len(other) > 0
        for x, y in zip(one, other, strict=True):
            np.testing.assert_array_equal(x, y)


def test_a_function_that_many_ask_for_at_once_is_made_once(kit: Any, restless: None) -> None:
    made: list[Made] = []
    machine = compiled(kit.model("fivebar"), cached=False, report=made.append)
    whats = ("inverse", "forward", "step") * THREADS
    kernels = all_at_once([lambda what=what: machine.kernel(what) for what in whats])
    assert sorted(one.what for one in made) == ["forward", "inverse", "step"]
    assert len({id(kernel) for kernel in kernels}) == 3


def test_a_branch_that_many_ask_for_at_once_is_made_once(kit: Any, restless: None) -> None:
    made: list[Made] = []
    machine = compiled(kit.model("paper cpm"), cached=False, report=made.append)
    other = compiled(type(machine.paper)(machine.paper.parameters, (1, -1, 1)), cached=False).home
    found = all_at_once([lambda: machine.inverse_dynamics(other, np.ones(3), np.ones(3))] * 24)
    assert [one.what for one in made] == ["inverse"]
    assert all(np.array_equal(one, found[0]) for one in found)


def test_vector_code_and_lazy_values_are_made_once(kit: Any, restless: None, monkeypatch: pytest.MonkeyPatch) -> None:
    from cutjoint.compile.machine.llvm import native

    kernel = NativeKernel(kit.machine("fivebar").kernel("forward").program)
    machines: list[Any] = []
    own = native.Machine

    def counted(*what: Any, **options: Any) -> Any:
        machines.append(what)
        return own(*what, **options)

    monkeypatch.setattr(native, "Machine", counted)
    home = kit.machine("fivebar").home.q_full
    rows = [np.tile(home, (32, 1)), np.ones((32, 2)), np.ones(2), NOTHING]
    found = all_at_once([lambda: kernel.batch(rows)] * 16)
    assert len(machines) == 1
    assert all(np.array_equal(one[0], found[0][0]) for one in found)

    asked: list[int] = []

    class Slow:
        def __init__(self) -> None:
            self._lock = threading.RLock()

        @once
        def value(self) -> object:
            """Something that takes a while."""
            asked.append(1)
            return sum(range(200_000)), object()

    slow = Slow()
    assert len({id(one) for one in all_at_once([lambda: slow.value] * 32)}) == 1
    assert len(asked) == 1
    assert Slow.value.__doc__ == "Something that takes a while."


def test_runs_in_threads_are_the_runs(kit: Any, restless: None) -> None:
    machine = kit.machine("fivebar")
    loop = ClosedLoop(machine, PD(2.0, 0.1), machine, gains=("kp",))
    table = np.zeros((2 * 20 + 1, loop.sizes.columns))
    table[:, 1:3] = machine.home.q

    def job(k: int) -> Callable[[], Any]:
        return lambda: loop.run(table, gains={"kp": np.linspace(1.0, 2.0 + k, 9)}, every=5e-3, threads=1)

    jobs = [job(k) for k in range(24)]
    found = all_at_once(jobs)
    for one, again in zip(found, [job() for job in jobs], strict=True):
        assert not one.failed
        for x, y in zip(numbers_in(one), numbers_in(again), strict=True):
            np.testing.assert_array_equal(x, y)


def copies(value: Any) -> list[Any]:
    return [pickle.loads(pickle.dumps(value)), copy.deepcopy(value), copy.copy(value)]


@pytest.mark.parametrize("name", ["paper cpm", "fivebar"])
def test_a_compiled_robot_can_be_pickled_and_copied(kit: Any, name: str) -> None:
    made: list[Made] = []
    machine = compiled(kit.model(name), parameters=["payload"], report=made.append).with_parameters(payload=0.25)
    v, x = np.full(machine.n, 0.3), np.full(machine.n, -0.7)
    wanted = machine.inverse_dynamics(machine.home, v, x)
    reported = len(made)
    try:
        pickle.dumps(machine.model)
    except RuntimeError as error:
        pytest.skip(f"the model itself cannot be pickled: {error}")
    for one in copies(machine):
        assert type(one) is type(machine)
        assert one.parameters == {"payload": 0.25}
        np.testing.assert_array_equal(one.inverse_dynamics(one.home, v, x), wanted)
        assert not one._values.flags.writeable
    assert len(made) == reported
    batch = pickle.loads(pickle.dumps(machine.batch))
    rows = np.tile(machine.positions(machine.home), (3, 1))
    np.testing.assert_array_equal(batch.inverse_dynamics(rows, v, x), machine.batch.inverse_dynamics(rows, v, x))


def test_what_a_compiled_robot_gives_can_be_pickled_and_stays_read_only(kit: Any) -> None:
    machine = kit.machine("paper cpm")
    loop = ClosedLoop(machine, PD(2.0, 0.1), machine)
    table = np.zeros((2 * 20 + 1, loop.sizes.columns))
    table[:, 1:4] = machine.home.q
    many = loop.run(table, every=5e-3)
    for value in (machine.inverse_derivatives(machine.home, np.ones(3), np.ones(3)), many):
        for one in copies(value):
            assert type(one) is type(value)
            for x, y in zip(numbers_in(one), numbers_in(value), strict=True):
                np.testing.assert_array_equal(x, y)
                assert not x.flags.writeable
    for one in copies(loop):
        np.testing.assert_array_equal(one.run(table, every=5e-3).q, many.q)


def test_kernels_and_programs_travel_as_instructions(kit: Any) -> None:
    machine = kit.machine("paper cpm")
    kernel, home = machine.kernel("inverse"), machine.home.q
    for one in copies(kernel):
        assert one.address != kernel.address
        np.testing.assert_array_equal(one(home, home, home, NOTHING), kernel(home, home, home, NOTHING))
        assert not one.program.values.flags.writeable
        assert not one.program.op.flags.writeable
    library = machine.library()
    for one in copies(library):
        again = one["inverse"].kernel
        np.testing.assert_array_equal(again(home, home, home, NOTHING), kernel(home, home, home, NOTHING))
