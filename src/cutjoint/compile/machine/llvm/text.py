"""Programs as LLVM assembly: one flat function, and loops that run it over rows of arrays.

The same instructions are written for one number and for a vector of them.  A batch is therefore not left to a loop
vectoriser: eight (or four, or two) states stand side by side in the vector registers from the first load to the last
store, and each of them gets the digits that a scalar call gives.
"""

from __future__ import annotations

from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.machine.llvm.lanes import Lanes, Writer
from cutjoint.compile.machine.llvm.sine_cosine import sine_cosine

_BINARY = {Op.ADD: "fadd", Op.SUB: "fsub", Op.MUL: "fmul", Op.DIV: "fdiv"}
_UNARY = {Op.SQRT: "sqrt", Op.ABS: "fabs", Op.FLOOR: "floor", Op.NEAREST: "rint"}
_TEST = {Op.LESS: "olt", Op.AT_MOST: "ole"}


def declarations(lanes: int) -> str:
    """Declarations of what flat functions call."""
    lines = ["declare double @atan2(double, double)", "declare double @acos(double)"]
    lines.append("declare double @pow(double, double)")
    kinds = [("f64", "double"), *((f"v{k}f64", f"<{k} x double>") for k in (2, 4, 8) if k <= lanes)]
    for suffix, kind in kinds:
        lines.append(f"declare {kind} @llvm.fma.{suffix}({kind}, {kind}, {kind})")
        lines += (f"declare {kind} @llvm.{name}.{suffix}({kind})" for name in _UNARY.values())
    return "\n".join(dict.fromkeys(lines))


WHOLE = 8000
"""Longest program that becomes one function [instructions]; compile time grows faster than length."""
PIECE = 500
"""Longer programs are cut into functions of this length, which hand values on in memory."""


class FlatFunction:
    """`void symbol(const T *x, T *y)`: all results `y` of one evaluation with all arguments `x`, without a branch; in
    pieces where it is long.

    A scalar function takes sine and cosine of its angles `width` at a time, which changes no digit.

    Args:
        program: what to compute.
        symbol: name of the function.
        lanes: 1 for T = double, else T is a vector of so many.
        width: lanes of the processor's vector registers.
        fused: whether the processor has fused multiply-add.
        fast: allow the compiler to reassociate (off: every digit is what the program says).
    """

    def __init__(self, program: Program, symbol: str, lanes: int, width: int, fused: bool, fast: bool) -> None:
        self.program, self.symbol, self.lanes, self.width = program, symbol, lanes, width
        self.fused, self.flags = fused, " fast" if fast else ""
        self.type = "double" if lanes == 1 else f"<{lanes} x double>"
        self.align = 8 * lanes
        self.rows = list(zip(program.op.tolist(), program.operands.tolist(), program.values.tolist(), strict=True))
        self.piece = PIECE if len(self.rows) > WHOLE else max(len(self.rows), 1)
        self.pieces = max(1, -(-len(self.rows) // self.piece))
        self.last_piece = self._last_uses()
        self.slots: dict[tuple[int, str], int] = {}

    def _last_uses(self) -> list[int]:
        """Last piece that reads each value."""
        last = [0] * len(self.rows)
        for k, (code, operands, _) in enumerate(self.rows):
            for operand in operands[: Op(code).arity]:
                last[operand] = max(last[operand], k // self.piece)
        for source in self.program.outputs.tolist():
            last[source] = self.pieces - 1
        return last

    def text(self) -> str:
        """The function and its pieces."""
        size = self.align * max(self.program.n_in, 1), self.align * max(self.program.n_out, 1)
        heads = f"ptr noalias readonly dereferenceable({size[0]}) %x, ptr noalias dereferenceable({size[1]}) %y"
        if self.pieces == 1:
            return f"define void @{self.symbol}({heads}) #0 {{\n{self._piece(0)}\n  ret void\n}}\n"
        bodies = [
            f"define internal void @{self.symbol}.{k}(ptr noalias readonly %x, ptr noalias %y, ptr noalias %w) #0 {{\n"
            f"{self._piece(k)}\n  ret void\n}}\n"
            for k in range(self.pieces)
        ]
        calls = "\n".join(f"  call void @{self.symbol}.{k}(ptr %x, ptr %y, ptr %w)" for k in range(self.pieces))
        store = f"  %w = alloca {self.type}, i64 {max(len(self.slots), 1)}, align {max(self.align, 8)}"
        return "".join(bodies) + f"define void @{self.symbol}({heads}) #0 {{\n{store}\n{calls}\n  ret void\n}}\n"

    def _piece(self, piece: int) -> str:
        out = Writer()
        a = Lanes(out, self.lanes, fused=self.fused)
        names: dict[int, str] = {}
        angles: dict[int, tuple[str, str]] = {}

        def name(k: int) -> str:
            if k not in names:
                code, (i, _, _), value = self.rows[k]
                if code == Op.CONST:
                    names[k] = a.constant(value)
                elif code == Op.INPUT:
                    names[k] = a.load("%x", i)
                else:
                    names[k] = a.load("%w", self._slot(k, "value"))
            return names[k]

        def angle(k: int) -> tuple[str, str]:
            if k not in angles:
                if (k, "sine") in self.slots:
                    angles[k] = a.load("%w", self._slot(k, "sine")), a.load("%w", self._slot(k, "cosine"))
                else:
                    angles[k] = sine_cosine(a, name(k))
            return angles[k]

        if piece == 0 and self.lanes == 1:
            angles.update(_angles_together(self.program, out, self.width, self.fused))
        end = min(len(self.rows), (piece + 1) * self.piece)
        for k in range(piece * self.piece, end):
            code, operands, _ = self.rows[k]
            op = Op(code)
            if op in (Op.CONST, Op.INPUT):
                continue
            if op in (Op.SIN, Op.COS):
                names[k] = angle(operands[0])[0 if op is Op.SIN else 1]
            else:
                given = [name(i) for i in operands[: op.arity]]
                names[k] = _instruction(a, op, given, self.flags)
            if self.last_piece[k] > piece:
                a.store("%w", self._slot(k, "value"), names[k])
        if piece + 1 < self.pieces:
            for k, (sine, cosine) in angles.items():
                if (k, "sine") not in self.slots:
                    a.store("%w", self._slot(k, "sine"), sine)
                    a.store("%w", self._slot(k, "cosine"), cosine)
        else:
            for place, source in enumerate(self.program.outputs.tolist()):
                a.store("%y", place, name(source))
        return "\n".join(out.lines)

    def _slot(self, k: int, what: str) -> int:
        """Place in the memory between pieces."""
        return self.slots.setdefault((k, what), len(self.slots))


def _instruction(a: Lanes, op: Op, x: list[str], flags: str) -> str:
    """One instruction of a program; returns the name of its value."""
    out = a.out
    match op:
        case Op.ADD | Op.SUB | Op.MUL | Op.DIV:
            return out.emit(f"{_BINARY[op]}{flags} {a.type} {x[0]}, {x[1]}")
        case Op.FMA:
            return a.fma(x[0], x[1], x[2])
        case Op.FMS:
            return a.fma(x[0], x[1], out.emit(f"fneg {a.type} {x[2]}"))
        case Op.FNMA:
            return a.fma(out.emit(f"fneg {a.type} {x[0]}"), x[1], x[2])
        case Op.NEG:
            return out.emit(f"fneg {a.type} {x[0]}")
        case Op.SQRT | Op.ABS | Op.FLOOR | Op.NEAREST:
            return out.emit(f"call {a.type} @llvm.{_UNARY[op]}.{a.suffix}({a.type} {x[0]})")
        case Op.LESS | Op.AT_MOST:
            test = out.emit(f"fcmp {_TEST[op]} {a.type} {x[0]}, {x[1]}")
            return out.emit(f"uitofp {a.boolean} {test} to {a.type}")
        case Op.PICK:
            test = out.emit(f"fcmp une {a.type} {x[0]}, {a.constant(0.0)}")
            return a.choose(test, x[1], x[2])
        case Op.MIN | Op.MAX:
            test = out.emit(f"fcmp {'ult' if op is Op.MIN else 'ugt'} {a.type} {x[0]}, {x[1]}")
            return a.choose(test, x[0], x[1])
        case Op.ATAN2:
            return _library(a, "atan2", (x[0], x[1]))
        case Op.ACOS:
            return _library(a, "acos", (x[0],))
    raise AssertionError(op)


def _angles_together(program: Program, out: Writer, width: int, fused: bool) -> dict[int, tuple[str, str]]:
    """Sine and cosine of all arguments of which they are needed: instruction -> names."""
    trigonometric = program.operands[(program.op == Op.SIN) | (program.op == Op.COS), 0]
    inputs = [int(k) for k in dict.fromkeys(trigonometric.tolist()) if program.op[k] == Op.INPUT]
    found: dict[int, tuple[str, str]] = {}
    while inputs:
        lanes = width
        while lanes >= 2 * len(inputs) and lanes > 2:
            lanes //= 2
        group, inputs = inputs[:lanes], inputs[lanes:]
        a = Lanes(out, lanes, fused=fused)
        packed = "zeroinitializer"
        for lane, k in enumerate(group):
            one = Lanes(out, 1).load("%x", int(program.operands[k, 0]))
            packed = out.emit(f"insertelement {a.type} {packed}, double {one}, i32 {lane}")
        pair = sine_cosine(a, packed)
        for lane, k in enumerate(group):
            sine, cosine = (out.emit(f"extractelement {a.type} {x}, i32 {lane}") for x in pair)
            found[k] = (sine, cosine)
    return found


def _library(a: Lanes, function: str, arguments: tuple[str, ...]) -> str:
    """A call of the C library, lane by lane."""
    out = a.out
    if a.lanes == 1:
        return out.emit(f"call double @{function}({', '.join(f'double {x}' for x in arguments)})")
    result = "poison"
    for lane in range(a.lanes):
        given = [out.emit(f"extractelement {a.type} {x}, i32 {lane}") for x in arguments]
        value = out.emit(f"call double @{function}({', '.join(f'double {x}' for x in given)})")
        result = out.emit(f"insertelement {a.type} {result}, double {value}, i32 {lane}")
    return result


def row_loop(program: Program, symbol: str, flat: str, lanes: int) -> str:
    """`int64 symbol(int64 begin, int64 end, const int64 *table)`: the flat function over rows of arrays.

    The table holds address and row stride in bytes of every argument, then of every result; a stride of 0 gives all
    rows the same values.  Numbers of one row stand side by side.  Returns the first row that was not done: with lanes,
    a rest that fills no vector is left to the scalar loop.
    """
    out = Writer()
    a = Lanes(out, lanes)
    arrays = [*program.arguments, *program.results]
    out.do("entry:")
    x, y = a.room(program.n_in), a.room(program.n_out)
    bases: list[str] = []
    strides: list[str] = []
    for k in range(len(arrays)):
        for values, place in ((bases, 2 * k), (strides, 2 * k + 1)):
            pointer = out.emit(f"getelementptr i64, ptr %table, i64 {place}")
            values.append(out.emit(f"load i64, ptr {pointer}, align 8"))
    out.do("br label %head")
    out.do("head:")
    out.do("%i = phi i64 [ %begin, %entry ], [ %next, %body ]")
    out.do(f"%next = add i64 %i, {lanes}")
    out.do("%more = icmp sle i64 %next, %end")
    out.do("br i1 %more, label %body, label %done")
    out.do("body:")
    place = 0
    for k, (_, count) in enumerate(arrays):
        if k == len(program.arguments):
            out.do(f"call void @{flat}(ptr {x}, ptr {y})")
            place = 0
        rows = []
        for lane in range(lanes):
            row = out.emit(f"add i64 %i, {lane}")
            offset = out.emit(f"mul i64 {row}, {strides[k]}")
            rows.append(out.emit(f"inttoptr i64 {out.emit(f'add i64 {bases[k]}, {offset}')} to ptr"))
        for component in range(count):
            slot = a.at(x if k < len(program.arguments) else y, place)
            place += 1
            places = [out.emit(f"getelementptr double, ptr {row}, i64 {component}") for row in rows]
            if k < len(program.arguments):
                value = "poison"
                for lane, pointer in enumerate(places):
                    one = out.emit(f"load double, ptr {pointer}, align 8")
                    value = one if lanes == 1 else out.emit(f"insertelement {a.type} {value}, double {one}, i32 {lane}")
                out.do(f"store {a.type} {value}, ptr {slot}, align {a.align}")
            else:
                value = out.emit(f"load {a.type}, ptr {slot}, align {a.align}")
                for lane, pointer in enumerate(places):
                    one = value if lanes == 1 else out.emit(f"extractelement {a.type} {value}, i32 {lane}")
                    out.do(f"store double {one}, ptr {pointer}, align 8")
    out.do("br label %head")
    out.do("done:")
    out.do("ret i64 %i")
    body = "\n".join(out.lines)
    return f"define i64 @{symbol}(i64 %begin, i64 %end, ptr %table) #0 {{\n{body}\n}}\n"
