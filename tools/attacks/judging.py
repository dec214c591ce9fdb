"""One attack: something that is done with spoiled input, within a time, with a verdict."""

from __future__ import annotations

import os
import signal
import traceback
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from types import FrameType

LONGEST = 5.0
"""Seconds of processor time, of this process and of those that it starts, that any input may take."""
WAITING = 12.0
"""How many times as long it may take by the clock: other processes want the processor too."""


@dataclass(frozen=True)
class Attack:
    """What is done, and a name that finds it again.

    Attributes:
        name: kind, seed and number.
        act: does it; returns "refused", "accepted" or another word that is counted, and raises `Wrong` or anything else
            where it went wrong.
    """

    name: str
    act: Callable[[], str]


class Wrong(Exception):
    """Something was accepted that should not have been, or a verdict was none."""


class TooLong(BaseException):
    """The time is over; no handler of errors may catch it."""


@dataclass
class Tally:
    """What came of many attacks: counts by verdict, the faults, and the slowest one."""

    counts: dict[str, int] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")

    def __str__(self) -> str:
        counts = ", ".join(f"{count} {what}" for what, count in sorted(self.counts.items()))
        return f"{counts or 'nothing'}; {len(self.faults)} faults; slowest {self.slowest[0]:.2f} s ({self.slowest[1]})"


def judge(attacks: Iterable[Attack], longest: float = LONGEST) -> Tally:
    """Run attacks one after the other in this process, each for `longest` seconds at most."""
    tally = Tally()
    before = [signal.signal(one, _over) for one in (signal.SIGALRM, signal.SIGPROF)]
    try:
        for one in attacks:
            began = _used()
            try:
                signal.setitimer(signal.ITIMER_REAL, WAITING * longest)
                signal.setitimer(signal.ITIMER_PROF, longest)
                with warnings.catch_warnings():
                    warnings.simplefilter("error", RuntimeWarning)  # numpy's, which nobody should see
                    verdict = one.act()
            except TooLong:
                verdict = "hung"
                tally.faults.append(f"{one.name}: more than {longest} s")
            except Exception:
                verdict = "fault"
                tally.faults.append(f"{one.name}: {traceback.format_exc(limit=-6)}")
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                signal.setitimer(signal.ITIMER_PROF, 0.0)
            used = _used() - began
            if used > longest and verdict != "hung":
                tally.faults.append(f"{one.name}: {used:.1f} s with the processes that it started")
            tally.counts[verdict] = tally.counts.get(verdict, 0) + 1
            tally.slowest = max(tally.slowest, (used, one.name))
    finally:
        for number, handler in zip((signal.SIGALRM, signal.SIGPROF), before, strict=True):
            signal.signal(number, handler)
    return tally


def _used() -> float:
    """Seconds of processor time of this process and of those that it started and that have ended."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def _over(_: int, __: FrameType | None) -> None:
    raise TooLong
