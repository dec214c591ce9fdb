"""Robots whose redundant rows hold only up to rounding, as CAD programs export them.

A Delta with lengths rounded to a micrometre is, taken literally, a structure without mobility: its redundant rows are
nearly but not quite dependent.  Such rows show as singular values that are neither zero nor of the size of a motion, or
as loops that come to rest a little open.  Then as many independent rows as there are real singular values are chosen at
home, and the loops are closed on these to full accuracy; what the others are open by stays in the posture's gap.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.assembly import Assembler, Driver
from cutjoint.chain.kinematics import Kinematics


def trusted_rows(kinematics: Kinematics, q: Array, driver: Driver | None) -> Array | None:
    """Indices of the rows to close the loops on, or None where all of them can be trusted.

    Args:
        q: the rough home configuration, shape (nq,).
        driver: what is prescribed there.
    """
    k = kinematics
    if not k.closure.rows:
        return None
    assembler = Assembler(k)
    near, cost = assembler.nearest(q, driver)
    if not np.sqrt(cost) < tolerances.ROUNDING.value:
        return None
    closes = assembler.settle(near, driver) is not None
    k.update(near)
    matrix = k.scaled_jacobian()
    values = np.linalg.svd(matrix, compute_uv=False)
    rounded = values < tolerances.ROUNDING.value * values[0]
    if closes and not (values[rounded] > 1e-3 * tolerances.RANK.value * values[0]).any():
        return None
    rank = int(np.sum(~rounded))
    if rank < len(values) and values[rank] > 0.05 * values[rank - 1]:
        return None
    order = qr(matrix.T, mode="r", pivoting=True)[1]
    return np.sort(order[:rank])
