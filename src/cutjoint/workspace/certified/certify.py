"""A guarantee that a box of tool coordinates is wholly inside the workspace and free of singularities.

What is proven, where a box is certified: from the posture that the robot has in its middle, on the branch that was
chosen, the tool can be led to every point of the box and in no other posture of that branch; on all of it joints keep
their limits, and neither a type-1 nor a type-2 singularity is met.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import monotonic

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.interface import Need
from cutjoint.doors import described, door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.workspace.certified.certificate import Certificate, CounterExample, Status
from cutjoint.workspace.certified.cover import Cover
from cutjoint.workspace.certified.goals import BoxGoals
from cutjoint.workspace.certified.search import CounterSearch, shown_by_chain
from cutjoint.workspace.certified.system import LedSystem

MOST = 100_000
"""Sub-boxes that are looked at unless more are allowed."""


@door
def certify(
    robot: Mechanism,
    box: Mapping[str, tuple[float, float]],
    *,
    held: Mapping[str, float] | None = None,
    near: Posture | str | None = None,
    most: int = MOST,
    seconds: float | None = None,
    told: Callable[[float], object] | None = None,
) -> Certificate:
    """Prove that a box is wholly inside and free of singularities, or find a point of it that is not.

    Args:
        robot: a closed chain whose actuators determine its motion, compiled or not.
        box: led coordinates of the tool by name -> least and largest value, [m] or [rad].
        held: values of other led coordinates, [m] or [rad]; those that are named in neither are as at home.
        near: picks the branch, see `ClosedChain.reach`; default home.
        most: sub-boxes that are looked at, at most.
        seconds: time that it may take, about; default no limit.
        told: is called with the part of the box that is proven so far, 0 to 1; where it answers False, the proof ends
            there, and the box stays open.

    Raises:
        InputError: no chain, no box, or a coordinate that is not led.
        UnknownNameError: there is no such coordinate or home.
        ActuationError: the actuators do not determine the motion.
        CompileError: the loops close only when some of their equations are left out.
    """
    chain = _chain_of(robot)
    if most < 1 or (seconds is not None and not seconds > 0.0):
        raise InputError(f"at least one sub-box and some time are needed, found most={most}, seconds={seconds}")
    source = ChainSource(chain)
    for need in (Need.TOOL, Need.ACTUATED):
        if (lack := source.lacks(need)) is not None:
            raise lack
    source.need_all_rows()
    answer = _Answer(chain, *_ends(chain, box, held or {}))
    end = None if seconds is None else monotonic() + seconds

    def go_on(part: float) -> bool:
        if told is not None and told(part) is False:
            return False
        return end is None or monotonic() < end

    return _decided(source, answer, near, most, go_on)


def _decided(
    source: ChainSource, answer: _Answer, near: Posture | str | None, most: int, go_on: Callable[[float], bool]
) -> Certificate:
    """Look for counter-examples, then prove."""
    chain = source.chain
    start = shown_by_chain(chain, answer.middle, near)
    if isinstance(start, CounterExample):
        return answer.of("refused", start)
    wrong = _singular(chain, answer.middle, start)
    if wrong is not None:
        return answer.of("refused", wrong)
    system = LedSystem(source, BoxGoals(chain, answer.names, answer.axes), start)
    search = CounterSearch(system, answer.lower, answer.upper, start)
    found = search.first(
        near if isinstance(near, Posture) else ClosedChain(chain.description, near).home if near else chain.home
    )
    if found is not None:
        return answer.of("refused", found)
    cover = Cover(system, search, np.array(start.q_full), most, go_on)
    done = cover.run()
    if cover.counter_example is not None:
        return answer.of("refused", cover.counter_example, cover)
    return answer.of("certified" if done else "open", None, cover)


class _Answer:
    """Makes the answer for one box.

    Attributes:
        names, lower, upper: of all led coordinates, and their ends, the same where one is held.
        axes: numbers of those that the box is over.
        middle: of the box, by name.
    """

    def __init__(
        self, chain: ClosedChain, names: tuple[str, ...], lower: Array, upper: Array, axes: tuple[int, ...]
    ) -> None:
        self._chain, self.names, self.axes, self.lower, self.upper = chain, names, axes, lower, upper
        self.middle = dict(zip(names, (0.5 * (lower + upper)).tolist(), strict=True))

    def of(self, status: Status, found: CounterExample | None, cover: Cover | None = None) -> Certificate:
        names, axes = self.names, list(self.axes)
        lower, upper = self.lower[axes], self.upper[axes]
        nothing = lower[None], upper[None], np.zeros(1, dtype=bool), np.full(1, -1.0)
        lows, highs, proven, margins = nothing if cover is None else cover.leaves()
        volumes = np.prod((highs - lows) / (upper - lower), axis=1)
        part = 1.0 if status == "certified" else min(float(volumes[proven].sum()), float(np.nextafter(1.0, 0.0)))
        over = tuple(names[k] for k in axes)
        held = {name: float(self.lower[k]) for k, name in enumerate(names) if name not in over}
        units = tuple("rad" if name.startswith("r") else "m" for name in over)
        return Certificate(
            robot=self._chain.name,
            names=over,
            units=units,
            lower=lower,
            upper=upper,
            held=held,
            status=status,
            counter_example=found,
            part=part,
            lows=lows,
            highs=highs,
            proven=proven,
            margins=margins,
            looked=0 if cover is None else cover.looked,
        )


def _chain_of(robot: Mechanism) -> ClosedChain:
    if isinstance(robot, CompiledChain):
        return robot.chain
    if not isinstance(robot, ClosedChain):
        raise InputError(
            f"a box is certified for a robot of links and joints, a ClosedChain, found {described(robot)}: take the "
            "chain of that robot, such as cutjoint.load('omega3')"
        )
    return robot


def _ends(
    chain: ClosedChain, box: Mapping[str, tuple[float, float]], held: Mapping[str, float]
) -> tuple[tuple[str, ...], Array, Array, tuple[int, ...]]:
    """Names of the led coordinates, ends of the box along them, and numbers of those that it is over."""
    task = chain.task
    for name in (*box, *held):
        if name not in task.names:
            raise UnknownNameError("led coordinate", name, task.names)
    both = [name for name in box if name in held]
    if both:
        raise InputError(f"'{both[0]}' is an edge of the box and held; it can be one of them")
    if not box:
        raise InputError(f"a box has at least one edge, such as {{'{task.names[0]}': (-0.1, 0.1)}}")
    names = task.names
    if len(names) != chain.n:
        names = tuple(name for name in task.names if name in box or name in held)
        if len(names) != chain.n:
            raise InputError(
                f"{chain.name} has {chain.n} actuators, and its tool moves along {', '.join(task.names)} together: "
                f"name {chain.n} of these in the box and what is held, found {', '.join(names)}"
            )
    at_home = dict(zip(task.names, task.coordinates(task.home).tolist(), strict=True))
    lower, upper = np.empty(len(names)), np.empty(len(names))
    for k, name in enumerate(names):
        if name in box:
            lower[k], upper[k] = as_vector(f"edge {name} of the box", box[name], 2)
            if not lower[k] < upper[k]:
                raise InputError(f"edge {name} of the box must grow, found {lower[k]:g} to {upper[k]:g}")
        else:
            lower[k] = upper[k] = as_vector(name, [held.get(name, at_home[name])], 1)[0]
    turns = [k for k, name in enumerate(names) if name.startswith("r")]
    widest = float(np.linalg.norm(np.maximum(np.abs(lower), np.abs(upper))[turns]))
    if widest >= np.pi:
        raise InputError(f"rotations of a box stay below half a turn from home, found {widest:.4g} rad at a corner")
    return names, lower, upper, tuple(k for k, name in enumerate(names) if name in box)


def _singular(chain: ClosedChain, at: Mapping[str, float], start: Posture) -> CounterExample | None:
    """Whether the middle itself is singular."""
    report, limit = chain.mobility(start), tolerances.SINGULAR.value
    if not report.type2 > limit:
        told = f"The distance to a type-2 singularity is {report.type2:.1e} in the middle of the box"
        return CounterExample(at, "type-2 singular", "", told)
    if report.type1 <= limit:
        told = f"The distance to a type-1 singularity is {report.type1:.1e} in the middle of the box"
        return CounterExample(at, "type-1 singular", "", told)
    return None
