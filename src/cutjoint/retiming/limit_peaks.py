"""The largest of every limited quantity along a motion, beside its limit, and the file that holds a motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.files import write_whole
from cutjoint.mechanism import Actuator
from cutjoint.motion import JointSpline
from cutjoint.reprs import line
from cutjoint.retiming.limits import OF_ACTUATORS, OF_TOOL, MotionLimits
from cutjoint.tables import TextTable

ACTIVE = 0.98
"""The part of a limit from which on it is said to be active."""


@dataclass(frozen=True)
class LimitPeak:
    """The largest of one limited quantity along a motion.

    Attributes:
        quantity: what it is, such as `effort of arm1`.
        largest: in its `unit`.
        limit: in the same unit.
        unit: N, m/s, ...
        t: when [s].
        active: the part of the time for which it is at 98 % of its limit or more.
    """

    quantity: str
    largest: float
    limit: float
    unit: str
    t: float
    active: float

    __repr__ = line("quantity", "largest", "limit", "unit", "t", t="s")

    @property
    def part(self) -> float:
        """The largest beside its limit."""
        return self.largest / self.limit


def peaks_of(used: Mapping[str, Array], limits: MotionLimits, t: Array) -> tuple[tuple[LimitPeak, ...], Array]:
    """The peaks of quantities whose parts are known at instants t, and those parts as columns, shape (k, peaks)."""
    rows, columns = [], []
    span = np.gradient(t) / np.sum(np.gradient(t))
    for quantity in (one for one in (*OF_ACTUATORS, *OF_TOOL) if one in used):
        for j in np.flatnonzero(np.isfinite(limits.of(quantity))).tolist():
            part = np.abs(used[quantity][:, j])
            top, limit = int(np.argmax(part)), float(limits.of(quantity)[j])
            named, unit = limits.named(quantity, j), limits.unit(quantity, j)
            active = float(span[part >= ACTIVE].sum())
            rows.append(LimitPeak(named, float(part[top] * limit), limit, unit, float(t[top]), active))
            columns.append(used[quantity][:, j])
    return tuple(rows), np.array(columns).T


def table_of(name: str, checked: int, peaks: Sequence[LimitPeak]) -> TextTable:
    """The peaks of a robot beside their limits."""
    rows = [
        (
            one.quantity,
            f"{one.largest:.5g}",
            f"{one.limit:.5g}",
            one.unit,
            f"{100.0 * one.part:.2f} %",
            f"{one.t:.4g} s",
            f"{100.0 * one.active:.0f} %",
        )
        for one in peaks
    ]
    columns = ("quantity", "largest", "limit", "", "part", "at", "active")
    return TextTable(f"{name}, peaks of {checked} instants", columns, rows, right=columns[1:3] + columns[4:])


def write_motion(path: str | os.PathLike[str], motion: JointSpline, actuators: Sequence[Actuator], robot: str) -> Path:
    """Write a motion as a file that is a trajectory: t and the actuators, the rows of the spline, all digits.

    Raises:
        InputError: the suffix is not .csv, or nothing can be written there.
    """
    path = Path(path)
    if path.suffix.lower() != ".csv":
        raise InputError(f"'{path}': a motion is written as .csv, found '{path.suffix}'")
    names = [f"joint.{one.name}" for one in actuators]
    if any(mark in name for name in names for mark in ',;\t"\n'):
        raise InputError(f"actuators of {robot} have separators in their names, which headings cannot have")
    rows = np.column_stack([motion.times, motion.q])
    text = ",".join(["t", *names]) + "\n"
    text += "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
    return write_whole(path, text.encode())
