"""A law of time s(t) along one piece of a way, whose acceleration is continuous.

The quickest law has an acceleration u that is constant between samples of the way and jumps there.  Its average over a
time 2 c with the weights of a triangle, (1 - |t| / c) / c, changes its acceleration smoothly, keeps to the same way and
takes 2 c longer.  Of a jump by D at t_k the average is

    R(t - t_k) D,    R(r) = (r + c)^4 / (24 c^2)  up to 0,    r^2 / 2 + c^2 / 12 - (c - r)^4 / (24 c^2)  from 0 on,

so that nothing has to be integrated, and no digits are lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.reprs import line

AT_ONCE = 256
"""Instants whose distances to all jumps are in memory at once."""


@dataclass(frozen=True, eq=False)
class TimeLaw(Frozen):
    """A quickest law and its average.

    Attributes:
        times: at which the quickest law is at the samples, shape (k,) [s].
        s: their way lengths, shape (k,).
        speeds: s_dot there, shape (k,) [1/s].
        half: c [s].
        goes_round: whether it begins anew where it ends, at speed.
    """

    times: Array
    s: Array
    speeds: Array
    half: float
    goes_round: bool = False

    __repr__ = line("half", "duration", half="s", duration="s")

    @property
    def shortest(self) -> float:
        """How long the quickest law takes [s]."""
        return float(self.times[-1])

    @property
    def duration(self) -> float:
        """How long the average takes [s]."""
        return self.shortest + (0.0 if self.goes_round else 2.0 * self.half)

    def at(self, t: Array) -> Array:
        """Way lengths of the average at times from 0 to its duration, shape (len(t),); of one that goes round they go
        on beyond both ends."""
        times, speeds, s = self.times, self.speeds, self.s
        if self.goes_round:
            whole = s[-1] - s[0]
            times = np.concatenate([times[:-1] - times[-1], times[:-1], times + times[-1]])
            s = np.concatenate([s[:-1] - whole, s[:-1], s + whole])
            speeds = np.concatenate([speeds[:-1], speeds[:-1], speeds])
        else:
            t = t - self.half
        u = np.diff(speeds) / np.diff(times)
        inside = (t >= times[0]) & (t < times[-1])
        step = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(u) - 1)
        since = t - times[step]
        now = np.where(inside, u[step], 0.0)
        plain = np.where(
            inside, s[step] + since * (speeds[step] + 0.5 * since * now), np.where(t < times[0], s[0], s[-1])
        )
        jumps = np.diff(np.concatenate([[0.0], u, [0.0]]))
        found = plain + now * self.half**2 / 12.0
        for start in range(0, len(t), AT_ONCE):
            some = slice(start, start + AT_ONCE)
            near = slice(
                int(np.searchsorted(times, t[some].min() - self.half)),
                int(np.searchsorted(times, t[some].max() + self.half)),
            )
            away = t[some, None] - times[None, near]
            left = np.maximum(self.half - np.abs(away), 0.0)
            found[some] += np.sum(np.where(away >= 0.0, -1.0, 1.0) * left**4 * jumps[near], axis=1) / (
                24.0 * self.half**2
            )
        return np.asarray(found if self.goes_round else np.clip(found, self.s[0], self.s[-1]))


def law_of(s: Array, squares: Array, half: float, *, goes_round: bool = False) -> TimeLaw:
    """The law with s_dot^2 as given at the samples, u constant between them."""
    speeds = np.sqrt(squares)
    return TimeLaw(elapsed(s, squares), s, speeds, half, goes_round)


def elapsed(s: Array, squares: Array) -> Array:
    """Times at which the samples are passed, shape (k,) [s]."""
    speeds = np.sqrt(squares)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(speeds[1:] + speeds[:-1], 1e-300))])
