"""Laws that branch: what NumPy gives on numbers, a traced law gives, at kinks too; what cannot be traced says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import simulate_many
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.program import interpret
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.machine.llvm.native import NativeKernel
from cutjoint.compile.sources.traced_array import numbers, traced
from cutjoint.errors import InputError
from cutjoint.motion import Circle, Hold, Reference
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.simulation import ReducedPlant, RungeKutta4, run

KINKS = np.array([-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0])
TABLE = np.array([-1.5, -1.0, 0.0, 0.5, 2.0])
VALUES = np.array([3.0, -1.0, 0.25, 0.25, 7.0])

Piece = Callable[[Any, Any], Any]
PIECES: dict[str, Piece] = {
    "sign": lambda q, v: np.sign(q),
    "where": lambda q, v: np.where(q < v, q, -2.0 * v),
    "where with several": lambda q, v: np.where((q <= 0.5) & ~(v > 1.0) | (q == v), q - 1.0, 2.0),
    "where of one entry": lambda q, v: np.where(q[0] >= v[-1], v, q),
    "clip": lambda q, v: np.clip(q, -1.0, 0.5),
    "clip, called on it": lambda q, v: q.clip(-1.0, 1.0) + v.round(),
    "extremes": lambda q, v: np.minimum(q, 0.5) + np.maximum(v, q),
    "largest of all": lambda q, v: q * v.max() - q.min(),
    "sizes": lambda q, v: np.abs(q) + abs(v),
    "steps": lambda q, v: np.floor(q) + np.ceil(v) + np.rint(q) + np.round(v),
    "table": lambda q, v: np.interp(q, TABLE, VALUES),
    "table with ends": lambda q, v: np.interp(v, TABLE, VALUES, left=-9.0, right=9.0),
    "entry by entry": lambda q, v: np.array([np.where(x < 0.5, x, y) for x, y in zip(q, v, strict=True)]),
    "select": lambda q, v: np.select([q < -0.5, q < 0.5], [v, q], 3.0),
    "heaviside": lambda q, v: np.heaviside(q, 0.5) * v,
    "any and all": lambda q, v: np.where(np.any(q > 1.0) | np.all(v < 0.0), q, v),
    "dead zone": lambda q, v: np.sign(q) * np.maximum(np.abs(q) - 0.5, 0.0),
    "norm": lambda q, v: q / (1.0 + np.linalg.norm(v)) + np.sum(q) + q @ v,
    "powers": lambda q, v: q**2 - v**3 + np.hypot(q, 1.0) + np.square(v),
    "angles": lambda q, v: np.sin(q) + np.cos(v) + np.arctan2(q, 2.0 + v) + np.arctan(v),
    "picked with not": lambda q, v: np.where(np.logical_not(q < 0.0), v, -v),
    "stacked": lambda q, v: np.concatenate([q[:1], v[1:]]) * np.stack([q, v])[0],
}


def on_symbols(law: Piece, n: int = 3) -> tuple[Graph, Any, list[Any]]:
    graph = Graph()
    q, v = graph.symbols(n), graph.symbols(n)
    answer = numbers(law(traced(q), traced(v)))
    return graph, assemble(graph, "law", {"q": q, "v": v}, {"y": answer}), answer


@pytest.mark.parametrize("name", PIECES)
def test_a_traced_law_gives_what_it_gives_on_numbers(name: str) -> None:
    law, rng = PIECES[name], np.random.default_rng(len(name))
    _, program, _ = on_symbols(law)
    kernel = NativeKernel(program)
    for k in range(90):
        q, v = rng.choice(KINKS, 3) if k % 2 else rng.uniform(-2.5, 2.5, 3), rng.choice(KINKS, 3)
        if k % 3 == 0:  # one step of the numbers beside a kink
            q = np.nextafter(q, rng.choice([-9.0, 9.0], 3))
        wanted = np.asarray(law(q, v), dtype=np.float64)
        found = np.array(interpret(program, [*q, *v]), dtype=np.float64)
        np.testing.assert_allclose(found, wanted, rtol=1e-14, atol=1e-14, err_msg=f"{q} {v}")
        np.testing.assert_allclose(kernel(q, v), wanted, rtol=1e-14, atol=1e-14, err_msg=f"{q} {v}")


@pytest.mark.parametrize("seed", range(12))
def test_laws_made_of_random_pieces_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second, third = (
        PIECES[name] for name in rng.choice([name for name in PIECES if name != "entry by entry"], 3)
    )
    a, b = rng.normal(size=2)

    def law(q: Any, v: Any) -> Any:
        return np.where(first(q, v) < b, second(a * q, v), np.clip(third(q, v - b), -3.0, 5.0))

    _, program, _ = on_symbols(law)
    for _ in range(30):
        q, v = rng.uniform(-2.0, 2.0, (2, 3))
        found = np.array(interpret(program, [*q, *v]), dtype=np.float64)
        np.testing.assert_allclose(found, law(q, v), rtol=1e-11, atol=1e-11)


UNTRACED: dict[str, Piece] = {
    "if": lambda q, v: q if q[0] > 0.0 else v,
    "if of a sum": lambda q, v: q if q.sum() else v,
    "python's max": lambda q, v: np.array([max(x, 0.0) for x in q]),
    "equal in a plain list": lambda q, v: q if q.tolist()[0] == 0.0 else v,
    "while": lambda q, v: _counted(q),
    "float": lambda q, v: q * float(v[0]),
    "tanh": lambda q, v: np.tanh(q),
    "remainder": lambda q, v: q % 1.0,
    "argmax": lambda q, v: q * np.argmax(v),
    "sort": lambda q, v: np.sort(q),
    "mask": lambda q, v: q[q > 0.0],
    "table that is not given": lambda q, v: np.interp(0.5, [0.0, 1.0], v[:2]),
    "search": lambda q, v: np.searchsorted(TABLE, q[0]) * v,
    "plain array, compared": lambda q, v: np.where(np.array([q[0], v[0]]) < 0.0, 1.0, 2.0),
    "not in": lambda q, v: q if q[0] in [1.0, 2.0] else v,
}


def _counted(q: Any) -> Any:
    while q[0] < 1.0:
        q = q + 1.0
    return q


@pytest.mark.parametrize("name", UNTRACED)
def test_what_cannot_be_traced_is_refused_and_never_guessed(name: str) -> None:
    with pytest.raises((InputError, TypeError, ValueError, IndexError)):
        on_symbols(UNTRACED[name])


def relay(t: float, desired: Any, q: Any, v: Any) -> Any:
    """A stiff loop with dry friction made up for, a dead zone, a table of gains over time, and limits of its own."""
    error = desired.q - q
    stiff = np.interp(t, [0.0, 0.02, 0.05], [4000.0, 9000.0, 7000.0])
    push = np.where(np.abs(error) > 1e-5, stiff * error, 0.0) + 300.0 * (desired.v - v)
    return np.clip(push + 2.0 * np.sign(desired.v), -400.0, np.where(t < 0.03, 400.0, 250.0))


@pytest.mark.parametrize("name", ["cpm", "paper cpm"])
def test_many_runs_of_a_law_that_branches_are_single_runs_of_it(kit: Any, name: str) -> None:
    robot = kit.machine(name)
    reference = Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), kit.model("paper cpm"), 0.05)
    start = reference.at(0.0).q + np.array([[0.0, 0.0, 0.0], [1e-3, -1e-3, 2e-3]])
    many = simulate_many(robot, relay, reference, rate=1000.0, start=start, every=1e-3)
    for k, q in enumerate(start):
        single = run(
            ReducedPlant(kit.model(name)), relay, reference, integrator=RungeKutta4(1e-3), rate=1000.0, every=1e-3,
            start=kit.model(name).close(q),
        )  # fmt: skip
        np.testing.assert_allclose(many.q[k], single.q, rtol=0, atol=1e-12)
        np.testing.assert_allclose(many.effort[k], single.effort, rtol=0, atol=1e-8)


def test_a_law_that_cannot_be_traced_says_so_and_runs_between_steps(kit: Any) -> None:
    def bang(t: float, desired: Any, q: Any, v: Any) -> Any:
        return np.array([1.0 if x > 0.0 else -1.0 for x in desired.q - q])

    robot = kit.machine("fivebar")
    reference = Reference(Hold.at_home(kit.model("fivebar"), 0.02), kit.model("fivebar"))
    with pytest.raises(InputError, match=r"controller 'bang' cannot be compiled: .*no value"):
        simulate_many(robot, bang, reference, rate=1000.0)
    compiled_one = run(robot, bang, reference, rate=1000.0, every=1e-3)
    plain = run(ReducedPlant(kit.model("fivebar")), bang, reference, rate=1000.0, every=1e-3)
    assert "not_compiled" not in compiled_one.about
    np.testing.assert_allclose(compiled_one.q, plain.q, rtol=0, atol=1e-11)


class _Spring:
    """Called like a function, with a model inside; it sums errors up by itself if it is told to."""

    def __init__(self, model: Any, ki: float) -> None:
        self.model, self.ki, self.sum, self.last = model, ki, 0.0, 0.0

    def __call__(self, t: float, desired: Any, q: Any, v: Any) -> Any:
        error = desired.q - q
        if self.ki:
            self.sum, self.last = self.sum + error * (t - self.last), t
        at = self.model.close(q, desired.posture, limits="ignore")
        return self.model.inverse_dynamics(at, v, desired.a + 900.0 * error - 60.0 * v) + self.ki * self.sum


def test_a_called_object_with_a_model_is_traced_but_not_one_that_keeps_something(kit: Any) -> None:
    robot, model = kit.machine("fivebar"), kit.model("fivebar")
    reference = Reference(Hold.at_home(model, 0.02), model)
    many = simulate_many(robot, _Spring(model, 0.0), reference, rate=1000.0, every=1e-3)
    single = run(
        ReducedPlant(model), _Spring(model, 0.0), reference, integrator=RungeKutta4(1e-3), rate=1000.0, every=1e-3
    )
    np.testing.assert_allclose(many.q[0], single.q, rtol=0, atol=1e-11)

    count = 0

    def decimated(t: float, desired: Any, q: Any, v: Any) -> Any:
        nonlocal count
        count += 1
        return np.zeros(2) if count % 10 else desired.q - q

    noise = np.random.default_rng(1)
    for law in (_Spring(model, 5.0), decimated, lambda t, desired, q, v: desired.q - q + noise.normal(size=2)):
        with pytest.raises(InputError, match="keeps something from call to call"):
            simulate_many(robot, law, reference, rate=1000.0)
    with pytest.raises(InputError, match="it must return efforts, one an actuator"):
        simulate_many(robot, lambda t, desired, q, v: ["1", "2"], reference, rate=1000.0)
