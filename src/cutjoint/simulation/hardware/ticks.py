"""Time in whole ticks of the controller's clock.

Sample k begins with an edge of the clock, at k periods +- jitter.  At the edge the sensors are read (capture); the part
of the measurement's delay beyond whole periods later the law is asked (compute); the part of the command's delay beyond
whole periods after that a command takes effect (apply).  Whole periods of delay are places in a shift register.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from cutjoint.errors import InputError
from cutjoint.reprs import told

WHOLE = 1e-9
"""How far from a whole number of ticks a time may be, as a part of it: the rounding of decimals."""
FINEST = 10**7
"""Largest denominator that is tried for a tick that divides all times."""


class Ticks(NamedTuple):
    """Times in ticks.

    Attributes:
        length: of a tick [s].
        period: between two edges.
        jitter: most that an edge is early or late.
        seen_after, seen_late: delay of the measurement: whole periods, and ticks beyond them.
        acts_after, acts_late: delay of the command likewise.
    """

    length: float
    period: int
    jitter: int
    seen_after: int
    seen_late: int
    acts_after: int
    acts_late: int

    def __repr__(self) -> str:
        return told(self, length="s")

    @property
    def delayed(self) -> bool:
        """Whether there is any delay."""
        return bool(self.seen_after or self.seen_late or self.acts_after or self.acts_late)

    def time(self, tick: int) -> float:
        """Of a tick since the start [s]."""
        periods, rest = divmod(tick, self.period)
        return periods * (self.length * self.period) + rest * self.length if self.period > 1 else tick * self.length


def ticks_of(period: float, jitter: float, tick: float | None, measurement: float, command: float) -> Ticks:
    """All times in ticks [s]; without a `tick` it is the period.

    Raises:
        InputError: a time is not a whole number of ticks; jitter and the rest of a delay fill a whole period.
    """
    times = {
        "the period": period,
        "the jitter": jitter,
        "the delay of the encoder": measurement,
        "the delay of the drive": command,
    }
    length = period if tick is None else tick
    for name, time in times.items():
        count = time / length
        if abs(count - round(count)) > WHOLE * max(1.0, count) or (time > 0.0 and round(count) == 0):
            usual = " (the period, as no tick is given)" if tick is None else ""
            raise InputError(
                f"{name} of {time:g} s is not a whole number of ticks of {length:g} s{usual}; give the clock a tick "
                f"that divides period, jitter and delays{_proposal(list(times.values()))}"
            )
    whole, most = round(period / length), round(jitter / length)
    seen, acts = (divmod(round(time / length), whole) for time in (measurement, command))
    for name, rest in (("encoder", seen[1]), ("drive", acts[1])):
        if rest + 2 * most >= whole > 1 and most:
            raise InputError(
                f"the delay of the {name} is {rest} of {whole} ticks beyond whole periods, and with a jitter of {most} "
                f"ticks either way parts of two samples may overlap; less than {whole} - 2 x {most} ticks can be run"
            )
    return Ticks(period / whole, whole, most, *seen, *acts)


def _proposal(times: list[float]) -> str:
    """A tick that divides all times, as the end of a sentence; nothing where there is none that is not tiny."""
    given = [time for time in times if time > 0.0]
    parts = [Fraction(time).limit_denominator(FINEST) for time in given]
    if any(abs(float(part) - time) > WHOLE * time for part, time in zip(parts, given, strict=True)):
        return ""
    common = parts[0]
    for part in parts[1:]:
        common = _common(common, part)
    return f", such as {float(common):g} s" if common > 0 else ""


def _common(a: Fraction, b: Fraction) -> Fraction:
    """The greatest that divides both."""
    while b:
        a, b = b, a % b
    return a
