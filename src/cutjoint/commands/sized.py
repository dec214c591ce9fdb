"""What `cutjoint size` is asked and what it answers: robot, trajectories, motors; files and plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.commands.options import numbers, trajectory_of
from cutjoint.errors import InputError, shown

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Reference
    from cutjoint.sizing import Anywhere, Duty, Extreme, Gearing, MotorFit, ServoMotor, Sizing


def check_places(picture: Path | None, csv: Path | None) -> None:
    """Before the work: whether there is a place for the files.

    Raises:
        InputError: another suffix, no such folder, or nothing can be written there.
    """
    from cutjoint.files import check_place

    if picture is not None:
        from cutjoint.extras import needed
        from cutjoint.report.answers.sheet import check_picture

        check_picture(picture)
        needed("matplotlib", "a plot")
    if csv is not None:
        if csv.suffix != ".csv":
            raise InputError(f"the instants are written as .csv; found '{csv}'")
        check_place(csv)


def motors_of(
    files: Sequence[Path],
    gear: str | None,
    efficiency: float,
    inertia: float,
    pitch: float | None,
    brake_factor: float,
    ambient: float,
) -> tuple[list[ServoMotor], Gearing]:
    """The motors of all tables, and what is between them and the actuators.

    Raises:
        InputError: a table or number is wrong, or there are options of gears and no motors.
    """
    from cutjoint.sizing import Gearing, motors_from_file

    given = {
        "--gear": gear is not None,
        "--efficiency": efficiency != 1.0,
        "--gear-inertia": inertia != 0.0,
        "--pitch": pitch is not None,
        "--brake-factor": brake_factor != 1.5,
        "--ambient": ambient != 40.0,
    }
    used = [name for name, is_given in given.items() if is_given]
    if used and not files:
        raise InputError(f"{', '.join(used)} says more about motors; give their table too, with --motors FILE.csv")
    ratios: tuple[float, ...] = ()
    if gear is not None:
        array = np.atleast_1d(np.asarray(numbers("--gear", gear), dtype=np.float64))
        if array.ndim != 1:
            raise InputError(f"--gear must be ratios with commas, such as 3,5,10; found '{gear}'")
        ratios = tuple(array.tolist())
    gearing = Gearing(ratios, efficiency, inertia, pitch, brake_factor, ambient)
    return [motor for file in files for motor in motors_from_file(file)], gearing


def check_anywhere(
    wanted: bool, speed: float | None, acceleration: float | None, turning: float | None, turning_rate: float | None
) -> None:
    """Raises InputError where bounds of the tool are missing, or not used."""
    given = {
        "--tool-speed": speed,
        "--tool-acceleration": acceleration,
        "--turn-speed": turning,
        "--turn-acceleration": turning_rate,
    }
    if wanted and (missing := [name for name in ("--tool-speed", "--tool-acceleration") if given[name] is None]):
        raise InputError(f"--workspace needs bounds of the tool: give {', '.join(missing)}")
    used = [name for name, value in given.items() if value is not None]
    if used and not wanted:
        raise InputError(f"{', '.join(used)} is for the whole workspace; give --workspace too")


def robot_of(robot: str, variant: str | None, ideal: bool, lenient: bool) -> tuple[ClosedChain, list[str]]:
    """The robot, and what was chosen unasked."""
    from cutjoint.robots import load
    from cutjoint.simulation.watched import watched

    chain, link = watched(load(robot, variant, dynamics="ideal" if ideal else "real", lenient=lenient))
    if not chain.actuators:
        raise InputError(f"{robot} has no actuator to size; name its actuators in its loops.toml")
    return chain, [] if link is None else [f"no tool is named: it is link '{link}', the end of the longest limb"]


def references_of(
    chain: ClosedChain, specs: Sequence[str], duration: float | None
) -> tuple[Mechanism, list[Reference]]:  # fmt: skip
    """The robot, compiled where it can be, and the trajectories seen through it.

    Raises:
        UnknownNameError, InputError, UnreachableError: as of the trajectories.
        ActuationError: the actuators do not determine the motion.
    """
    from cutjoint.motion import Reference
    from cutjoint.robots import PUBLISHED
    from cutjoint.simulation.choice import quick

    row = PUBLISHED.get(chain.description.name)
    default = "paper" if row is not None and row.path is not None else "about-home"
    twice = [spec for spec in specs if list(specs).count(spec) > 1]
    if twice:
        raise InputError(f"trajectory '{shown(twice[0])}' is given twice")
    paths = [trajectory_of(chain, spec) for spec in specs or (default,)]
    fast = quick(chain)
    return fast, [Reference(path, fast, duration) for path in paths]


def too_small(found: Sizing) -> bool:
    """Whether there are motors, and none does it at some actuator."""
    return bool(found.fits) and any(
        not any(fit.fits for fit in found.fits_of(actuator.name)) for actuator in found.actuators
    )


def write_files(found: Sizing, picture: Path | None, csv: Path | None) -> None:
    """Write the picture and the instants."""
    if picture is not None:
        from cutjoint.report.answers.sheet import write_sheet
        from cutjoint.report.answers.sizing import draw_sizing

        write_sheet(draw_sizing(found), picture)
    if csv is not None:
        from cutjoint.files import write_whole

        write_whole(csv, instants(found))


def instants(found: Sizing) -> str:
    """All instants that were evaluated as the text of a CSV file."""
    from cutjoint.simulation.csv_text import csv_text

    courses = [cycle.course for cycle in found.cycles]
    number = [np.full(len(one.t), float(k)) for k, one in enumerate(courses, start=1)]
    columns = {"trajectory": np.concatenate(number), "time [s]": np.concatenate([one.t for one in courses])}
    for i, actuator in enumerate(found.actuators):
        unit, force = actuator.unit, actuator.effort_unit
        told = (("position", unit, "q"), ("speed", f"{unit}/s", "v"), ("acceleration", f"{unit}/s2", "a"),
                ("effort", force, "effort"), ("holding", force, "holding"), ("power", "W", "power"))  # fmt: skip
        for name, of, field in told:
            values = np.concatenate([getattr(one, field)[:, i] for one in courses])
            columns[f"{actuator.name} {name} [{of}]"] = values
    return csv_text(list(columns), list(columns.values()))


def data(found: Sizing, anywhere: Anywhere | None, told: Sequence[str]) -> dict[str, object]:
    """All of it as plain values, SI units."""
    answer: dict[str, object] = {
        "robot": found.robot,
        "payload_kg": found.payload,
        "worst": [_duty(one) for one in found.worst],
        "trajectories": [
            {
                "name": one.name,
                "duration_s": one.duration,
                "actuators": [_duty(duty) for duty in one.duties],
                "work_j": sum(duty.work for duty in one.duties),
                "friction_j": one.lost,
                "loads_j": one.received,
                "gained_j": one.gained,
                "balance": one.balance,
                "error": one.error,
            }
            for one in found.cycles
        ],
    }
    if found.fits:
        answer["motors"] = [_fit(one) for one in found.fits]
        answer["all_fit"] = not too_small(found)
    if found.bearings:
        answer["bearings"] = [asdict(one) for one in found.bearings]
    if anywhere is not None:
        names = [one.name for one in anywhere.actuators]
        numbers_of = ("effort", "speed", "power", "holding", "at_effort", "reach", "postures")
        answer["anywhere"] = {"actuators": names, **{name: getattr(anywhere, name) for name in numbers_of}}
    if told:
        answer["chosen"] = list(told)
    return answer


def _extreme(one: Extreme) -> dict[str, object]:
    return {"value": one.value, "at_s": one.time, "trajectory": one.trajectory}


def _duty(one: Duty) -> dict[str, object]:
    return {
        "actuator": one.actuator.name,
        "effort_unit": one.actuator.effort_unit,
        "speed_unit": f"{one.actuator.unit}/s",
        "effort": _extreme(one.effort),
        "rms_effort": one.rms_effort,
        "holding": _extreme(one.holding),
        "speed": _extreme(one.speed),
        "rms_speed": one.rms_speed,
        "power_w": _extreme(one.power),
        "returned_w": _extreme(one.returned),
        "given_j": one.given,
        "back_j": one.back,
    }


def _fit(one: MotorFit) -> dict[str, object]:
    named = (
        *("ratio", "is_chosen", "best_ratio", "least_heat", "effort", "rms_effort", "speed", "rms_speed"),
        *("peak_use", "heat_use", "speed_use", "inertia_ratio", "reflected", "brake_use", "worst_at", "margin"),
        *("fits", "why_not"),
    )
    answer = {name: getattr(one, name) for name in named}
    return {
        "actuator": one.actuator.name,
        "motor": one.motor.name,
        **answer,
        "temperature_degc": one.temperature,
    }
