"""The smallest integer gain whose tracking error stays under a bound (Elkady et al. 2008, sections 5.3 and 5.4).

The error along the worst axis from a time on falls as the gain grows, so one sign change is sought: regula falsi on the
gain, which is nearly linear in one over the error, then the two integers around it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cutjoint.errors import InputError

ROUNDS = 40


@dataclass(frozen=True)
class SmallestGain:
    """Where the rule ends.

    Attributes:
        gain: smallest integer gain that keeps the bound.
        error: its error.
        error_below: error of the next smaller integer, which breaks the bound.
        runs: how many gains were tried.
    """

    gain: int
    error: float
    error_below: float
    runs: int


def smallest_gain(error_of: Callable[[int], float], bound: float, guess: int) -> SmallestGain:
    """Smallest integer k with error_of(k) < bound, where error_of falls with k.

    Raises:
        InputError: no sign change was found near the guess.
    """
    known: dict[int, float] = {}

    def holds(gain: int) -> bool:
        if gain not in known:
            known[gain] = error_of(gain)
        return known[gain] < bound

    low, high = guess - 1, guess
    while holds(low) or not holds(high):
        if len(known) > ROUNDS:
            raise InputError(f"no gain near {guess} brings the error to {bound:g}; nearest tried {sorted(known)}")
        # error * gain is nearly constant, which tells where the bound is met; the bracket closes in on it.
        nearest = min(known, key=lambda gain: abs(known[gain] / bound - 1.0))
        low, high = _next(known, bound, nearest)
    return SmallestGain(high, known[high], known[low], len(known))


def _next(known: dict[int, float], bound: float, nearest: int) -> tuple[int, int]:
    """Two neighbouring integers to try, by the secant of the two tries nearest to the bound."""
    others = sorted(known, key=lambda gain: abs(known[gain] / bound - 1.0))
    root = nearest * known[nearest] / bound
    for other in others[1:]:
        rise = known[other] - known[nearest]
        if rise != 0.0 and abs(other - nearest) >= 1:
            root = nearest + (bound - known[nearest]) * (other - nearest) / rise
            break
    # Between a known failure and a known success it must lie.
    low = max((gain for gain, error in known.items() if error >= bound), default=0)
    high = min((gain for gain, error in known.items() if error < bound), default=None)
    middle = max(round(root + 0.5), low + 1)
    if high is not None:
        middle = min(middle, high)
    return middle - 1, middle
