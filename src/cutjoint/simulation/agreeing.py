"""Whether the columns of a run agree with each other: coordinates with speeds, efforts with work, configurations with
gaps.

Integrals over the samples are only as good as the samples are dense, so each is taken in several ways, and only what
differs by more than these do among themselves counts.  Runs with fewer samples than half their steps are not looked at:
what moved in between is not in them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.simulation.result import Result
from cutjoint.simulation.summary import actuators_of

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain

SPREADS = 4.0
"""Times that ways of integration may differ among themselves."""
FEWEST = 5
"""Samples of which something can be said."""
SMALL = 1e-6
"""Parts of a radian or of the tool's distance from the origin below which a robot stands still."""
LOOKED_AT = 200
"""Configurations of a run of which gaps are computed anew."""


def why_not(result: Result) -> str:
    """Why the columns cannot be held against each other; empty where they can."""
    if "steps" not in result.about:
        return "the run does not tell its steps"
    steps = int(result.about["steps"])
    if len(result) < FEWEST or 2 * len(result) < steps:
        return f"{len(result)} samples of {steps} steps do not show what moved in between"
    return ""


def disagreements(result: Result) -> dict[str, float]:
    """How far columns are from each other beyond what the samples leave open, as parts of their sizes, by name."""
    time, q = result.time, np.array(result.q)
    length = float(np.linalg.norm(result.tool, axis=1).max())
    found = {
        "tool and its velocity": _apart(
            result.tool - result.tool[:1], _integrals(time, result.tool_velocity), SMALL * length
        )
    }
    turning = np.array([kind != "translation" for _, kind in actuators_of(result)], dtype=bool)
    for name, own, size in (("angles and speeds", turning, 1.0), ("ways and speeds", ~turning, length)):
        if own.any():
            moved = np.unwrap(q[:, own], axis=0) if own is turning else q[:, own]
            found[name] = _apart(moved - moved[:1], _integrals(time, result.v[:, own]), SMALL * size)
    if q.shape[1]:
        turned = max(result.kinetic.max(), np.ptp(result.potential), SMALL * np.abs(result.potential).max())
        found["efforts and work"] = _apart(result.work[:, None], _works(result), float(turned))
    return found


def gap_of(result: Result, robot: ClosedChain) -> tuple[float, float]:
    """Worst loop gap ([m], [rad]) of the configurations themselves, whatever the column of gaps says."""
    if result.q_full.shape[1] != robot.nq:
        return 0.0, 0.0
    some = np.unique(np.linspace(0, len(result) - 1, LOOKED_AT).astype(int))
    gaps = np.array([robot.gap(result.q_full[i]) for i in some])
    return float(gaps[:, 0].max()), float(gaps[:, 1].max())


def _apart(values: Array, ways: list[Array], size: float) -> float:
    """How far values (m, n) are from the nearest of some ways to compute them, less what these differ, as a
    part of them, or of `size` where that is more."""
    spread = float(np.ptp(np.array(ways), axis=0).max())
    least = min(float(np.abs(values - way).max()) for way in ways)
    whole = max(size, float(np.abs(values).max()), *(float(np.abs(way).max()) for way in ways))
    return max(least - SPREADS * spread, 0.0) / whole if whole > 0.0 else 0.0


def _integrals(time: Array, rates: Array) -> list[Array]:
    """Integrals of rates (m, n) from the first sample on: with straight lines between samples, and with a spline."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time, rates).antiderivative()
    return [
        _summed(np.diff(time)[:, None] * (rates[1:] + rates[:-1]) / 2.0),
        np.asarray(spline(time) - spline(time[0])),
    ]


def _works(result: Result) -> list[Array]:
    """Work of efforts on speeds, shape (m, 1): held from each sample on, as a clock has it, else also until it, and as
    power that changes."""
    clocked = result.about.get("rate") is not None and "hardware" not in result.about
    held = []
    for moved in (np.diff(one, axis=0) for one in _integrals(result.time, result.v)):
        for effort in (result.effort[:-1],) if clocked else (result.effort[:-1], result.effort[1:]):
            held.append(_summed((effort * moved).sum(axis=1)[:, None]))
    if clocked:
        return held
    return [*held, *_integrals(result.time, (result.effort * result.v).sum(axis=1)[:, None])]


def _summed(parts: Array) -> Array:
    return np.concatenate([np.zeros((1, parts.shape[1])), np.cumsum(parts, axis=0)])
