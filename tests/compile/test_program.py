"""Stored programs: what is read back is what was written, or nothing."""

from __future__ import annotations

from hashlib import sha256
from typing import Any

import numpy as np
import pytest

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program, ProgramError, interpret
from cutjoint.compile.expressions.straight_line import assemble


@pytest.fixture
def program() -> Program:
    graph = Graph()
    a, b = graph.symbols(2), graph.symbols(1)
    y = [a[0] * a[1] + b[0], functions.sin(a[0]) / b[0] + a[1] / b[0]]
    return assemble(graph, "small", {"a": a, "b": b}, {"y": y, "z": [2.5]})


def sealed(body: bytes) -> bytes:
    """Any bytes with the digest that belongs to them: what a forger would write."""
    return body + sha256(body).digest()


def test_round_trip(program: Program) -> None:
    again = Program.from_bytes(program.to_bytes())
    assert (again.name, again.arguments, again.results) == (program.name, program.arguments, program.results)
    for name in ("op", "operands", "values", "outputs"):
        np.testing.assert_array_equal(getattr(again, name), getattr(program, name))
    x = [0.3, -0.2, 0.7]
    np.testing.assert_array_equal(interpret(again, x), interpret(program, x))


def test_any_changed_byte_is_noticed(program: Program) -> None:
    data = program.to_bytes()
    for k in range(len(data)):
        changed = bytearray(data)
        changed[k] ^= 1 << (k % 8)
        with pytest.raises(ProgramError):
            Program.from_bytes(bytes(changed))


def test_any_truncation_is_noticed(program: Program) -> None:
    data = program.to_bytes()
    for k in range(len(data)):
        with pytest.raises(ProgramError):
            Program.from_bytes(data[:k])
    with pytest.raises(ProgramError):
        Program.from_bytes(data + b"\0")


@pytest.mark.parametrize(
    ("field", "place", "value"),
    [
        ("op", 0, 0),
        ("op", 0, 200),
        ("operands", -1, 10**6),
        ("operands", -1, -5),
        ("operands", 0, 99),
        ("outputs", 0, 10**6),
        ("outputs", 0, -1),
        ("values", 0, np.nan),
    ],
)
def test_instructions_that_are_not_straight_line_code_are_refused(
    program: Program, field: str, place: int, value: Any
) -> None:
    parts = {name: np.array(getattr(program, name)) for name in ("op", "operands", "values", "outputs")}
    if field == "operands":
        row = int(np.flatnonzero(program.op == (Op.INPUT if place == 0 else Op.FMA))[0])
        parts["operands"][row, 0] = value
    else:
        parts[field][place] = value
    forged = Program(program.name, program.arguments, program.results, **parts)
    with pytest.raises(ProgramError):
        Program.from_bytes(forged.to_bytes())


@pytest.mark.parametrize("header", [b"{}", b"[]", b"not json", b'{"name": 1}'])
def test_headers_that_cannot_be_read_are_refused(program: Program, header: bytes) -> None:
    body = program.to_bytes()[:-32]
    magic, _, rest = body.partition(b"\n")
    with pytest.raises(ProgramError):
        Program.from_bytes(sealed(magic + b"\n" + header + b"\n" + rest.partition(b"\n")[2]))
