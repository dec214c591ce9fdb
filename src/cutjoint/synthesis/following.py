"""The numbers of a description that design variables change, and how they follow the variables.

Every number is affine in a path, of the third degree in the ratio of a stretch (lengths 1, masses 1, moments of
inertia 3), and made of sine and cosine in a mounting.  So the derivatives come from as many nodes as their degree asks
for: they are exact but for rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from cutjoint.arrays import Array
from cutjoint.description import RobotDescription
from cutjoint.description.paths import Path, every_path
from cutjoint.description.values import number
from cutjoint.reprs import line
from cutjoint.synthesis.variables import Variable, chosen

PROBES = 8
"""Random designs at which numbers are told apart."""
MOST_CORNERS = 6
"""Up to so many variables, all corners of their ranges tell what numbers span."""
SAME = 1e-12
TURN = 2e-3
"""Step of a mounting [rad]: the fifth power of it is beyond the digits."""


@dataclass(frozen=True)
class JoinedNumbers:
    """Numbers that are one and the same in every design.

    Attributes:
        paths: to them.
        low, high: what they span.
    """

    paths: tuple[Path, ...]
    low: float
    high: float

    __repr__ = line("name", "low", "high")

    @property
    def first(self) -> Path:
        """One of the paths."""
        return self.paths[0]

    @property
    def name(self) -> str:
        """The paths joined, as `cutjoint.compile.compiled` takes them."""
        return " = ".join(map(str, self.paths))


class FollowedNumbers:
    """How groups of numbers, and the mass that moves, follow the variables of a robot.

    Attributes:
        groups: what changes.
    """

    __repr__ = line("groups")

    def __init__(self, robot: RobotDescription, variables: tuple[Variable, ...]) -> None:
        self._robot, self._variables = robot, variables
        now = np.array([one.now(robot) for one in variables])
        low, high = np.array([one.low for one in variables]), np.array([one.high for one in variables])
        self._low, self._high = low, high
        unit = qmc.Sobol(len(now), scramble=True, seed=0).random(PROBES)
        points = [now, *(low + unit * (high - low))]
        if len(now) <= MOST_CORNERS:
            points += [low + np.array(one) * (high - low) for one in np.ndindex(*[2] * len(now))]
        every = every_path(robot)
        table = np.array([_read(chosen(robot, variables, point), every) for point in points])
        self.groups = _groups(every, table)
        self._first = tuple(one.first for one in self.groups)

    def at(self, values: Array) -> Array:
        """The groups' numbers in a design, shape (groups,)."""
        return self._numbers(values)[:-1]

    def slopes(self, values: Array) -> tuple[Array, Array]:
        """How they follow the variables there, shape (groups, variables), and the mass that moves, (variables,)."""
        columns = []
        for k, one in enumerate(self._variables):
            nodes = _nodes(one, float(values[k]))
            weights = _weights(nodes - values[k])
            table = []
            for node in nodes.tolist():
                there = np.array(values)
                there[k] = node
                table.append(self._numbers(there))
            columns.append(weights @ np.array(table))
        found = np.array(columns).T
        return found[:-1], found[-1]

    def _numbers(self, values: Array) -> Array:
        robot = chosen(self._robot, self._variables, values)
        return np.append(_read(robot, self._first), moving_mass(robot))


def moving_mass(robot: RobotDescription) -> float:
    """Of all links but the base [kg]."""
    return float(sum(one.inertial.mass for one in robot.links if one.inertial is not None and one.name != robot.root))


def _read(robot: RobotDescription, every: tuple[Path, ...]) -> Array:
    return np.array([number(robot, path) for path in every])


def _groups(every: tuple[Path, ...], table: Array) -> tuple[JoinedNumbers, ...]:
    """Columns that change, those that are the same in all rows joined."""
    size = np.maximum(np.abs(table).max(axis=0), np.finfo(float).tiny)
    changed = np.flatnonzero(np.ptp(table, axis=0) > SAME * size)
    groups: list[list[int]] = []
    for column in changed.tolist():
        for group in groups:
            same = np.abs(table[:, column] - table[:, group[0]]).max() <= SAME * size[column]
            if same and _kind(every[column]) == _kind(every[group[0]]):
                group.append(column)
                break
        else:
            groups.append([column])
    return tuple(
        JoinedNumbers(
            tuple(every[column] for column in group),
            float(table[:, group[0]].min()),
            float(table[:, group[0]].max()),
        )
        for group in groups
    )


def _kind(path: Path) -> tuple[str, str]:
    """Numbers of one kind may be joined: masses, moments of inertia, places of joints."""
    return path.part, path.field.partition(".")[0] if path.part == "links" else ""


def _nodes(variable: Variable, at: float) -> Array:
    """Values at which all numbers are read: within the range, but for a mounting."""
    if variable.kind == "mount":
        return at + TURN * np.arange(-2.0, 3.0)
    count = 2 if variable.kind == "path" else 4
    return np.linspace(variable.low, variable.high, count)


def _weights(away: Array) -> Array:
    """Weights of values at nodes, `away` from where the derivative is asked for, that give it."""
    size = float(np.abs(away).max())
    powers = np.vander(away / size, increasing=True)
    wanted = np.zeros(len(away))
    wanted[1] = 1.0 / size
    return np.asarray(np.linalg.solve(powers.T, wanted), dtype=np.float64)
