"""The loop of a simulation as LLVM assembly: classical Runge-Kutta of order four over many runs side by side.

One group of runs (as many as the vector registers have lanes) goes through all its steps before the next group starts,
so its state stays in the nearest cache and memory does not grow with the number of steps.
"""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.compile.machine.llvm.text import Writer


@dataclass(frozen=True)
class Sizes:
    """Numbers of a run: state, columns of the reference table, per-run arguments, watched values, residuals."""

    state: int
    columns: int
    given: int
    watched: int
    settled: int
    """Leading part of the state that the settling function rewrites; 0 where there is none."""


def run_loop(symbol: str, sizes: Sizes, lanes: int) -> str:
    """`void symbol(int64 begin, int64 end, int64 steps, int64 every, double h, double limit, const int64 *table)`.

    Calls `rate(x, y)` with x = state, row of the reference, per-run arguments and y = rates, watched values, strain;
    and, if anything is settled, `settle(x, y)` with y = settled part, residual, strain.

    The table holds addresses: states and per-run arguments (group, number, lane), reference rows (2 steps + 1,
    columns), records (group, record, state + watched, lane), sums (group, 2 watched + 2, lane), and the number of
    records.  Sums are the largest |w| and the integral of w^2 of every watched value, the first step whose strain was
    beyond the limit (steps + 1: none), and the largest residual.
    """
    return _RunLoop(symbol, sizes, lanes).text()


class _RunLoop:
    def __init__(self, symbol: str, sizes: Sizes, lanes: int) -> None:
        self.symbol, self.sizes, self.lanes = symbol, sizes, lanes
        self.kind = "double" if lanes == 1 else f"<{lanes} x double>"
        self.suffix = "f64" if lanes == 1 else f"v{lanes}f64"
        self.boolean = "i1" if lanes == 1 else f"<{lanes} x i1>"
        self.size = 8 * lanes
        self.out = Writer()

    # -- small pieces ------------------------------------------------------------------------------------------------

    def at(self, base: str, index: int | str) -> str:
        return self.out.emit(f"getelementptr {self.kind}, ptr {base}, i64 {index}")

    def load(self, base: str, index: int) -> str:
        return self.out.emit(f"load {self.kind}, ptr {self.at(base, index)}, align {self.size}")

    def store(self, base: str, index: int, value: str) -> None:
        self.out.do(f"store {self.kind} {value}, ptr {self.at(base, index)}, align {self.size}")

    def spread(self, scalar: str) -> str:
        """A double in every lane."""
        if self.lanes == 1:
            return scalar
        one = self.out.emit(f"insertelement {self.kind} poison, double {scalar}, i32 0")
        mask = f"<{self.lanes} x i32> zeroinitializer"
        return self.out.emit(f"shufflevector {self.kind} {one}, {self.kind} poison, {mask}")

    def fma(self, x: str, y: str, z: str) -> str:
        k = self.kind
        return self.out.emit(f"call {k} @llvm.fma.{self.suffix}({k} {x}, {k} {y}, {k} {z})")

    def larger(self, x: str, y: str) -> str:
        """The larger one; not a number if x is not."""
        test = self.out.emit(f"fcmp ugt {self.kind} {x}, {y}")
        return self.out.emit(f"select {self.boolean} {test}, {self.kind} {x}, {self.kind} {y}")

    def absolute(self, x: str) -> str:
        return self.out.emit(f"call {self.kind} @llvm.fabs.{self.suffix}({self.kind} {x})")

    def row(self, index: str) -> None:
        """Put a row of the reference into the arguments."""
        s = self.sizes
        offset = self.out.emit(f"mul i64 {index}, {s.columns}")
        base = self.out.emit(f"getelementptr double, ptr {self.rows}, i64 {offset}")
        for k in range(s.columns):
            pointer = self.out.emit(f"getelementptr double, ptr {base}, i64 {k}")
            one = self.out.emit(f"load double, ptr {pointer}, align 8")
            self.store(self.x, s.state + k, self.spread(one))

    def judge(self, strain: str) -> None:
        """Note the step if the strain is beyond the limit, or not a number."""
        bad = self.out.emit(f"fcmp ugt {self.kind} {strain}, {self.limit}")
        broken = self.load(self.sums, 2 * self.sizes.watched)
        now = self.spread(self.out.emit("sitofp i64 %i to double"))
        earlier = self.out.emit(f"fcmp olt {self.kind} {now}, {broken}")
        first = self.out.emit(f"and {self.boolean} {bad}, {earlier}")
        chosen = self.out.emit(f"select {self.boolean} {first}, {self.kind} {now}, {self.kind} {broken}")
        self.store(self.sums, 2 * self.sizes.watched, chosen)

    def evaluate(self) -> None:
        """Rates at the arguments, judged."""
        self.out.do(f"call void @rate(ptr {self.x}, ptr {self.y})")
        self.judge(self.load(self.y, self.sizes.state + self.sizes.watched))

    # -- the loop ----------------------------------------------------------------------------------------------------

    def text(self) -> str:
        s, out = self.sizes, self.out
        width = s.state + s.watched
        totals = 2 * s.watched + 2
        out.do("entry:")

        def room(count: int) -> str:
            return out.emit(f"alloca {self.kind}, i64 {max(count, 1)}, align {max(self.size, 8)}")

        self.x, self.y = room(s.state + s.columns + s.given), room(width + 1)
        self.base, self.total, self.sums = room(s.state), room(s.state), room(totals)
        settled = room(s.settled + 2)
        pointers = []
        for k in range(6):
            place = out.emit(f"getelementptr i64, ptr %table, i64 {k}")
            value = out.emit(f"load i64, ptr {place}, align 8")
            pointers.append(value if k == 5 else out.emit(f"inttoptr i64 {value} to ptr"))
        states, given, self.rows, records, results, count = pointers
        h = self.spread("%h")
        half = self.out.emit(f"fmul {self.kind} {h}, {self.spread('5.0e-01')}")
        sixth = self.out.emit(f"fdiv {self.kind} {h}, {self.spread('6.0e+00')}")
        two = self.spread("2.0e+00")
        self.limit = self.spread("%limit")
        zero = "0.0" if self.lanes == 1 else "zeroinitializer"
        never = self.spread(out.emit(f"sitofp i64 {out.emit('add i64 %steps, 1')} to double"))
        out.do("br label %groups")

        out.do("groups:")
        out.do("%g = phi i64 [ %begin, %entry ], [ %g.next, %finish ]")
        out.do("%g.more = icmp slt i64 %g, %end")
        out.do("br i1 %g.more, label %start, label %leave")

        out.do("start:")
        mine = self.at(states, out.emit(f"mul i64 %g, {s.state}"))
        for k in range(s.state):
            self.store(self.base, k, self.load(mine, k))
        own = self.at(given, out.emit(f"mul i64 %g, {s.given}"))
        for k in range(s.given):
            self.store(self.x, s.state + s.columns + k, self.load(own, k))
        for k in range(totals):
            self.store(self.sums, k, never if k == 2 * s.watched else zero)
        first = self.at(records, out.emit(f"mul i64 {out.emit(f'mul i64 %g, {count}')}, {width}"))
        out.do("br label %step")

        out.do("step:")
        out.do("%i = phi i64 [ 0, %start ], [ %i.next, %advanced ]")
        out.do("%taken = phi i64 [ 0, %start ], [ %taken.next, %advanced ]")
        for k in range(s.state):
            self.store(self.x, k, self.load(self.base, k))
        doubled = out.emit("mul i64 %i, 2")
        self.row(doubled)
        self.evaluate()
        for k in range(s.watched):
            w = self.load(self.y, s.state + k)
            self.store(self.sums, 2 * k, self.larger(self.absolute(w), self.load(self.sums, 2 * k)))
            self.store(self.sums, 2 * k + 1, self.fma(w, w, self.load(self.sums, 2 * k + 1)))
        over = out.emit("srem i64 %i, %every")
        due = out.emit(f"icmp eq i64 {over}, 0")
        last = out.emit("icmp eq i64 %i, %steps")
        take = out.emit(f"or i1 {due}, {last}")
        out.do(f"br i1 {take}, label %record, label %go")

        out.do("record:")
        place = self.at(first, out.emit(f"mul i64 %taken, {width}"))
        for k in range(s.state):
            self.store(place, k, self.load(self.base, k))
        for k in range(s.watched):
            self.store(place, s.state + k, self.load(self.y, s.state + k))
        more = out.emit("add i64 %taken, 1")
        out.do("br label %go")

        out.do("go:")
        out.do(f"%taken.next = phi i64 [ %taken, %step ], [ {more}, %record ]")
        out.do(f"br i1 {last}, label %finish, label %advance")

        out.do("advance:")
        for stage in range(3):
            weight = half if stage < 2 else h
            for k in range(s.state):
                slope = self.load(self.y, k)
                total = slope if stage == 0 else self.fma(two, slope, self.load(self.total, k))
                self.store(self.total, k, total)
                self.store(self.x, k, self.fma(weight, slope, self.load(self.base, k)))
            if stage != 1:
                self.row(out.emit(f"add i64 {doubled}, {1 if stage == 0 else 2}"))
            self.evaluate()
        for k in range(s.state):
            total = out.emit(f"fadd {self.kind} {self.load(self.total, k)}, {self.load(self.y, k)}")
            self.store(self.base, k, self.fma(sixth, total, self.load(self.base, k)))
        if s.settled:
            for k in range(s.state):
                self.store(self.x, k, self.load(self.base, k))
            out.do(f"call void @settle(ptr {self.x}, ptr {settled})")
            for k in range(s.settled):
                self.store(self.base, k, self.load(settled, k))
            residual = self.load(settled, s.settled)
            self.store(self.sums, totals - 1, self.larger(residual, self.load(self.sums, totals - 1)))
            self.judge(self.load(settled, s.settled + 1))
        out.do("br label %advanced")

        out.do("advanced:")
        out.do("%i.next = add i64 %i, 1")
        out.do("br label %step")

        out.do("finish:")
        answer = self.at(results, out.emit(f"mul i64 %g, {totals}"))
        for k in range(totals):
            self.store(answer, k, self.load(self.sums, k))
        out.do("%g.next = add i64 %g, 1")
        out.do("br label %groups")
        out.do("leave:")
        out.do("ret void")
        head = "i64 %begin, i64 %end, i64 %steps, i64 %every, double %h, double %limit, ptr %table"
        body = "\n".join(out.lines)
        return f"define void @{self.symbol}({head}) #0 {{\n{body}\n}}\n"
