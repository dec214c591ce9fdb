"""Whether a run can be believed: each sign with its number, what is good, and one sentence over all of them.

Signs of two kinds: those of the computation (open loops, energy that came from nowhere) can make a run worthless; those
of the machine (limits passed, saturated actuators) say that it shows something else than was meant.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from cutjoint.errors import CutjointError
from cutjoint.simulation.agreeing import disagreements, gap_of, why_not
from cutjoint.simulation.coordinates import coordinates, joints_of
from cutjoint.simulation.reaction_samples import check_same_robot
from cutjoint.simulation.result import Result
from cutjoint.simulation.summary import effort_tops
from cutjoint.tolerances import CLOSURE, RUN_AGREE, RUN_DRIFT, RUN_GAP, RUN_OPEN, RUN_SATURATED, RUN_STRAYED, RUN_WRONG

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain

Grade = Literal["good", "half", "bad"]
"""Holds; look closer; does not hold."""
AT_LIMIT = 1.0 - 1e-9
"""Part of a limit from which an effort is at it: what is clipped is there to the last digit but rounding."""

AWAY = "the robot is not at hand"
REDUCED = "the run has no configurations of this robot, as of a reduced model"


@dataclass(frozen=True)
class Sign:
    """One thing that tells whether a run can be believed.

    Attributes:
        name: what was looked at.
        found: its number, in words with the unit.
        good: what would be good.
        grade: how it is; None where it could not be looked at, and `found` says why.
        means: what it means where it is not good.
    """

    name: str
    found: str
    good: str
    grade: Grade | None
    means: str = ""


@dataclass(frozen=True)
class Belief:
    """All signs of a run, and what they come to."""

    signs: tuple[Sign, ...]

    @property
    def grade(self) -> Grade:
        """The worst of all."""
        grades = [one.grade for one in self.signs]
        return "bad" if "bad" in grades else "half" if "half" in grades else "good"

    @property
    def sentence(self) -> str:
        """Whether the run can be believed, and if not so why."""
        worst = [one for one in self.signs if one.grade in ("half", "bad")]
        if not worst:
            left = [one.name for one in self.signs if one.grade is None]
            rest = f"; not looked at: {', '.join(left)}" if left else ""
            return f"This run can be believed: every sign that was looked at is good{rest}."
        told = "; ".join(f"{one.name}: {one.found} ({one.means})" for one in worst)
        if self.grade == "bad":
            return f"This run cannot be believed. {told}."
        return f"This run can be believed with care. {told}."


def verdict_of(result: Result, robot: ClosedChain | None = None) -> Belief:
    """Whether a run can be believed.

    Args:
        result: the run.
        robot: that it was made with: the limits of its joints are looked at too, and its length is the measure of gaps;
            else how far the tool is from the origin of the world.
    """
    length = robot.length if robot is not None else float(np.linalg.norm(result.tool, axis=1).max())
    signs = [_gap(result, length, robot), *_strayed(result, length), _energy(result), _agreement(result)]
    return Belief((*_whole(result), *signs, _energies(result, robot), *_limits(result, robot), *_saturation(result)))


def _whole(result: Result) -> list[Sign]:
    """Whether the run went on to its end; results of old files do not tell."""
    if "stopped" not in result.about:
        return []
    found = f"stopped {result.about['stopped']}"
    return [Sign("whole run", found, "until its end", "half", "what would have come then is not known")]


def _graded(value: float, good: float, bad: float = np.inf) -> Grade:
    return "good" if value <= good else "half" if value <= bad else "bad"


def _gap(result: Result, length: float, robot: ClosedChain | None) -> Sign:
    gap, angle = result.loop_gap()
    if robot is not None:
        gap, angle = (max(two) for two in zip((gap, angle), gap_of(result, robot), strict=True))
    measure = length if length > 0.0 else 1.0
    return Sign(
        "loop gap",
        f"{gap:.1e} m, {angle:.1e} rad",
        f"at most {RUN_GAP.value * measure:.2g} m, {RUN_GAP.value:g} rad",
        _graded(max(gap / measure, angle), RUN_GAP.value, RUN_OPEN.value),
        "the loops did not stay closed, so the links were not as long as they are",
    )


def _strayed(result: Result, length: float) -> list[Sign]:
    if "strayed" not in result.about:
        return []
    strayed, measure = float(result.about["strayed"]), length if length > 0.0 else 1.0
    return [
        Sign(
            "steps strayed",
            f"{strayed:.1e} m before they were put back",
            f"at most {RUN_STRAYED.value * measure:.2g} m",
            _graded(strayed / measure, RUN_STRAYED.value),
            "steps were long for this motion; take smaller ones or tighter tolerances",
        )
    ]


def _energy(result: Result) -> Sign:
    name, good = "energy balance", f"at most {RUN_DRIFT.value:g}"
    if len(result) == 1:
        return Sign(name, "one sample, so nothing changed", good, None)
    if np.abs(result.unaccounted).max() <= CLOSURE.value * np.abs(result.potential).max():
        drift = 0.0  # states are put back onto the loops to that, and so is how high everything is
    else:
        drift = result.energy_drift()
    return Sign(
        name,
        f"off by {drift:.1e} of the energy turned over",
        good,
        _graded(drift, RUN_DRIFT.value, RUN_WRONG.value),
        "energy came from nowhere; take smaller steps or tighter tolerances",
    )


def _agreement(result: Result) -> Sign:
    """Whether the columns say the same."""
    name, good = "columns agree", f"up to {RUN_AGREE.value:g} of their sizes"
    if why := why_not(result):
        return Sign(name, why, good, None)
    apart = disagreements(result)
    worst = max(apart, key=apart.__getitem__)
    grade = _graded(apart[worst], RUN_AGREE.value, RUN_WRONG.value)
    found = "they do" if grade == "good" else f"{worst} differ by {apart[worst]:.1e} of their sizes"
    means = "the columns are not those of one run, or there is motion between the samples that they do not show"
    return Sign(name, found, good, grade, means)


def _energies(result: Result, robot: ClosedChain | None) -> Sign:
    """Whether the robot at hand has the energies of the run; a payload is no fault, so none is said to be there."""
    name, good = "energies of the robot", "those of the run"
    if robot is None:
        return Sign(name, AWAY, good, None)
    if result.q_full.shape[1] != robot.nq:
        return Sign(name, REDUCED, good, None)
    try:
        check_same_robot(result, robot)
    except CutjointError as error:
        return Sign(name, str(error), good, None)
    return Sign(name, "those of the run", good, "good")


def _limits(result: Result, robot: ClosedChain | None) -> list[Sign]:
    """Joints beyond the limits that their files give."""
    name, good = "limits of the joints", "none passed"
    if robot is None:
        return [Sign(name, AWAY, good, None)]
    joints = joints_of(robot) or []
    if result.q_full.shape[1] != robot.nq:
        return [Sign(name, REDUCED, good, None)]
    own = {one.joint: one for one in coordinates(result.q_full, joints)}
    passed = []
    for joint in robot.description.joints:
        if joint.type.limited and joint.name in own:
            low, high = joint.limits.ends
            values, unit = own[joint.name].values, own[joint.name].unit
            slack = (robot.length if unit == "m" else 1.0) * RUN_GAP.value
            over = max(low - values.min(), values.max() - high, 0.0)
            if over > slack:
                passed.append(f"{joint.name} by {over:.3g} {unit}")
    means = "the machine would have met its stops"
    return [Sign(name, ", ".join(passed) or "none passed", good, "half" if passed else "good", means)]


def _saturation(result: Result) -> list[Sign]:
    """How long the law asked for as much as there is."""
    top = effort_tops(result)
    if top is None:
        return []
    at = (np.abs(result.more.get("command", result.effort)) >= AT_LIMIT * top).any(axis=1)
    # an effort is given from each sample on
    span = np.diff(result.time, append=result.time[-1])
    share = float(span[at].sum() / span.sum()) if span.sum() > 0.0 else float(at.mean())
    return [
        Sign(
            "actuators at their limits",
            f"{100.0 * share:.3g} % of the time",
            f"at most {100.0 * RUN_SATURATED.value:g} %",
            _graded(share, RUN_SATURATED.value),
            "the law could not do what it wanted; what is seen is the limit's doing too",
        )
    ]
