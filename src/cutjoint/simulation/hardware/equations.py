"""The equations of a sampled loop: what sensors read, what the law is shown, what drives and gears make of its answer.

They are written once, for `run` on arrays of floats and for compiled loops on arrays of expressions: every operation is
+ - *, or one of the namespace `fn`, entry by entry.  Nothing is changed: registers go in, new registers come out.

    capture     reading = step nearest(( position + offset + noise) / step); into the shift register of readings
    compute     the reading of so many periods ago; speed = speed + alpha ((reading - last one) / period - speed) with
                alpha = 1 - exp(-2 pi cutoff period); the law's answer, rounded to a step of the drive and held within
                its limits, goes into the shift register of commands
    apply       the command of so many periods ago takes effect
    always      the motor gives what of the command its speed allows; a gear with play gives the joint
                stiffness x + damping x', x how far the motor is beyond the play, and never pulls
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from cutjoint.arrays import Array
from cutjoint.simulation.hardware.fitted import Fitted


class Entrywise(Protocol):
    """The functions that the equations need, entry by entry."""

    def nearest(self, x: Array, /) -> Array:
        """The nearest whole number; of two that are as near, the even one."""

    def minimum(self, a: Array, b: Array, /) -> Array:
        """The smaller one."""

    def maximum(self, a: Array, b: Array, /) -> Array:
        """The larger one."""

    def where_less(self, a: Array, b: Array, x: Array, y: Array, /) -> Array:
        """x where a < b, else y."""


class _Floats:
    """On arrays of floats."""

    def nearest(self, x: Array, /) -> Array:
        return np.rint(x)

    def minimum(self, a: Array, b: Array, /) -> Array:
        return np.minimum(a, b)

    def maximum(self, a: Array, b: Array, /) -> Array:
        return np.maximum(a, b)

    def where_less(self, a: Array, b: Array, x: Array, y: Array, /) -> Array:
        return np.where(a < b, x, y)


FLOATS: Entrywise = _Floats()


class Registers(NamedTuple):
    """What a sampled loop remembers from one instant to the next; arrays of shape (n,).

    Attributes:
        readings: of positions, the newest first; one more than the measurement's whole periods of delay.
        speeds: of a tachometer likewise; none where speeds are differences.
        last: the reading that the law saw last.
        speed: what it saw as speed.
        commands: the newest first; one more than the command's whole periods of delay.
        held: the command in effect.
    """

    readings: tuple[Array, ...]
    speeds: tuple[Array, ...]
    last: Array
    speed: Array
    commands: tuple[Array, ...]
    held: Array


class LoopEquations:
    """The equations of one loop.

    Args:
        fitted: the hardware, for n actuators.
        fn: the functions to use.
    """

    def __init__(self, fitted: Fitted, fn: Entrywise = FLOATS) -> None:
        self.fitted, self.fn = fitted, fn

    def read(self, q: Array, v: Array, normals: Array | None) -> tuple[Array, Array]:
        """What the sensors say of position and speed; `normals` are standard normal numbers, shape (channels,)."""
        fitted, used = self.fitted, 0
        if fitted.offset is not None:
            q = q + fitted.offset
        if fitted.noise is not None and normals is not None:
            q, used = q + fitted.noise * normals[: fitted.n], fitted.n
        if fitted.step is not None:
            q = self.fn.nearest(q * (1.0 / fitted.step)) * fitted.step
        if fitted.speed_noise is not None and normals is not None:
            v = v + fitted.speed_noise * normals[used:]
        return q, v

    def begun(self, q: Array, v: Array, normals: Array | None) -> Registers:
        """The registers of a loop that has stood at `q`; speeds are those at `v`, differences are 0."""
        fitted = self.fitted
        reading, speed = self.read(q, v, normals)
        places, nothing = fitted.ticks.seen_after + 1, 0.0 * reading
        speeds = () if fitted.differences else (speed,) * places
        commands = (nothing,) * (fitted.ticks.acts_after + 1)
        return Registers((reading,) * places, speeds, reading, nothing, commands, nothing)

    def captured(self, memory: Registers, q: Array, v: Array, normals: Array | None) -> Registers:
        """The sensors are read."""
        reading, speed = self.read(q, v, normals)
        speeds = (speed, *memory.speeds[:-1]) if memory.speeds else ()
        return memory._replace(readings=(reading, *memory.readings[:-1]), speeds=speeds)

    def seen(self, memory: Registers) -> Registers:
        """The law is shown `last` and `speed`."""
        reading = memory.readings[-1]
        if memory.speeds:
            return memory._replace(last=reading, speed=memory.speeds[-1])
        raw = (reading - memory.last) * self.fitted.rate
        speed = raw if self.fitted.cutoff is None else memory.speed + self.fitted.filter_part * (raw - memory.speed)
        return memory._replace(last=reading, speed=speed)

    def saturated(self, asked: Array) -> Array:
        """`asked` within the limits of the drive."""
        top = self.fitted.limits
        return asked if top is None else self.fn.minimum(self.fn.maximum(asked, -top), top)

    def commanded(self, memory: Registers, asked: Array) -> Registers:
        """The law has `asked` for efforts."""
        step = self.fitted.command_step
        given = asked if step is None else self.fn.nearest(asked * (1.0 / step)) * step
        return memory._replace(commands=(self.saturated(given), *memory.commands[:-1]))

    def applied(self, memory: Registers) -> Registers:
        """A command takes effect."""
        return memory._replace(held=memory.commands[-1])

    def motor(self, command: Array, v: Array) -> Array:
        """Effort of motors that move at `v`."""
        fitted = self.fitted
        if fitted.stall is None or fitted.no_load_speed is None:
            return command
        part = v * (1.0 / fitted.no_load_speed)
        top, bottom = fitted.stall * (1.0 - part), -fitted.stall * (1.0 + part)
        return self.fn.minimum(self.fn.maximum(command, bottom), top)

    def transmitted(self, rotor_q: Array, rotor_v: Array, q: Array, v: Array) -> Array:
        """Effort that gears with play hand from their rotors to the joints."""
        fn, gear = self.fn, self.fitted.gear
        assert gear is not None, "there are rotors only where there is play"
        ahead = rotor_q - q
        beyond = ahead - fn.minimum(fn.maximum(ahead, -gear.half), gear.half)
        push, nothing = gear.stiffness * beyond + gear.damping * (rotor_v - v), 0.0 * beyond
        backward = fn.where_less(beyond, nothing, fn.minimum(push, nothing), nothing)
        return fn.where_less(nothing, beyond, fn.maximum(push, nothing), backward)

    def rotor_rates(self, effort: Array, handed_on: Array) -> Array:
        """Acceleration of the rotors under the `effort` of their motors."""
        gear = self.fitted.gear
        assert gear is not None, "there are rotors only where there is play"
        return (effort - handed_on) * (1.0 / gear.rotor)

    def resting(self, command: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Positions and speeds of rotors that hold their joints under a command."""
        fn, gear = self.fn, self.fitted.gear
        assert gear is not None, "there are rotors only where there is play"
        effort = self.motor(command, v)
        nothing = 0.0 * effort
        side = fn.where_less(effort, nothing, -gear.half, fn.where_less(nothing, effort, gear.half, nothing))
        return q + side + effort * (1.0 / gear.stiffness), v
