"""Quantities over the cells of a workspace.

With J the rates of the led coordinates by the actuators (n, n), J_p its rows of places, and the same made dimensionless
by the robot's length, J_0:

    type1       least singular value of J_0
    condition   largest singular value of J_0 over the least
    isotropy    1 / condition
    effort      largest effort of one actuator that a force of 1 N on the tool point asks, whatever its direction along
                the led places: the largest column of J_p
    speed       largest rate of one actuator at a speed of 1 m/s of the tool point, whatever its direction, led turns
                held: the largest row of the columns of J^-1 of places
    stiffness   least stiffness of the tool point against forces, where every actuator has the stiffness 1 N/m or
                1 N m/rad: 1 / (largest singular value of J_p)^2
    type2       distance to a type-2 singularity, as `ClosedChain.mobility` tells it
    bearing     largest force in a joint or cut that a force of 1 N on the tool point adds, whatever its direction in
                space: of all joints and cuts, the largest singular value of what three unit forces add
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile import CompiledChain
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Load
from cutjoint.reprs import line
from cutjoint.workspace.exploring import Exploring, led_jacobian
from cutjoint.workspace.filling import Filled, Told
from cutjoint.workspace.region import FieldMap
from cutjoint.workspace.walking import ChainWalker


class Cells:
    """What is known of the cells that are reached.

    Args:
        survey: the workspace.
        filled: its cells.
        told: called with how many cells are done.
    """

    def __init__(self, survey: Exploring, filled: Filled, told: Told | None) -> None:
        self.survey, self.numbers, self.told = survey, np.flatnonzero(filled.inside), told
        self.states = filled.states[self.numbers]
        self.at = filled.lattice.coordinates(self.numbers)

    @cached_property
    def jacobian(self) -> Array:
        """Rates of all led coordinates by the actuators, shape (N, led, n)."""
        walker = self.survey.walker
        if isinstance(walker, ChainWalker):
            return np.asarray(np.linalg.inv(walker.rates(self.states, self.at).actuated))
        return np.array([self._one(state) for state in self.states])

    def _one(self, state: Array) -> Array:
        survey = self.survey
        return led_jacobian(survey.robot, survey.goals.task, survey.posture(state))

    @property
    def places(self) -> list[int]:
        """Rows of J that are of places."""
        return [k for k, row in enumerate(self.survey.goals.task.rows) if row < 3]

    @property
    def scaled(self) -> Array:
        """J, dimensionless."""
        survey, length = self.survey, self.survey.length
        rows = np.array([1.0 / length if row < 3 else 1.0 for row in survey.goals.task.rows])
        columns = np.array([length if one.kind == "translation" else 1.0 for one in survey.robot.actuators])
        return np.asarray(rows[:, None] * self.jacobian * columns)


Computed = Callable[[Cells], Array]


@dataclass(frozen=True)
class MapRow:
    """A row of the table.

    Attributes:
        title: what it is, in words.
        values: of all cells, shape (N,).
        best: "high" or "low".
        unit: SI unit, in which A stands for that of an actuator's coordinate and F for that of its effort; "" for a
            ratio.
        of_places: whether it needs places that are led.
        of_chains: whether it needs a closed chain.
    """

    title: str
    values: Computed
    best: str = "high"
    unit: str = ""
    of_places: bool = False
    of_chains: bool = False

    __repr__ = line("title", "unit", "best")


def _singular(cells: Cells) -> Array:
    return np.asarray(np.linalg.svd(cells.scaled, compute_uv=False))


def _condition(cells: Cells) -> Array:
    values = _singular(cells)
    with np.errstate(divide="ignore"):
        return np.asarray(values[:, 0] / values[:, -1])


def _effort(cells: Cells) -> Array:
    return np.asarray(np.linalg.norm(cells.jacobian[:, cells.places], axis=1).max(axis=1))


def _speed(cells: Cells) -> Array:
    rates = np.linalg.pinv(cells.jacobian)[:, :, cells.places]
    return np.asarray(np.linalg.norm(rates, axis=2).max(axis=1))


def _stiffness(cells: Cells) -> Array:
    return np.asarray(np.linalg.norm(cells.jacobian[:, cells.places], ord=2, axis=(1, 2)) ** -2.0)


def _type2(cells: Cells) -> Array:
    chain, found = _chain(cells), np.empty(len(cells.states))
    for k, state in enumerate(cells.states):
        found[k] = chain.mobility(cells.survey.posture(state)).type2
        if cells.told is not None and k % 100 == 0:
            cells.told(float(k))
    return found


def _bearing(cells: Cells) -> Array:
    chain, found = _chain(cells).geometry, np.empty(len(cells.states))
    for k, state in enumerate(cells.states):
        at = cells.survey.posture(state)
        free = [one.force for one in chain.reactions(at)]
        added = [np.array([one.force for one in chain.reactions(at, loads=Load(axis))]) - free for axis in np.eye(3)]
        found[k] = np.linalg.norm(np.stack(added, axis=2), ord=2, axis=(1, 2)).max()
        if cells.told is not None and k % 10 == 0:
            cells.told(float(k))
    return found


def _chain(cells: Cells) -> CompiledChain:
    robot = cells.survey.robot
    assert isinstance(robot, CompiledChain)
    return robot


MAPS: Mapping[str, MapRow] = {
    "condition": MapRow("condition number of the Jacobian", _condition, "low"),
    "isotropy": MapRow("isotropy: 1 / condition number", lambda cells: 1.0 / _condition(cells)),
    "type1": MapRow("distance to type-1 singularities", lambda cells: _singular(cells)[:, -1]),
    "type2": MapRow("distance to type-2 singularities", _type2, of_chains=True),
    "bearing": MapRow("largest joint force per force at the tool", _bearing, "low", "N/N", of_chains=True),
    "effort": MapRow("largest effort per force at the tool", _effort, "low", "F/N", of_places=True),
    "speed": MapRow("largest actuator speed per tool speed", _speed, "low", "(A/s)/(m/s)", of_places=True),
    "stiffness": MapRow("least stiffness per actuator stiffness", _stiffness, "high", "(N/m)/(F/A)", of_places=True),
}
"""Quantities over the cells, by name."""


def chosen_maps(names: Sequence[str], survey: Exploring) -> tuple[str, ...]:
    """Names of maps that this robot can have.

    Raises:
        UnknownNameError: there is none of a name.
        InputError: this robot cannot have it, or a name is given twice.
    """
    for name in names:
        if name not in MAPS:
            raise UnknownNameError("map", name, list(MAPS))
    led, actuators = len(survey.goals.task.rows), len(survey.robot.actuators)
    if names and (survey.goals.free or led != actuators):
        raise InputError(
            f"maps need as many actuators ({actuators} here) as the task has coordinates ({led} here): "
            "leave the maps out"
        )
    places = any(row < 3 for row in survey.goals.task.rows)
    for name in names:
        if MAPS[name].of_places and not places:
            raise InputError(
                f"map {name} is of forces and speeds of the tool point, which {survey.robot.name} does not lead"
            )
        if MAPS[name].of_chains and not isinstance(survey.robot, CompiledChain):
            raise InputError(f"map {name} is of closed chains; {survey.robot.name} is a reduced model")
    if len(set(names)) < len(names):
        raise InputError(f"a map is asked for twice among {', '.join(names)}")
    return tuple(names)


def mapped(names: Sequence[str], survey: Exploring, filled: Filled, told: Told | None = None) -> dict[str, FieldMap]:
    """The maps over all cells."""
    cells, found = Cells(survey, filled, told), {}
    for name in names:
        row = MAPS[name]
        values = np.full(filled.lattice.size, np.nan)
        values[cells.numbers] = row.values(cells)
        unit = _unit(row.unit, survey)
        found[name] = FieldMap(row.title, unit, values.reshape(filled.lattice.shape), row.best)
    return found


def _unit(unit: str, survey: Exploring) -> str:
    kinds = {one.kind for one in survey.robot.actuators}
    a, f = ("m", "N") if kinds == {"translation"} else ("rad", "N m") if kinds == {"rotation"} else ("m|rad", "N|N m")
    return unit.replace("A", a).replace("F", f)
