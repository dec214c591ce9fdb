"""The smallest gain that keeps a bound, as the CPM's paper chooses K_P (Elkady et al. 2008, sections 5.3 and 5.4).

The rule asks for the smallest integer gain whose tracking error stays under a bound.  The error along the worst axis
from a time on falls as the gain grows, so one sign change is sought: a bracket around it, then regula falsi on
logarithmic scales until two neighbouring integers are left.
"""

from __future__ import annotations

import math
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
        error_of_guess: error of the gain that was tried first.
        runs: how many gains were tried.
    """

    gain: int
    error: float
    error_below: float
    error_of_guess: float
    runs: int


def smallest_gain(error_of: Callable[[int], float], bound: float, guess: int) -> SmallestGain:
    """Smallest integer k >= 1 with error_of(k) < bound, where error_of falls with k; `guess` is tried first.

    Raises:
        InputError: no such gain was found.
    """
    known: dict[int, float] = {}

    def holds(gain: int) -> bool:
        known[gain] = error_of(gain)
        return known[gain] < bound

    # A guess that is right costs two runs: itself and its lower neighbour.
    low, high = (guess - 1, guess) if holds(guess) else (guess, guess + 1)
    while True:
        if low < 1 or len(known) > ROUNDS:
            raise InputError(f"no gain near {guess} brings the error to {bound:g}; tried {sorted(known)}")
        if low not in known and holds(low):
            high, low = low, _below(low, known[low], bound)
        elif high not in known and not holds(high):
            low, high = high, _above(high, known[high], bound)
        elif high - low == 1:
            return SmallestGain(high, known[high], known[low], known[guess], len(known))
        else:
            middle = _between(low, high, known, bound, halve=len(known) % 3 == 0)
            if holds(middle):
                high = middle
            else:
                low = middle


def _above(gain: int, error: float, bound: float) -> int:
    """Beyond where the bound is met if error times gain is constant, which it nearly is."""
    return max(gain + 1, math.ceil(1.02 * gain * min(error / bound, 10.0)))


def _below(gain: int, error: float, bound: float) -> int:
    """The same downwards."""
    return min(gain - 1, math.floor(0.98 * gain * max(error / bound, 0.1)))


def _between(low: int, high: int, known: dict[int, float], bound: float, halve: bool) -> int:
    """The next gain to try: by the line through the bracket's ends on logarithmic scales, now and then its middle."""
    if halve or known[high] <= 0.0:
        return (low + high) // 2
    fall = math.log(known[low] / known[high])
    share = math.log(known[low] / bound) / fall if fall > 0.0 else 0.5
    root = float(low * (high / low) ** share)
    # The answer is the next integer above the root: try it, or its neighbour where it is an end already.
    return min(max(math.ceil(root), low + 1), high - 1)
