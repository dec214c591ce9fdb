"""Curves of couplings by other means than the library's: numpy's polynomials, scipy's splines.

A curve gives its value, slope and bend at a number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import CubicSpline

Curve = Callable[[float], tuple[float, float, float]]


def power_series(*coefficients: float) -> Curve:
    """sum of coefficients[k] x^k."""
    whole = Polynomial(coefficients)
    parts = whole, whole.deriv(), whole.deriv(2)
    return lambda x: tuple(float(part(x)) for part in parts)  # type: ignore[return-value]


def natural_spline(points: Sequence[Sequence[float]]) -> Curve:
    """Through points (x, y) without bend at the ends, and straight beyond them."""
    x, y = np.array(points, dtype=float).T
    spline = CubicSpline(x, y, bc_type="natural")

    def curve(at: float) -> tuple[float, float, float]:
        near = float(np.clip(at, x[0], x[-1]))
        slope = float(spline(near, 1))
        return float(spline(near)) + slope * (at - near), slope, float(spline(near, 2)) if near == at else 0.0

    return curve
