"""Back ends: every row gives the numbers that the interpreter gives, and what a back end leaves out is done for it."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from cutjoint.arrays import Array
from cutjoint.compile import compiled, simulate_many
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program, interpret
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.machine.backends import BACKENDS, Backend
from cutjoint.compile.machine.kernel import Kernel, LoopParts, Sizes, Stages
from cutjoint.control import PD
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion import Hold, Reference


def program(*, fused: bool) -> Program:
    """One with every operation that a back end may meet; it cannot be evaluated where the last input is zero."""
    graph = Graph()
    x = graph.symbols(6)
    results = [
        functions.sin(x[0]) * functions.cos(x[1]) + x[2],
        functions.atan2(x[0], x[1]) - functions.acos(x[2] / (abs(x[2]) + 1.0)),
        functions.minimum(x[0], x[1]) * functions.maximum(x[2], x[3]) - functions.sqrt(x[4] * x[4] + 2.0),
        x[5] - x[0] * x[3],
        x[3] * x[4],
        1.0 / x[5],
        -x[0],
        3.25,
        functions.floor(3.0 * x[0]) + functions.nearest(3.0 * x[1]) + functions.nearest(-2.0 * x[2]),
        functions.pick(functions.at_most(x[0], x[1]), functions.sqrt(abs(x[4])), -x[3]),
        functions.where_less(x[1], x[0], functions.floor(-x[3]), 0.5) + functions.where_less(-x[1], -x[2], x[3], x[4]),
    ]
    made = assemble(graph, "everything", {"a": x[:2], "b": x[2:]}, {"y": results[:4], "z": results[4:]}, fused=fused)
    met = {Op(code) for code in made.op.tolist()}
    assert met == (set(Op) if fused else set(Op) - {Op.FMA, Op.FMS, Op.FNMA})
    return made


class Interpreted(Kernel):
    """The least that a back end may be."""

    def __call__(self, *arguments: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.array([float(x) for x in interpret(self.program, np.concatenate(arguments).tolist())])


ROWS = {**BACKENDS, "interpreted": Backend(Interpreted)}


@pytest.mark.parametrize("name", ROWS)
def test_a_kernel_computes_its_program(name: str) -> None:
    row = ROWS[name]
    kernel = row.kernel(program(fused=row.fused()))
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(21, 2)), rng.normal(size=(21, 4))
    wanted = np.array([interpret(kernel.program, [*x, *y]) for x, y in zip(a, b, strict=True)])
    called = np.array([kernel(x, y) for x, y in zip(a, b, strict=True)])
    np.testing.assert_allclose(called, wanted, rtol=1e-13, atol=1e-14)
    for lanes in (True, False):
        y, z = kernel.batch([a, b], lanes=lanes, threads=2)
        np.testing.assert_array_equal(np.concatenate([y, z], axis=1), called)
    (shared, _) = kernel.batch([a[0], b])
    np.testing.assert_array_equal(shared, kernel.batch([np.tile(a[0], (21, 1)), b])[0])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(kernel))(a[0], b[0]), called[0])
    assert not np.isfinite(kernel(a[0], np.zeros(4)).sum())
    with pytest.raises(InputError, match=r"b must have shape \(N, 4\)"):
        kernel.batch([a, a])
    with pytest.raises(InputError, match="agree in their number of rows"):
        kernel.batch([a, b[1:]])


def test_a_robot_goes_through_any_back_end(kit: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACKENDS, "interpreted", ROWS["interpreted"])  # type: ignore[misc]
    native, other = kit.machine("fivebar"), compiled(kit.model("fivebar"), backend="interpreted")
    at, v, a = native.home, np.array([0.3, -0.2]), np.array([1.0, 2.0])
    assert isinstance(other.kernel("inverse"), Interpreted)
    effort = native.inverse_dynamics(at, v, a)
    np.testing.assert_allclose(other.inverse_dynamics(at, v, a), effort, rtol=1e-12)
    np.testing.assert_allclose(pickle.loads(pickle.dumps(other)).inverse_dynamics(at, v, a), effort, rtol=1e-12)
    near = at.q + np.array([[0.0, 0.0], [0.01, -0.02]])
    wanted = native.batch.inverse_dynamics(near, v, a)
    np.testing.assert_allclose(other.batch.inverse_dynamics(near, v, a), wanted, rtol=1e-12)
    with pytest.raises(InputError, match="many runs"):
        simulate_many(other, PD(1.0, 1.0), Reference(Hold(native.tool(at).position), native, 0.1))


def test_what_a_back_end_lacks_is_said(kit: Any) -> None:
    with pytest.raises(UnknownNameError, match="llvm"):
        compiled(kit.model("fivebar"), backend="fortran")
    kernel = Interpreted(program(fused=False))
    with pytest.raises(InputError, match="address"):
        print(kernel.address)
    with pytest.raises(InputError, match="many runs"):
        ROWS["interpreted"].runs(LoopParts(kernel.program, None, Stages((), (1,), 1), Sizes(1, 1, 1, 1, 0)), fast=False)
