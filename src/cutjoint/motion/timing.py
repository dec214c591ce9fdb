"""How far along its way a motion is at a time: laws of time for ways from rest to rest, and smooth corners.

- Minimum jerk: 10 s^3 - 15 s^4 + 6 s^5 of s = t / duration (T. Flash, N. Hogan: The coordination of arm movements.
  J. Neurosci. 5 (1985) 1688-1703).  Twice continuously differentiable (C2).
- There and back: 64 s^3 (1 - s)^3, out by 1 and home again, at rest without acceleration at both ends (C2).
- Trapezoid: constant acceleration, constant speed, constant deceleration.  Only C1: the acceleration jumps four times.
- Corners: straight legs at constant speed, joined by blends.  In a blend of 2 b around the corner at t_k the velocity
  goes from that of one leg to that of the next by a step S(u), u = (t - t_k) / (2 b) + 1/2:  u for the parabolic blend
  (C1), 3 u^2 - 2 u^3 for the quintic one, which is the polynomial of at most fifth degree that meets both legs in
  position, velocity and acceleration (C2).  Both have the integral 1/2, so that the sum

      x(t) = x_0 + sum_k (velocity after - velocity before)_k 2 b integral S

  is on every leg between two blends, and misses the corners themselves (J. J. Craig: Introduction to robotics, chapter
  on trajectory generation: linear functions with blends).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import line

Progress = tuple[float, float, float]
"""Part of the way, its rate [1/s] and the rate of that [1/s2]."""

Smooth = Literal["quintic", "parabolic"]


def minimum_jerk(t: float, duration: float) -> Progress:
    """Progress with the least mean squared jerk from rest at 0 to rest at `duration` [s]; it rests outside."""
    s = min(max(t / duration, 0.0), 1.0)
    return (
        s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        30.0 * s * s * (1.0 - s) ** 2 / duration,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2,
    )


def there_and_back(t: float, duration: float) -> Progress:
    """Progress from rest at 0 to 1 at half the `duration` [s] and back to rest; it rests outside."""
    s = min(max(t / duration, 0.0), 1.0)
    product, slope = s * (1.0 - s), 1.0 - 2.0 * s
    return (
        64.0 * product**3,
        192.0 * product * product * slope / duration,
        384.0 * product * (1.0 - 5.0 * product) / duration**2,
    )


def trapezoid(t: float, duration: float, ramp: float) -> Progress:
    """Progress at constant speed but for the first and last `ramp` [s], which have constant acceleration."""
    if not 0.0 <= t < duration:
        return (0.0 if t < 0.0 else 1.0), 0.0, 0.0
    speed, left = 1.0 / (duration - ramp), duration - t
    if t < ramp:
        return 0.5 * speed * t * t / ramp, speed * t / ramp, speed / ramp
    if left < ramp:
        return 1.0 - 0.5 * speed * left * left / ramp, speed * left / ramp, -speed / ramp
    return speed * (t - 0.5 * ramp), speed, 0.0


@door
@dataclass(frozen=True, eq=False)
class Corners(Values):
    """Straight legs from point to point, from rest to rest, with blends at every point, the first and last included.

    Attributes:
        points: shape (k, width), k >= 2.
        seconds: from each point to the next, were there no blends, shape (k - 1,), [s].
        blend: half the time of a blend [s]; at most half of the shortest leg.
        smooth: "quintic" (C2) or "parabolic" (C1).
    """

    points: Array
    seconds: Array
    blend: float
    smooth: Smooth = "quintic"

    __repr__ = line(points="m or rad", seconds="s", blend="s")

    def __post_init__(self) -> None:
        own = self.__dict__
        own["points"] = readonly(points_of("points", self.points))
        own["seconds"] = readonly(as_vector("seconds", self.seconds, len(self.points) - 1, "s"))
        own["blend"] = positive("blend", self.blend, "s")
        shortest = positive("the seconds of the shortest leg", self.seconds.min(), "s")
        if self.smooth not in ("quintic", "parabolic"):
            raise InputError(f"smooth must be 'quintic' or 'parabolic', found {self.smooth!r}")
        if 2.0 * self.blend > shortest * (1.0 + 1e-12):
            raise InputError(
                f"blends of {self.blend:.4g} s to both sides overlap on the leg of {shortest:.4g} s; at most half of it"
            )

    @cached_property
    def _times(self) -> Array:
        """Of the corners, shape (k,) [s]."""
        return self.blend + np.concatenate([[0.0], np.cumsum(self.seconds)])

    @cached_property
    def _jumps(self) -> Array:
        """Of the velocity at the corners, shape (k, width)."""
        legs = np.diff(self.points, axis=0) / self.seconds[:, None]
        still = np.zeros((1, self.points.shape[1]))
        return np.diff(np.concatenate([still, legs, still]), axis=0)

    @property
    def duration(self) -> float:
        """From rest to rest [s]."""
        return float(self.seconds.sum() + 2.0 * self.blend)

    def at(self, t: float) -> tuple[Array, Array, Array]:
        """Place, velocity and acceleration at a time [s], shape (width,) each."""
        if t >= self.duration:
            still = np.zeros(self.points.shape[1])
            return self.points[-1], still, still
        length = 2.0 * self.blend
        since = t - self._times
        u = np.clip(since / length + 0.5, 0.0, 1.0)
        if self.smooth == "quintic":
            step, rate, area = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / length, u**3 * (1.0 - 0.5 * u)
        else:
            step, rate, area = u, ((u > 0.0) & (u < 1.0)) / length, 0.5 * u * u
        ramp = np.where(u < 1.0, length * area, since)
        return self.points[0] + ramp @ self._jumps, step @ self._jumps, rate @ self._jumps


def points_of(name: str, values: npt.ArrayLike, width: int | None = None) -> Array:
    """At least two points as a finite array (k, width).

    Raises:
        InputError: they are none; the message names the argument.
    """
    wanted = f"{name} must be at least two points of {'as many' if width is None else width} numbers each"
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{wanted}, found {values!r}") from error
    if array.ndim != 2 or array.shape[0] < 2 or width not in (None, array.shape[1]):
        raise InputError(f"{wanted}, found shape {array.shape}")
    as_vector(name, array.ravel(), array.size)
    return array
