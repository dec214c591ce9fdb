"""A law behind hardware, as events of a compiled loop: `cutjoint.simulation.hardware` on expressions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cutjoint.arrays import Array
from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.many.instants import together
from cutjoint.compile.many.registers import entries, equations, flat, numbers, register_count, registers
from cutjoint.compile.many.tracing import Actuation, Tracing
from cutjoint.simulation.hardware.equations import Registers
from cutjoint.simulation.hardware.fitted import Fitted
from cutjoint.simulation.hardware.schedule import Stage


class Now(NamedTuple):
    """What events change: registers, the law's memory, and what the law asked for last."""

    registers: Registers
    memory: list[Number]
    asked: list[Number]

    @property
    def numbers(self) -> list[Number]:
        """All of it, in order."""
        return [*flat(self.registers), *self.memory, *self.asked]


class Sampled:
    """The loop behind hardware.

    Attributes:
        fitted: the hardware.
        actuation: what moves the plant.
        symbols: what events change, in the order of `Now.numbers`.
        noise: random numbers of a sample.
        begun: all that is changed before the first step, rotors first.
        events: new values of the symbols, after each list of stages of `together`.
        shown: measured positions and speeds, asked efforts and commands, as symbols, n each.
    """

    def __init__(self, one: Tracing, fitted: Fitted) -> None:
        graph, n = one.graph, fitted.n
        self.one, self.fitted = one, fitted
        self.equations = equations(fitted)
        rotors = graph.symbols(2 * n if fitted.gear is not None else 0)
        held, memory = graph.symbols(register_count(fitted)), graph.symbols(one.law.memory(n))
        asked, self.noise = graph.symbols(n), graph.symbols(fitted.channels)
        self.symbols = [*held, *memory, *asked]
        first = Now(registers(held, fitted), list(memory), list(asked))
        self.actuation = self._actuation(first.registers, rotors)
        self.begun = self._begun(first)
        self.events = [self._after(stages, first, rotors) for stages in together(fitted.ticks)]
        now = first.registers
        shown = [*numbers(now.last), *numbers(now.speed), *asked, *numbers(now.held)]
        self.shown = [x for x in shown if isinstance(x, Expression)]

    def _actuation(self, now: Registers, rotors: list[Expression]) -> Actuation:
        """Efforts of motors, through gears with play where there are any."""
        equations, n = self.equations, self.fitted.n
        q, v = self._joints
        if not rotors:
            return Actuation(numbers(equations.motor(now.held, v)), rotors, [])
        place, speed = entries(rotors[:n]), entries(rotors[n:])
        handed_on = equations.transmitted(place, speed, q, v)
        rates = equations.rotor_rates(equations.motor(now.held, speed), handed_on)
        return Actuation(numbers(handed_on), rotors, [*numbers(speed), *numbers(rates)])

    @property
    def _joints(self) -> tuple[Array, Array]:
        """Where the actuated joints are, and how fast."""
        return entries(self.one.traced.actuated), entries(self.one.v)

    @property
    def _normals(self) -> Array | None:
        return entries(self.noise) if self.noise else None

    def _begun(self, now: Now) -> list[Number]:
        """See `Coupled.begin`: where commands come late or through play, the law has held the robot before."""
        equations, fitted = self.equations, self.fitted
        q, v = self._joints
        begun, rotors = equations.begun(q, v, self._normals), list[Number]()
        now = now._replace(registers=begun, asked=numbers(begun.held))
        if fitted.gear is None and not fitted.ticks.delayed:
            return now.numbers
        seen = equations.seen(begun)
        asked, _ = self._asked(now._replace(registers=seen))
        held = self._held(seen, asked)
        if fitted.gear is not None:
            place, speed = equations.resting(held.held, q, v)
            rotors = [*numbers(place), *numbers(speed)]
            seat = (place, speed) if fitted.at_motor else (q, v)
            held = self._held(equations.begun(seat[0], seat[1], self._normals), asked)
        return [*rotors, *now._replace(registers=held, asked=asked).numbers]

    def _held(self, now: Registers, asked: list[Number]) -> Registers:
        """As if the law had asked for this for long."""
        for _ in now.commands:
            now = self.equations.commanded(now, entries(asked))
        return self.equations.applied(now)

    def _asked(self, now: Now) -> tuple[list[Number], list[Number]]:
        """What the law asks for, and the rate of its memory."""
        last, speed = now.registers.last, now.registers.speed
        own = [x for x in now.memory if isinstance(x, Expression)]
        answer = self.one.answer(numbers(last), numbers(speed), own, self.fitted.limits)
        return answer.asked, answer.memory_rate

    def _after(self, stages: Sequence[Stage], now: Now, rotors: list[Expression]) -> list[Number]:
        """All numbers after some stages."""
        equations, n = self.equations, self.fitted.n
        for stage in stages:
            before = now.registers
            if stage == "capture":
                seat = (entries(rotors[:n]), entries(rotors[n:])) if self.fitted.at_motor else self._joints
                now = now._replace(registers=equations.captured(before, seat[0], seat[1], self._normals))
            elif stage == "compute":
                now = now._replace(registers=equations.seen(before))
                asked, rate = self._asked(now)
                moved = [x + self.fitted.period * dx for x, dx in zip(now.memory, rate, strict=True)]
                now = Now(equations.commanded(now.registers, entries(asked)), moved, asked)
            else:
                now = now._replace(registers=equations.applied(before))
        return now.numbers
