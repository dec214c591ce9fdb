"""Margins of a linear loop: how much gain, phase and delay it bears.

Of every actuator, with the loops of the others closed, by python-control; and of all together

    sensitivity   the largest singular value of D^-1 S D over frequencies, D the roots of the diagonal of the mass
                  matrix, by which actuators of different units and sizes compare.  A peak of Ms leaves every loop a
                  gain margin of Ms / (Ms - 1) or more and a phase margin of 2 asin(1 / (2 Ms)) or more
    delay         by which all efforts may come later together until the loop is unstable: of a sampled loop by the
                  poles of its exact discretisation, of a continuous one from where the loci of the eigenvalues of L
                  cross the unit circle
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.extras import needed
from cutjoint.reprs import line
from cutjoint.tuning.loop import Complex, LinearLoop

WHAT = "a margin of a loop"
MOST_DELAY = 100.0
"""Periods up to which the delay margin of a sampled loop is sought."""
CLOSE = 1e-4
REAL = 1e-6


@dataclass(frozen=True)
class ActuatorMargins:
    """How much the loop of one actuator bears, the others being closed.

    Attributes:
        actuator: its name.
        gain: factor by which the loop's gain may change, below 1 where it may only fall; infinite where it may grow
            without end.
        gain_at: frequency of it [rad/s]; NaN where there is none.
        phase: margin [deg]; infinite where the gain is below 1 everywhere.
        crossover: frequency of the phase margin [rad/s]; NaN where there is none.
        delay: by which this effort alone may come later [s].
    """

    actuator: str
    gain: float
    gain_at: float
    phase: float
    crossover: float
    delay: float

    __repr__ = line(
        "actuator", "gain", "phase", "crossover", "delay", gain_at="rad/s", phase="deg", crossover="rad/s", delay="s"
    )


@dataclass(frozen=True, eq=False)
class LoopMargins(Values):
    """Margins of a loop at one posture.

    Attributes:
        actuators: of every actuator.
        sensitivity: peak of the sensitivity; infinite where the loop is unstable.
        delay: by which all efforts may come later together [s]; 0 where the loop is unstable.
        poles: of the closed loop, shape (poles,) [1/s].
        damping: least damping ratio of a pole.
        decay: of the slowest pole [1/s].
        omega: frequencies, shape (w,) [rad/s].
        loops: of every actuator, the others closed, shape (w, n).
    """

    actuators: tuple[ActuatorMargins, ...]
    sensitivity: float
    delay: float
    poles: Complex
    damping: float
    decay: float
    omega: Array
    loops: Complex

    __repr__ = line("sensitivity", "delay", "damping", "decay", delay="s", decay="1/s")

    @property
    def stable(self) -> bool:
        """Whether the loop is stable."""
        return self.decay > 0.0


def margins_of(loop: LinearLoop, names: tuple[str, ...]) -> LoopMargins:
    """Margins of a loop whose actuators have these names.

    Raises:
        MissingPackageError: python-control is not installed.
    """
    needed("control", WHAT)
    omega = loop.frequencies()
    whole = loop.response(omega)
    sensitivity: Complex = np.asarray(np.linalg.inv(np.eye(loop.n) + whole))
    loops = 1.0 / np.einsum("wii->wi", sensitivity) - 1.0
    stable, is_sampled = loop.stable, loop.timing.period > 0.0
    loops.setflags(write=False)
    return LoopMargins(
        tuple(
            _of_actuator(name, omega, loops[:, i], stable=stable, is_sampled=is_sampled) for i, name in enumerate(names)
        ),
        peak_of(loop, sensitivity) if stable else math.inf,
        _delay(loop, omega, whole) if stable else 0.0,
        loop.poles,
        loop.damping,
        loop.decay,
        readonly(omega),
        loops,
    )


def sensitivity_peak(loop: LinearLoop, points: int) -> float:
    """The peak of the sensitivity alone; infinite where the loop is unstable."""
    if not loop.stable:
        return math.inf
    return peak_of(loop, loop.sensitivity(loop.frequencies(points)))


def peak_of(loop: LinearLoop, sensitivity: Complex) -> float:
    """The largest singular value of S, shape (frequencies, n, n), in the sizes of the actuators."""
    size = np.sqrt(np.maximum(np.diag(loop.plant.mass), 1e-300))
    return float(np.linalg.norm(sensitivity * size[None, None, :] / size[None, :, None], 2, axis=(1, 2)).max())


def _of_actuator(name: str, omega: Array, loop: Complex, *, stable: bool, is_sampled: bool) -> ActuatorMargins:
    if not stable:
        return ActuatorMargins(name, math.nan, math.nan, math.nan, math.nan, 0.0)
    control = needed("control", WHAT)
    phase = np.degrees(np.unwrap(np.angle(loop)))
    gains, phases, _, turns, crossovers, _ = control.stability_margins((np.abs(loop), phase, omega), returnall=True)
    gains, turns = np.asarray(gains), np.asarray(turns)
    if is_sampled and loop[-1].real < 0.0 and abs(loop[-1].imag) < REAL * abs(loop[-1]):
        # it may cross 180 deg just at the last frequency, where it is real
        gains, turns = np.append(gains, 1.0 / abs(loop[-1])), np.append(turns, omega[-1])
    gain, gain_at = math.inf, math.nan
    if len(gains):
        k = int(np.abs(np.log(np.maximum(gains, 1e-300))).argmin())
        gain, gain_at = float(gains[k]), float(turns[k])
    phases, crossovers = np.asarray(phases), np.asarray(crossovers)
    if not len(phases):
        return ActuatorMargins(name, gain, gain_at, math.inf, math.nan, math.inf)
    least = int(np.abs(phases).argmin())
    delay = float((np.radians(np.mod(phases, 360.0)) / crossovers).min())
    return ActuatorMargins(name, gain, gain_at, float(abs(phases[least])), float(crossovers[least]), delay)


def _delay(loop: LinearLoop, omega: Array, whole: Complex) -> float:
    """By how much all efforts may come later [s]."""
    period = loop.timing.period
    return _delay_by_poles(loop) if period else _delay_by_loci(omega, whole)


def _delay_by_loci(omega: Array, whole: Complex) -> float:
    """Where |eigenvalue of L| = 1: the phase that is left there, over the frequency; the least of all."""
    loci = np.linalg.eigvals(whole)
    for k in range(1, len(loci)):  # each goes on as what is nearest
        away = np.abs(loci[k - 1][:, None] - loci[k][None, :])
        order = [0] * len(away)
        for _ in range(len(away)):
            row, column = np.unravel_index(int(away.argmin()), away.shape)
            order[int(row)] = int(column)
            away[row], away[:, column] = np.inf, np.inf
        loci[k] = loci[k, order]
    least = math.inf
    for locus in loci.T:
        size, turn = np.log(np.abs(locus)), np.unwrap(np.angle(locus))
        for k in np.flatnonzero(size[:-1] * size[1:] <= 0.0).tolist():
            if size[k] == size[k + 1]:
                continue
            part = size[k] / (size[k] - size[k + 1])
            at = omega[k] * (omega[k + 1] / omega[k]) ** part
            left = np.mod(turn[k] + part * (turn[k + 1] - turn[k]) + math.pi, 2.0 * math.pi)
            least = min(least, float(left / at))
    return least


def _delay_by_poles(loop: LinearLoop) -> float:
    """The first delay at which a pole of the sampled loop grows."""
    period, timing = loop.timing.period, loop.timing

    def stable(more: float) -> bool:
        return replace(loop, timing=replace(timing, delay=timing.delay + more)).stable

    low, high = 0.0, 0.25 * period
    while stable(high):
        low, high = high, high + max(0.25 * period, 0.15 * high)
        if high > MOST_DELAY * period:
            return math.inf
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
