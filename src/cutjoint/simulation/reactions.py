"""Reactions over a run: force and moment in every joint and cut as columns, and their peaks.

A run records how the actuators move and what efforts act.  Accelerations follow from these by forward dynamics once
more, so a run of any plant of the chain will do, and reactions cost nothing while it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.chain.reactions import Reaction, Stiffness
from cutjoint.doors import door
from cutjoint.errors import ActuationError, InputError, UnknownNameError
from cutjoint.files import check_place, write_whole
from cutjoint.mechanism import Load, Posture
from cutjoint.mechanism.loads import as_loads
from cutjoint.reprs import line, told
from cutjoint.simulation.csv_text import csv_text
from cutjoint.simulation.held import HeldJoints
from cutjoint.simulation.plant import Observation
from cutjoint.simulation.pushing import RunLoads
from cutjoint.simulation.result import Result

ReactionAxes = Literal["world", "own"]
"""Along which axes reactions are told: those of the world, or of the child's frame (of frame b of a cut)."""
SAME = 1e-9
"""Part of their size that actuated coordinates of a run may differ from those of its configurations."""


_PEAK_UNITS = {"force": "N", "force_time": "s", "moment": "N m", "moment_time": "s"}


class Peak(NamedTuple):
    """The largest force [N] and moment [N m] of a joint, when [s], and whether all components of each are unique."""

    name: str
    force: float
    force_time: float
    force_unique: bool
    moment: float
    moment_time: float
    moment_unique: bool

    def __repr__(self) -> str:
        return told(self, "name", "force", "force_time", "moment", "moment_time", **_PEAK_UNITS)


@dataclass(frozen=True, eq=False)
class ReactionHistory(Frozen):
    """Reactions at the m samples of a run, of k joints and cuts, each at its own origin.

    Attributes:
        names: of the joints and cuts.
        axes: along which they are.
        time: shape (m,) [s].
        force: of the parent on the child, of body A of a cut on body B, shape (m, k, 3) [N].
        moment: shape (m, k, 3) [N m].
        unique: for each the six components, forces first: whether the values are the only ones possible all the time.
    """

    names: tuple[str, ...]
    axes: ReactionAxes
    time: Array
    force: Array
    moment: Array
    unique: tuple[tuple[bool, ...], ...]

    __repr__ = line("names", "time", "axes", time="s")

    @property
    def columns(self) -> dict[str, Array]:
        """Every column by its heading, such as "crank force x [N]", the time first, shape (m,) each."""
        found = {"time [s]": self.time}
        for k, name in enumerate(self.names):
            for what, unit, values in (("force", "N", self.force), ("moment", "N m", self.moment)):
                found |= {f"{name} {what} {axis} [{unit}]": values[:, k, i] for i, axis in enumerate("xyz")}
        return found

    @property
    def peaks(self) -> tuple[Peak, ...]:
        """Of every joint and cut."""
        found = []
        for k, name in enumerate(self.names):
            parts: list[tuple[float, float, bool]] = []
            for values, unique in ((self.force, self.unique[k][:3]), (self.moment, self.unique[k][3:])):
                sizes = np.linalg.norm(values[:, k], axis=1)
                worst = int(np.argmax(sizes))
                parts.append((float(sizes[worst]), float(self.time[worst]), all(unique)))
            found.append(Peak(name, *parts[0], *parts[1]))
        return tuple(found)

    def save(self, path: str | Path) -> Path:
        """Write the columns as CSV, one row a sample.

        Raises:
            InputError: the name does not end in .csv, or nothing can be written there.
        """
        columns = self.columns
        return write_whole(check_csv(path), csv_text(list(columns), list(columns.values())))


def check_csv(path: str | Path) -> Path:
    """`path` as a place for a CSV file; worth asking before a long run.

    Raises:
        InputError: another suffix, no such folder, or a folder of that name.
    """
    target = Path(path)
    if target.suffix != ".csv":
        raise InputError(f"reactions are written as .csv; found {str(target)!r}")
    return check_place(target)


@door
def reactions_of(
    result: Result,
    chain: ClosedChain,
    names: str | Sequence[str] | None = None,
    *,
    axes: ReactionAxes = "world",
    stiffness: Stiffness | None = None,
    loads: RunLoads | None = None,
    progress: Callable[[float], None] | None = None,
) -> ReactionHistory:
    """Reactions at every sample of a run.

    Args:
        result: of a plant of this chain.
        chain: the robot that moved, payload included.
        names: of joints and cuts, or of one; default all of them.
        axes: along which to tell them.
        stiffness: that splits loads where loops are redundant; default the least reactions.
        loads: those of the run, where they were a function; constant ones the result tells.
        progress: called with the number of samples that are done, after each.

    Raises:
        InputError: the run is not one of this chain, or its loads were a function that is not given.
        UnknownNameError: there is no such joint or cut.
        ActuationError: the actuators do not tell how all joints move.
        ClosureError: the loops of the result are open, as of a run that was not put back onto them.
    """
    chosen = _names(chain, names)
    pushed = _loads_of(result, loads)
    force, moment = np.zeros((2, len(result), len(chosen), 3))
    unique = np.ones((len(chosen), 6), dtype=bool)
    states = [(at := posture_of(result, chain, i), velocity_of(chain, at, result.v[i])) for i in range(len(result))]
    fastest = max((abs(float(v[index])) for _, v in states for index in chain.sticking), default=0.0)
    held = HeldJoints(chain, fastest)
    for i, (at, v) in enumerate(states):
        outside = pushed(float(result.time[i]), _observation(result, i)) if callable(pushed) else pushed
        moving, effort = held.motion(at, v, result.effort[i], outside)
        found = chain.full_reactions(at, moving, effort_full=effort, loads=outside, stiffness=stiffness)
        for k, name in enumerate(chosen):
            one: Reaction = found[name]
            one = one.in_axes(one.own_axes) if axes == "own" else one
            force[i, k], moment[i, k] = one.force, one.moment
            unique[k] &= one.unique
        if progress is not None:
            progress(i + 1)
    kept = tuple(tuple(map(bool, row)) for row in unique)
    return ReactionHistory(chosen, axes, result.time, force, moment, kept)


def _names(chain: ClosedChain, names: str | Sequence[str] | None) -> tuple[str, ...]:
    joints, cuts = chain.description.joints, chain.description.cuts
    known = [*(one.name for one in joints), *(one.name for one in cuts)]
    wanted = tuple(known) if names is None else (names,) if isinstance(names, str) else tuple(names)
    for name in wanted:
        if name not in known:
            raise UnknownNameError(f"joint or cut of {chain.name}", str(name), known)
        if known.count(name) > 1:
            raise InputError(f"a joint and a cut of {chain.name} are called '{name}'; rename one of them")
    return wanted


def posture_of(result: Result, chain: ClosedChain, i: int) -> Posture:
    """Where the robot was at a sample.

    Raises:
        InputError: that was another robot.
        ClosureError: its loops are open.
    """
    q = result.q_full[i]
    told = f"this result is of {result.about.get('plant', 'another robot')}, not of the chain {chain.name}"
    if (q.size, result.q.shape[1]) != (chain.nq, chain.n):
        raise InputError(
            f"{told}: it has {q.size} coordinates and {result.q.shape[1]} actuators, not {chain.nq} and {chain.n}; "
            "simulate the chain"
        )
    if not np.allclose(chain.actuated(q), result.q[i], rtol=SAME, atol=SAME * chain.length):
        raise InputError(f"{told}: its actuated coordinates are not those of its configurations; simulate the chain")
    return chain.posture(q)


def velocity_of(chain: ClosedChain, at: Posture, v: Array) -> Array:
    """Velocity of all joints, shape (nv,), from that of the actuators (n,).

    Raises:
        ActuationError: the actuators do not tell it.
    """
    full = chain.led_velocity(at, v)
    if not chain.idle_is_cyclic:
        report = chain.mobility(at)
        raise ActuationError(
            f"{chain.name} has idle motions that its masses or weights notice ({', '.join(report.idle)}), of which a "
            "result does not tell the speed; ask full_reactions for a motion of all joints",
            mobility=report.mobility,
            actuators=report.actuators,
            free=report.idle,
        )
    return full


def _loads_of(result: Result, loads: RunLoads | None) -> RunLoads:
    """The loads of a run: those that are given, or the constant ones that it tells."""
    told = result.about.get("loads", [])
    if loads is not None:
        return loads if callable(loads) else as_loads(loads)
    if isinstance(told, str):
        raise InputError(f"this run had {told}; give it again as `loads`, a result does not hold functions")
    try:
        return tuple(Load(**one) for one in told)  # type: ignore[arg-type]  # as `Pushing.about` writes them
    except TypeError as error:
        raise InputError(f"the loads that this result tells are none ({error}); give them as `loads`") from error


def _observation(result: Result, i: int) -> Observation:
    """What was seen at a sample."""
    turned = (result.more[name][i] if name in result.more else None for name in ("orientation", "angular_velocity"))
    return Observation(
        result.q[i],
        result.v[i],
        result.tool[i],
        result.tool_velocity[i],
        float(result.kinetic[i]),
        float(result.potential[i]),
        (float(result.gap[i, 0]), float(result.gap[i, 1])),
        result.q_full[i],
        *turned,
    )
