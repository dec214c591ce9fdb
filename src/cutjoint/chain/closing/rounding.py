"""Robots whose redundant rows hold only up to rounding, as CAD programs export them.

A Delta with lengths rounded to a micrometre is, taken literally, a structure without mobility: its redundant rows are
nearly but not quite dependent, and its loops cannot be closed.  Only where they cannot are rows dropped: those that are
dependent but for an error of the size of the gap at which the loops come to rest.  The loops are then closed on the
others to full accuracy; what the dropped ones are open by stays in the posture's gap, and must be small.

Where all rows can be closed, all of them count, however small their singular values: a linkage of a millimetre beside
one of a metre is no rounding.  But a file may be written at its home, where the loops then close to the last digit, and
nowhere else: two parallelograms on one crank lock each other as soon as their lengths differ.  So the robot is moved
without the rows that nearly depend on others, and those of them are dropped that open by no more than a tiny part of
what the motions of their joints, which cancel in them, would do one by one.  Where any of them opens by more, the
robot is made so, and all its rows count.
"""

from __future__ import annotations

import warnings

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import around, nearest
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import WELL
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.factoring import pivots_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import singular_values
from cutjoint.errors import ClosureError, RoundingWarning

AMPLIFIED = 300.0
"""How much larger than the gap the singular values of rounded rows may be: rounding adds up over a loop."""

SHIFT, MOVES = 0.1, 3
"""How far around home the robot is moved, in radians or characteristic lengths, and how often."""
EXACT = 1e-11
"""Dependent rows that differ by less, dimensionless, from what they depend on stay closed."""

Gap = tuple[float, float, str]
"""Worst distance [m] and angle [rad] by which cuts are open, and the worst cut."""


def trusted_rows(kinematics: Kinematics, q: Array, driver: Driver | None) -> Array | None:
    """Indices of the rows to close the loops on, or None where all of them can be closed (or none of them can).

    Args:
        q: the rough home configuration, shape (nq,).
        driver: what is prescribed there.
    """
    k = kinematics
    if not k.closure.rows:
        return None
    near, cost = nearest(k, q, driver)
    gap = float(np.sqrt(cost))
    if not gap < tolerances.ROUNDING.value:
        return None
    if settle(k, near, driver, tolerances.ROUNDING.value) is not None:
        return None
    matrix = _along_a(k).at(near).scaled
    values = singular_values(matrix)
    bound = min(max(AMPLIFIED * gap, 10.0 * tolerances.RANK.value), tolerances.ROUNDING.value) * max(values[0], 1.0)
    rank = int(np.count_nonzero(values > bound))
    if rank == len(matrix):
        return None
    order = pivots_of(matrix.T)
    return np.sort(order[:rank])


def lasting(kinematics: Kinematics, home: Placed) -> tuple[Kinematics, Gap]:
    """The same robot closed on those rows that can stay closed as it moves, and what the others are open by."""
    k, gap = kinematics, home.gap
    if _is_exact(k, home):
        return _finished(k, home, k.closure.trusted), gap
    own = _along_a(k)
    matrix = own.at(home.q).scaled
    main = np.sort(pivots_of(matrix.T)[: _rank(singular_values(matrix))])
    fewer = Kinematics(k.description, own.closure.trusted[main])
    closed = tolerances.CLOSURE.value * np.where(own.closure.is_length, k.reach / k.length, 1.0)
    opened, part = np.zeros(len(matrix)), np.zeros(len(matrix))
    for start in around(k, home.q, np.full(MOVES, SHIFT)):
        moved = settle(fewer, start, None, 3.0 * SHIFT)
        if moved is not None:
            there = own.at(moved.q)
            left = np.abs(own.row_scale * there.residual)
            motion = k.tree.difference(home.q, moved.q)
            terms = own.row_scale * own.closure.travelled(there.frames, there.twists, moved.q, motion)
            opened, part = np.maximum(opened, left / closed), np.maximum(part, left / np.maximum(terms, closed))
            gap = max(gap, there.gap)
    spare = np.setdiff1d(np.arange(len(matrix)), main)
    small = part < tolerances.ROUNDED_GAP.value
    locks = bool((opened > 1.0)[spare][~small[spare]].any())  # a robot that is made so, and not by rounding
    rounded = (opened > WELL) & small
    rounded[main] = False
    if locks or not (opened[rounded] > 1.0).any():
        return _finished(k, home, k.closure.trusted), home.gap
    return _finished(k, home, own.closure.trusted[~rounded]), gap


def _finished(kinematics: Kinematics, home: Placed, trusted: Array) -> Kinematics:
    """The same with these rows, which knows from home how well they hold the robot."""
    k = kinematics
    return Kinematics(k.description, trusted, home.q) if len(trusted) < k.closure.all_rows else k


def _is_exact(kinematics: Kinematics, home: Placed) -> bool:
    """Whether rows that depend on others, nearly or quite, do so in the next moments too."""
    left, values, right = np.linalg.svd(home.scaled)
    rank = _rank(values)
    if values[rank:].max(initial=0.0) > EXACT:
        return False
    k, dependent, motions = kinematics, left[:, rank:], right[rank:]
    for speed in np.random.default_rng(0).uniform(-1.0, 1.0, (2, len(motions))):
        drift = k.moving(home.q, k.column_scale * (speed @ motions)).drift
        if np.abs((k.row_scale * drift) @ dependent).max(initial=0.0) > EXACT:
            return False
    return True


def _rank(values: Array) -> int:
    """How many singular values are none of rounding."""
    return int(np.count_nonzero(values > tolerances.ROUNDING.value * max(float(values.max(initial=0.0)), 1.0)))


def _along_a(kinematics: Kinematics) -> Kinematics:
    """The same with rows that go along with the robot."""
    k = kinematics
    return k if k.closure.along_a else Kinematics(k.description, k.closure.trusted)


def check_rounding(kinematics: Kinematics, home: Placed, moved: Gap) -> None:
    """Say which rows were dropped and what they are open by.

    Raises:
        ClosureError: more than rounding explains.
    """
    k = kinematics
    if not k.closure.left_out:
        return
    distance, angle, cut = home.gap
    rows = ", ".join(k.closure.left_out)
    if max(distance / k.reach, angle) > tolerances.ROUNDED_GAP.value:
        raise ClosureError(
            f"{k.name}: the loops cannot be closed with all of their rows; without {rows} {k.closure.told(cut)} stays "
            f"{distance:.3g} m, {angle:.3g} rad open, which is more than rounded lengths explain "
            f"({tolerances.ROUNDED_GAP.value:g} of {k.reach:.3g} m). Mend the frames of that one, or choose a cut "
            "type that leaves the motion free",
            gap=(distance, angle),
            cut=cut,
        )
    distance, angle, _ = moved
    warnings.warn(
        f"{k.name}: the loops close only up to rounding: {rows} dropped as dependent but for {distance:.2g} m, "
        f"{angle:.2g} rad, which stay open or open as it moves. More digits in the file would close them",
        RoundingWarning,
        stacklevel=3,
    )
