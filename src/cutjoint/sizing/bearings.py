"""What the bearings of all joints and cuts carry along trajectories.

Forces and moments are those of `ClosedChain.reactions`, motors and friction included, at even instants.  In a joint
that turns or slides along one axis they are told along it (axial) and across it (radial, tilting).  The mean force is
the cubic one over time, by which rolling bearings are chosen at an even speed (ISO 281 and the makers' catalogues),

    F_m = (1/T integral |F|^3 dt)^(1/3)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.reactions import Reaction
from cutjoint.errors import InputError
from cutjoint.motion import Reference
from cutjoint.reprs import line
from cutjoint.sizing.moving import Mover
from cutjoint.sizing.values import Extreme

ALONG_AN_AXIS = ("revolute", "continuous", "prismatic")
OF_A_CUT = (0.0, 0.0, 1.0)
"""The free axis of a cut that has one, in its frames."""


@dataclass(frozen=True)
class BearingLoad:
    """What a joint or cut carries at worst.

    Attributes:
        name, type: of the joint or cut.
        force: largest [N].
        moment: largest [N m], about the origin of the joint.
        radial, axial: largest force across and along the axis [N]; None where there is no single axis.
        tilting: largest moment across the axis [N m]; None where there is no single axis.
        mean_force: cubic mean over time of the trajectory of the largest one [N].
        is_unique: whether equilibrium alone tells it; else it is the least of many (see docs/reactions.md).
    """

    name: str
    type: str
    force: Extreme
    moment: Extreme
    radial: Extreme | None
    axial: Extreme | None
    tilting: Extreme | None
    mean_force: float
    is_unique: bool

    __repr__ = line("name", "type", "force", "moment", "mean_force", mean_force="N")


def bearing_loads(
    mover: Mover,
    references: Mapping[str, Reference],
    samples: int,
    progress: Callable[[float], None] | None,
) -> tuple[BearingLoad, ...]:
    """Of all joints that move and all cuts, at so many even instants of every trajectory (by name).

    Raises:
        InputError: the robot is a published model, which has no joints of its own.
    """
    chain = chain_of(mover)
    axes = _axes(chain)
    found: dict[str, list[tuple[Array, str, list[Array], bool]]] = {name: [] for name in axes}
    done = 0
    for way, reference in references.items():
        times = np.linspace(0.0, reference.duration, samples)
        rows: dict[str, list[Array]] = {name: [] for name in axes}
        unique = dict.fromkeys(axes, True)
        for t in times.tolist():
            desired = reference.at(t)
            reactions = chain.reactions(mover.posture(desired), desired.v, desired.a, loads=mover.loads(t))
            for name, (_, axis) in axes.items():
                reaction = reactions[name]
                rows[name].append(_sizes(reaction, axis))
                unique[name] &= all(reaction.unique)
            done += 1
            if progress is not None:
                progress(done)
        for name in axes:
            found[name].append((times, way, rows[name], unique[name]))
    return tuple(_load(name, type, axis is not None, found[name]) for name, (type, axis) in axes.items())


def chain_of(mover: Mover) -> ClosedChain:
    """Raises InputError where the robot has no joints that carry anything."""
    if not isinstance(mover.plain, ClosedChain):
        raise InputError(f"{mover.plain.name} is a published model, without joints that carry anything; take the chain")
    return mover.plain


def _axes(chain: ClosedChain) -> dict[str, tuple[str, Array | None]]:
    """Joints that move and cuts -> type, and the axis in their own frame where there is one."""
    joints = [(one.name, one.type.value, one.axis) for one in chain.description.joints if one.type.coordinates]
    cuts = [(one.name, one.type.value, np.array(OF_A_CUT)) for one in chain.description.cuts]
    found: dict[str, tuple[str, Array | None]] = {}
    for name, type, axis in (*joints, *cuts):
        if name in found:
            raise InputError(f"a joint and a cut of {chain.name} are called '{name}'; rename one of them")
        found[name] = str(type), np.asarray(axis) if type in ALONG_AN_AXIS else None
    return found


def _sizes(reaction: Reaction, axis: Array | None) -> Array:
    """Sizes of force and moment, then across and along the axis, and of the moment across it, shape (5,)."""
    force, moment = reaction.force, reaction.moment
    sizes = np.zeros(5)
    sizes[:2] = np.linalg.norm(force), np.linalg.norm(moment)
    if axis is not None:
        along = reaction.own_axes @ axis
        axial = float(along @ force)
        sizes[2:] = (
            np.linalg.norm(force - axial * along),
            abs(axial),
            np.linalg.norm(moment - float(along @ moment) * along),
        )
    return sizes


def _load(
    name: str, type: str, has_axis: bool, found: Sequence[tuple[Array, str, list[Array], bool]]
) -> BearingLoad:  # fmt: skip
    extremes = []
    for j in range(5):
        worst = [
            (float(rows[k][j]), float(times[k]), way)
            for times, way, rows, _ in found
            if (k := int(np.argmax([row[j] for row in rows]))) >= 0
        ]
        extremes.append(Extreme(*max(worst)))
    means = []
    for times, _, rows, _ in found:
        cubes = np.array([row[0] ** 3 for row in rows])
        means.append(float(np.sum(0.5 * (cubes[1:] + cubes[:-1]) * np.diff(times)) / (times[-1] - times[0])))
    radial, axial, tilting = extremes[2:] if has_axis else (None, None, None)
    unique = all(one for _, _, _, one in found)
    mean = max(means) ** (1.0 / 3.0)
    return BearingLoad(name, type, extremes[0], extremes[1], radial, axial, tilting, mean, unique)
