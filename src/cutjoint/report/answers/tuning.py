"""The picture of a tuning: Bode plot of the loops at the worst posture, with margins, and step responses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import COLOURS, DASHES, GREY, INK, Drawing, drawable
from cutjoint.simulation.charts import look
from cutjoint.tuning import ActuatorMargins, JudgedGains, Tuning
from cutjoint.tuning.loop import Complex

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import Locator

SHOWN = 1e-4
WIDE = 100.0
"""Smallest size of a loop that is drawn, and its reciprocal; and how far from where it crosses 0 dB."""


def tuning_sheet(tuning: Tuning) -> Drawing:
    """Magnitude and phase of every actuator's loop over frequency, and what each does on a step.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """

    def draw(drawn: Figure) -> None:
        places = drawn.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
        size = drawn.add_subplot(places[0, 0])
        turn = drawn.add_subplot(places[1, 0], sharex=size)
        _bode(size, turn, tuning)
        _steps(drawn.add_subplot(places[:, 1]), tuning)
        handles, labels = size.get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4), handlelength=3.0)

    return sheet(draw, f"{tuning.robot}, {tuning.law}")


def _bode(size: Axes, turn: Axes, tuning: Tuning) -> None:
    found = tuning.found
    worst = _worst(found)
    for k, name in enumerate(tuning.actuators):
        colour, dash = COLOURS[look(k)[0]], DASHES[look(k)[1]]
        _loop(size, turn, found, k, colour=colour, linestyle=dash, label=drawable(name))
    for row, dash in zip(tuning.rows[1:3], ("--", ":"), strict=False):
        label = drawable(f"{row.label} gains, {tuning.actuators[worst]}")
        _loop(size, turn, row, worst, colour=GREY, linestyle=dash, label=label)
    omega, loop = _shown(found, worst)
    size.axhline(0.0, color=INK, linewidth=0.8)
    turn.axhline(-180.0, color=INK, linewidth=0.8)
    _mark(size, turn, found.margins.actuators[worst], omega, loop)
    size.set_xscale("log")
    size.set_ylabel("magnitude [dB]")
    turn.set_ylabel("phase [deg]")
    turn.set_xlabel("frequency [rad/s]")
    size.set_title("Loops, one broken at a time")
    size.tick_params(labelbottom=False)
    for axis in (size.xaxis, size.yaxis, turn.xaxis, turn.yaxis):
        axis.set_major_formatter(lambda x, _: f"{x:g}".replace("-", "\N{MINUS SIGN}"))
    turn.yaxis.set_major_locator(_every(45.0, turn.get_ylim()))


def _every(step: float, limits: tuple[float, float]) -> Locator:
    from matplotlib.ticker import MultipleLocator

    span = limits[1] - limits[0]
    return MultipleLocator(step if span < 8.0 * step else 2.0 * step if span < 16.0 * step else 8.0 * step)


def _shown(row: JudgedGains, k: int) -> tuple[Array, Complex]:
    """What of a loop is drawn."""
    omega, loop = row.margins.omega, row.margins.loops[:, k]
    near = (np.abs(loop) > SHOWN) & (np.abs(loop) < 1.0 / SHOWN)
    if math.isfinite(at := row.margins.actuators[k].crossover):
        near &= (omega > at / WIDE) & (omega < at * WIDE)
    return omega[near], loop[near]


def _phase(loop: Complex) -> Array:
    """Unwrapped [deg]; where the loop crosses 0 dB it is between -360 and 0."""
    found = np.degrees(np.unwrap(np.angle(loop)))
    if len(found):
        here = int(np.abs(np.log(np.abs(loop))).argmin())
        found = found - 360.0 * math.ceil((found[here] - 1e-6) / 360.0)
    return np.asarray(found, dtype=np.float64)


def _loop(size: Axes, turn: Axes, row: JudgedGains, k: int, *, colour: str, linestyle: object, label: str) -> None:
    omega, loop = _shown(row, k)
    size.plot(omega, 20.0 * np.log10(np.abs(loop)), color=colour, linestyle=linestyle, label=label)
    turn.plot(omega, _phase(loop), color=colour, linestyle=linestyle)


def _mark(size: Axes, turn: Axes, margins: ActuatorMargins, omega: Array, loop: Complex) -> None:
    """The phase margin at its frequency, and the gain margin at its own."""
    if not len(omega):
        return
    phase = _phase(loop)
    if math.isfinite(margins.crossover):
        at = float(np.interp(margins.crossover, omega, phase))
        for axis in (size, turn):
            axis.axvline(margins.crossover, color=GREY, linewidth=0.8)
        turn.plot([margins.crossover] * 2, [-180.0, at], color=INK, linewidth=2.5)
        words = f"{margins.phase:.0f} deg at {margins.crossover:.3g} rad/s"
        _say(turn, words, (margins.crossover, -180.0), (8, -14), "left")
    if math.isfinite(margins.gain_at) and math.isfinite(margins.gain):
        at = -20.0 * math.log10(margins.gain)
        size.plot([margins.gain_at] * 2, [0.0, at], color=INK, linewidth=2.5)
        words = f"{abs(at):.1f} dB at {margins.gain_at:.4g} rad/s"
        _say(size, words, (margins.gain_at, 0.0), (4, 10), "right")


def _say(axis: Axes, words: str, at: tuple[float, float], away: tuple[int, int], side: str) -> None:
    paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
    axis.annotate(words, at, away, textcoords="offset points", va="center", ha=side, bbox=paper)


def _worst(row: JudgedGains) -> int:
    """The actuator with the least phase margin."""
    phases = [one.phase if math.isfinite(one.phase) else math.inf for one in row.margins.actuators]
    return int(np.argmin(phases))


def _steps(axis: Axes, tuning: Tuning) -> None:
    found = tuning.found
    for k, one in enumerate(found.steps):
        colour, dash = COLOURS[look(k)[0]], DASHES[look(k)[1]]
        axis.plot(one.time, one.response, color=colour, linestyle=dash)
    worst = _worst(found)
    for row, dash in zip(tuning.rows[1:3], ("--", ":"), strict=False):
        if row.steps:
            axis.plot(row.steps[worst].time, row.steps[worst].response, color=GREY, linestyle=dash)
    axis.axhline(1.0, color=INK, linewidth=0.8)
    for side in (axis.xaxis, axis.yaxis):
        side.set_major_formatter(lambda x, _: f"{x:g}")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("response over the step [-]")
    axis.set_title("Step of each actuator" if found.steps else "Unstable: no step response")
    if found.steps:
        axis.set_xlim(0.0, found.steps[0].time[-1])
