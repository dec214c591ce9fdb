"""What matters most: how much of the spread of a quantity comes from which path.

Of independent draws: Spearman's rank correlation with the quantity, and the standardised regression coefficient b_i
s_i / s of a linear fit, with the share R^2 of the variance that the fit explains.  Of "saltelli": Sobol's indices S1
(what the path does alone) and ST (with all that it does together with others), with their 95 % confidence, estimated by
SALib (A. Saltelli et al., Computer Physics Communications 181 (2010) 259-270).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.extras import needed
from cutjoint.reprs import line

FEWEST = 10
"""Runs, times paths, from which on a fit says anything."""
RESAMPLES = 100
SEED = 0
"""Of the resampling that gives the confidence."""


@dataclass(frozen=True)
class PathEffect:
    """What a path does to a quantity; of the four numbers those of the other method are None.

    Attributes:
        path: what varies.
        rank: Spearman's rank correlation.
        regression: standardised regression coefficient.
        first, first_within: Sobol's S1, and half the width of its 95 % interval.
        total, total_within: Sobol's ST, and half the width of its 95 % interval.
    """

    path: str
    rank: float | None = None
    regression: float | None = None
    first: float | None = None
    first_within: float | None = None
    total: float | None = None
    total_within: float | None = None

    __repr__ = line()

    @property
    def size(self) -> float:
        """By which paths are ranked: ST, or |rank|."""
        found = self.total if self.total is not None else self.rank
        return 0.0 if found is None or not np.isfinite(found) else abs(found)


@dataclass(frozen=True)
class Ranking:
    """The paths of a quantity, the one that matters most first.

    Attributes:
        case: number of the case.
        column: of the table.
        effects: of the paths.
        explained: share R^2 of the variance that the linear fit explains; None of Sobol's indices.
        runs: that it is made of.
    """

    case: int
    column: str
    effects: tuple[PathEffect, ...]
    explained: float | None
    runs: int

    __repr__ = line("column", "effects")


def ranked(method: str, case: int, column: str, paths: Sequence[str], x: Array, y: Array) -> Ranking | None:
    """The ranking of a quantity `y`, shape (N,), by what varied, `x`, shape (N, paths); None where nothing can be said:
    too few runs, or a quantity that does not vary."""
    if method == "saltelli":
        return _sobol(case, column, paths, y)
    good = np.isfinite(y)
    moving = [k for k in range(len(paths)) if np.ptp(x[good, k]) > 0.0] if good.any() else []
    x, y = x[good][:, moving], y[good]
    if not moving or len(y) < FEWEST * len(moving) or not _varies(y):
        return None
    from scipy.stats import rankdata

    ranks = rankdata(x, axis=0)
    order = rankdata(y)
    rank = np.array([np.corrcoef(ranks[:, k], order)[0, 1] for k in range(len(moving))])
    scaled, target = (x - x.mean(axis=0)) / x.std(axis=0), (y - y.mean()) / y.std()
    slopes = np.linalg.lstsq(scaled, target, rcond=None)[0]
    explained = 1.0 - float(np.mean((target - scaled @ slopes) ** 2))
    effects = [
        PathEffect(paths[moving[k]], rank=float(rank[k]), regression=float(slopes[k])) for k in range(len(moving))
    ]
    return Ranking(case, column, _sorted(effects), explained, len(y))


def _sobol(case: int, column: str, paths: Sequence[str], y: Array) -> Ranking | None:
    """Indices from whole groups of rows; a group with a run that failed is left out."""
    width = len(paths) + 2
    groups = y[: len(y) // width * width].reshape(-1, width)
    groups = groups[np.isfinite(groups).all(axis=1)]
    if len(groups) < 2 or not _varies(groups):
        return None
    needed("SALib", "the Sobol indices of a study")
    from SALib.analyze import sobol

    problem = {"num_vars": len(paths), "names": list(paths), "bounds": [[0.0, 1.0]] * len(paths)}
    found = sobol.analyze(
        problem, groups.ravel(), calc_second_order=False, num_resamples=RESAMPLES, seed=SEED, print_to_console=False
    )
    effects = [
        PathEffect(
            path,
            first=float(found["S1"][k]),
            first_within=float(found["S1_conf"][k]),
            total=float(found["ST"][k]),
            total_within=float(found["ST_conf"][k]),
        )
        for k, path in enumerate(paths)
    ]
    return Ranking(case, column, _sorted(effects), None, groups.size)


def _varies(y: Array) -> bool:
    return bool(np.ptp(y) > 1e-12 * np.abs(y).max())


def _sorted(effects: Sequence[PathEffect]) -> tuple[PathEffect, ...]:
    return tuple(sorted(effects, key=lambda one: (-one.size, one.path)))
