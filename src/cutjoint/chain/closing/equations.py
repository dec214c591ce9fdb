"""Closure and driver as one system of equations: errors, their derivative, and when they are met."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.kinematics import Kinematics, Placed

WELL = 1e-3
"""Openness (1 is closed) below which nothing is left to gain."""
SMALL = 1e-4
"""Steps of Newton's method smaller than this (in radians or link lengths) leave errors of its square, and change
a determinant too little to look at."""


class Scales(NamedTuple):
    """What all systems of equations with a kind of driver have in common.

    Attributes:
        scale: factor per row that makes errors dimensionless, shape (rows,).
        driven: the same for the driver's rows, and for the velocities of its Jacobian, shape (driver's rows, nv).
        lengths: 1 for every row that is a length, else 0, shape (rows,).
        fixed: what counts as closed of every row whatever the length: of angles, and the rounding of places [m].
        closed: one over what counts as closed, of every row, where that is the same everywhere.
    """

    scale: Array
    driven: Array
    lengths: Array
    fixed: Array
    closed: Array | None

    @staticmethod
    def of(kinematics: Kinematics, driver: Driver | None) -> Scales:
        """Of a driver; made once for each kind."""
        k = kinematics
        kind = None if driver is None else (type(driver), driver.is_length.tobytes())
        found = k.scales.get(kind)
        if not isinstance(found, Scales):
            lengths = k.closure.is_length if driver is None else np.concatenate([k.closure.is_length, driver.is_length])
            scale = np.where(lengths, 1.0 / k.length, 1.0)
            driven = scale[k.closure.rows :, None] * k.column_scale
            rounded = k.rounded if driver is not None and driver.is_of_tool else 0.0
            far = np.where(np.arange(len(lengths)) >= k.closure.rows, rounded, 0.0)
            fixed = far + np.where(lengths, 0.0, tolerances.CLOSURE.value)
            found = Scales(scale, driven, lengths.astype(float), fixed, None)
            if not k.travels:
                found = found._replace(closed=found.closed_by(k.closed_length))
            k.scales[kind] = found
        return found

    def closed_by(self, length: float) -> Array:
        """One over what counts as closed, of every row, for a length."""
        return np.asarray(1.0 / (self.lengths * length + self.fixed))


class System:
    """The rows of closure and driver as one system of equations."""

    def __init__(self, kinematics: Kinematics, driver: Driver | None) -> None:
        self.k, self.driver, self.scales = kinematics, driver, Scales.of(kinematics, driver)

    def at(self, placed: Placed, fraction: float = 1.0) -> Equations:
        """The equations at one configuration, this fraction of the driver's way."""
        raw, scales = placed.residual, self.scales
        if self.driver is not None:
            raw = np.concatenate([raw, self.driver.error(placed, fraction)])
        closed = scales.closed_by(self.k.closed_within(placed.q)) if scales.closed is None else scales.closed
        left = raw * closed
        openness = max(sqrt(left.dot(left)), self.k.left_open(placed))
        return Equations(self, placed, fraction, scales.scale * raw, openness)


class Equations(NamedTuple):
    """Closure and driver at one configuration.

    Attributes:
        placed: the configuration.
        fraction: of the driver's way.
        error: of all rows, dimensionless, shape (rows,).
        openness: norm of the errors in units of what counts as closed; 1 is closed.  Rows that are left out count where
            they are open by more than rounding.
    """

    system: System
    placed: Placed
    fraction: float
    error: Array
    openness: float

    @property
    def matrix(self) -> Array:
        """Derivative of the error by dimensionless motions, shape (rows, nv)."""
        driver = self.system.driver
        if driver is None:
            return self.placed.scaled
        return np.concatenate(
            [self.placed.scaled, driver.jacobian(self.placed, self.fraction) * self.system.scales.driven]
        )

    @property
    def driven(self) -> Array:
        """The driver's part of the error."""
        return self.error[self.system.k.closure.rows :]

    def is_closed(self, last: float = inf, motion: float = inf) -> bool:
        """Whether Newton's method has done its work here: well below what counts as closed, or below it and no better
        than before.

        Args:
            last: openness before the last step.
            motion: size of that step; what a small one leaves is rounding.
        """
        worst = self.openness
        return worst < (WELL if motion > SMALL else 10.0 * WELL) or (worst < 1.0 and worst > 0.1 * last)
