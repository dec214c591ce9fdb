"""What happens between the steps of a run as LLVM assembly, such as the sample instants of a controller.

Each run has instants of its own: a lane takes what an event makes of it where its byte says that the event is due, and
noise only then.  The bytes and the noise are in the table of the loop (`RunLoopText`).
"""

from __future__ import annotations

from cutjoint.compile.machine.kernel import Event, LoopParts
from cutjoint.compile.machine.llvm.lanes import Lanes


class RunEventsText:
    """Writes the events of a loop into it.

    Args:
        a: writes instructions; all values that the events read or write are in its lanes.
        parts: of the loop.
        x, y: arguments and results of its functions.
        noise: where the arguments have noise.
        clocks, rows: addresses of the tables with the addresses of each lane's due bytes, and of its noise.
    """

    def __init__(self, a: Lanes, parts: LoopParts, x: str, y: str, noise: int, clocks: str, rows: str) -> None:
        self.a, self.out, self.lanes = a, a.out, a.lanes
        self.parts, self.sizes, self.noise = parts, parts.sizes, noise
        self.x, self.y, self.all_clocks, self.all_noise = x, y, clocks, rows
        self.drawn = self.out.emit(f"alloca ptr, i64 {self.lanes}, align 8")
        self.clocks: list[str] = []

    def before_step(self) -> None:
        """All that falls due before this step."""
        if not self.parts.events:
            return
        out, lanes = self.out, self.lanes
        kind = "i8" if lanes == 1 else f"<{lanes} x i8>"
        due = "poison"
        for lane, pointer in enumerate(self.clocks):
            one = out.emit(f"load i8, ptr {out.emit(f'getelementptr i8, ptr {pointer}, i64 %i')}, align 1")
            due = one if lanes == 1 else out.emit(f"insertelement {kind} {due}, i8 {one}, i32 {lane}")
        for k, event in enumerate(self.parts.events):
            bit = str(1 << k) if lanes == 1 else "<" + ", ".join([f"i8 {1 << k}"] * lanes) + ">"
            nothing = "0" if lanes == 1 else "zeroinitializer"
            mask = out.emit(f"icmp ne {kind} {out.emit(f'and {kind} {due}, {bit}')}, {nothing}")
            some = mask
            if lanes > 1:
                some = out.emit(f"icmp ne i{lanes} {out.emit(f'bitcast {self.a.boolean} {mask} to i{lanes}')}, 0")
            out.do(f"br i1 {some}, label %happens{k}, label %happened{k}")
            out.do(f"happens{k}:")
            self.happens(f"event{k}", event, mask)
            out.do(f"br label %happened{k}")
            out.do(f"happened{k}:")

    def happens(self, symbol: str, event: Event, mask: str) -> None:
        """An event in the lanes of a mask."""
        out, a = self.out, self.a
        if event.draws:
            self._draw(mask)
        out.do(f"call void @{symbol}(ptr {self.x}, ptr {self.y})")
        for place, target in enumerate(event.targets):
            a.store(self.x, target, a.choose(mask, a.load(self.y, place), a.load(self.x, target)))

    def _draw(self, mask: str) -> None:
        """The next row of noise of every lane; those of the mask go on to the row after it."""
        out, a, noise = self.out, self.a, self.sizes.noise
        values = ["poison"] * noise
        for lane in range(self.lanes):
            place = out.emit(f"getelementptr ptr, ptr {self.drawn}, i64 {lane}")
            row = out.emit(f"load ptr, ptr {place}, align 8")
            for k in range(noise):
                at = out.emit(f"getelementptr double, ptr {row}, i64 {k}")
                one = out.emit(f"load double, ptr {at}, align 8")
                fill = f"insertelement {a.type} {values[k]}, double {one}, i32 {lane}"
                values[k] = one if self.lanes == 1 else out.emit(fill)
            now = mask if self.lanes == 1 else out.emit(f"extractelement {a.boolean} {mask}, i32 {lane}")
            step = out.emit(f"select i1 {now}, i64 {noise}, i64 0")
            out.do(f"store ptr {out.emit(f'getelementptr double, ptr {row}, i64 {step}')}, ptr {place}, align 8")
        for k, value in enumerate(values):
            a.store(self.x, self.noise + k, value)

    def start(self) -> None:
        """The group's due bytes, and the beginning of its noise."""
        out, self.clocks = self.out, list[str]()
        if not self.parts.events:
            return
        lane0 = out.emit(f"mul i64 %g, {self.lanes}")
        for lane in range(self.lanes):
            index = out.emit(f"add i64 {lane0}, {lane}")
            clock, noise = (
                out.emit(f"load ptr, ptr {out.emit(f'getelementptr ptr, ptr {x}, i64 {index}')}, align 8")
                for x in (self.all_clocks, self.all_noise)
            )
            self.clocks.append(clock)
            out.do(f"store ptr {noise}, ptr {out.emit(f'getelementptr ptr, ptr {self.drawn}, i64 {lane}')}, align 8")

    def everywhere(self) -> str:
        """A mask of all lanes."""
        return "true" if self.lanes == 1 else "<" + ", ".join(["i1 true"] * self.lanes) + ">"
