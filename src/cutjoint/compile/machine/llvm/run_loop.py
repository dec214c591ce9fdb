"""The loop of a simulation as LLVM assembly: an explicit Runge-Kutta method over many runs side by side.

One group of runs (as many as the vector registers have lanes) goes through all its steps before the next group starts,
so its state stays in the nearest cache and memory does not grow with the number of steps.  Between steps there may be
events, such as the sample instants of a controller, in each run at instants of its own.
"""

from __future__ import annotations

from cutjoint.compile.machine.kernel import LoopParts
from cutjoint.compile.machine.llvm.lanes import Lanes, Writer
from cutjoint.compile.machine.llvm.run_events import RunEventsText


class RunLoopText:
    """`void symbol(int64 begin, int64 end, int64 steps, int64 every, double h, double limit, const int64 *table)`.

    Calls `rate(x, y)` with x = state, row of the reference, per-run arguments, memory and y = rates, watched values,
    strain; if anything is settled, `settle(x, y)` with y = settled part, residual, strain; and `begin(x, y)` and
    `eventK(x, y)` with x = all of that and noise, y = the new values of their targets.

    The table holds addresses: states and per-run arguments (group, number, lane), reference rows (steps + 1, or without
    events 2 steps + 1; columns), records (group, record, width, lane), sums (group, totals, lane), the number of
    records, and the addresses of each lane's due bytes (steps + 1; bit K: event K) and of its noise (one row more than
    is drawn; noise), (group, lane) each; and of a flag, an int64: where it is not 0 before a step, the loop ends there.
    Sums are the largest |w| and the sum of w^2 of every watched value, the first
    step whose strain was beyond the limit (steps + 1: none), and the largest residual.

    It is written block by block.

    Attributes:
        x, y: arguments and results of `rate`.
        base, total: state at the beginning of a step, and the sum of its slopes.
        sums: what is kept of a run.
    """

    def __init__(self, symbol: str, parts: LoopParts, lanes: int) -> None:
        self.symbol, self.parts, self.sizes, self.lanes = symbol, parts, parts.sizes, lanes
        self.out = Writer()
        self.a = Lanes(self.out, lanes)
        s = parts.sizes
        self.noise = s.changing + s.memory

    def text(self) -> str:
        """The whole function."""
        self._entry()
        self._groups()
        self._step()
        self._record()
        self._advance()
        self._finish()
        head = "i64 %begin, i64 %end, i64 %steps, i64 %every, double %h, double %limit, ptr %table"
        body = "\n".join(self.out.lines)
        return f"define void @{self.symbol}({head}) #0 {{\n{body}\n}}\n"

    def copy(self, count: int, source: str, target: str) -> None:
        """Copy numbers from one place to another."""
        for k in range(count):
            self.a.store(target, k, self.a.load(source, k))

    def larger(self, x: str, y: str) -> str:
        """The larger one; not a number if x is not."""
        test = self.out.emit(f"fcmp ugt {self.a.type} {x}, {y}")
        return self.a.choose(test, x, y)

    def row(self, index: str) -> None:
        """Put a row of the reference into the arguments."""
        s = self.sizes
        offset = self.out.emit(f"mul i64 {index}, {s.columns}")
        base = self.out.emit(f"getelementptr double, ptr {self.rows}, i64 {offset}")
        for k in range(s.columns):
            pointer = self.out.emit(f"getelementptr double, ptr {base}, i64 {k}")
            one = self.out.emit(f"load double, ptr {pointer}, align 8")
            self.a.store(self.x, s.state + k, self.a.spread(one))

    def judge(self, strain: str) -> None:
        """Note the step if the strain is beyond the limit, or not a number."""
        bad = self.out.emit(f"fcmp ugt {self.a.type} {strain}, {self.limit}")
        broken = self.a.load(self.sums, 2 * self.sizes.watched)
        now = self.a.spread(self.out.emit("sitofp i64 %i to double"))
        earlier = self.out.emit(f"fcmp olt {self.a.type} {now}, {broken}")
        first = self.out.emit(f"and {self.a.boolean} {bad}, {earlier}")
        self.a.store(self.sums, 2 * self.sizes.watched, self.a.choose(first, now, broken))

    def evaluate(self) -> None:
        """Rates at the arguments, judged."""
        self.out.do(f"call void @rate(ptr {self.x}, ptr {self.y})")
        self.judge(self.a.load(self.y, self.sizes.state + self.sizes.watched))

    def settle(self, *, within: bool = False) -> None:
        """One Newton step onto the loops, from and to the arguments.  Of a stage within a step, which is off by the
        order of the stage, the residual is noted that the step leaves: its square."""
        s = self.sizes
        self.out.do(f"call void @settle(ptr {self.x}, ptr {self.settled})")
        self.copy(s.settled, self.settled, self.x)
        residual = self.a.load(self.settled, s.settled)
        if within:
            residual = self.out.emit(f"fmul {self.a.type} {residual}, {residual}")
        self.a.store(self.sums, s.totals - 1, self.larger(residual, self.a.load(self.sums, s.totals - 1)))
        self.judge(self.a.load(self.settled, s.settled + 1))

    def _entry(self) -> None:
        """Room, addresses and constants."""
        s, out = self.sizes, self.out
        out.do("entry:")
        events = [*self.parts.events, *([] if self.parts.begin is None else [self.parts.begin])]
        results = max([s.state + s.watched + 1, *(len(event.targets) for event in events)])
        self.x, self.y = self.a.room(self.noise + s.noise), self.a.room(results)
        self.base, self.total, self.sums = self.a.room(s.state), self.a.room(s.state), self.a.room(s.totals)
        self.settled = self.a.room(s.settled + 2)
        pointers = []
        for k in range(9):
            place = out.emit(f"getelementptr i64, ptr %table, i64 {k}")
            value = out.emit(f"load i64, ptr {place}, align 8")
            pointers.append(value if k == 5 else out.emit(f"inttoptr i64 {value} to ptr"))
        self.states, self.given, self.rows, self.records, self.results, self.count, *others, self.flag = pointers
        self.events = RunEventsText(self.a, self.parts, self.x, self.y, self.noise, *others)
        self.h = self.a.spread("%h")
        self.half = out.emit(f"fmul {self.a.type} {self.h}, {self.a.spread('5.0e-01')}")
        divisor = self.a.constant(float(self.parts.stages.divisor))
        self.part = out.emit(f"fdiv {self.a.type} {self.h}, {divisor}")
        self.limit = self.a.spread("%limit")
        self.never = self.a.spread(out.emit(f"sitofp i64 {out.emit('add i64 %steps, 1')} to double"))
        out.do("br label %groups")

    def _groups(self) -> None:
        """Head of the outer loop, and the start of a group."""
        s, out = self.sizes, self.out
        out.do("groups:")
        out.do("%g = phi i64 [ %begin, %entry ], [ %g.next, %finish ]")
        out.do("%g.more = icmp slt i64 %g, %end")
        out.do("br i1 %g.more, label %start, label %leave")
        out.do("start:")
        self.copy(s.state, self.a.at(self.states, out.emit(f"mul i64 %g, {s.state}")), self.base)
        own = self.a.at(self.given, out.emit(f"mul i64 %g, {s.given}"))
        self.copy(s.given, own, self.a.at(self.x, s.state + s.columns))
        zero = "0.0" if self.lanes == 1 else "zeroinitializer"
        for k in range(s.totals):
            self.a.store(self.sums, k, self.never if k == 2 * s.watched else zero)
        self.first = self.a.at(self.records, out.emit(f"mul i64 {out.emit(f'mul i64 %g, {self.count}')}, {s.width}"))
        for k in range(s.memory):
            self.a.store(self.x, s.changing + k, zero)
        self.events.start()
        if self.parts.begin is not None:
            self.copy(s.state, self.base, self.x)
            self.row("0")
            self.events.happens("begin", self.parts.begin, self.events.everywhere())
            self.copy(s.state, self.x, self.base)
            self.events.start()
        out.do("br label %step")

    def _step(self) -> None:
        """Head of the inner loop: events, rates at the beginning of a step, and whether it is recorded."""
        s, out = self.sizes, self.out
        out.do("step:")
        out.do("%i = phi i64 [ 0, %start ], [ %i.next, %advanced ]")
        out.do("%taken = phi i64 [ 0, %start ], [ %taken.next, %advanced ]")
        stop = out.emit(f"icmp ne i64 {out.emit(f'load volatile i64, ptr {self.flag}, align 8')}, 0")
        out.do(f"br i1 {stop}, label %leave, label %stepping")
        out.do("stepping:")
        self.copy(s.state, self.base, self.x)
        self.doubled = out.emit("mul i64 %i, 2")
        self.row("%i" if self.parts.events else self.doubled)
        self.events.before_step()
        self.evaluate()
        for k in range(s.watched):
            w = self.a.load(self.y, s.state + k)
            self.a.store(self.sums, 2 * k, self.larger(self.a.absolute(w), self.a.load(self.sums, 2 * k)))
            self.a.store(self.sums, 2 * k + 1, self.a.fma(w, w, self.a.load(self.sums, 2 * k + 1)))
        over = out.emit("srem i64 %i, %every")
        due = out.emit(f"icmp eq i64 {over}, 0")
        self.last = out.emit("icmp eq i64 %i, %steps")
        take = out.emit(f"or i1 {due}, {self.last}")
        out.do("br label %watched")
        out.do("watched:")
        out.do(f"br i1 {take}, label %record, label %go")

    def _record(self) -> None:
        """Keep state, watched and shown values."""
        s, out = self.sizes, self.out
        out.do("record:")
        place = self.a.at(self.first, out.emit(f"mul i64 %taken, {s.width}"))
        self.copy(s.state, self.base, place)
        for k in range(s.state, s.state + s.watched):
            self.a.store(place, k, self.a.load(self.y, k))
        for k, memory in enumerate(s.shown, start=s.state + s.watched):
            self.a.store(place, k, self.a.load(self.x, s.changing + memory))
        more = out.emit("add i64 %taken, 1")
        out.do("br label %go")
        out.do("go:")
        out.do(f"%taken.next = phi i64 [ %taken, %watched ], [ {more}, %record ]")
        out.do(f"br i1 {self.last}, label %finish, label %advance")

    def _advance(self) -> None:
        """The further stages of a step, and the step onto the loops."""
        s, out, stages = self.sizes, self.out, self.parts.stages
        out.do("advance:")
        nodes = (0.0, *stages.nodes)
        for stage, weight in enumerate(stages.weights):
            if stage > 0:
                length = self.h if nodes[stage] == 1.0 else self.half
                for k in range(s.state):
                    self.a.store(self.x, k, self.a.fma(length, self.a.load(self.y, k), self.a.load(self.base, k)))
                if s.settled:
                    self.settle(within=True)
                if nodes[stage] != nodes[stage - 1] and not self.parts.events:
                    self.row(out.emit(f"add i64 {self.doubled}, {1 if nodes[stage] == 0.5 else 2}"))
                self.evaluate()
            self._sum(stage, weight)
        for k in range(s.state):
            self.a.store(self.x, k, self.a.fma(self.part, self.a.load(self.total, k), self.a.load(self.base, k)))
        if s.settled:
            self.settle()
        self.copy(s.state, self.x, self.base)
        out.do("br label %advanced")
        out.do("advanced:")
        out.do("%i.next = add i64 %i, 1")
        out.do("br label %step")

    def _sum(self, stage: int, weight: int) -> None:
        """Add a slope to the weighted sum."""
        if weight == 0:
            return
        first = not any(self.parts.stages.weights[:stage])
        factor = self.a.constant(float(weight))
        for k in range(self.sizes.state):
            slope = self.a.load(self.y, k)
            if first:
                total = slope if weight == 1 else self.a.mul(factor, slope)
            else:
                total = self.a.load(self.total, k)
                total = self.a.add(total, slope) if weight == 1 else self.a.fma(factor, slope, total)
            self.a.store(self.total, k, total)

    def _finish(self) -> None:
        """Hand out what was kept of a group."""
        s, out = self.sizes, self.out
        out.do("finish:")
        self.copy(s.totals, self.sums, self.a.at(self.results, out.emit(f"mul i64 %g, {s.totals}")))
        out.do("%g.next = add i64 %g, 1")
        out.do("br label %groups")
        out.do("leave:")
        out.do("ret void")
