"""The workspace of a robot: which cells of a grid its tool can be led to from home, and how well it does there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, compiled
from cutjoint.doors import door
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.workspace.bounding import COARSE, SLOW_COARSE, check_memory, filled_whole, lattice_for
from cutjoint.workspace.exploring import Assembly, Exploring, Question, surveyed
from cutjoint.workspace.filling import Filled, Told
from cutjoint.workspace.lattice import Lattice, Numbers
from cutjoint.workspace.maps import chosen_maps, mapped
from cutjoint.workspace.region import GridAxis, Workspace

CELLS = 40
"""Cells along the longest axis, as a rule."""
PUBLISHED_CELLS = 36
"""The same of a published model, of whose cells at the boundary it is known what part is reached."""
SLOW_CELLS = 16
"""The same of a robot that is asked posture by posture."""
MOST_CELLS = 100_000
"""Cells along an axis at most."""


@door
def workspace(
    robot: Mechanism,
    *,
    axes: Sequence[str] | None = None,
    region: Mapping[str, Sequence[float]] | None = None,
    held: Mapping[str, float] | None = None,
    cells: int | None = None,
    near: Posture | None = None,
    assembly: Assembly = "home",
    limits: JointLimits = "respect",
    maps: Sequence[str] = (),
    collisions: bool = False,
    told: Told | None = None,
) -> Workspace:
    """Where the tool of a robot can be, joined with a posture without a singularity between.

    Args:
        robot: a closed chain or a published model, compiled or not; any other mechanism is asked posture by posture.
        axes: 1 to 3 coordinates of its task that the grid is over; default those of `region`, else the places that are
            led and not held, else the turns.
        region: coordinate -> (least, largest) [m] or [rad]; default as far as is reached.
        held: the other coordinates, where they are held [m] or [rad]; default as at the start.
        cells: along the longest axis; default 40, of a published model 36, of a
            robot that is asked posture by posture 16.
        near: the posture to start from, which picks working mode and assembly mode; default home.
        assembly: "home" for the assembly mode of the start, "any" for what is reached through type-2 singularities too.
        limits: whether joint limits are respected or ignored.
        maps: names of quantities over the cells, of `cutjoint.workspace.MAPS`.
        collisions: whether postures in which links touch each other are left out.
        told: called now and then with how many cells are done.

    Raises:
        InputError: a range that is none or does not hold the start, too many cells or axes, something held that
            varies, or collisions or a map that this robot cannot have.
        UnknownNameError: no such coordinate or map.
        ActuationError: the actuators do not determine the motion.
        UnreachableError, LimitError, SingularError: what is held cannot be, from the start.
    """
    said = None if axes is None else tuple(axes)
    asked = Question(said, region or {}, held or {}, near, assembly, limits, collisions)
    checked_cells(cells)
    survey = surveyed(robot, asked, told)
    chosen = chosen_maps(maps, survey)
    filled = filled_for(survey, cells)
    return finished(survey, filled, chosen, told)


def checked_cells(cells: int | None) -> None:
    """Raises InputError where they are no number of cells along an axis."""
    if cells is not None and not 3 <= cells <= MOST_CELLS:
        raise InputError(f"cells along the longest axis must be 3 to {MOST_CELLS}, found {cells}")


def filled_for(survey: Exploring, cells: int | None) -> Filled:
    """All that is reached, cropped."""
    usual = PUBLISHED_CELLS if survey.walker is None else SLOW_CELLS if survey.is_slow else CELLS
    count = usual if cells is None else cells
    check_memory(survey.filler, len(survey.goals.names), count)
    coarse = SLOW_COARSE if survey.is_slow else COARSE
    stride = survey.stride * (COARSE / coarse)
    lattice = lattice_for(survey.filler, survey.goals, survey.limits, count, stride, coarse)
    return cropped(filled_whole(survey.filler, lattice))


def cropped(filled: Filled) -> Filled:
    """The same without what lies more than a cell beside all that is reached."""
    lattice, block = filled.lattice, filled.inside.reshape(filled.lattice.shape)
    if not block.any():
        return filled
    parts = []
    for axis, count in enumerate(lattice.shape):
        where = np.flatnonzero(block.any(axis=tuple(k for k in range(block.ndim) if k != axis)))
        parts.append((max(int(where[0]) - 1, 0), min(int(where[-1]) + 2, count)))
    cells: Numbers = np.arange(lattice.size).reshape(lattice.shape)[tuple(slice(*one) for one in parts)].ravel()
    ends = tuple(
        one and part == (0, count) for one, part, count in zip(lattice.ends, parts, lattice.shape, strict=True)
    )
    first = lattice.first + lattice.steps * [low for low, _ in parts]
    smaller = Lattice(first, lattice.steps, tuple(high - low for low, high in parts), ends)
    shares = None if filled.shares is None else filled.shares[cells]
    return Filled(smaller, filled.inside[cells], filled.states[cells], filled.ways[:, cells], shares)


def finished(survey: Exploring, filled: Filled, maps: Sequence[str], told: Told | None = None) -> Workspace:
    """The workspace as a value, with maps over it."""
    lattice, goals = filled.lattice, survey.goals
    if not filled.inside.any():
        raise InputError(
            f"no cell of the grid is reached from the start of {survey.robot.name}: it may lie at an edge of its "
            "workspace, or the cells are too large; ask for more cells, or start elsewhere"
        )
    cells = np.flatnonzero(filled.inside)
    q = np.full((lattice.size, survey.robot.n), np.nan)
    q[cells] = survey.actuated(filled.states[cells])
    axes = tuple(
        GridAxis(name, unit, lattice.values(axis))
        for axis, (name, unit) in enumerate(zip(goals.names, goals.units, strict=True))
    )
    inside = filled.inside.reshape(lattice.shape)
    inside.setflags(write=False)
    return Workspace(
        robot=survey.robot.name.removesuffix(", compiled"),
        axes=axes,
        held=goals.held,
        inside=inside,
        extent=filled.extent,
        q=_block(q, lattice),
        maps=mapped(maps, survey, filled, told),
        told=survey.told,
        ways=readonly(filled.ways.reshape(-1, *lattice.shape)),
    )


def _block(values: Array, lattice: Lattice) -> Array:
    found = values.reshape(*lattice.shape, values.shape[1])
    found.setflags(write=False)
    return found


@door
def workspaces(
    robot: ClosedChain | CompiledChain,
    *,
    axes: Sequence[str] | None = None,
    held: Mapping[str, float] | None = None,
    cells: int | None = None,
    assembly: Assembly = "home",
    limits: JointLimits = "respect",
    maps: Sequence[str] = (),
    told: Told | None = None,
) -> tuple[Workspace, ...]:
    """The workspaces of all working modes of a chain, that of home first: each is joined with one of the postures that
    hold the tool as home does (`ClosedChain.working_modes`).  Those that cannot have what is held are left out, which
    the first one tells.  All but the robot is as of `workspace`.

    Args:
        robot: the chain.

    Raises:
        InputError, UnknownNameError, ActuationError, UnreachableError, LimitError, SingularError: as of `workspace`.
    """
    chain = robot.chain if isinstance(robot, CompiledChain) else robot
    fast = robot if isinstance(robot, CompiledChain) else compiled(chain)

    def joined_with(mode: Posture) -> Workspace:
        return workspace(
            fast, axes=axes, held=held, cells=cells, near=mode, assembly=assembly, limits=limits, maps=maps, told=told
        )

    found, left = [joined_with(chain.home)], []
    for number, mode in enumerate(chain.working_modes().postures[1:], start=2):
        try:
            found.append(joined_with(mode))
        except CutjointError as error:
            left.append(f"working mode {number} is left out: {error}")
    return (replace(found[0], told=(*found[0].told, *left)), *found[1:])
