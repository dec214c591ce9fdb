"""A motion from a file: a table of numbers with named columns (see `table` and `headings`) as a smooth trajectory.

Columns are t and some of x, y, z; an orientation as a quaternion qx, qy, qz, qw, as roll, pitch, yaw about the fixed
axes x, y, z in this order (as in URDF), or as the rotation vector rx, ry, rz away from home, which are the coordinates
of the task; or else names of actuators.  What has no column stays as at home.

All of it is in the axes in which the robot's task is: those of the world, or of the tool at home, from there on.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.doors import door_but, of_type
from cutjoint.errors import WaypointError
from cutjoint.files import is_file
from cutjoint.mechanism import Mechanism, Task
from cutjoint.mechanism.rotations import NOT_QUITE, quaternion_of
from cutjoint.motion.headings import FIXED_AXES, POINT, QUATERNION, VECTOR, meaning_of
from cutjoint.motion.rotation_vectors import Four, product
from cutjoint.motion.splines import APART, JointSpline, PointSpline, PoseSpline, as_poses, is_closed
from cutjoint.motion.table import NumberTable, read_table

SUFFIXES = (".csv", ".tsv")
HEADINGS = -1
"""The row that stands for the line of headings."""
SEAM = np.deg2rad(30.0)
"""The largest step in which an angle may pass from half a turn to minus half a turn, or from a whole one to none."""


def is_motion_file(spec: str) -> bool:
    """Whether a word where a trajectory is named is a file with a motion."""
    return spec.casefold().endswith(SUFFIXES) or is_file(spec)


@door_but("mechanism")
def motion_from_file(path: str | os.PathLike[str], mechanism: Mechanism) -> PointSpline | PoseSpline | JointSpline:
    """The motion that a file tells a mechanism: the spline through its rows, closed where the last row is the first.

    Raises:
        MotionFileError: the file is none, or a cell, heading or row is wrong; the message tells line and column.
        InputError: the robot has no tool, or its task cannot be told.
    """
    if not hasattr(mechanism, "home"):
        of_type("mechanism of motion_from_file", mechanism, Mechanism)
    table = read_table(path)
    columns = _columns(table, mechanism)
    clock = columns.pop("t")
    times, name = _times(table, clock), Path(path).stem
    try:
        if all(one.of_joint for one in columns.values()):
            q = np.tile(mechanism.home.q, (len(times), 1))
            for at, joint in enumerate(mechanism.actuators):
                if joint.name in columns:
                    q[:, at] = columns[joint.name].si
            return JointSpline(times, q, is_closed(q), name)
        task = mechanism.task
        points, given = _points(columns, task), tuple(one for one in POINT if one in columns)
        turning = tuple(one for one in VECTOR if one in columns)
        if not turning and not columns.keys() <= set(POINT):
            turning = VECTOR
        if not turning:
            return PointSpline(times, points, is_closed(points), given, name)
        poses = as_poses(np.column_stack([points, *_quaternions(table, columns, task)]))
        return PoseSpline(times, poses, is_closed(poses), (*given, *turning), name)
    except WaypointError as error:
        raise table.fault(str(error), error.waypoint) from error


@dataclass(frozen=True, eq=False)
class _Column(Frozen):
    """A column of the table: its number, what it tells, and its numbers as they are written."""

    number: int
    of_joint: bool
    factor: float
    values: Array

    @property
    def si(self) -> Array:
        """Its numbers in SI units."""
        return self.values * self.factor


def _times(table: NumberTable, clock: _Column) -> Array:
    """Times since the first row [s]."""
    times: Array = (clock.values - clock.values[0]) * clock.factor
    late = np.flatnonzero(np.diff(times) < APART)
    if len(late):
        before, now = clock.values[late[0] : late[0] + 2].tolist()
        what = f"{now!r} after {before!r}" if now != before else f"{now!r} a second time"
        raise table.fault(f"found {what}; expected times that ascend from row to row", int(late[0]) + 1, clock.number)
    return times


def _columns(table: NumberTable, mechanism: Mechanism) -> dict[str, _Column]:
    """The columns by what they tell, among them t."""
    columns: dict[str, _Column] = {}
    for number, heading in enumerate(table.headings):
        try:
            meaning = meaning_of(heading, mechanism.actuators)
        except ValueError as error:
            raise table.fault(str(error), HEADINGS, number) from error
        if meaning.name in columns:
            first = table.headings[columns[meaning.name].number]
            raise table.fault(
                f"found a second column for {meaning.name}, after '{first}'; expected one", HEADINGS, number
            )
        columns[meaning.name] = _Column(number, meaning.of_joint, meaning.factor, table.values[:, number])
    _check_together(table, columns)
    return columns


def _check_together(table: NumberTable, columns: Mapping[str, _Column]) -> None:
    """Raises where columns do not make a motion together."""
    found = ", ".join(table.headings)
    if "t" not in columns:
        raise table.fault(f"found no column t among {found}; expected the time of every row, as t or t [ms]", HEADINGS)
    if len(columns) == 1:
        raise table.fault("found no column but t; expected some of x, y, z, an orientation, or actuators", HEADINGS)
    of_joint = {name: one.of_joint for name, one in columns.items() if name != "t"}
    if len(set(of_joint.values())) > 1:
        raise table.fault(
            f"found columns of the tool and of actuators, {found}; expected one or the other: together they say things "
            "twice",
            HEADINGS,
        )
    ways = [way for way in (QUATERNION, FIXED_AXES, VECTOR) if not columns.keys().isdisjoint(way)]
    if len(ways) > 1:
        raise table.fault(f"found the orientation told in {len(ways)} ways, {found}; expected one of them", HEADINGS)
    if ways == [QUATERNION] and (missing := [name for name in QUATERNION if name not in columns]):
        raise table.fault(f"found a quaternion without {', '.join(missing)}; expected qx, qy, qz and qw", HEADINGS)


def _points(columns: Mapping[str, _Column], task: Task) -> Array:
    """Where the tool point is, shape (rows, 3) [m]."""
    in_tool = task.axes == "tool"
    start = np.zeros(3) if in_tool else task.home.position
    rows = len(next(iter(columns.values())).values)
    points = np.tile(start, (rows, 1))
    for at, name in enumerate(POINT):
        if name in columns:
            points[:, at] = columns[name].si
    return task.home.position + points @ task.basis.T if in_tool else points


def _quaternions(table: NumberTable, columns: Mapping[str, _Column], task: Task) -> Four[Array]:
    """The orientation of the tool in the world, x y z w, each of shape (rows,)."""
    home = _constant(task.home.rotation, len(table.values))
    if not columns.keys().isdisjoint(VECTOR):
        turning = [columns[one] for one in VECTOR if one in columns and columns[one].values.any()]
        if len(turning) == 1:
            _check_jumps(table, turning)
        turn = _of_vectors(*(columns[one].si if one in columns else 0.0 * home[0] for one in VECTOR))
        return product(home, turn) if task.axes == "tool" else product(turn, home)
    if "qx" in columns:
        found = _units(table, columns)
    else:
        _check_jumps(table, [columns[one] for one in FIXED_AXES if one in columns])
        found = _of_fixed_axes(table, columns, np.eye(3) if task.axes == "tool" else task.home.rotation)
    return product(home, found) if task.axes == "tool" else found


def _units(table: NumberTable, columns: Mapping[str, _Column]) -> Four[Array]:
    """Quaternions that are given."""
    x, y, z, w = (columns[one].si for one in QUATERNION)
    sizes = np.sqrt(x * x + y * y + z * z + w * w)
    wrong = np.flatnonzero(~(np.abs(sizes - 1.0) <= 1e3 * NOT_QUITE))
    if len(wrong):
        row = int(wrong[0])
        raise table.fault(
            f"found a quaternion of length {sizes[row]:.6g}; expected 1 for qx, qy, qz, qw", row, columns["qx"].number
        )
    return x, y, z, w


def _of_fixed_axes(table: NumberTable, columns: Mapping[str, _Column], home: Array) -> Four[Array]:
    """Roll about x, then pitch about y, then yaw about z; one that is not given is as at `home`, shape (3, 3)."""
    angles = [
        np.arctan2(home[2, 1], home[2, 2]),
        np.arcsin(np.clip(-home[2, 0], -1.0, 1.0)),
        np.arctan2(home[1, 0], home[0, 0]),
    ]
    missing = [one for one in FIXED_AXES if one not in columns]
    if missing and abs(home[2, 0]) > 1.0 - 1e-9:
        raise table.fault(
            f"found no {' and '.join(missing)}, which cannot be as at home: with a pitch of 90 degrees as there, roll "
            "and yaw are one; expected roll, pitch and yaw, or a quaternion",
            HEADINGS,
        )
    zero = np.zeros(len(table.values))
    roll, pitch, yaw = (
        columns[one].si if one in columns else zero + angle for one, angle in zip(FIXED_AXES, angles, strict=True)
    )
    return product(_of_vectors(zero, zero, yaw), product(_of_vectors(zero, pitch, zero), _of_vectors(roll, zero, zero)))


def _of_vectors(x: Array, y: Array, z: Array) -> Four[Array]:
    """Quaternions of rotation vectors [rad]."""
    angle = np.sqrt(x * x + y * y + z * z)
    factor = 0.5 * np.sinc(angle / (2.0 * np.pi))  # numpy's sinc(x) is sin(pi x) / (pi x)
    return factor * x, factor * y, factor * z, np.cos(0.5 * angle)


def _constant(rotation: Array, rows: int) -> Four[Array]:
    x, y, z, w = (np.full(rows, one) for one in quaternion_of(rotation))
    return x, y, z, w


def _check_jumps(table: NumberTable, given: Sequence[_Column]) -> None:
    """Refuses an angle that jumps by more than half a turn, unless all that it does is to pass the seam at half or at a
    whole turn: from 0 to 270 degrees the spline would go 90 degrees the other way, from 0 to 360 not at all.

    Where two of three jump, it may be a change between two ways to write one orientation.
    """
    jumps = np.array([np.abs(np.diff(one.si)) for one in given])
    large = jumps > np.pi + 1e-9
    left = np.abs(jumps - 2.0 * np.pi * np.round(jumps / (2.0 * np.pi)))
    wrong = large & (large.sum(axis=0) == 1) & ((left > SEAM) | (left < 1e-9))
    if wrong.any():
        row = int(np.flatnonzero(wrong.any(axis=0))[0])
        angle = given[int(np.flatnonzero(wrong[:, row])[0])]
        before, now = angle.values[row : row + 2]
        turn = 2.0 * np.pi / angle.factor
        raise table.fault(
            f"found a step from {before:.6g} to {now:.6g}; expected less than half a turn from row to row: give rows "
            f"between, or write {now - turn * np.round((now - before) / turn):.6g} for {now:.6g} if it goes that way",
            row + 1,
            angle.number,
        )
