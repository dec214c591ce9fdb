"""Looks for points of a box that do not hold what is asked, before and beside the proof.

Points are led to from the middle of the box along straight lines by Newton's method; what does not arrive, or is
beyond a limit, is asked of the chain, whose answer counts.  From corners, middles of edges and faces, and the middle,
the smallest singular values (with the sign of their determinant) and the room to joint limits are then followed
downhill.  A determinant with the actuators held that changes its sign is followed to the singularity by bisection.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.errors import LimitError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.workspace.certified.certificate import CounterExample, Why
from cutjoint.workspace.certified.proof import settled
from cutjoint.workspace.certified.system import LedSystem

STAGES = 16
"""Into how many pieces the way to a point is taken apart."""
JUMP = 0.7
"""Changes of the configuration by more in one piece, in radians or lengths of the robot, are none of one branch."""
BEST = 6
"""From how many points a quantity is followed downhill."""
STEPS = 20
ASKED = 64
"""How often the chain is asked at most."""
HALVINGS = 60


class WalkedPoints(NamedTuple):
    """Postures at some points.

    Attributes:
        at: led coordinates (N, led).
        q: configurations (N, size).
        arrived: whether Newton's method led there, (N,).
        measures: signed smallest singular values led by the tool and by the actuators, and room to limits, (3, N).
    """

    at: Array
    q: Array
    arrived: npt.NDArray[np.bool_]
    measures: Array


class CounterSearch:
    """Looks for counter-examples in one box.

    Args:
        system: equations of the robot.
        lower, upper: ends of the box along all led coordinates, (led,); the same where one is held.
        start: posture in the middle.
    """

    def __init__(self, system: LedSystem, lower: Array, upper: Array, start: Posture) -> None:
        self._system, self.lower, self.upper, self._start = system, lower, upper, start
        self._asked = 0
        self.middle = 0.5 * (lower + upper)
        at = self.middle[None], np.array(start.q_full)[None]
        goals = system.goals.numbers(at[0])
        led, driven = (one * system.units for one in system.matrices(at[1], goals))
        self.signs = np.array([np.linalg.slogdet(one)[0][0] for one in (led, driven)])

    def first(self, near: Posture) -> CounterExample | None:
        """A counter-example: the middle, on another assembly mode than `near`, some points, or downhill from them."""
        if (found := self._other_mode(near)) is not None:
            return found
        axes = self._system.goals.axes
        shares = np.array(list(product((-1.0, 1.0, 0.0), repeat=len(axes))))
        points = np.tile(self.middle, (len(shares), 1))
        points[:, axes] += shares * (0.5 * (self.upper - self.lower))[list(axes)]
        seen = self._walked(points)
        found = self._wrong(seen)
        for kind in range(3):
            if found is not None:
                break
            found = self._downhill(seen, kind)
        return found

    def at(self, points: Array, q: Array) -> CounterExample | None:
        """A counter-example among points (N, led) with postures near `q` (N, size)."""
        settled_q, arrived = settled(self._system, q, self._system.goals.numbers(points))
        return self._wrong(self._measured(points, settled_q, arrived))

    # ---- ways ------------------------------------------------------------------------------------------------------

    def _walked(self, points: Array) -> WalkedPoints:
        """Postures at points (N, led), along straight lines from the middle."""
        system = self._system
        q = np.tile(np.array(self._start.q_full), (len(points), 1))
        arrived = np.ones(len(points), dtype=bool)
        for stage in range(1, STAGES + 1):
            at = self.middle + stage / STAGES * (points - self.middle)
            found, good = settled(system, q, system.goals.numbers(at))
            arrived &= good & (np.abs((found - q) / system.units).max(axis=1) < JUMP)
            q = np.where(arrived[:, None], found, q)
        return self._measured(points, q, arrived)

    def _measured(self, at: Array, q: Array, arrived: npt.NDArray[np.bool_]) -> WalkedPoints:
        system = self._system
        measures = np.empty((3, len(at)))
        for kind, matrices in enumerate(system.matrices(q, system.goals.numbers(at))):
            scaled = matrices * system.units
            signs, _ = np.linalg.slogdet(scaled)
            measures[kind] = signs * self.signs[kind] * np.linalg.svd(scaled, compute_uv=False)[:, -1]
        room = np.minimum(q - system.lower, system.upper - q) / system.units
        measures[2] = room.min(axis=1)
        return WalkedPoints(at, q, arrived & (measures[0] > 0.0), measures)

    def _downhill(self, seen: WalkedPoints, kind: int) -> CounterExample | None:
        """Follow one of the measures from the points where it is least."""
        axes = list(self._system.goals.axes)
        if kind == 2 and not np.isfinite(seen.measures[2]).all():
            return None
        order = np.argsort(np.where(seen.arrived, seen.measures[kind], np.inf))[:BEST]
        at, q, value = seen.at[order], seen.q[order], seen.measures[kind][order]
        step = np.full(len(order), 0.25)
        moves = np.concatenate([np.eye(len(axes)), -np.eye(len(axes))])
        for _ in range(STEPS):
            tried = np.repeat(at[:, None], len(moves), axis=1)
            edges = (self.upper - self.lower)[axes]
            tried[:, :, axes] += step[:, None, None] * moves * edges
            tried = np.clip(tried, self.lower, self.upper).reshape(-1, at.shape[1])
            near = np.repeat(q, len(moves), axis=0)
            found, good = settled(self._system, near, self._system.goals.numbers(tried))
            good &= np.abs((found - near) / self._system.units).max(axis=1) < JUMP
            there = self._measured(tried, np.where(good[:, None], found, near), good)
            wrong = self._wrong(there)
            if wrong is not None:
                return wrong
            values = np.where(there.arrived, there.measures[kind], np.inf).reshape(len(at), -1)
            best = values.argmin(axis=1)
            pick = np.arange(len(at)) * len(moves) + best
            better = values[np.arange(len(at)), best] < value
            at = np.where(better[:, None], there.at[pick], at)
            q = np.where(better[:, None], there.q[pick], q)
            value = np.where(better, there.measures[kind][pick], value)
            step = np.where(better, step, 0.5 * step)
        return None

    # ---- what is wrong ---------------------------------------------------------------------------------------------

    def _wrong(self, seen: WalkedPoints) -> CounterExample | None:
        """A counter-example among points, if the chain agrees."""
        crossed = np.flatnonzero(seen.arrived & (seen.measures[1] <= 0.0))
        for k in crossed[:2].tolist():
            found = self._crossing(seen.at[k])
            if found is not None:
                return found
        doubtful = np.flatnonzero(~seen.arrived | (seen.measures[2] < 0.0))
        for k in doubtful.tolist():
            found = self._by_chain(seen.at[k])
            if found is not None:
                return found
        return None

    def _by_chain(self, at: Array) -> CounterExample | None:
        """What the chain says of a point."""
        if self._asked >= ASKED:
            return None
        self._asked += 1
        names = dict(zip(self._system.goals.names, at.tolist(), strict=True))
        found = shown_by_chain(self._system.chain, names, self._start)
        return found if isinstance(found, CounterExample) else None

    def _other_mode(self, near: Posture) -> CounterExample | None:
        """Whether a type-2 singularity lies between a posture and the middle of the box."""
        system, q = self._system, np.array(near.q_full)[None]
        sign, size = np.linalg.slogdet(system.matrices(q, system.goals.numbers(self.middle[None]))[1] * system.units)
        if sign[0] != -self.signs[1] or size[0] < np.log(tolerances.SINGULAR.value):
            return None
        names = dict(zip(system.goals.names, self.middle.tolist(), strict=True))
        told = (
            "The determinant with the actuators held has another sign here, in the middle of the box, than at the "
            "posture that the robot comes from, so every way between them leads through a type-2 singularity; a "
            "posture in the box as `near` picks this assembly mode"
        )
        return CounterExample(names, "another assembly mode", "", told)

    def _crossing(self, at: Array) -> CounterExample | None:
        """The type-2 singularity between the middle and a point with the other sign."""
        system = self._system
        low, near, high = self.middle, np.array(self._start.q_full), at
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            found, good = settled(system, near[None], system.goals.numbers(middle[None]))
            if not good[0] or np.abs((found[0] - near) / system.units).max() > 4.0 * JUMP:
                return None
            sign = self._measured(middle[None], found, good).measures[1, 0]
            if sign > 0.0:
                low, near = middle, found[0]
            else:
                high = middle
        last = self._measured(low[None], near[None], np.ones(1, dtype=bool)).measures[1, 0]
        if not abs(last) < 1e-6:
            return None
        names = dict(zip(system.goals.names, low.tolist(), strict=True))
        told = (
            "The determinant with the actuators held changes its sign between the middle of the box and here, where "
            f"the smallest singular value is {abs(last):.1e}"
        )
        return CounterExample(names, "type-2 singular", "", told)


def shown_by_chain(
    chain: ClosedChain, names: Mapping[str, float], near: Posture | str | None
) -> CounterExample | Posture:
    """What the chain says of a point: a counter-example, or its posture there.

    Raises:
        CutjointError: something else is wrong.
    """
    why: Why = "unreachable"
    joint = ""
    try:
        return chain.reach(names, near, free=True)
    except LimitError as error:
        why, joint, told = "joint limit", error.joint, str(error)
    except UnreachableError as error:
        told = str(error)
    except SingularError as error:
        why, told = ("type-2 singular" if error.kind == "type-2" else "type-1 singular"), str(error)
    return CounterExample(names, why, joint, told)
