"""Motions from files: how long it takes to load one and to ask it, beside numpy's and scipy's own functions."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.rounds import Contender, Timing, duration, measure, repeated
from cutjoint.motion import ToolMotion, motion_from_file
from cutjoint.robots import load

HEADINGS = "t,x,y,z,qx,qy,qz,qw"


def timings(rows: int, calls: int, rounds: int) -> tuple[dict[str, Timing], float]:
    """CPU time of loading a file of poses, and of one instant of it; and by how much its rotations differ from scipy's
    spline [rad]."""
    from scipy.spatial.transform import Rotation, RotationSpline

    robot = load("stewart")
    times = np.linspace(0.0, 20.0, rows)
    turns = Rotation.from_rotvec(0.2 * np.sin(np.outer(times, [1.0, 1.3, 0.7])) ** 3)
    points = robot.task.home.position + 0.02 * np.sin(np.outer(times, [0.8, 1.1, 1.7])) ** 2
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "way.csv"
        table = np.column_stack([times, points, turns.as_quat()])
        np.savetxt(path, table, delimiter=",", header=HEADINGS, comments="", fmt="%.17g")
        motion, peer = motion_from_file(path, robot), RotationSpline(times, turns)
        found = measure(
            {
                f"load {rows} poses": Contender(partial(motion_from_file, path, robot)),
                "numpy.loadtxt alone": Contender(partial(np.loadtxt, path, delimiter=",", skiprows=1)),
                "scipy's RotationSpline alone": Contender(partial(RotationSpline, times, turns)),
                "an instant: pose, twist and its rate": Contender(repeated(partial(motion.at, 7.77), calls), calls),
                "scipy's: rotation, rate and its rate": Contender(
                    repeated(lambda: [peer(7.77, order) for order in range(3)], calls), calls
                ),
            },
            rounds,
        )
    now = motion.at(7.77)
    assert isinstance(now, ToolMotion)
    assert now.rotation is not None
    return found, float((peer(7.77).inv() * Rotation.from_matrix(now.rotation)).magnitude())


def table_rows(found: dict[str, Timing]) -> list[tuple[str, ...]]:
    """What was timed and how long it takes."""
    return [(name, duration(timing.median)) for name, timing in found.items()]
