"""The ends of the ranges of a study, looked at before it begins: whether there can be such a body, and whether the
robot closes there.

Of up to six paths all corners of the box of ranges are looked at; of more the two ends of every path, the others in the
middle, and 64 corners drawn at random.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.sources.parameters import Parameters
from cutjoint.description.check import check_description
from cutjoint.errors import DescriptionError, InputError
from cutjoint.findings import listing
from cutjoint.reprs import counted
from cutjoint.studies.blocks import Prepared
from cutjoint.studies.cases import StudyCase
from cutjoint.studies.loops import CANNOT_START, PreparedCase
from cutjoint.studies.paths import is_of_robot
from cutjoint.studies.values import Study

MOST_PATHS = 6
DRAWN = 64
STEPS = 2
"""Of the integrator, which show whether a run can start."""


def corners(case: StudyCase) -> Array:
    """The corners that are looked at, shape (N, paths)."""
    bounds = np.array([spread.bounds for spread in case.spreads]).reshape(-1, 2)
    count = len(bounds)
    if count <= MOST_PATHS:
        return np.array(list(product(*bounds.tolist()))).reshape(-1, count)
    middle = bounds.mean(axis=1)
    ends = []
    for k in range(count):
        for bound in bounds[k]:
            ends.append(middle.copy())
            ends[-1][k] = bound
    sides = np.random.default_rng(0).integers(0, 2, (DRAWN, count))
    return np.concatenate([np.array(ends), bounds[np.arange(count), sides]])


def check_extremes(prepared: Prepared) -> None:
    """Look at the ends of the ranges of all cases.

    Raises:
        InputError: there is no such body, or the robot does not close there.
    """
    recipe = prepared.recipe
    known: set[tuple[object, ...]] = set()
    for k, case in enumerate(recipe.cases):
        own = (case.variant, *(spread.bounds for spread in case.spreads), id(case.trajectory), case.hardware is None)
        if own in known or not case.spreads:
            continue
        known.add(own)
        _check_bodies(recipe.study, case)
        _check_closing(prepared.case(k), corners(case))


def _check_bodies(study: Study, case: StudyCase) -> None:
    """Inertias and joints of the description at every corner."""
    if case.robot is None:
        return
    index = [k for k, one in enumerate(study.varied) if is_of_robot(one.path)]
    if not index:
        return
    names = [study.varied[k].path for k in index]
    parameters = Parameters(case.robot, names)
    before = {one.found for one in check_description(case.robot) if one.severity == "error"}
    for row in corners(case)[:, index]:
        try:
            robot = parameters.rebuilt(dict(zip(parameters.names, row.tolist(), strict=True)))
            wrong = [one for one in check_description(robot) if one.severity == "error" and one.found not in before]
        except (InputError, DescriptionError) as error:
            raise InputError(f"at {_told(names, row)}: {error}") from error
        if wrong:
            raise InputError(f"at {_told(names, row)}: {wrong[0].found}; expected {wrong[0].expected}")


def _check_closing(case: PreparedCase, rows: Array) -> None:
    """Whether the robot can start at every corner."""
    steps = STEPS * case.grid.step * max(1, case.grid.beat)
    duration = min(steps, case.reference.duration)
    try:
        found = case.run(rows, 0, duration=duration)
    except CANNOT_START as error:  # the reference itself
        raise InputError(f"{case.case.name or 'the study'}: {error}") from error
    failed = [k for k, why in enumerate(found.failed) if why is not None]
    if failed:
        first = failed[0]
        raise InputError(
            f"at {_told(case.paths, rows[first])} the robot cannot start ({counted(len(failed), 'corner')} of "
            f"{len(rows)} of the ranges): {found.failed[first]}"
        )


def _told(names: list[str], row: Array) -> str:
    return listing([f"{name} = {x:.6g}" for name, x in zip(names, row.tolist(), strict=True)])
