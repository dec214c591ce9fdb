"""Laws of the expression graph: sharing, signs, and the same numbers as plain floats, whatever is written."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.derivative import tangent
from cutjoint.compile.expressions.functions import maximum, minimum
from cutjoint.compile.expressions.graph import Expression, Graph
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import interpret
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.machine.llvm import text
from cutjoint.compile.machine.llvm.native import NativeKernel
from cutjoint.compile.machine.llvm.sine_cosine import LARGEST
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.errors import InputError

TREES = st.recursive(
    st.one_of(st.integers(0, 3), st.floats(-2, 2).map(lambda x: round(x, 3))),
    lambda inner: st.one_of(
        st.tuples(st.sampled_from("+-*/<>"), inner, inner),
        st.tuples(st.sampled_from(["neg", "sin", "cos", "abs"]), inner),
    ),
    max_leaves=25,
)


def evaluate(tree: Any, x: list[Any]) -> Any:
    """A random formula on floats or expressions; integers are inputs; quotients and roots stay away from trouble."""
    match tree:
        case int():
            return x[tree]
        case float():
            return tree
        case ("neg", a):
            return -evaluate(a, x)
        case ("abs", a):
            return abs(evaluate(a, x))
        case ("sin", a):
            return functions.sin(evaluate(a, x))
        case ("cos", a):
            return functions.cos(evaluate(a, x))
    sign, a, b = tree[0], evaluate(tree[1], x), evaluate(tree[2], x)
    match sign:
        case "+":
            return a + b
        case "-":
            return a - b
        case "*":
            return a * b
        case "/":
            return a / (functions.sqrt(b * b + 1.5))
        case "<":
            return minimum(a, b) if any(isinstance(y, Expression) for y in (a, b)) else min(a, b)
    return maximum(a, b) if any(isinstance(y, Expression) for y in (a, b)) else max(a, b)


@given(TREES, st.lists(st.floats(-3, 3), min_size=4, max_size=4), st.booleans())
def test_a_traced_formula_gives_what_the_formula_gives(tree: Any, x: list[float], fused: bool) -> None:
    graph = Graph()
    symbols = graph.symbols(4)
    program = assemble(graph, "f", {"x": symbols}, {"y": [evaluate(tree, symbols)]}, fused=fused)
    program.validate()
    wanted = evaluate(tree, x)
    scale = max(1.0, abs(wanted)) * 1e3
    assert abs(float(interpret(program, x)[0]) - wanted) <= 1e-13 * scale
    assert abs(float(interpret(scheduled(program), x)[0]) - wanted) <= 1e-13 * scale


def test_signs_and_order_do_not_make_new_nodes() -> None:
    graph = Graph()
    a, b, c = graph.symbols(3)
    assert (a - b).ref == -(b - a).ref
    assert (a + b).ref == (b + a).ref
    assert (a * -b).ref == -(b * a).ref
    assert (-a - b).ref == -(a + b).ref
    assert ((a + b) - (b + a)).constant == 0.0
    assert (2.0 * (3.0 * c)).ref == (6.0 * c).ref
    assert (functions.sin(a - b) + functions.sin(b - a)).constant == 0.0
    assert (functions.cos(a - b) - functions.cos(b - a)).constant == 0.0


def test_trigonometry_of_inverse_functions_becomes_algebra() -> None:
    graph = Graph()
    u, w, k = graph.symbols(3)
    angle = functions.atan2(w, u) - functions.acos(k)
    program = assemble(graph, "f", {"x": [u, w, k]}, {"y": [functions.sin(angle), functions.cos(angle)]})
    assert not {"sin", "cos", "atan2", "acos"} & {Op(code).name.lower() for code in program.op.tolist()}
    sine, cosine = interpret(program, [0.4, -0.7, 0.3])
    wanted = math.atan2(-0.7, 0.4) - math.acos(0.3)
    np.testing.assert_allclose([sine, cosine], [math.sin(wanted), math.cos(wanted)], rtol=0, atol=1e-15)


def test_a_branch_on_a_value_is_refused() -> None:
    x = Graph().symbols(1)[0]
    with pytest.raises(InputError, match="branch"):
        bool(x)
    with pytest.raises(InputError, match="compare"):
        _ = x > 0.0


@given(TREES, st.lists(st.floats(-3, 3), min_size=4, max_size=4))
def test_tangents_are_the_limit_of_differences(tree: Any, x: list[float]) -> None:
    if any(sign in repr(tree) for sign in ("'<'", "'>'", "'abs'")):
        return
    graph = Graph()
    symbols = graph.symbols(4)
    direction = [0.3, -0.5, 0.7, 0.2]
    seed = {abs(symbol.ref): rate for symbol, rate in zip(symbols, direction, strict=True)}
    slope = tangent(graph, [evaluate(tree, symbols)], seed)
    program = assemble(graph, "df", {"x": symbols}, {"y": slope})
    h = 1e-5
    ahead = [a + h * b for a, b in zip(x, direction, strict=True)]
    behind = [a - h * b for a, b in zip(x, direction, strict=True)]
    wanted = (evaluate(tree, ahead) - evaluate(tree, behind)) / (2 * h)
    size = 1.0 + abs(evaluate(tree, x)) / h * 1e-10 + abs(wanted)
    assert abs(float(interpret(program, x)[0]) - wanted) <= 1e-4 * size


def test_every_rule_of_differentiation() -> None:
    graph = Graph()
    x = graph.symbols(2)
    made = {
        "acos": (functions.acos(x[0] * x[1]), lambda a, b: math.acos(a * b)),
        "atan2": (functions.atan2(x[0], x[1]), math.atan2),
        "sqrt": (functions.sqrt(x[0] + x[1] * x[1]), lambda a, b: math.sqrt(a + b * b)),
        "div": (x[0] / (x[1] + 3.0), lambda a, b: a / (b + 3.0)),
        "trig": (functions.sin(x[0]) * functions.cos(x[1]), lambda a, b: math.sin(a) * math.cos(b)),
    }
    at, h = (0.4, 0.7), 1e-6
    for name, (expression, function) in made.items():
        for k in range(2):
            slope = tangent(graph, [expression], {abs(x[k].ref): 1.0})
            found = float(interpret(assemble(graph, name, {"x": x}, {"y": slope}), at)[0])
            step = [h if i == k else 0.0 for i in range(2)]
            wanted = (function(at[0] + step[0], at[1] + step[1]) - function(at[0] - step[0], at[1] - step[1])) / (2 * h)
            assert found == pytest.approx(wanted, rel=1e-8), (name, k)


def kernel_of_everything() -> NativeKernel:
    """A kernel that uses every operation at least once."""
    graph = Graph()
    x = graph.symbols(6)
    fn = functions
    results = [
        fn.sin(x[0]),
        fn.cos(x[0]),
        fn.sin(x[0] + x[1]),
        fn.atan2(x[0], x[1]),
        fn.acos(x[2] / (abs(x[2]) + 1.0)),
        fn.sqrt(abs(x[3]) + 0.1) - x[4],
        minimum(x[0], x[1]) * maximum(x[2], x[3]),
        x[0] * x[1] + x[2],
        x[1] * x[2] - fn.sqrt(x[4] * x[4] + 2.0),
        x[5] - x[0] * x[3],
        x[4] / x[5] + x[3] / x[5],
        -x[0],
        3.25,
        fn.floor(3.0 * x[0]) + fn.nearest(-3.0 * x[1]),
        fn.pick(fn.at_most(x[0], x[1]), x[2], -x[3]),
        fn.where_less(x[1], x[0], x[3], x[4]),
    ]
    program = assemble(graph, "everything", {"a": x[:2], "b": x[2:]}, {"y": results})
    used = {Op(int(code)) for code in program.op}
    assert used == set(Op), set(Op) - used
    return NativeKernel(program)


def test_one_state_and_many_give_the_same_digits() -> None:
    kernel = kernel_of_everything()
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(37, 2)) * 3, rng.normal(size=(37, 4)) * 3
    (side_by_side,) = kernel.batch([a, b])
    (one_by_one,) = kernel.batch([a, b], lanes=False)
    called = np.array([kernel(x, y) for x, y in zip(a, b, strict=True)])
    np.testing.assert_array_equal(side_by_side, one_by_one)
    np.testing.assert_array_equal(side_by_side, called)
    wanted = np.array([interpret(kernel.program, [*x, *y]) for x, y in zip(a, b, strict=True)])
    np.testing.assert_allclose(called, wanted, rtol=1e-13, atol=1e-14)


def test_pieces_of_a_long_program_give_the_same_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = kernel_of_everything()
    monkeypatch.setattr(text, "WHOLE", 5)
    monkeypatch.setattr(text, "PIECE", 4)
    pieces = kernel_of_everything()
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(20, 2)), rng.normal(size=(20, 4))
    np.testing.assert_array_equal(whole.batch([a, b])[0], pieces.batch([a, b])[0])
    np.testing.assert_array_equal(whole(a[0], b[0]), pieces(a[0], b[0]))


def test_a_shared_argument_and_threads_change_nothing() -> None:
    kernel = kernel_of_everything()
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(5000, 2)), rng.normal(size=4)
    (shared,) = kernel.batch([a, b], threads=3)
    (tiled,) = kernel.batch([a, np.tile(b, (5000, 1))])
    np.testing.assert_array_equal(shared, tiled)
    with pytest.raises(InputError, match="shape"):
        kernel.batch([a[:, :1], b])
    with pytest.raises(InputError, match="rows"):
        kernel.batch([a, np.tile(b, (3, 1))])


def test_sine_and_cosine_to_the_last_digits() -> None:
    graph = Graph()
    x = graph.symbols(1)
    kernel = NativeKernel(assemble(graph, "sincos", {"x": x}, {"s": [x[0].sin()], "c": [x[0].cos()]}))
    rng = np.random.default_rng(0)
    quarters = np.arange(-200, 200)[:, None] * np.pi / 2 + rng.normal(size=(1, 50)) * 10.0 ** rng.uniform(-12, 0, 50)
    angles = np.concatenate([rng.uniform(-7, 7, 20000), rng.uniform(-LARGEST, LARGEST, 20000), quarters.ravel(), [0.0]])
    for found, function in zip(kernel.batch([angles[:, None]]), (np.sin, np.cos), strict=True):
        wanted = function(angles.astype(np.longdouble))
        unit = np.spacing(np.abs(wanted.astype(np.float64)))
        # where long double is no longer than double the reference itself is wrong by half a unit
        allowed = 0.9 if np.finfo(np.longdouble).eps < 1e-18 else 1.5
        assert float((np.abs(found[:, 0] - wanted) / unit).max()) < allowed
    beyond = np.array([[2 * LARGEST], [-1e300], [np.inf], [np.nan], [1e5], [0.5], [1.0], [2.0]])
    assert np.isnan(kernel.batch([beyond])[0][:5]).all()
    assert np.isnan(kernel(np.array([np.inf]))).all()


NUMBERS = st.one_of(st.sampled_from([-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 2.5]), st.floats(-3, 3))


@given(st.lists(NUMBERS, min_size=4, max_size=4))
def test_operations_that_jump_do_so_where_they_should(x: list[float]) -> None:
    def jumps(a: Any, b: Any, c: Any, d: Any) -> list[Any]:
        turned = functions.where_less(-a, -b, -c, -d)
        return [
            functions.floor(a),
            functions.floor(-a),
            functions.nearest(b),
            functions.nearest(-b),
            functions.less(a, b),
            functions.at_most(a, b),
            functions.pick(functions.at_most(b, a), c, d),
            turned + functions.where_less(a, 0.5, 1.0, c),
            functions.pick(b, -c, d),
        ]

    graph = Graph()
    symbols = graph.symbols(4)
    traced = jumps(*symbols)
    program = assemble(graph, "f", {"x": symbols}, {"y": traced})
    program.validate()
    a, b, c, d = x
    wanted = [math.floor(a), math.floor(-a), round(b), round(-b), a < b, a <= b, c if b <= a else d]
    wanted += [(-c if b < a else -d) + (1.0 if a < 0.5 else c), -c if b else d]
    assert [float(y) for y in interpret(program, x)] == wanted == jumps(*x)
    folded = Graph()
    assert [
        folded.constant_of(folded.reference(y)) for y in jumps(*(Expression(folded, folded.constant(y)) for y in x))
    ] == wanted
    # between the jumps: the slope of what is picked, nothing of what is constant
    slopes = tangent(graph, traced, {symbols[2].ref: 1.0})
    found = [float(y) for y in interpret(assemble(graph, "g", {"x": symbols}, {"y": slopes}), x)]
    assert found == [0] * 6 + [float(b <= a), -float(b < a) + float(not a < 0.5), -float(b != 0.0)]


def test_what_is_not_picked_may_be_not_a_number() -> None:
    graph = Graph()
    (x,) = graph.symbols(1)
    root = functions.pick(functions.less(0.0, x), functions.sqrt(x), 1.0)
    program = assemble(graph, "f", {"x": [x]}, {"y": [root], "slope": tangent(graph, [root], {x.ref: 1.0})})
    for kernel in (NativeKernel(program), NativeKernel(program, fast=True)):
        assert kernel(np.array([4.0])).tolist() == [2.0, 0.25]
        assert kernel(np.array([-4.0])).tolist() == [1.0, 0.0]


@given(st.lists(st.floats(-3, 3), min_size=2, max_size=2, unique=True), st.floats(-1, 1))
def test_kinks_have_the_slope_of_their_side(x: list[float], rate: float) -> None:
    graph = Graph()
    a, b = graph.symbols(2)
    slopes = tangent(graph, [minimum(a, b), maximum(a, b), abs(a)], {a.ref: 1.0, b.ref: rate})
    found = [float(y) for y in interpret(assemble(graph, "f", {"x": [a, b]}, {"y": slopes}), x)]
    assert found[:2] == ([1.0, rate] if x[0] < x[1] else [rate, 1.0])
    assert found[2] == (-1.0 if x[0] < 0.0 else 1.0)
