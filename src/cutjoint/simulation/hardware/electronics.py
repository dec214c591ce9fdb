"""The hardware of one run: its registers, its clock and its chance."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from cutjoint.arrays import Array
from cutjoint.simulation.hardware.equations import LoopEquations
from cutjoint.simulation.hardware.fitted import Fitted
from cutjoint.simulation.hardware.noise import Jitter, Noise
from cutjoint.simulation.hardware.schedule import Schedule, Stage
from cutjoint.simulation.hardware.values import Hardware

AT_ONCE = 256
"""Samples whose noise is drawn at a time."""


class Signals(NamedTuple):
    """What passes between law and joints at one instant, arrays of shape (n,): what the law saw last of positions and
    speeds, what it asked for then, the command in effect; and the rotors before gears with play, if there are any."""

    measured_q: Array
    measured_v: Array
    asked: Array
    command: Array
    rotor_q: Array | None
    rotor_v: Array | None


class Electronics:
    """What is between law and joints.

    Args:
        hardware: as values.
        n: number of actuators.
        run: its number, which picks noise and jitter.

    Attributes:
        schedule: when something happens.
        equations: what happens.
        rotors: numbers of state of the rotors: 2 n with play, else 0.
    """

    def __init__(self, hardware: Hardware, n: int, run: int) -> None:
        fitted = Fitted(hardware, n)
        self.equations = LoopEquations(fitted)
        self.schedule = Schedule(fitted.ticks, Jitter(hardware.seed, run, fitted.ticks.jitter))
        self.rotors = 0 if fitted.gear is None else 2 * n
        self._noise = Noise(hardware.seed, run, fitted.channels)
        self._drawn: deque[Array] = deque()

    def begin(self, q: Array, v: Array) -> None:
        """A loop that has stood at `q`, shape (n,); with no command yet."""
        self._memory = self.equations.begun(q, v, self._normals())
        self._asked = self._memory.held

    def hold(self, asked: Array) -> None:
        """As if the law had `asked` for this for long."""
        for _ in self._memory.commands:
            self.command(asked)
        self.apply()

    def due(self) -> list[Stage]:
        """The stages of the instant that has come."""
        return self.schedule.due()

    def capture(self, q: Array, v: Array) -> None:
        """The sensors are at `q` and `v`, shape (n,) each."""
        self._memory = self.equations.captured(self._memory, q, v, self._normals())
        if self._drawn:
            self._drawn.popleft()

    def see(self) -> tuple[Array, Array]:
        """What the law is shown of positions and speeds, shape (n,) each."""
        self._memory = self.equations.seen(self._memory)
        return self._memory.last, self._memory.speed

    def command(self, asked: Array) -> None:
        """The law has asked."""
        self._asked, self._memory = asked, self.equations.commanded(self._memory, asked)

    def apply(self) -> None:
        """A command takes effect."""
        self._memory = self.equations.applied(self._memory)

    @property
    def holds(self) -> bool:
        """Whether efforts at the joints only change at instants, not with the motion."""
        fitted = self.equations.fitted
        return not self.rotors and (fitted.stall is None or fitted.no_load_speed is None)

    @property
    def held(self) -> Array:
        """The command in effect, shape (n,)."""
        return self._memory.held

    def effort(self, q: Array, v: Array, rotors: Array) -> tuple[Array, Array]:
        """Effort at the joints, shape (n,), and the rate of the `rotors` (positions, then speeds)."""
        n, held = q.size, self._memory.held
        if not rotors.size:
            return self.equations.motor(held, v), rotors
        rate, speed = rotors.copy(), rotors[n:]
        handed_on = self.equations.transmitted(rotors[:n], speed, q, v)
        rate[:n], rate[n:] = speed, self.equations.rotor_rates(self.equations.motor(held, speed), handed_on)
        return handed_on, rate

    def resting(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Positions and speeds of rotors that hold their joints."""
        return self.equations.resting(self._memory.held, q, v)

    def signals(self, rotors: Array) -> Signals:
        """What to record."""
        memory, n = self._memory, rotors.size // 2
        own = (rotors[:n], rotors[n:]) if n else (None, None)
        return Signals(memory.last, memory.speed, self._asked, memory.held, *own)

    def _normals(self) -> Array | None:
        """Of the sample that comes next."""
        if not self._noise.channels:
            return None
        if not self._drawn:
            self._drawn.extend(self._noise.rows(AT_ONCE))
        return self._drawn[0]
