"""The table of compiled functions: a row is all that a function needs, and all that is said of it elsewhere."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import compiled, functions_of
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions import tracing
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import RobotSample
from cutjoint.compile.functions.table import FUNCTIONS, Function, ResultPart
from cutjoint.compile.functions.tracing import Call, Traced
from cutjoint.compile.functions.verify import Checker
from cutjoint.compile.sources.interface import Need
from cutjoint.errors import CompileError

GUIDE = Path(__file__).parents[2] / "docs" / "compile.md"
FOR = {Need.JOINTS: "chains", Need.CLOSED_FORM: "published models"}


def momentum(call: Call) -> Traced:
    """M v."""
    v = call["v"]
    products = [[x * y for x, y in zip(row, v, strict=True)] for row in call.state.mass()]
    return {"p": [sum(row[1:], row[0]) for row in products]}, call.state.strain


def moved(sample: RobotSample) -> dict[str, np.ndarray]:
    return {"p": sample.terms.mass @ sample.v}


def place(program: Program, name: str) -> slice:
    """Where a result stands among the outputs."""
    names = [found for found, _ in program.results]
    start = sum(size for _, size in program.results[: names.index(name)])
    return slice(start, start + dict(program.results)[name])


MOMENTUM = Function("momentum", "M v", ("q", "v", "parameters"), (ResultPart("p", "n", "1/v"),), momentum, moved)


@pytest.mark.parametrize("name", ["fivebar", "paper omega3"])
def test_a_new_function_is_a_row(kit: Any, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FUNCTIONS, "momentum", MOMENTUM)
    robot = compiled(kit.model(name), cached=False)
    assert "momentum" in functions_of(robot)
    v = np.arange(1.0, robot.n + 1.0)
    found = robot.library()["momentum"](robot.positions(robot.home), v, np.zeros(0))
    assert found is not None
    np.testing.assert_allclose(found["p"], robot.terms(robot.home).mass @ v, rtol=1e-12)
    assert not found["p"].flags.writeable


@pytest.mark.parametrize("name", ["fivebar", "paper omega3"])
def test_a_row_that_says_what_is_not_so_is_refused(kit: Any, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = replace(MOMENTUM, known=lambda sample: {"p": sample.terms.mass @ sample.v * (1.0 + 1e-8)})
    monkeypatch.setitem(FUNCTIONS, "momentum", wrong)
    with pytest.raises(CompileError, match="'p' is off by"):
        compiled(kit.model(name), cached=False).kernel("momentum")


@pytest.mark.parametrize("name", ["fivebar", "cpm", "paper omega3", "underactuated"])
def test_parts_come_by_name_in_their_shapes(kit: Any, name: str) -> None:
    robot, rng = kit.machine(name), np.random.default_rng(0)
    sizes = {"n": robot.source.n, "nv": robot.source.nv, "positions": robot.source.positions, "rows": robot.source.rows}
    for what in functions_of(robot):
        function = robot.library()[what]
        row, program = function.row, function.kernel.program
        assert (program.arguments, program.results) == row.lengths(robot.source)
        y = rng.normal(size=program.n_out)
        parts = function.parts(y)
        assert list(parts) == [part.name for part in row.parts]
        for part in row.parts:
            assert parts[part.name].shape == tuple(int(sizes.get(s, s)) for s in part.shape.split(","))
            np.testing.assert_array_equal(parts[part.name].ravel(), y[place(program, part.name)])


@pytest.mark.parametrize("name", ["cpm", "paper omega3"])
def test_an_error_in_any_part_of_any_function_is_noticed(kit: Any, name: str) -> None:
    """Every number that a function gives is replaced by another one: only what the loops are open by goes unseen, and a
    determinant, which is in no unit that the model knows."""
    robot = kit.machine(name)
    check = Checker(robot.source, robot.model, np.zeros(0))
    rng = np.random.default_rng(1)
    for what in functions_of(robot):
        function = robot.library()[what]
        right = function.kernel.program
        assert not check(function)
        for part in function.row.parts:
            where = range(right.n_out)[place(right, part.name)]
            if part.name in ("residual", "determinant") or not where:
                continue
            outputs = np.array(right.outputs)
            outputs[rng.choice(where)] = right.op.tolist().index(0) if 0 in right.op else right.outputs[-1]
            if right.outputs.tolist() == outputs.tolist():
                continue
            harmed = Program(
                right.name, right.arguments, right.results, right.op, right.operands, right.values, outputs
            )
            kernel = type(function.kernel)(harmed)
            assert "off by" in check(CompiledFunction(function.row, kernel, robot.source)), (what, part.name)


def test_the_guide_has_the_table() -> None:
    lines = ["| function | arguments | gives | for |", "| --- | --- | --- | --- |"]
    for row in FUNCTIONS.values():
        whose = next((FOR[need] for need in row.needs if need in FOR), "both")
        given, parts = ", ".join(row.arguments[:-1]), ", ".join(f"{one.name} ({one.shape})" for one in row.parts)
        lines.append(f"| `{row.name}` | `{given}` | {row.about}: `{parts}` | {whose} |")
    table = "\n".join(lines)
    assert table in GUIDE.read_text(encoding="utf-8"), f"docs/compile.md should have this table:\n\n{table}"


def test_every_argument_is_of_one_size_everywhere() -> None:
    for row in FUNCTIONS.values():
        assert row.arguments[0] in ("q", "p")
        assert row.arguments[-1] == "parameters"
        assert set(row.arguments) <= set(tracing.ARGUMENTS)
