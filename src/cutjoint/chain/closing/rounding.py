"""Robots whose redundant rows hold only up to rounding, as CAD programs export them.

A Delta with lengths rounded to a micrometre is, taken literally, a structure without mobility: its redundant rows are
nearly but not quite dependent, and its loops cannot be closed.  Only where they cannot are rows dropped: those that are
dependent but for an error of the size of the gap at which the loops come to rest.  The loops are then closed on the
others to full accuracy; what the dropped ones are open by stays in the posture's gap, and must be small.

Where all rows can be closed, all of them count, however small their singular values: a linkage of a millimetre beside
one of a metre is no rounding.
"""

from __future__ import annotations

import warnings

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import nearest
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.factoring import pivots_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import singular_values
from cutjoint.errors import ClosureError, RoundingWarning

AMPLIFIED = 300.0
"""How much larger than the gap the singular values of rounded rows may be: rounding adds up over a loop."""


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
    matrix = k.at(near).scaled
    values = singular_values(matrix)
    bound = min(max(AMPLIFIED * gap, 10.0 * tolerances.RANK.value), tolerances.ROUNDING.value) * max(values[0], 1.0)
    rank = int(np.count_nonzero(values > bound))
    if rank == len(matrix):
        return None
    order = pivots_of(matrix.T)
    return np.sort(order[:rank])


def check_rounding(kinematics: Kinematics, home: Placed) -> None:
    """Say which rows were dropped and what stays open at home.

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
    warnings.warn(
        f"{k.name}: the loops close only up to rounding: {rows} dropped as dependent but for {distance:.2g} m, "
        f"{angle:.2g} rad, which stay open. More digits in the file would close them",
        RoundingWarning,
        stacklevel=3,
    )
