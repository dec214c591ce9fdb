"""Sizing, drawn: efforts over speeds of every actuator, and of the best motor the curves of what it can give.

With motors each panel is at the shaft of the motor that fits best, behind its gear; without, at the actuator.
"""

from __future__ import annotations

from math import ceil, pi
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import Actuator
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import BLUE, COLOURS, DASHES, GREY, INK, Drawing, drawable
from cutjoint.simulation.panels import scaled
from cutjoint.sizing import MotorFit, Sizing
from cutjoint.sizing.matching import choices

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RPM = 30.0 / pi
MOST = 6
"""Panels on a sheet."""
CURVE = 200


def draw_sizing(found: Sizing) -> Drawing:
    """Efforts over speeds, a panel an actuator; of more than six actuators the first six.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    shown = found.actuators[:MOST]
    columns = min(len(shown), 3)
    rows = ceil(len(shown) / columns)

    def draw(figure: Figure) -> None:
        from matplotlib.ticker import MaxNLocator

        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for i, (actuator, ax) in enumerate(zip(shown, axes, strict=False)):
            fits = found.fits_of(actuator.name)
            if fits:
                _at_motor(ax, found, i, fits[0])
            else:
                _at_actuator(ax, found, i, actuator)
            ax.axhline(0.0, color=GREY, linewidth=0.8, zorder=0)
            ax.axvline(0.0, color=GREY, linewidth=0.8, zorder=0)
            ax.margins(x=0.06, y=0.08)
            ax.xaxis.set_major_locator(MaxNLocator(4))
        for ax in axes[len(shown) :]:
            ax.set_axis_off()
        handles: dict[str, Artist] = {}
        for ax in axes:
            for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
                handles.setdefault(label, handle)
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=min(len(handles), 4))

    left = len(found.actuators) - len(shown)
    more = f", the first {MOST} of {len(found.actuators)} actuators" if left else ""
    payload = f" with {found.payload:g} kg" if found.payload else ""
    return sheet(draw, f"{found.robot}{payload}: effort over speed{more}", (4.1 * columns + 1.0, 3.7 * rows + 1.2))


def _paths(ax: Axes, found: Sizing, i: int, curves: list[tuple[Array, Array]]) -> None:
    for number, (cycle, (x, y)) in enumerate(zip(found.demands, curves, strict=True)):
        look = COLOURS[number % len(COLOURS)], DASHES[number % len(DASHES)]
        ax.plot(x, y, color=look[0], linestyle=look[1], linewidth=1.6, label=drawable(cycle.name))


def _at_actuator(ax: Axes, found: Sizing, i: int, actuator: Actuator) -> None:
    """At the actuator, with its rotor as the robot has it."""
    courses = [cycle.course for cycle in found.cycles]
    factor, unit = scaled(np.concatenate([one.effort[:, i] for one in courses]), actuator.effort_unit)
    _paths(ax, found, i, [(one.v[:, i], factor * one.effort[:, i]) for one in courses])
    duty = found.worst[i]
    ax.plot(duty.rms_speed, factor * duty.rms_effort, "o", color=INK, markersize=7, label="root mean squares")
    ax.set_title(drawable(actuator.name))
    ax.set_xlabel(f"speed [{actuator.unit}/s]")
    ax.set_ylabel(f"effort [{unit}]")


def _at_motor(ax: Axes, found: Sizing, i: int, fit: MotorFit) -> None:
    """At the shaft of a motor, with what it can give."""
    motor = fit.motor
    turns = motor.kind == "rotation"
    fast, speed_unit = (RPM, "rpm") if turns else (1.0, "m/s")
    factor, unit = scaled(np.array([motor.peak]), "N m" if turns else "N")
    curves = [choices(fit, [cycle], found.gearing, i) for cycle in found.demands]
    speed = np.linspace(-motor.max_speed, motor.max_speed, 2 * CURVE + 1)
    largest, lasting = factor * motor.largest(speed), factor * motor.lasting(speed)
    for sign in (1.0, -1.0):
        ax.fill_between(fast * speed, sign * lasting, color=BLUE, alpha=0.12, linewidth=0.0)
        ax.plot(fast * speed, sign * lasting, color=BLUE, linewidth=1.2, label="for ever")
        ax.plot(fast * speed, sign * largest, color=INK, linewidth=1.2, label="at most")
    for side in (1.0, -1.0):
        ax.plot([side * fast * motor.max_speed] * 2, [-largest[-1], largest[-1]], color=INK, linewidth=1.2)
    for number, (cycle, (x, y)) in enumerate(zip(found.demands, curves, strict=True)):
        colour, dash = COLOURS[(number + 1) % len(COLOURS)], DASHES[number % len(DASHES)]
        ax.plot(fast * x, factor * y, color=colour, linestyle=dash, linewidth=1.6, label=drawable(cycle.name))
    ax.plot(
        fast * fit.rms_speed, factor * fit.rms_effort, "o", color="#D55E00", markersize=7, label="root mean squares"
    )
    verdict = "fits" if fit.fits else f"too small: {fit.why_not}"
    name = drawable(fit.actuator.name)
    ax.set_title(f"{name}\n{drawable(motor.name)}, gear {fit.ratio:.4g}: {verdict}")
    ax.set_xlabel(f"speed of the motor [{speed_unit}]")
    ax.set_ylabel(f"effort of the motor [{unit}]")
