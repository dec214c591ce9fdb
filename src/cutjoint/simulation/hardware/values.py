"""What stands between a control law and the joints of a built machine: clock, sensors, drives.

All are values; what is 0 or None is ideal.  A number stands for all actuators alike, several are one an actuator.
Lengths and angles in [m] or [rad], efforts in [N] or [N m], as the actuator slides or turns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import UnionType
from typing import Literal, TypeAlias, get_args

import numpy as np

from cutjoint.arrays import LARGEST, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.simulation.hardware.ticks import Ticks, ticks_of

FINEST_STEP = 1e-100
"""Below it a step is 0: how many of them there are cannot be told."""

Each: TypeAlias = float | Sequence[float]
"""One number for all actuators, or one an actuator."""


@door
@dataclass(frozen=True)
class Clock:
    """When the controller works.

    Attributes:
        rate: samples a second [Hz].
        jitter: most that a sample is early or late [s]; every one is by a random number of ticks, all as likely.
        tick: of the controller's clock [s]; samples, jitter and delays are whole ticks.  Default the period, which does
            where there is no jitter and delays are whole periods.

    Raises:
        InputError: a rate or tick that is not positive, jitter of half a period or more.
    """

    rate: float
    jitter: float = 0.0
    tick: float | None = None

    __repr__ = line(rate="Hz", jitter="s", tick="s")

    def __post_init__(self) -> None:
        _keep(self, "rate", positive("rate of the clock", self.rate, "Hz"))
        _keep(self, "jitter", _plain("jitter of the clock", self.jitter, "s"))
        if self.tick is not None:
            _keep(self, "tick", positive("tick of the clock", self.tick, "s"))
        if 2.0 * self.jitter >= self.period:
            raise InputError(
                f"jitter of {self.jitter:g} s is half the period of {self.period:g} s or more, so samples would change "
                "places; give less jitter or a lower rate"
            )

    @property
    def period(self) -> float:
        """Between two samples, without jitter [s]."""
        return 1.0 / self.rate


@door
@dataclass(frozen=True)
class Encoder:
    """What measures the position of an actuator: the nearest step to position + offset + noise.

    Attributes:
        resolution: one step, [m] or [rad]; None for as fine as the numbers are.
        offset: error of the zero, [m] or [rad].
        noise: standard deviation, before the steps, [m] or [rad].
        delay: until the controller has a measurement [s]; that of the speed too.
        at: whether it sits at the joint, or at the motor, before the play of a gear.

    Raises:
        InputError: a resolution that is not positive, negative noise or delay.
    """

    resolution: Each | None = None
    offset: Each = 0.0
    noise: Each = 0.0
    delay: float = 0.0
    at: Literal["joint", "motor"] = "joint"

    __repr__ = line(resolution="m or rad", offset="m or rad", noise="m or rad", delay="s")

    def __post_init__(self) -> None:
        if self.resolution is not None:
            mend = "; leave it out for an encoder without steps"
            _keep(self, "resolution", _each("resolution of the encoder", self.resolution, above=FINEST_STEP, mend=mend))
        _keep(self, "offset", _each("offset of the encoder", self.offset, least=-math.inf))
        _keep(self, "noise", _each("noise of the encoder", self.noise))
        _keep(self, "delay", _plain("delay of the encoder", self.delay, "s"))
        if self.at not in ("joint", "motor"):
            raise InputError(f"an encoder sits at the joint or at the motor, found at={self.at!r}")


@door
@dataclass(frozen=True)
class Differences:
    """Speed as the difference of two measured positions over a period, and a low pass of first order.

    Attributes:
        cutoff: where the filter has lost 3 dB [Hz]; None for no filter.

    Raises:
        InputError: a cutoff that is not positive.
    """

    cutoff: float | None = None

    __repr__ = line(cutoff="Hz")

    def __post_init__(self) -> None:
        if self.cutoff is not None:
            _keep(self, "cutoff", positive("cutoff of the filter", self.cutoff, "Hz"))


@door
@dataclass(frozen=True)
class Tachometer:
    """Speed as it is.

    Attributes:
        noise: standard deviation, [m/s] or [rad/s].

    Raises:
        InputError: negative noise.
    """

    noise: Each = 0.0

    __repr__ = line(noise="m/s or rad/s")

    def __post_init__(self) -> None:
        _keep(self, "noise", _each("noise of the tachometer", self.noise))


@door
@dataclass(frozen=True)
class TorqueSpeed:
    """What a motor at full voltage can give: a line from the stall effort at rest to nothing at the no-load speed.

    The effort stays within -stall (1 + v/v0) and stall (1 - v/v0).  What brakes may be more than the stall effort, as
    far as the limits of the drive let it.

    Attributes:
        stall: effort at rest, [N] or [N m].
        no_load_speed: of the actuator, [m/s] or [rad/s].

    Raises:
        InputError: one of them is not positive.
    """

    stall: Each
    no_load_speed: Each

    __repr__ = line(stall="N or N m", no_load_speed="m/s or rad/s")

    def __post_init__(self) -> None:
        _keep(self, "stall", _each("stall effort of the motor", self.stall, above=0.0))
        _keep(self, "no_load_speed", _each("no-load speed of the motor", self.no_load_speed, above=0.0))


@door
@dataclass(frozen=True)
class Backlash:
    """Play in the gear between motor and joint; outside of it a spring and damper that push and never pull.

    All as seen from the joint: a rotor of inertia J behind a gear of ratio N weighs N^2 J.

    Attributes:
        width: of the play from end to end, [m] or [rad].
        stiffness: of the gear, [N/m] or [N m/rad].
        damping: of the gear, [N s/m] or [N m s/rad].
        rotor: inertia of the motor before the play, [kg] or [kg m2].

    Raises:
        InputError: a negative width or damping, stiffness or rotor that are not positive.
    """

    width: Each
    stiffness: Each
    damping: Each
    rotor: Each

    __repr__ = line(width="m or rad", stiffness="N/m or N m/rad", damping="N s/m or N m s/rad", rotor="kg or kg m2")

    def __post_init__(self) -> None:
        _keep(self, "width", _each("width of the backlash", self.width))
        _keep(self, "stiffness", _each("stiffness of the backlash", self.stiffness, above=0.0))
        _keep(self, "damping", _each("damping of the backlash", self.damping))
        _keep(self, "rotor", _each("rotor of the backlash", self.rotor, above=0.0))


@door
@dataclass(frozen=True)
class Drive:
    """What makes an effort of a command: rounded to a step, held within limits, late, through motor and gear.

    Attributes:
        limits: largest |effort|, [N] or [N m]; None for none.
        resolution: one step of the command, [N] or [N m]; None for as fine as the numbers are.
        delay: until a command acts [s].
        torque_speed: what the motor can give at its speed; None for anything.
        backlash: play in the gear; None for none.

    Raises:
        InputError: limits or a resolution that are not positive, a negative delay.
    """

    limits: Each | None = None
    resolution: Each | None = None
    delay: float = 0.0
    torque_speed: TorqueSpeed | None = None
    backlash: Backlash | None = None

    __repr__ = line(limits="N or N m", resolution="N or N m", delay="s")

    def __post_init__(self) -> None:
        if self.limits is not None:
            _keep(self, "limits", _each("limits", self.limits, above=0.0, mend="; leave them out for a drive without"))
        if self.resolution is not None:
            mend = "; leave it out for commands without steps"
            _keep(self, "resolution", _each("resolution of the drive", self.resolution, above=FINEST_STEP, mend=mend))
        _keep(self, "delay", _plain("delay of the drive", self.delay, "s"))
        for name, kind in (("torque_speed", TorqueSpeed), ("backlash", Backlash)):
            if getattr(self, name) is not None:
                _kind(f"{name} of the drive", getattr(self, name), kind)


@dataclass(frozen=True)
class Hardware:
    """All that stands between a control law and the joints.

    Attributes:
        clock: when the controller works.
        encoder: how it sees positions.
        speed: how it sees speeds.
        drive: how its commands become efforts.
        seed: of noise and jitter.

    Raises:
        InputError: a tick that does not divide period, jitter and delays; jitter that lets parts of two samples
            overlap; a seed that is no whole number >= 0.
    """

    clock: Clock
    encoder: Encoder = field(default_factory=Encoder)
    speed: Differences | Tachometer = field(default_factory=Tachometer)
    drive: Drive = field(default_factory=Drive)
    seed: int = 0

    __repr__ = line()

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not isinstance(self.seed, int | np.integer) or self.seed < 0:
            raise InputError(f"a seed is a whole number >= 0, found {self.seed!r}")
        _keep(self, "seed", int(self.seed))
        parts = (("clock", Clock), ("encoder", Encoder), ("speed", Differences | Tachometer), ("drive", Drive))
        for name, kind in parts:
            _kind(f"{name} of hardware", getattr(self, name), kind)
        self.ticks  # noqa: B018  it raises

    @property
    def ticks(self) -> Ticks:
        """Period, jitter and delays in whole ticks."""
        clock = self.clock
        return ticks_of(clock.period, clock.jitter, clock.tick, self.encoder.delay, self.drive.delay)


def _keep(value: object, name: str, checked: object) -> None:
    object.__setattr__(value, name, checked)


def _kind(name: str, value: object, kind: type | UnionType) -> None:
    """Raises InputError where a part is something else."""
    if not isinstance(value, kind):
        wanted = " or ".join(one.__name__ for one in get_args(kind) or (kind,))
        raise InputError(f"{name} must be of {wanted}, found {value!r}")


def _plain(name: str, value: float, unit: str) -> float:
    """`value` as a finite float >= 0."""
    wanted = f"{name} must be one finite number >= 0 [{unit}], found {value!r}"
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(wanted) from error
    if not 0.0 <= number <= LARGEST:
        raise InputError(wanted)
    return number


def _each(name: str, value: Each, *, least: float = 0.0, above: float | None = None, mend: str = "") -> Each:
    """`value` as a float or a tuple of floats, finite and at least `least`, or more than `above`."""
    bound = 0.0 if above == FINEST_STEP else above
    wanted = "" if least == -math.inf else f" >= {least:g}" if bound is None else f" > {bound:g}"
    told = f"{name} must be one number{wanted} or one an actuator, found {value!r}{mend}"
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(told) from error
    if array.ndim > 1 or not array.size or not (np.abs(array) <= LARGEST).all():
        raise InputError(told)
    if not (array >= least if above is None else array > above).all():
        raise InputError(told)
    return float(array) if array.ndim == 0 else tuple(array.tolist())
