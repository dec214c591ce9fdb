"""A block under a sampled loop, by another way: the motion between two instants is a parabola, everything that was
measured and commanded is kept in lists, and what is late is looked up there.

Nothing of the package is used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field


@dataclass
class SampledBlock:
    """One block [kg]; times [s].

    Attributes:
        edges: when the sensors are read.
        seen_periods, seen_rest: delay of the measurement: whole periods and the rest.
        acts_periods, acts_rest: delay of the command.
        law: (time, position, speed) -> effort.
        step, offset, cutoff: of encoder and filter; step 0 for none, cutoff None for none.
        top, command_step: of the drive; inf and 0 for none.
        noise: of the encoder, one number a sample.
    """

    mass: float
    period: float
    edges: Sequence[float]
    law: Callable[[float, float, float], float]
    seen_periods: int = 0
    seen_rest: float = 0.0
    acts_periods: int = 0
    acts_rest: float = 0.0
    step: float = 0.0
    offset: float = 0.0
    differences: bool = False
    cutoff: float | None = None
    top: float = math.inf
    command_step: float = 0.0
    noise: Sequence[float] = ()
    readings: list[tuple[float, float]] = field(default_factory=list)
    commands: list[float] = field(default_factory=list)

    def run(self, q: float, v: float, times: Sequence[float]) -> list[tuple[float, float, float]]:
        """Position, speed and effort in effect at `times`, from (q, v) at 0."""
        instants = []
        for k, edge in enumerate(self.edges):
            instants.append((edge, 3 * k, "read", k))
            instants.append((edge + self.seen_rest, 3 * k + 1, "ask", k))
            instants.append((edge + self.seen_rest + self.acts_rest, 3 * k + 2, "act", k))
        instants += [(time, math.inf, "record", 0) for time in times]
        instants.sort(key=lambda one: (round(one[0], 12), one[1]))
        self.speed, self.last = 0.0, None
        self.first = self.read(q, v, 0)
        force = self.ask(0.0, -1) if self.late else 0.0
        self.before, self.speed, self.last = force, 0.0, None
        now, found = 0.0, []
        for time, _, what, k in instants:
            h = time - now
            q, v, now = q + h * v + 0.5 * h * h * force / self.mass, v + h * force / self.mass, time
            if what == "read":
                self.readings.append(self.read(q, v, k))
            elif what == "ask":
                self.commands.append(self.ask(time, k))
            elif what == "act":
                force = self.commands[k - self.acts_periods] if k >= self.acts_periods else self.before
            else:
                found.append((q, v, force))
        return found

    @property
    def late(self) -> bool:
        return bool(self.seen_periods or self.seen_rest or self.acts_periods or self.acts_rest)

    def read(self, q: float, v: float, k: int) -> tuple[float, float]:
        shown = q + self.offset + (self.noise[k] if self.noise else 0.0)
        return (round(shown / self.step) * self.step if self.step else shown), v

    def ask(self, time: float, k: int) -> float:
        which = k - self.seen_periods
        place, speed = self.readings[which] if which >= 0 else self.first
        if self.differences:
            raw = 0.0 if self.last is None else (place - self.last) / self.period
            part = 1.0 if self.cutoff is None else 1.0 - math.exp(-2.0 * math.pi * self.cutoff * self.period)
            self.speed = (1.0 - part) * self.speed + part * raw
            self.last, speed = place, self.speed
        asked = self.law(time, place, speed)
        if self.command_step:
            asked = round(asked / self.command_step) * self.command_step
        return max(-self.top, min(self.top, asked))
