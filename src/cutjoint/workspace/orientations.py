"""Workspaces of robots that turn their tools, by sets of orientations.

Where the turns are held, a workspace is one of constant orientation.  Of a set of orientations the tool can have some
at a point (the reachable workspace of that set) or all of them (the dextrous one): union and intersection of the
workspaces of constant orientation, on one lattice, each joined with the start turned there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Literal

import numpy as np

from cutjoint.doors import door
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.mechanism.task import NAMES
from cutjoint.workspace.bounding import filled_whole
from cutjoint.workspace.exploring import Assembly, Exploring, Question, surveyed
from cutjoint.workspace.filling import Filled, Told, embedded
from cutjoint.workspace.lattice import Lattice
from cutjoint.workspace.map import checked_cells, cropped, filled_for, finished
from cutjoint.workspace.region import Workspace

Kind = Literal["reachable", "dextrous"]
"""Some orientation of a set, or all of them."""


@door
def orientation_workspace(
    robot: Mechanism,
    kind: Kind,
    tilt: float,
    *,
    axes: Sequence[str] | None = None,
    held: Mapping[str, float] | None = None,
    cells: int | None = None,
    near: Posture | None = None,
    assembly: Assembly = "home",
    limits: JointLimits = "respect",
    told: Told | None = None,
) -> Workspace:
    """Where the tool can be in some, or in all, orientations of a set: as at the start, and turned from there by `tilt`
    [rad] to either side of every led turn that is not held, and of their sums in all directions.

    All that is not told here is as of `workspace`.

    Args:
        robot: whose task leads places and turns.
        kind: "reachable" for some orientation of the set, "dextrous" for all.
        tilt: how far the orientations of the set are turned [rad], more than 0 and less than half a turn.

    Raises:
        InputError: the task leads no turns or no places, `tilt` or `kind` is none; and as of `workspace`.
    """
    if kind not in ("reachable", "dextrous"):
        raise InputError(f'kind must be "reachable" or "dextrous", found {kind!r}')
    if not 0.0 < tilt < np.pi:
        raise InputError(f"tilt must be more than 0 and less than pi rad, found {tilt!r}")
    checked_cells(cells)
    asked = Question(None if axes is None else tuple(axes), {}, held or {}, near, assembly, limits)
    survey = surveyed(robot, asked)
    given = dict(held or {})
    turns = [name for name in survey.goals.held if NAMES.index(name) >= 3 and name not in given]
    if not turns or any(unit == "rad" for unit in survey.goals.units):
        raise InputError(
            f"a {kind} workspace is over places, of a robot that leads turns too; the task of {robot.name} "
            f"is {robot.task}"
        )
    found = [_turned(survey, asked, shift) for shift in _shifts(turns, tilt)]
    surveys = [one for one in found if one is not None]
    if kind == "dextrous" and len(surveys) < len(found):
        raise InputError(
            f"{robot.name} cannot turn its tool by {tilt:g} rad to all sides at the start, so nothing is joined "
            "with it; ask for a smaller tilt, or start elsewhere"
        )
    together = _together(surveys, cells, all_of_them=kind == "dextrous", told=told)
    if not together.inside.any():
        raise InputError(f"at no point that was looked at {robot.name} has all orientations of the set")
    words = f"{kind}: {len(surveys)} orientations, turned by up to {tilt:g} rad in {', '.join(turns)}"
    best = replace(survey, told=(*survey.told, words))
    return finished(best, cropped(together), ())


def _together(surveys: Sequence[Exploring], cells: int | None, *, all_of_them: bool, told: Told | None) -> Filled:
    """Union or intersection of the workspaces of all orientations."""
    base, parts = filled_for(surveys[0], cells).lattice, list[Filled]()
    for k, one in enumerate(surveys):
        # what all of them have lies in what the first has
        whole = one.filler.fill(base, coarse=False)
        parts.append(whole if all_of_them else filled_whole(one.filler, base, whole))
        if told is not None:
            told(float(k + 1))
    lattice = _lattice([one.lattice for one in parts])
    return _combined(lattice, [embedded(one, lattice) for one in parts], all_of_them=all_of_them)


def _shifts(turns: Sequence[str], tilt: float) -> list[dict[str, float]]:
    """Turns of a set: none, and `tilt` in all directions in which each turn has a part or none."""
    found = []
    for signs in product((0, 1, -1), repeat=len(turns)):
        size = float(np.linalg.norm(signs)) or 1.0
        found.append({name: tilt * sign / size for name, sign in zip(turns, signs, strict=True)})
    return found


def _turned(survey: Exploring, asked: Question, shift: Mapping[str, float]) -> Exploring | None:
    """The survey with the tool turned; None where it cannot be, at the start."""
    held = {name: value for name, value in survey.goals.held.items() if NAMES.index(name) >= 3}
    turned = {name: value + shift.get(name, 0.0) for name, value in held.items()}
    try:
        return surveyed(survey.robot, replace(asked, axes=survey.goals.names, held={**asked.held, **turned}))
    except CutjointError:
        return None


def _lattice(parts: Sequence[Lattice]) -> Lattice:
    """One lattice over all that some have, in their cells."""
    steps = parts[0].steps
    first = np.array([one.first for one in parts]).min(axis=0)
    last = np.array([one.first + steps * np.array(one.shape) for one in parts]).max(axis=0)
    shape = np.round((last - first) / steps).astype(int)
    return Lattice(first, steps, tuple(shape.tolist()), (False,) * len(shape))


def _combined(lattice: Lattice, parts: Sequence[Filled], *, all_of_them: bool) -> Filled:
    inside, ways = np.array([one.inside for one in parts]), np.array([one.ways for one in parts])
    joined = np.asarray(inside.all(axis=0) if all_of_them else inside.any(axis=0), dtype=bool)
    together = np.where(joined, ways.min(axis=0) if all_of_them else ways.max(axis=0), 0.0)
    states = np.array(parts[0].states)
    for here, one in zip(inside[1:], parts[1:], strict=True):
        missing = np.isnan(states).any(axis=1) & here
        states[missing] = one.states[missing]
    states[~joined] = np.nan
    return Filled(lattice, joined, states, together)
