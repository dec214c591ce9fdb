"""Moves of a closed chain that go as far as they can, and never onto another branch.

A move ends at a joint limit, where the loops cannot be kept closed or the tool cannot go (the edge of the workspace),
and before a singularity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import velocity_scale
from cutjoint.errors import ClosureError, SingularError, UnreachableError
from cutjoint.mechanism import Posture

NEAR_SINGULAR = 2e-3
"""A move stops where a distance to a singularity (dimensionless) would fall below this, or below half that of home."""

SMALLEST_MOTION = 1e-3
SMALLEST_STEP = 1e-4
"""The place where a move stops is found to this motion of the joints (dimensionless), or, where the chain cannot be
closed beyond it, to this part of the move."""

FASTEST = 1e-8
"""A step that would have to be a smaller part of the move than this is not taken: the joints run away."""

ROUNDING = 1e-9

Go = Callable[[float, Posture], Posture]
"""The posture at a fraction of a move, from a posture near it."""


def words(value: float, unit: str) -> str:
    """A coordinate as the page shows it: angles in degrees."""
    return f"{math.degrees(value):.4g}°" if unit == "rad" else f"{value:.4g} {unit}"


@dataclass(frozen=True)
class Stop:
    """Why a move ended early."""

    kind: Literal["limit", "workspace", "singularity"]
    text: str


class BranchWalker:
    """Moves of one chain."""

    def __init__(self, chain: ClosedChain) -> None:
        self._chain = chain
        self._scale = velocity_scale(chain.model, chain.length)
        self._types = {joint.name: joint.type for joint in chain.description.joints}
        self._guard = min(NEAR_SINGULAR, 0.5 * min(self._distances(chain.home)))

    def walk(self, at: Posture, go: Go, longest: float = 1.0) -> tuple[Posture, Stop | None]:
        """Walk from `at` along `go`; returns how far it came and what ended it, if anything did.

        A step moves no joint by more than half the distance to a singularity (both dimensionless), so none is stepped
        over and the branch is kept.  Watching a determinant change sign would be cheaper and is not enough: in a
        symmetric robot two limbs pass their singularities at once.  `longest` bounds a step, as part of the move: what
        lies far outside the workspace takes long to refuse.
        """
        before, distances = self._chain.limit_violations(at), self._distances(at)
        done, step, stride = 0.0, longest, self._stride(distances)
        while done < 1.0:
            end = min(1.0, done + step)
            found, stop = self._try(go, end, at)
            motion = math.inf if found is None else self._motion(at, found)
            tried = end - done
            if found is not None and motion <= stride:
                there = self._distances(found)
                stop = self._refusal(found, before, distances, there)
                if stop is None:
                    at, done, distances, stride = found, end, there, self._stride(there)
                    step = min(longest, tried * min(2.0, 0.9 * stride / max(motion, 1e-12)))
                    continue
            step = tried * (min(0.5, 0.9 * stride / motion) if math.isfinite(motion) else 0.5)
            if step < (SMALLEST_STEP if found is None else FASTEST) or (stop and motion < SMALLEST_MOTION):
                return at, stop or Stop("singularity", "a singularity is near: the joints would have to move very fast")
        return at, None

    @staticmethod
    def _stride(distances: tuple[float, float]) -> float:
        """Longest motion of a joint in one step, at these distances to singularities."""
        return max(0.5 * min(*distances, 1.0), SMALLEST_MOTION)

    def _try(self, go: Go, fraction: float, near: Posture) -> tuple[Posture | None, Stop | None]:
        try:
            return go(fraction, near), None
        except SingularError as error:
            return None, Stop("singularity", f"a {error.kind} singularity lies ahead")
        except UnreachableError:
            return None, Stop(
                "workspace", "this is the edge of the workspace; the tool cannot go further on this branch"
            )
        except ClosureError:
            return None, Stop(
                "workspace", "the loops cannot be kept closed beyond; a type-2 singularity bounds the motion"
            )

    def _refusal(
        self,
        at: Posture,
        before: Mapping[str, tuple[float, float, float]],
        last: tuple[float, float],
        now: tuple[float, float],
    ) -> Stop | None:
        """Why `at` must not be taken, at distances `now` to singularities, coming from distances `last`.

        A joint that was beyond a limit `before` may come back, but not go further.
        """
        for name, (value, lower, upper) in self._chain.limit_violations(at).items():
            began = before[name][0] if name in before else 0.5 * (lower + upper)
            if not min(lower, began) - ROUNDING <= value <= max(upper, began) + ROUNDING:
                unit = "m" if self._types[name].slides else "rad"
                return Stop("limit", f"joint {name} is at its limit {words(lower if value < lower else upper, unit)}")
        for kind, here, there in zip(("type-1", "type-2"), now, last, strict=True):
            if here < self._guard and here < there:
                return Stop("singularity", f"a {kind} singularity is near (distance {here:.2g})")
        return None

    def _distances(self, at: Posture) -> tuple[float, float]:
        """Distance to type-1 and type-2 singularities; infinite where undefined."""
        report = self._chain.mobility(at)
        type1, type2 = (x if math.isfinite(x) else math.inf for x in (report.type1, report.type2))
        return type1, type2

    def _motion(self, start: Posture, end: Posture) -> float:
        """Largest motion of any joint between two postures, lengths over the characteristic length."""
        difference = pin.difference(self._chain.model, np.array(start.q_full), np.array(end.q_full))
        return float(np.abs(difference / self._scale).max(initial=0.0))
