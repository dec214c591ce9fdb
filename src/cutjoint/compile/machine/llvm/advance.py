"""An integrator as LLVM assembly: from one sample to the next, with the error of every step under control.

The pair of orders 5 and 4 by J. R. Dormand and P. J. Prince (A family of embedded Runge-Kutta formulae, J. Comput.
Appl. Math. 6 (1980) 19-26), the solution of order 5 carried on; steps as in E. Hairer, S. P. Norsett, G. Wanner,
Solving Ordinary Differential Equations I, section II.4.
"""

from __future__ import annotations

from cutjoint.compile.machine.kernel import MotionPrograms
from cutjoint.compile.machine.llvm.lanes import Lanes, Writer

WEIGHTS = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
SAFETY, LEAST, MOST = 0.9, 0.2, 5.0
"""What a step is shortened by, and how much shorter or longer than the last one it may be."""
SHORTEST = 1e-9
"""Steps shorter than this part of the span get nowhere."""


class AdvanceText:
    """`int64 symbol(double *state, double *given, double *found, double *h, double span, double relative, double
    absolute, double limit)`.

    Carries `state` (positions, velocities, works) on by `span` under what is `given` (efforts, parameters) all the
    time, with steps that begin with `h`, which is then what the next one should begin with.  Works steer the steps too:
    where a joint meets its stop or turns round they are the first to notice.  Positions are put onto the loops at the
    end.  `found` is what the loops were open by before that, and after, and what else is asked for of the last state.
    Returns the number of evaluations; -1 where there is no step that may be trusted.

    Calls `rate(x, y)` with x = positions, velocities, given and y = rates of the state, what is asked for, strain; and,
    where there are loops, `settle(x, y)` with x = positions, target, parameters and y = positions, residual, strain.
    """

    def __init__(self, symbol: str, motion: MotionPrograms) -> None:
        self.symbol, self.motion = symbol, motion
        self.out = Writer()
        self.a = Lanes(self.out, 1)
        self.count = motion.positions + motion.velocities
        self.all = motion.integrated

    def text(self) -> str:
        """The whole function."""
        self._entry()
        self._step()
        self._judge()
        self._finish()
        head = (
            "ptr %state, ptr %given, ptr %found, ptr %h, double %span, double %relative, double %absolute, "
            "double %limit"
        )
        body = "\n".join(self.out.lines)
        return f"define i64 @{self.symbol}({head}) #0 {{\n{body}\n}}\n"

    def copy(self, count: int, source: str, target: str) -> None:
        """Copy numbers from one place to another."""
        for k in range(count):
            self.a.store(target, k, self.a.load(source, k))

    def larger(self, x: str, y: str) -> str:
        """The larger one; not a number if one of them is not."""
        test = self.out.emit(f"fcmp ugt double {x}, {y}")
        chosen = self.out.emit(f"select i1 {test}, double {x}, double {y}")
        ordered = self.out.emit(f"fcmp ord double {y}, {y}")
        return self.out.emit(f"select i1 {ordered}, double {chosen}, double {y}")

    def number(self, value: float) -> str:
        """A literal."""
        return self.a.constant(value)

    def summed(self, weights: tuple[float, ...], k: int) -> str:
        """A weighted sum of the slopes of number `k`."""
        total = ""
        for weight, slope in zip(weights, self.slopes, strict=False):
            if weight:
                one, factor = self.a.load(slope, k), self.number(weight)
                total = self.a.fma(factor, one, total) if total else self.a.mul(factor, one)
        return total

    def evaluate(self, slope: str) -> str:
        """Rates at the arguments into `slope`; returns the strain."""
        self.out.do(f"call void @rate(ptr {self.x}, ptr {self.y})")
        self.copy(self.all, self.y, slope)
        return self.a.load(self.y, self.all + self.motion.more)

    # -- the function, block by block --------------------------------------------------------------------------------

    def _entry(self) -> None:
        """Room, and the slope at the start."""
        out, a, count, motion = self.out, self.a, self.count, self.motion
        out.do("entry:")
        self.x, self.y = a.room(count + motion.given), a.room(motion.rate.n_out)
        self.slopes = [a.room(self.all) for _ in WEIGHTS]
        self.after = a.room(self.all)
        self.place, self.put = a.room(self.motion.settle_in), a.room(self.motion.settle_out)
        self.copy(count, "%state", self.x)
        self.copy(self.motion.given, "%given", a.at(self.x, count))
        strain = self.evaluate(self.slopes[0])
        first = a.load("%h", 0)
        fits = out.emit(f"fcmp ole double {strain}, %limit")
        out.do(f"br i1 {fits}, label %step, label %failed")
        out.do("step:")
        out.do("%t = phi double [ 0.0, %entry ], [ %t.next, %accepted ], [ %t, %rejected ]")
        out.do(f"%ask = phi double [ {first}, %entry ], [ %ask.next, %accepted ], [ %shorter, %rejected ]")
        out.do("%calls = phi i64 [ 1, %entry ], [ %calls.next, %accepted ], [ %calls.next, %rejected ]")

    def _step(self) -> None:
        """One step that is tried."""
        out, a = self.out, self.a
        out.do("%rest = fsub double %span, %t")
        near = a.mul("%rest", self.number(1.0 - 1e-12))
        out.do(f"%last = fcmp oge double %ask, {near}")
        out.do("%step.h = select i1 %last, double %rest, double %ask")
        out.do("%calls.next = add i64 %calls, 6")
        strain = self.number(0.0)
        for stage in range(1, len(WEIGHTS)):
            to_end = stage == len(WEIGHTS) - 1
            for k in range(self.all if to_end else self.count):
                moved = a.fma("%step.h", self.summed(WEIGHTS[stage], k), a.load("%state", k))
                if k < self.count:
                    a.store(self.x, k, moved)
                if to_end:
                    a.store(self.after, k, moved)
            strain = self.larger(self.evaluate(self.slopes[stage]), strain)
        self.strain = strain

    def _judge(self) -> None:
        """Whether the step is small enough, and how long the next one should be."""
        out, a = self.out, self.a
        worst = self.number(0.0)
        for k in range(self.all):
            error = a.absolute(a.mul("%step.h", self.summed(ERROR, k)))
            before, after = a.absolute(a.load("%state", k)), a.absolute(a.load(self.after, k))
            allowed = a.fma("%relative", self.larger(before, after), "%absolute")
            worst = self.larger(out.emit(f"fdiv double {error}, {allowed}"), worst)
        small = out.emit(f"fcmp ole double {worst}, {self.number(1.0)}")
        fits = out.emit(f"fcmp ole double {self.strain}, %limit")
        good = out.emit(f"and i1 {small}, {fits}")
        some = self.larger(worst, self.number(1e-9))
        power = out.emit(f"call double @pow(double {some}, double {self.number(-0.2)})")
        factor = a.mul(power, self.number(SAFETY))
        for test, bound in (("ogt", LEAST), ("olt", MOST)):
            within = out.emit(f"fcmp {test} double {factor}, {self.number(bound)}")
            factor = out.emit(f"select i1 {within}, double {factor}, double {self.number(bound)}")
        known = out.emit(f"select i1 {fits}, double {factor}, double {self.number(LEAST)}")
        out.do(f"%ahead = fmul double %step.h, {known}")
        out.do(f"br i1 {good}, label %accepted, label %rejected")
        out.do("rejected:")
        shorter = out.emit(f"fcmp olt double {known}, {self.number(SAFETY)}")
        least = a.mul("%step.h", self.number(SAFETY))
        out.do(f"%shorter = select i1 {shorter}, double %ahead, double {least}")
        floor = a.mul("%span", self.number(SHORTEST))
        going = out.emit(f"fcmp ogt double %shorter, {floor}")
        out.do(f"br i1 {going}, label %step, label %failed")
        out.do("accepted:")
        self.copy(self.all, self.after, "%state")
        self.copy(self.all, self.slopes[-1], self.slopes[0])
        out.do("%t.next = fadd double %t, %step.h")
        longer = out.emit("fcmp ogt double %ask, %ahead")
        kept = out.emit(f"and i1 {longer}, %last")
        out.do(f"%ask.next = select i1 {kept}, double %ask, double %ahead")
        out.do("br i1 %last, label %arrived, label %step")

    def _finish(self) -> None:
        """Onto the loops."""
        out, a, motion = self.out, self.a, self.motion
        out.do("arrived:")
        a.store("%h", 0, "%ask.next")
        self.copy(motion.more, a.at(self.y, self.all), a.at("%found", 2 * motion.rows))
        if motion.settled:
            parameters = a.at("%given", motion.given - motion.parameters)
            held = [a.load("%state", k) for k in motion.actuated]
            for k, value in enumerate(held):
                a.store(self.place, motion.positions + k, value)
            self.copy(motion.parameters, parameters, a.at(self.place, motion.positions + len(held)))
            for part in range(2):
                self.copy(motion.positions, "%state", self.place)
                out.do(f"call void @settle(ptr {self.place}, ptr {self.put})")
                self.copy(motion.rows, a.at(self.put, motion.positions), a.at("%found", part * motion.rows))
                if part == 0:
                    self.copy(motion.positions, self.put, "%state")
        out.do("ret i64 %calls.next")
        out.do("failed:")
        out.do("ret i64 -1")
