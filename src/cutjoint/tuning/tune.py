"""Gains of a law for a robot and what it follows: by the CPM paper's rule, by poles, or by search, beside others."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.control.usual_gains import usual_gains
from cutjoint.doors import door
from cutjoint.errors import ActuationError, InputError, Interrupted, SingularError
from cutjoint.extras import needed
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Reference
from cutjoint.simulation.hardware import Hardware
from cutjoint.tuning.case import Gains, Of, TuningCase
from cutjoint.tuning.judging import judged
from cutjoint.tuning.known import COMPUTED_TORQUE, GAINS
from cutjoint.tuning.margins import WHAT
from cutjoint.tuning.poles import PolePlacement, by_poles
from cutjoint.tuning.rule import FoundGains, PaperRule, by_rule
from cutjoint.tuning.runs import CaseRuns
from cutjoint.tuning.search import GainSearch, Searching
from cutjoint.tuning.values import JudgedGains, Tuning

SETTLED = 0.3
"""From when on late errors count where nobody says [s]: as the CPM's paper (section 5.4)."""
SLACK = 1e-6
"""Part by which a limit or bound may be passed: two runs of the same gains with other steps differ by less."""
PAPERS = ("cpm",)
"""Robots of whose known gains the paper prints all; the others' are this project's."""


# long: its arguments and what they mean
@door
def tune(
    robot: Mechanism,
    law: str,
    reference: Reference,
    *,
    by: PaperRule | PolePlacement | GainSearch,
    model: Mechanism | None = None,
    hardware: Hardware | None = None,
    limit: npt.ArrayLike | None = None,
    payloads: npt.ArrayLike = (0.0,),
    after: float | None = None,
    of: Of | None = None,
    begin: Mapping[str, npt.ArrayLike] | None = None,
    compare: Mapping[str, Mapping[str, npt.ArrayLike]] | None = None,
    draws: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Tuning:
    """Find gains, and tell how the loop does with them and with others.

    Args:
        robot: a closed chain or published model, compiled or not.
        law: name of the law, as of `cutjoint.control.law`; one from outside too.
        reference: what is followed.
        by: how: `PaperRule(error)`, `PolePlacement(bandwidth, damping)` or `GainSearch(...)`.
        model: what the law believes; default the robot.
        hardware: what stands between law and joints; default continuous control.
        limit: efforts that should not be exceeded, one or one an actuator, [N] or [N m]; nothing is cut off there
            (limits of the hardware's drive do that).
        payloads: masses at the tool [kg], the worst of which counts; the law does not know them.
        after: from when on the late error counts [s]; default 0.3 s, or half of a shorter run.
        of: whether late errors are those of the "tool" (the default where its point moves) or the "actuators".
        begin: gains where rule and search begin; default those known for the robot, or the usual ones.
        compare: further gains to judge beside those found, by label.
        draws: runs of every set of gains and payload, each with other noise and jitter, the worst of which counts;
            default 3 where there is noise or jitter.  All sets of gains meet the same.
        progress: called with the number of sets of gains that a search has tried.

    Raises:
        InputError: arguments that are wrong or do not fit; the actuators do not determine the motion; no such gains.
        UnknownNameError: there is no such law.
        MissingPackageError: python-control is not installed, or optuna where it is asked for.
        Interrupted: a `KeyboardInterrupt` came in a search; `result` is the `Tuning` with the best gains until then.
    """
    needed("control", WHAT)
    late = min(SETTLED, 0.5 * reference.duration) if after is None else after
    case = TuningCase(
        robot,
        law,
        reference,
        model=model,
        hardware=hardware,
        limits=limit,
        payloads=payloads,
        after=late,
        of=of,
        draws=draws,
    )
    others = _others(case, compare or {})
    interrupted = False
    if isinstance(by, PaperRule):
        guess = _beginning(case, begin, others)
        found = by_rule(case, by, guess)
    elif isinstance(by, PolePlacement):
        if begin is not None:
            raise InputError("poles are placed at once; gains to begin with are for the rule and the search")
        found = by_poles(case, by)
    else:
        search = Searching(case, by, _beginning(case, begin, others), progress)
        found, interrupted = search.outcome(), search.interrupted
    made = _judge(case, by, found, others)
    if interrupted:
        words = f"the search was interrupted after {search.done} of {by.trials} sets of gains"  # type: ignore[union-attr]
        raise Interrupted(words, done=search.done / by.trials, result=made)  # type: ignore[union-attr]
    return made


def _judge(
    case: TuningCase,
    by: PaperRule | PolePlacement | GainSearch,
    found: FoundGains,
    others: Mapping[str, Mapping[str, Array]],
) -> Tuning:
    sets: dict[str, Mapping[str, Array]] = {"found": found.gains, **others}
    n = case.robot.n
    top = {
        name: np.max([np.broadcast_to(np.asarray(one[name]), (n,)) for one in sets.values()], axis=0)
        for name in found.gains
    }
    runs = CaseRuns(case, top)
    rows: list[JudgedGains] = [judged(case, runs, label, gains) for label, gains in sets.items()]
    return Tuning(
        _name(case),
        case.name,
        tuple(one.name for one in case.robot.actuators),
        by.words,
        case.units(),
        tuple(one.effort_unit for one in case.robot.actuators),
        case.of,
        case.error_unit,
        case.after,
        tuple(rows),
        found.free,
        (*found.told, *_left_out(case)),
        tuple(_unmet(case, by, rows[0])),
    )


def _unmet(case: TuningCase, by: PaperRule | PolePlacement | GainSearch, found: JudgedGains) -> list[str]:
    """What was asked for and does not hold with the gains found."""
    told = list[str]()
    if not found.margins.stable:
        told.append("the loop, its rate and delays included, is unstable: ask for slower poles, or search")
    elif found.failed:
        told.append(f"the run does not come to its end: {found.failed}")
    if case.limits is not None:
        for one, peak, limit in zip(case.robot.actuators, found.peak.tolist(), case.limits.tolist(), strict=True):
            if peak > limit * (1.0 + SLACK):
                unit = one.effort_unit
                told.append(f"the run needs {peak:.4g} {unit} of {one.name}, and its limit is {limit:.4g} {unit}")
    if isinstance(by, PaperRule) and by.error is not None and not found.late < by.error * (1.0 + SLACK):
        told.append(f"the late error is {found.late:.4g} {case.error_unit}, and its bound is {by.error:g}")
    if isinstance(by, GainSearch) and found.margins.stable and found.margins.sensitivity > 1.02 * by.sensitivity:
        told.append(
            f"the sensitivity peaks at {found.margins.sensitivity:.4g}, and {by.sensitivity:g} is asked for at most"
        )
    return told


def _name(case: TuningCase) -> str:
    """Of the robot that was compiled."""
    return str(getattr(case.robot, "plain", case.robot).name)


def _left_out(case: TuningCase) -> list[str]:
    """What the linear loop leaves out of the real one."""
    told = list[str]()
    if not case.is_smooth:
        told.append("dry friction is in the runs and steps, and left out of margins and poles")
    hardware = case.hardware
    if hardware is None:
        told.append("control is continuous: margins are those of the law alone; a rate and delays take some of them")
        return told
    drive, encoder = hardware.drive, hardware.encoder
    parts = [
        ("jitter", hardware.clock.jitter),
        ("steps of encoders", encoder.resolution),
        ("steps of commands", drive.resolution),
        ("limits of the drive", drive.limits),
        ("the motor's torque-speed line", drive.torque_speed),
        ("play of gears", drive.backlash),
    ]
    if present := [name for name, one in parts if one]:
        told.append(f"in the runs, and left out of margins and poles: {', '.join(present)}")
    return told


def _others(case: TuningCase, given: Mapping[str, Mapping[str, npt.ArrayLike]]) -> dict[str, Mapping[str, Array]]:
    """Gains to compare with: those given, those known of the robot, the usual ones.

    Raises:
        InputError: gains that the law does not take.
    """
    sets: dict[str, Gains] = dict(given)
    robot = _name(case).split(" ")[0]
    known = GAINS.get(robot, {}).get(case.name)
    if known is not None:
        sets.setdefault("paper" if robot in PAPERS else "known", known)
    if usual := _usual(case):
        sets.setdefault("usual", usual)
    for label, gains in sets.items():
        if label == "found":
            raise InputError("'found' is the label of the gains that are found; give those to compare another one")
        case.law(gains)
    return {
        label: {name: np.asarray(one, dtype=np.float64) for name, one in gains.items()} for label, gains in sets.items()
    }


def _usual(case: TuningCase) -> Gains | None:
    """Gains that `cutjoint simulate` takes where none are known."""
    if case.name == "computed-torque":
        return COMPUTED_TORQUE
    if case.row.told or not set(case.row.gains) <= {"kp", "ki", "kd"}:
        return None
    try:
        found = usual_gains(case.robot)
    except (ActuationError, SingularError):
        return None
    return {name: found[name] for name in case.row.gains}


def _beginning(
    case: TuningCase, begin: Mapping[str, npt.ArrayLike] | None, others: Mapping[str, Mapping[str, Array]]
) -> Mapping[str, Array]:
    """Where rule and search begin.

    Raises:
        InputError: nothing is given or known.
    """
    if begin is not None:
        case.law(begin)
        return {name: np.asarray(one, dtype=np.float64) for name, one in begin.items()}
    for label in ("paper", "known", "usual"):
        if label in others:
            return others[label]
    raise InputError(f"no gains of '{case.name}' are known to begin with; give some: {', '.join(case.row.gains)}")
