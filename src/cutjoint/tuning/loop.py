"""The linear loop of a robot and a law, continuous or sampled: its poles and its frequency response.

A sampled loop is discretised exactly: between two samples efforts are held, so that with Phi = exp(A T) and a delay of
d periods and a rest r from reading to effort

    x[k+1] = Phi x[k] + Gamma1 u[k-d-1] + Gamma0 u[k-d]
    Gamma0 = integral of exp(A s) B from 0 to T - r,  Gamma1 = exp(A (T - r)) times the integral from 0 to r

(K. J. Astroem, B. Wittenmark: Computer-Controlled Systems, 3rd edition, section 2.3).  Speeds that are differences of
positions through a low pass are in it, and so is the memory of the law, which moves on by a period a sample.

The loop is broken at the efforts: L = -C P, with the efforts in the order of the actuators.  With one actuator's loop
broken and those of the others closed its loop is 1/S_ii - 1, where S = 1 / (1 + L) is the sensitivity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.simulation.hardware import Differences, Hardware
from cutjoint.tuning.linear import LinearLaw, LinearPlant, discretised

Complex = npt.NDArray[np.complex128]
POINTS = 600
"""Frequencies on the even part of the grid; there are more about every pole."""
SHARP = 0.6
"""Damping ratio of a pole below which it is looked at closely."""
MOST_PERIODS = 400
"""Longest delay of a sampled loop in periods."""
LEFT = 1e-7
"""A pole this near to z = 0 is a place of a shift register."""


@dataclass(frozen=True)
class Timing:
    """When a sampled loop acts.

    Attributes:
        period: between two samples [s]; 0 for continuous control.
        delay: from a reading until the effort that answers it [s].
        differences: whether speeds are differences of positions.
        alpha: part of a new difference in the low pass of first order; 1 for none.
    """

    period: float = 0.0
    delay: float = 0.0
    differences: bool = False
    alpha: float = 1.0

    __repr__ = line(period="s", delay="s")


def timing_of(hardware: Hardware | None) -> Timing:
    """What is linear of hardware: rate, delays and differences.  Jitter, steps, noise, limits and play are not."""
    if hardware is None:
        return Timing()
    period, speed = hardware.clock.period, hardware.speed
    differences = isinstance(speed, Differences)
    cutoff = speed.cutoff if isinstance(speed, Differences) else None
    alpha = 1.0 if cutoff is None else -math.expm1(-2.0 * math.pi * cutoff * period)
    return Timing(period, hardware.encoder.delay + hardware.drive.delay, differences, alpha)


class _Part(NamedTuple):
    """x+ = a x + b u, y = c x + d u."""

    a: Array
    b: Array
    c: Array
    d: Array

    def at(self, points: Complex) -> Complex:
        """Its transfer matrix, shape (points, outputs, inputs)."""
        d = np.broadcast_to(self.d.astype(np.complex128), (len(points), *self.d.shape))
        if not len(self.a):
            return d
        resolvent = points[:, None, None] * np.eye(len(self.a)) - self.a
        return np.asarray(
            self.c @ np.linalg.solve(resolvent, np.broadcast_to(self.b, (len(points), *self.b.shape))) + d
        )


@dataclass(frozen=True, eq=False)
class LinearLoop(Values):
    """A plant and a law with the times of their hardware.

    Attributes:
        plant, law: near rest at the same posture.
        timing: continuous by default.

    Raises:
        InputError: a delay under continuous control, or of more than `MOST_PERIODS` periods.
    """

    plant: LinearPlant
    law: LinearLaw
    timing: Timing = Timing()

    __repr__ = line("plant", "timing")

    def __post_init__(self) -> None:
        period, delay = self.timing.period, self.timing.delay
        if not period and delay:
            raise InputError(f"a delay of {delay:g} s needs a loop that is sampled; give it a period")
        if period and delay > MOST_PERIODS * period:
            raise InputError(f"a delay of {delay:g} s is more than {MOST_PERIODS} periods of {period:g} s")

    @property
    def n(self) -> int:
        """Number of actuators."""
        return len(self.plant.q)

    @cached_property
    def _held(self) -> tuple[int, Array, Array, Array]:
        """Whole periods of the delay, Phi, Gamma0 and Gamma1 of a sampled loop."""
        a, b, period = self.plant.state, self.plant.input, self.timing.period
        late, rest = _split(self.timing.delay, period)
        begun, newer = discretised(a, b, period - rest)
        if not rest:
            return late, begun, newer, np.zeros_like(newer)
        over, older = discretised(a, b, rest)
        return late, begun @ over, newer, begun @ older

    @cached_property
    def _plant(self) -> _Part:
        """From efforts to measured positions and speeds; of a sampled loop with the commands on their way as states."""
        n = self.n
        if not self.timing.period:
            return _Part(self.plant.state, self.plant.input, np.eye(2 * n), np.zeros((2 * n, n)))
        late, begun, newer, older = self._held
        places = late + (1 if older.any() else 0)
        size = 2 * n + places * n
        whole, inputs = np.zeros((size, size)), np.zeros((size, n))
        whole[: 2 * n, : 2 * n] = begun
        for lag, gamma in ((late, newer), (late + 1, older)):
            if lag == 0:
                inputs[: 2 * n] = gamma
            elif lag <= places:
                whole[: 2 * n, 2 * n + (lag - 1) * n : 2 * n + lag * n] = gamma
        if places:
            inputs[2 * n : 3 * n] = np.eye(n)
            whole[3 * n :, 2 * n : size - n] += np.eye(size - 3 * n)
        return _Part(whole, inputs, np.eye(2 * n, size), np.zeros((2 * n, n)))

    def _plant_at(self, points: Complex) -> Complex:
        """Transfer matrix of the plant: without the registers, which are powers of 1 / z."""
        if not self.timing.period:
            return self._plant.at(points)
        late, begun, newer, older = self._held
        one = points[:, None, None]
        resolvent = one * np.eye(len(begun)) - begun
        return np.asarray(np.linalg.solve(resolvent, newer + older / one) / one**late)

    @cached_property
    def _law(self) -> _Part:
        """From measured positions and speeds to efforts."""
        law, timing, n = self.law, self.timing, self.n
        m = law.by_memory.shape[1]
        both, rates = np.hstack([law.by_q, law.by_v]), np.hstack([law.rate_q, law.rate_v])
        if not timing.period:
            return _Part(law.rate_memory, rates, law.by_memory, both)
        memory = np.eye(m) + timing.period * law.rate_memory
        if not timing.differences:
            return _Part(memory, timing.period * rates, law.by_memory, both)
        # its own state is (m, last reading, speed): what it sees as speed is a part of them
        keep, gain = 1.0 - timing.alpha, timing.alpha / timing.period
        none, one = np.zeros((n, n)), np.eye(n)
        seen = np.hstack([np.zeros((n, m)), -gain * one, keep * one])
        from_q = np.hstack([gain * one, none])
        a = np.vstack([np.zeros((m + n, m + 2 * n)), seen])
        a[:m, :m] = memory
        a[:m] += timing.period * law.rate_v @ seen
        q_alone = np.hstack([one, none])
        b = np.vstack([timing.period * (law.rate_q @ q_alone + law.rate_v @ from_q), q_alone, from_q])
        c = np.hstack([law.by_memory, np.zeros((n, 2 * n))]) + law.by_v @ seen
        return _Part(a, b, c, law.by_q @ q_alone + law.by_v @ from_q)

    @property
    def closed(self) -> Array:
        """The matrix of the closed loop: of x' = A x, or of x[k+1] = A x[k]."""
        p, c = self._plant, self._law
        return np.block([[p.a + p.b @ c.d @ p.c, p.b @ c.c], [c.b @ p.c, c.a]])

    @cached_property
    def poles(self) -> Complex:
        """Of the closed loop [1/s], the slowest first; of a sampled one log(z) / T, without registers at z = 0."""
        found: Complex = np.asarray(np.linalg.eigvals(self.closed), dtype=np.complex128)
        if self.timing.period:
            found = np.asarray(np.log(found[np.abs(found) > LEFT]) / self.timing.period)
        return np.asarray(found[np.lexsort((found.imag, -found.real))])

    @property
    def stable(self) -> bool:
        """Whether all poles decay."""
        return bool(np.isfinite(self.closed).all() and self.poles.real.max() < 0.0)

    @property
    def decay(self) -> float:
        """Of the slowest pole [1/s]; negative where it grows."""
        return float(-self.poles.real.max())

    @property
    def damping(self) -> float:
        """The least damping ratio of a pole; negative where one grows."""
        return float((-self.poles.real / np.maximum(np.abs(self.poles), 1e-300)).min())

    def frequencies(self, points: int = POINTS) -> Array:
        """Where to look at it [rad/s], with more points about every pole, open and closed."""
        period = self.timing.period
        open_poles = np.abs(np.linalg.eigvals(self.plant.state))
        sizes = np.concatenate([np.abs(self.poles), open_poles])
        sizes = sizes[sizes > 1e-9 * sizes.max()]
        top = math.pi / period if period else 1e3 * sizes.max()
        low = 1e-3 * min(sizes.min(), top)
        near = [
            abs(one) * (1.0 + k * max(-one.real / max(abs(one), 1e-300), 1e-3))
            for one in self.poles
            if -one.real < SHARP * abs(one)
            for k in (-3.0, -1.5, -0.7, -0.3, 0.0, 0.3, 0.7, 1.5, 3.0)
        ]
        grid: Array = np.unique(np.concatenate([np.geomspace(low, top, points), near]))
        return np.asarray(grid[(grid >= low) & (grid <= top)])

    def response(self, omega: Array) -> Complex:
        """L at frequencies [rad/s], shape (frequencies, n, n)."""
        period = self.timing.period
        points = np.exp(1j * omega * period) if period else 1j * omega.astype(np.complex128)
        return np.asarray(-self._law.at(points) @ self._plant_at(points))

    def sensitivity(self, omega: Array) -> Complex:
        """S = 1 / (1 + L) at frequencies [rad/s], shape (frequencies, n, n)."""
        return np.asarray(np.linalg.inv(np.eye(self.n) + self.response(omega)))


def _split(delay: float, period: float) -> tuple[int, float]:
    """Whole periods of a delay, and the rest [s]."""
    late = math.floor(delay / period * (1.0 + 1e-12) + 1e-12)
    rest = delay - late * period
    return late, rest if rest > 1e-9 * period else 0.0
