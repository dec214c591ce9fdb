"""Where a robot is at home: the angle at which its loop is as far from singular as may be, or near one that looks well.

A template scores angles: 0 is singular, NaN where the loop cannot close, 1 is best.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

from cutjoint.arrays import Array

NEARLY = 0.85
"""LinkSketch of the best score that is good enough where it is nearer to the angle that is preferred."""
USABLE = 0.12
"""Score that a joint with limits keeps within them."""
STEPS = 1440


def best_angle(score: Callable[[float], float], preferred: float, least: float = -pi, most: float = pi) -> float | None:
    """The angle [rad] nearest to the preferred one whose score is nearly the best; None where nothing closes."""
    angles = np.append(np.linspace(least, most, STEPS), preferred)
    scores = np.array([score(angle) for angle in angles])
    if not np.nanmax(np.where(np.isnan(scores), -1.0, scores)) > 0.0:
        return None
    good = angles[np.nan_to_num(scores, nan=-1.0) >= NEARLY * np.nanmax(scores)]
    return float(good[np.argmin(np.abs(good - preferred))])


def usable_range(score: Callable[[float], float], home: float) -> tuple[float, float] | None:
    """The range [rad] around `home` in which the loop closes and keeps away from singularities; None for all round."""
    ways = []
    for sign in (-1.0, 1.0):
        turned: Array = home + sign * np.linspace(0.0, 2.0 * pi, STEPS)
        bad = [not score(float(angle)) >= min(USABLE, 0.5 * score(home)) for angle in turned]
        if not any(bad):
            return None
        ways.append(float(turned[max(bad.index(True) - 1, 0)]))
    return ways[0], ways[1]
