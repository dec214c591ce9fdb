"""What `cutjoint tune` tunes, how, and how it tells what came of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.commands.options import assigned, numbers, trajectory_of
from cutjoint.commands.output import say, show
from cutjoint.commands.simulated import Robots, has_paper, robots_of
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.motion import Reference
    from cutjoint.tuning import GainSearch, JudgedGains, PaperRule, PolePlacement, Tuning

INFERRED = "inferred"
OPTIONS = {
    "rule": ("--error",),
    "poles": ("--bandwidth", "--damping"),
    "optimise": ("--method", "--trials", "--sensitivity"),
}
"""Options of each way."""


class HowTuned(NamedTuple):
    """How gains are found, the limit of efforts, and what was chosen unasked."""

    by: PaperRule | PolePlacement | GainSearch
    limit: npt.ArrayLike | None
    told: tuple[str, ...]


def robots_for(
    robot: str,
    variant: str | None,
    plant: str | None,
    model: str | None,
    payload: Sequence[float] | None,
    ideal: bool,
    lenient: bool,
) -> Robots:
    """The robot, and what the controller believes.

    Raises:
        UnknownNameError: there is no such robot, variant, plant or model.
        InputError: these do not fit each other.
    """
    from cutjoint.errors import InputError, UnknownNameError

    if plant not in (None, "chain", "paper", INFERRED):
        raise UnknownNameError("plant", plant, ("chain", "paper", INFERRED))
    most = max(payload or [0.0], key=abs)
    found = robots_of(robot, variant, "paper" if plant == "paper" else None, model, 0.0, ideal, lenient, False)
    if most and found.link is not None:
        raise InputError(f"{robot} has no tool frame to carry a payload; name one under [tool] in its loops.toml")
    if plant != INFERRED:
        return found
    if found.chain.description.name != "cpm" or model is not None or variant is not None:
        raise InputError("--plant inferred is a model of the CPM as it is; leave out --model and --variant")
    from cutjoint.papers.cpm import InferredCpmModel

    inferred = InferredCpmModel()
    return found._replace(moving=inferred, inside=inferred)


def way_of(
    robot: str, controller: str, by: str | None, used: Mapping[str, object], limit: str | None, seed: int | None
) -> HowTuned:
    """How gains are found; `used` are the options of all ways, None where they are not given.

    Raises:
        InputError: options of another way.
    """
    from cutjoint.errors import InputError
    from cutjoint.papers.cpm.published import FORCE_LIMIT, TABLE_3
    from cutjoint.tuning import GainSearch, PaperRule, PolePlacement

    printed = next((row for row in TABLE_3 if robot == "cpm" and row.controller.replace("_", "-") == controller), None)
    chosen = by or ("rule" if printed is not None or used["--error"] is not None else "poles")
    given = {name: one for name, one in used.items() if one is not None}
    if others := [name for name in given if name not in OPTIONS[chosen]]:
        whose = ", ".join(f"--by {way}" for way, names in OPTIONS.items() if set(names) & set(others))
        raise InputError(f"{', '.join(others)} is of {whose}, and the gains are found by {chosen}; leave it out")
    bound = None if limit is None else numbers("--limit", limit)
    told = [] if by else [f"by {chosen}, as nothing is said"]
    if chosen == "rule":
        error = given.get("--error")
        if printed is not None and bound is None:
            bound = FORCE_LIMIT
            told.append(f"limit {FORCE_LIMIT:g} N, the paper's")
        if printed is not None and error is None and printed.bound is not None:
            error = printed.bound
            told.append(f"bound of the error {error:g} m, the paper's")
        return HowTuned(PaperRule(error), bound, tuple(told))  # type: ignore[arg-type]
    if chosen == "poles":
        values = {name.removeprefix("--"): one for name, one in given.items()}
        return HowTuned(PolePlacement(**values), bound, tuple(told))  # type: ignore[arg-type]
    values = {name.removeprefix("--"): one for name, one in given.items()}
    if "method" in values:
        values["method"] = str(values["method"])
    return HowTuned(GainSearch(**values, seed=seed or 0), bound, tuple(told))  # type: ignore[arg-type]


def reference_of(robots: Robots, trajectory: str | None, duration: float | None) -> tuple[Reference, list[str]]:
    """What is followed, and what was chosen of it.

    Raises:
        InputError: the robot has no actuators that determine its motion, or the trajectory is wrong.
        UnreachableError, LimitError: it cannot be followed.
    """
    from cutjoint.errors import ActuationError, InputError
    from cutjoint.motion import Reference

    chain = robots.chain
    if chain.n == 0:
        raise InputError(f"{chain.name} has no actuator, so there is no loop to tune; name some in its description")
    spec = trajectory or ("paper" if has_paper(chain) else "about-home")
    try:
        made = trajectory_of(chain, spec, robots.inside)
        reference = Reference(made, robots.inside, duration)
    except ActuationError as error:
        raise InputError(
            f"{error}. A law in actuated coordinates needs actuators that determine the motion: add some to the "
            "description of the robot, one for each motion that is left"
        ) from error
    told = [] if trajectory else [f"following {made.name} for {reference.duration:g} s"]
    return reference, [*told, *getattr(made, "chosen", ())]


def begin_with(controller: str, given: Sequence[str]) -> dict[str, npt.ArrayLike] | None:
    """The gains that are given, all that the controller takes.

    Raises:
        InputError: one is missing, not used, or no number.
    """
    from cutjoint.control.catalogue import law_row
    from cutjoint.errors import InputError

    row = law_row(controller)
    if not given:
        return None
    found = {
        name.replace("-", "_"): numbers(f"--gain {name}", text)
        for name, text in assigned("a gain", "--gain NAME=K", given).items()
    }
    if set(found) != set(row.gains):
        raise InputError(f"controller '{controller}' takes the gains {', '.join(row.gains)}; found {', '.join(found)}")
    return found


# ---- what came of it -----------------------------------------------------------------------------------------------


def show_tuning(found: Tuning, notes: Sequence[str]) -> None:
    """Print gains, figures and what is left open."""
    show(_compared(found))
    if found.found.steps:
        show(_steps(found))
    for one in found.free:
        say(Cell(one, "caution"), first="not fixed: ")
    for one in found.unmet:
        say(Cell(one, "bad"), first="not met: ")
    for one in (*notes, *found.told):
        say(one, first="note: ")


def _compared(found: Tuning) -> TextTable:
    """Gains and figures, a column a set."""
    rows = found.rows
    whose = "tool" if found.of == "tool" else "actuators"
    unit = found.error_unit
    lines = [
        (f"{name} [{found.units[name]}]" if found.units[name] else name, [_spread(row.gains[name]) for row in rows])
        for name in found.gains
    ]
    effort = " or ".join(dict.fromkeys(found.effort_units))
    lines += [
        (f"error of the {whose} from {found.after:g} s on [{unit}]", [_number(row.late) for row in rows]),
        (f"the same over the whole run [{unit}]", [_number(row.largest) for row in rows]),
        (f"rms error of the actuators [{_unit_of_actuators(found)}]", [_number(row.rms) for row in rows]),
        (f"largest effort [{effort}]", [_number(float(row.peak.max())) for row in rows]),
        ("least gain margin [-]", [_least(row, "gain") for row in rows]),
        ("least phase margin [deg]", [_least(row, "phase") for row in rows]),
        ("delay margin, all together [s]", [_number(row.margins.delay) for row in rows]),
        ("peak of the sensitivity [-]", [_number(row.margins.sensitivity) for row in rows]),
        ("least damping of a pole [-]", [_number(row.margins.damping) for row in rows]),
        ("decay of the slowest pole [1/s]", [_number(row.margins.decay) for row in rows]),
        ("longest rise, 10 to 90 % [s]", [_most(row, "rise") for row in rows]),
        ("largest overshoot [%]", [_most(row, "overshoot", 100.0) for row in rows]),
        ("longest settling, 2 % [s]", [_most(row, "settling") for row in rows]),
    ]
    columns = ["", *(row.label for row in rows)]
    failed = "; ".join(f"{row.label}: {row.failed}" for row in rows if row.failed)
    unstable = ", ".join(row.label for row in rows if not row.margins.stable)
    note = "; ".join(part for part in (unstable and f"unstable: {unstable}", failed) if part)
    title = f"{found.robot}, {found.law}: gains by {found.by}"
    return TextTable(title, columns, [(name, *cells) for name, cells in lines], right=columns[1:], note=note)


def _unit_of_actuators(found: Tuning) -> str:
    units = {{"N": "m", "N m": "rad"}[one] for one in found.effort_units}
    return units.pop() if len(units) == 1 else "rad or lengths"


def _steps(found: Tuning) -> TextTable:
    columns = ("actuator", "rise [s]", "overshoot [%]", "settling [s]", "steady error", "gain margin", "phase [deg]")
    units = {"N": "m", "N m": "rad"}
    margins = {one.actuator: one for one in found.found.margins.actuators}
    rows = [
        (
            one.actuator,
            _number(one.rise),
            _number(100.0 * one.overshoot),
            _number(one.settling),
            f"{_number(one.steady)} {units[effort]}",
            _number(margins[one.actuator].gain),
            _number(margins[one.actuator].phase),
        )
        for one, effort in zip(found.found.steps, found.effort_units, strict=True)
    ]
    return TextTable("Step responses and margins with the gains found", columns, rows, right=columns[1:])


def _number(value: float) -> str:
    if math.isinf(value):
        return "no end" if value > 0.0 else "-"
    return "-" if math.isnan(value) else f"{value:.4g}"


def _spread(value: npt.ArrayLike) -> str:
    """One number, or the least and largest of several."""
    array = np.ravel(np.asarray(value, dtype=np.float64))
    low, high = f"{array.min():.6g}", f"{array.max():.6g}"
    if low == high:
        return low
    return f"{array.min():.4g}..{array.max():.4g}"


def _least(row: JudgedGains, name: str) -> str:
    values = [float(getattr(one, name)) for one in row.margins.actuators]
    known = [one for one in values if not math.isnan(one)]
    if not known:
        return "-"
    return _number(min(known, key=lambda one: abs(math.log(max(one, 1e-300)))) if name == "gain" else min(known))


def _most(row: JudgedGains, name: str, factor: float = 1.0) -> str:
    values = [factor * float(getattr(one, name)) for one in row.steps]
    return "-" if not values or any(math.isnan(one) for one in values) else _number(max(values))


def tuning_data(found: Tuning, notes: Sequence[str], *, interrupted: bool) -> dict[str, object]:
    """All of it for machines; what has no end is null."""
    data: dict[str, object] = {
        "robot": found.robot,
        "controller": found.law,
        "by": found.by,
        "gains": dict(found.gains),
        "units": dict(found.units),
        "actuators": found.actuators,
        "error_of": found.of,
        "error_unit": found.error_unit,
        "after_s": found.after,
        "sets": [_row_data(row) for row in found.rows],
        "not_met": found.unmet,
        "not_fixed": found.free,
        "told": [*notes, *found.told],
    }
    return data | ({"interrupted": True} if interrupted else {})


def _row_data(row: JudgedGains) -> dict[str, object]:
    margins = row.margins
    return {
        "label": row.label,
        "gains": dict(row.gains),
        "rms_error": row.rms,
        "late_error": row.late,
        "largest_error": row.largest,
        "largest_effort": row.peak,
        "stable": margins.stable,
        "sensitivity": margins.sensitivity,
        "delay_margin_s": margins.delay,
        "least_damping": margins.damping,
        "slowest_decay_1_s": margins.decay,
        "poles_1_s": np.stack([margins.poles.real, margins.poles.imag], axis=1),
        "margins": [
            {
                "actuator": one.actuator,
                "gain": one.gain,
                "gain_at_rad_s": one.gain_at,
                "phase_deg": one.phase,
                "crossover_rad_s": one.crossover,
                "delay_s": one.delay,
            }
            for one in margins.actuators
        ],
        "steps": [
            {
                "actuator": one.actuator,
                "size": one.size,
                "rise_s": one.rise,
                "overshoot": one.overshoot,
                "settling_s": one.settling,
                "steady_error": one.steady,
            }
            for one in row.steps
        ],
        "failed": row.failed,
    }
