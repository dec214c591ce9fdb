"""A way of the actuators without its time: coordinates over a way length s from 0 to 1, and their derivatives.

A trajectory is sampled along the way of its actuators, whatever its own time does, denser where that bends, and a
quintic spline over the chord length goes through the samples; where it stands and goes on in another direction the way
has a corner, where any motion must stop, and each piece between two corners has a spline of its own.  How far the
splines miss the trajectory between the samples is measured, and there are twice as many samples where that is too much.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline, CubicHermiteSpline, PchipInterpolator, make_interp_spline
from scipy.optimize import minimize_scalar

from cutjoint.arrays import Array, Frozen
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.motion import Reference
from cutjoint.reprs import line

LOOKS = 400
"""Instants at which a trajectory is looked at first."""
NODES, MOST_NODES = 400, 3200
LEAST_NODES = 60
"""Samples of a whole way, at most, and of one of its pieces at least."""
MISSED = 1e-7
"""By how much of its length a way may be missed before there are more samples."""
STANDS, TURNS = 1e-6, 0.5
"""A speed beside the largest one that is none, and the cosine from which on a change of direction is a corner."""
NOWHERE = 1e-9
"""A way shorter than that, beside the size of the robot, is none."""


@dataclass(frozen=True, eq=False)
class WayPiece(Frozen):
    """A smooth piece of a way, between two corners.

    Attributes:
        s: way length of its samples, ascending, shape (k,).
        times: of the trajectory there, shape (k,) [s].
        q: coordinates there, shape (k, n) [m] or [rad].
        postures: of the robot there.
        curve: the spline through them.
    """

    s: Array
    times: Array
    q: Array
    postures: tuple[Posture, ...]
    curve: BSpline

    __repr__ = line("s", "q", q="m or rad")

    def at(self, s: Array, order: int = 0) -> Array:
        """Derivatives of an order at way lengths, shape (len(s), n)."""
        return np.asarray(self.curve(s, order))

    def missed(self, reference: Reference, units: Array) -> float:
        """How far the spline misses the trajectory half-way between samples, beside the size of the robot."""
        most = 0.0
        for i in range(0, len(self.s) - 1, max(1, len(self.s) // 24)):
            q = reference.at(float(0.5 * (self.times[i] + self.times[i + 1]))).q
            most = max(most, float(np.abs(self.away(q, 0.5 * (self.s[i] + self.s[i + 1]), units)).max()))
        return most

    def away(self, q: Array, s: float, units: Array) -> Array:
        """From the nearest place of the piece to `q`, in robot sizes; `s` is near that place."""
        for _ in range(4):
            off, along = (q - self.at(np.array(s))) / units, self.at(np.array(s), 1) / units
            s = float(np.clip(s + along @ off / (along @ along), self.s[0], self.s[-1]))
        return np.asarray((q - self.at(np.array(s))) / units)


@dataclass(frozen=True, eq=False)
class WholeWay(Frozen):
    """A whole way.

    Attributes:
        pieces: between its corners.
        units: what coordinates are divided by to have no dimension, shape (n,).
        length: of the whole way, in robot sizes.
        closed: whether it ends where it began.
        smooth: whether it does so without a corner.
        missed: how far the splines miss the trajectory, in robot sizes.
        rests: for how long the trajectory stood still meanwhile [s].
    """

    pieces: tuple[WayPiece, ...]
    units: Array
    length: float
    closed: bool
    smooth: bool
    missed: float
    rests: float

    __repr__ = line("pieces", "length", "closed", "units", units="m or rad")

    def time_of(self, s: float) -> float:
        """The time at which the trajectory is at a way length [s]."""
        for one in self.pieces:
            if s <= one.s[-1]:
                break
        return float(np.interp(s, one.s, one.times))


def way_of(reference: Reference, units: Array, *, round_and_round: bool = False, nodes: int = NODES) -> WholeWay:
    """The way of a trajectory, seen through a mechanism.

    Args:
        reference: the trajectory and the mechanism.
        units: what coordinates are divided by to have no dimension, shape (n,).
        round_and_round: whether it shall be smooth where it begins anew.
        nodes: how many samples it has, about, or more where it needs them.

    Raises:
        InputError: it does not move, or it cannot go round.
        UnreachableError, LimitError: it leaves the workspace, or joint limits.
    """
    times = np.linspace(0.0, reference.duration, LOOKS + 1)
    looks = [reference.at(float(t)) for t in times]
    q, rates = np.array([one.q for one in looks]) / units, np.array([one.v for one in looks]) / units
    speeds = np.linalg.norm(rates, axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    if lengths[-1] < NOWHERE:
        raise InputError(
            f"trajectory '{reference.trajectory.name}' does not move, so there is no way to be gone quicker"
        )
    moving = speeds > STANDS * speeds.max()
    still = float(np.sum(np.diff(times)[~moving[:-1] & ~moving[1:]]))
    corners = _corners(reference, units, times, rates, speeds, moving)
    closed = bool(np.abs(q[-1] - q[0]).max() < 1e-9)
    smooth = closed and _goes_on(rates[moving][-1], rates[moving][0]) and not (corners)
    if round_and_round and not smooth:
        why = "it has corners, where it must stop" if closed else "it does not end where it begins"
        why = "it begins in another direction than it ends" if closed and not corners else why
        raise InputError(f"trajectory '{reference.trajectory.name}' cannot go round without a stop: {why}")
    ends = [0.0, *corners, reference.duration]
    turned = _turned(rates, moving)
    bends = turned[-1] > STANDS
    spread = lengths / lengths[-1] + (turned / turned[-1] if bends else 0.0)
    along = PchipInterpolator(times, spread) if bends else CubicHermiteSpline(times, spread, speeds / lengths[-1])
    count = nodes
    while True:
        pieces = _pieces(reference, units, ends, along, count, round_and_round)
        total = sum(_chords(one.q / units)[-1] for one in pieces)
        missed = max(one.missed(reference, units) for one in pieces)
        if missed <= MISSED * total or 2 * count > MOST_NODES:
            break
        count *= 2
    return WholeWay(tuple(pieces), units, float(total), closed, smooth, missed, still)


def _turned(rates: Array, moving: Array) -> Array:
    """By how much the direction of the way has turned until each instant but in its corners, shape (k,) [rad]."""
    found = np.zeros(len(rates))
    places = np.flatnonzero(moving)
    towards = rates[places] / np.linalg.norm(rates[places], axis=1, keepdims=True)
    cosines = np.sum(towards[1:] * towards[:-1], axis=1)
    sides = np.linalg.norm(towards[1:] - cosines[:, None] * towards[:-1], axis=1)
    found[places[1:]] = np.where(cosines > TURNS, np.arctan2(sides, cosines), 0.0)
    return np.cumsum(found)


def _goes_on(before: Array, after: Array) -> bool:
    return bool(before @ after > TURNS * np.linalg.norm(before) * np.linalg.norm(after))


def _corners(
    reference: Reference, units: Array, times: Array, rates: Array, speeds: Array, moving: Array
) -> list[float]:
    """Instants at which the trajectory stands and then goes on in another direction [s]."""
    found = []
    places = np.flatnonzero(moving)
    for i, j in pairwise(places.tolist()):
        if _goes_on(rates[i], rates[j]):
            continue
        if j > i + 1:
            found.append(float(0.5 * (times[i] + times[j])) if j > i + 2 else float(times[i + 1]))
            continue
        least = minimize_scalar(
            lambda t: float(np.sum((reference.at(float(t)).v / units) ** 2)),
            bounds=(times[i], times[j]),
            method="bounded",
            options={"xatol": 1e-9 * (times[-1] - times[0])},
        )
        if np.sqrt(least.fun) < 1e-3 * speeds.max():
            found.append(float(least.x))
    return found


def _pieces(
    reference: Reference, units: Array, ends: list[float], along: CubicHermiteSpline, count: int, closed: bool
) -> list[WayPiece]:
    """Samples and splines between corners."""
    whole = float(along(ends[-1]) - along(ends[0]))
    pieces: list[WayPiece] = []
    parts = []
    for start, end in pairwise(ends):
        fine = np.linspace(start, end, 20 * LOOKS + 1)
        lengths = np.maximum.accumulate(along(fine))
        own = lengths[-1] - lengths[0]
        if own <= 1e-6 * whole:
            continue
        steps = max(LEAST_NODES, int(np.ceil(count * own / whole)))
        times = np.interp(np.linspace(lengths[0], lengths[-1], steps + 1), lengths, fine)
        times[0], times[-1] = start, end
        seen = [reference.at(float(t)) for t in times]
        chords = _chords(np.array([one.q for one in seen]) / units)
        kept = _apart(chords, 0.05 * chords[-1] / steps)
        parts.append(([seen[k] for k in kept], np.array([times[k] for k in kept])))
    total = sum(_chords(np.array([one.q for one in seen]) / units)[-1] for seen, _ in parts)
    begun = 0.0
    for seen, times in parts:
        q = np.array([one.q for one in seen])
        if closed:
            q[-1] = q[0]
        s = begun + _chords(q / units) / total
        begun = float(s[-1])
        curve = make_interp_spline(s, q, k=5, bc_type="periodic" if closed else None)
        pieces.append(WayPiece(s, times, q, tuple(one.posture for one in seen), curve))
    return pieces


def _apart(chords: Array, least: float) -> list[int]:
    """Samples that are at least so far from one another, the first and the last among them."""
    kept = [0]
    for k in range(1, len(chords) - 1):
        if chords[k] - chords[kept[-1]] > least and chords[-1] - chords[k] > least:
            kept.append(k)
    return [*kept, len(chords) - 1]


def _chords(q: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
