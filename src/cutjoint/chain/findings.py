"""What is wrong or odd with a robot that only its closed chain can tell.

Loops that do not close or only up to rounding, cuts that add nothing, no mobility left, actuators that depend on each
other, joints that stay free, joints that move no mass, a task that cannot be told or done.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from functools import partial
from typing import Literal

import numpy as np

from cutjoint import tolerances
from cutjoint.chain.closed_chain import ClosedChain
from cutjoint.chain.dynamics import massless_motions
from cutjoint.chain.joints import joints_of
from cutjoint.chain.mobility_report import MobilityReport
from cutjoint.chain.rank import null_space
from cutjoint.description.model import CutJoint, Place, RobotDescription
from cutjoint.errors import ClosureError, DynamicsError, InputError, Problem, RoundingWarning

NEAR_SINGULAR = 1e-2
"""Distance to a singularity below which home is called near it."""


def kinematic_problems(description: RobotDescription) -> tuple[tuple[Problem, ...], ClosedChain | None]:
    """Problems of a robot whose files are right, and its closed chain where the loops close at home."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RoundingWarning)  # it is one of the problems below
            chain = ClosedChain(description)
    except ClosureError as error:
        place = next((cut.place for cut in description.cuts if cut.name == error.cut), None)
        problem = Problem(
            found=f"the loops do not close at home: {error}",
            expected="a closed posture near the rough passive coordinates of the home posture",
            mend="give passive coordinates that nearly close the loops, or mend the frames of the cut",
            file=place.file if place else str(description.path or ""),
            line=place.line if place else None,
        )
        return (problem,), None
    return chain_problems(chain, chain.mobility()), chain


def chain_problems(chain: ClosedChain, report: MobilityReport) -> tuple[Problem, ...]:
    """Problems of a closed chain, whose mobility at home is `report`."""
    return tuple(_problems(chain, report))


def usual_mobility(chain: ClosedChain) -> int:
    """The mobility at nearly every posture around home: less than at home where home is singular."""
    return int(chain.model.nv) - chain._mobility.structure.rank


def _problems(chain: ClosedChain, report: MobilityReport) -> Iterator[Problem]:
    description = chain.description
    file = str(description.path or "")
    warning = partial(Problem, file=file, severity="warning")
    if report.mobility == 0:
        yield Problem(
            found=f"the robot cannot move: {report.velocities} joint velocities, {report.rank} independent constraints",
            expected="a mobility of at least 1",
            mend="a cut locks too much; a planar loop wants a revolute or spherical cut rather than a fixed one",
            file=file,
        )
    if report.dropped_rows:
        distance, angle = report.gap
        yield warning(
            found=f"the loops close only up to rounding: {', '.join(report.dropped_rows)} dropped, which are open by "
            f"{distance:.2g} m, {angle:.2g} rad at home",
            expected="lengths with which all rows can be closed",
            mend="export the frames with more digits",
        )
    for cut in _idle_cuts(chain):
        yield warning(
            found=f"cut '{cut.name}' adds nothing: the tree and the other cuts already hold its frames together",
            mend="leave it out, or check that it joins the frames that you mean",
            file=cut.place.file or file,
            line=cut.place.line,
        )
    usual = usual_mobility(chain)
    if usual < report.mobility:
        yield warning(
            found=f"home is singular: the loops allow {report.mobility} independent motions there, {usual} around it",
            expected=f"a home posture where the mobility is {usual}, and that many actuators",
            mend="choose a home posture away from it, where links are not in line or folded onto each other",
        )
    if report.mobility and report.actuators:
        yield from _actuation(report, file)
    if report.type2 < NEAR_SINGULAR:
        yield warning(
            found=f"home is near a type-2 singularity: distance {report.type2:.2g}, 0 is singular",
            mend="choose a home posture away from stretched or folded limbs",
        )
    yield from _task(chain, file)
    home = chain._postures.at_home
    try:
        massless = joints_of(chain.model, massless_motions(chain._k, home.q, null_space(home.scaled)))
    except DynamicsError as one:
        yield Problem(found=str(one), expected="moments of inertia >= 0", file=file)
        return
    if massless:
        yield warning(
            found=f"these joints move no mass: {', '.join(massless)}; they rest, and a force on them has no answer",
            expected="an inertia on every link at the end of a limb",
            mend="add <inertial> to the links they move; kinematics works without",
        )


def _task(chain: ClosedChain, file: str) -> Iterator[Problem]:
    """One that must be said is a warning: what needs none works.  One that is said and cannot be done is an error."""
    robot = chain.description
    if robot.tool is None:
        return
    try:
        _ = chain.task
    except InputError as error:
        place = robot.places.get("task" if robot.task else "tool", Place())
        severity: Literal["error", "warning"] = "error" if robot.task else "warning"
        yield Problem(str(error), file=place.file or file, line=place.line, severity=severity)


def _actuation(report: MobilityReport, file: str) -> Iterator[Problem]:
    warning = partial(Problem, file=file, severity="warning")
    moving = [joint for joint in report.free if joint not in report.idle]
    needed = report.mobility - report.idle_mobility
    if moving:
        yield warning(
            found=f"with all actuators locked these joints still move: {', '.join(moving)}",
            expected=f"as many independent actuators as the mobility, which is {needed} without idle motions"
            if report.idle
            else f"as many independent actuators as the mobility, which is {needed}",
            mend="name further actuators, or add the cut that is missing; full coordinates work all the same",
        )
    surplus = report.actuators - needed
    if not needed:
        yield warning(
            found=f"the actuators cannot move, the loops hold them; what moves is idle: {', '.join(report.idle)}",
            mend="a cut locks too much, or name other joints as actuators",
        )
    elif surplus > 0 and not moving:
        yield warning(
            found=f"the actuators depend on each other: {report.actuators} of them for a mobility of {needed}",
            mend="that is redundant actuation if it is meant; efforts are then not unique",
        )


def _idle_cuts(chain: ClosedChain) -> Iterator[CutJoint]:
    """The cuts without any of which the rank at home is the same: all their rows depend on other rows."""
    k, start = chain._k, 0
    dependences = null_space(chain._postures.at_home.scaled.T)
    for cut in chain.description.cuts:
        own = (k.closure.trusted >= start) & (k.closure.trusted < start + cut.type.rows)
        start += cut.type.rows
        sizes = np.linalg.svd(dependences[own], compute_uv=False)
        if len(sizes) == own.sum() and sizes.min(initial=1.0) > tolerances.RANK.value:
            yield cut
