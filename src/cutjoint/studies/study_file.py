"""Reading a study file: TOML, every key with its type; all that is wrong is told at once, with lines."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import numpy.typing as npt

from cutjoint.doors import door
from cutjoint.errors import DescriptionError, InputError
from cutjoint.findings import listing
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware, Tachometer, hardware_of
from cutjoint.simulation.hardware.values import Each
from cutjoint.simulation.integrators import FIXED_STEP
from cutjoint.studies.quantities import QUANTITIES, USUAL
from cutjoint.studies.spreads import KINDS, Kind, Spread
from cutjoint.studies.values import METHODS, FollowingLaw, Method, Study, VariedPath
from cutjoint.toml.reading import read_settings
from cutjoint.toml.table import TomlTable
from cutjoint.toml.taking import one_of, positive, several, truth, whole

MODELS = ("chain", "published")
EVERY = 0.01
MOST_STEPS = 10**6
"""Values of one path in a grid."""
LARGEST_SEED = 2**63
LARGEST_BLOCK = 2**20
HARDWARE_PARTS = ("clock", "encoder", "differences", "tachometer", "drive")
"""Tables of docs/hardware.md; the short keys stand for them."""


@door
def read_study(path: str | os.PathLike[str]) -> Study:
    """A study of a TOML file (docs/studies.md).

    Raises:
        SettingsError: no such file, no TOML, keys that are missing or unknown, values that are wrong: all of them,
            with their lines.
    """
    place = Path(path)
    return read_settings(place, lambda top: _checked(_study(top, place), top))


def _study(top: TomlTable, place: Path) -> Study:
    method = one_of(top, "method", tuple(METHODS), "random")
    seed, runs = whole(top, "seed", 0, LARGEST_SEED) or 0, whole(top, "runs", 1, 10**18)
    hardware = [
        (_named(table, f"hardware {k + 1}"), _hardware(table, seed)) for k, table in enumerate(several(top, "hardware"))
    ]
    laws = tuple(_law(table) for table in several(top, "controller"))
    if not laws:
        top.findings.error("no [controller]", "who follows the trajectory", 'add [controller] with name = "pd"')
    keep, every = _kept(top.table("keep"))
    made = Study(
        name=place.stem,
        robot=_robot(top, place),
        model=one_of(top, "model", MODELS, "chain"),
        variants=_texts(top, "variant", "variants") or (None,),
        ideal=truth(top, "ideal"),
        duration=positive(top, "duration"),
        step=positive(top, "step") or 1e-3,
        integrator=one_of(top, "integrator", tuple(FIXED_STEP), "rk4"),
        method=cast(Method, method),
        runs=runs,
        seed=seed,
        trajectories=_trajectories(top, place),
        laws=laws,
        hardware=tuple(hardware) or (("", None),),
        varied=tuple(_varied(table, method) for table in top.tables("vary")),
        keep=keep,
        every=every,
        block=whole(top, "block", 1, LARGEST_BLOCK),
        settings=json.dumps(top.data, sort_keys=True, default=str),
    )
    top.finish()
    return made


def _checked(study: Study, top: TomlTable) -> Study:
    """The study, after noting what does not fit each other."""
    findings = top.findings
    if study.method == "grid" and study.runs is not None:
        findings.error("runs of a grid", "no key runs: a grid has all combinations", "", top.place("runs"))
    if study.method != "grid" and study.runs is None and "runs" not in top.data:
        findings.error("no runs", "how many runs every case has", "add runs = ...", top.place())
    if study.method in ("sobol", "saltelli") and not study.varied:
        findings.error(f"method '{study.method}' without [[vary]]", "something that varies", "", top.place("method"))
    if study.model == "published" and study.variants != (None,):
        findings.error("variants of a published model", 'model = "chain"', "", top.place("variant"))
    paths = [one.path for one in study.varied]
    for path in {one for one in paths if paths.count(one) > 1}:
        findings.error(f"{path} varies twice", "one [[vary]] a path", "", top.place("vary"))
    for what, names in (
        ("trajectories", study.trajectories), ("variants", study.variants),
        ("hardware", tuple(name for name, _ in study.hardware)),
    ):  # fmt: skip
        if len(set(names)) < len(names):
            findings.error(f"{what} with one name twice", "a name each", "", top.place())
    if not findings.failed:
        try:
            _ = study.total
        except InputError as error:
            findings.error(str(error), at=top.place("runs"))
    return study


def _robot(top: TomlTable, place: Path) -> str:
    """The robot; a path is one from the folder of the study."""
    name = top.string("robot", required=True)
    beside = place.parent / name
    return str(beside.resolve()) if name and ("/" in name or "." in name) and beside.exists() else name


def _trajectories(top: TomlTable, place: Path) -> tuple[str, ...]:
    """Trajectories; a file of one is looked for from the folder of the study."""
    found = _texts(top, "trajectory", "trajectories") or ("",)
    beside = [place.parent / one for one in found]
    return tuple(str(at.resolve()) if one and at.is_file() else one for one, at in zip(found, beside, strict=True))


def _varied(table: TomlTable, method: str) -> VariedPath:
    path = table.string("path", required=True)
    given = [kind for kind in KINDS if table.take(kind) is not None]
    steps = whole(table, "steps", 1, MOST_STEPS)
    table.finish()
    spread = Spread("values", (0.0,))
    if len(given) != 1:
        known = ", ".join(f"{name} = {about}" for name, about in KINDS.items())
        what = f"{' and '.join(given)}" if given else "no values"
        table.findings.error(f"{what} for '{path}' in {table.name}", f"one of: {known}", "", table.place())
        return VariedPath(path, spread)
    kind = given[0]
    numbers = table.values(kind)
    if numbers is not None:
        listed = numbers if isinstance(numbers, tuple) else (numbers,)
        if fault := _fault(kind, listed, isinstance(numbers, tuple)):
            table.wrong(kind, table.data[kind], f"{KINDS[kind]}: {fault}")
        else:
            spread = Spread(cast(Kind, kind), listed, steps or 0)
    if method == "grid" and kind == "normal":
        table.wrong(kind, table.data[kind], "values, uniform, log-uniform or relative in a grid")
    elif method == "grid" and kind != "values" and steps is None:
        table.findings.error(f"{kind} without steps in a grid", "how many values", "add steps = ...", table.place())
    elif steps is not None and (method != "grid" or kind == "values"):
        table.findings.error(f"steps of '{path}'", "steps only of a range in a grid", "", table.place("steps"))
    return VariedPath(path, spread)


def _fault(kind: str, numbers: Sequence[float], is_list: bool) -> str:
    """What is wrong with the numbers of a spread; nothing where they are right."""
    if kind == "relative":
        return "" if not is_list and 0.0 < numbers[0] < 1.0 else "one number between 0 and 1"
    if kind == "values":
        distinct = is_list and numbers and len(set(numbers)) == len(numbers)
        return "" if distinct else "an empty list, or the same number twice"
    if not is_list or len(numbers) != 2:
        return "two numbers"
    if kind == "normal":
        return "" if numbers[1] > 0.0 else "a standard deviation > 0"
    if kind == "log-uniform" and numbers[0] <= 0.0:
        return "numbers > 0"
    return "" if numbers[0] < numbers[1] else "the range is empty or upside down"


def _law(table: TomlTable) -> FollowingLaw:
    name = table.string("name", required=True)
    believes = one_of(table, "model", ("", *MODELS), "")
    gains: dict[str, npt.ArrayLike] = {}
    own = table.table("gains")
    for gain in own.data if own is not None else ():
        assert own is not None
        value = own.take(gain)
        try:
            array = np.asarray(value, dtype=np.float64)
            if isinstance(value, bool | str) or not np.isfinite(array).all() or not array.size:
                raise ValueError
        except (TypeError, ValueError):
            own.wrong(gain, value, "a number, a list of one an actuator, or a matrix")
            continue
        gains[gain] = cast(npt.ArrayLike, value)
    table.finish()
    return FollowingLaw(name, gains, believes)


def _hardware(table: TomlTable, seed: int) -> Hardware | None:
    """Short keys, or the tables of docs/hardware.md; with the noise and jitter of a seed."""
    if any(name in table.data for name in HARDWARE_PARTS):
        parts = {name: table.take(name) for name in HARDWARE_PARTS if name in table.data}
        table.finish()
        try:
            return hardware_of({**parts, "seed": seed})
        except DescriptionError as error:
            for one in error.problems:
                table.findings.error(one.found, one.expected, one.mend, table.place())
            return None
    numbers = {name: positive(table, name, zero=True) for name in ("delay", "command_delay", "jitter")}
    rate, tick, cutoff = (positive(table, name) for name in ("rate", "tick", "filter"))
    limits, resolution, noise = (
        cast(Each | None, table.values(name)) if table.take(name) is not None else None
        for name in ("limits", "resolution", "noise")
    )
    table.finish()
    if rate is None:
        if "rate" not in table.data:
            table.findings.error(
                f"{table.name} without a rate", "the sample rate [Hz]", "add rate = ...", table.place()
            )
        return None
    try:
        return Hardware(
            Clock(rate, numbers["jitter"] or 0.0, tick),
            Encoder(resolution, noise=0.0 if noise is None else noise, delay=numbers["delay"] or 0.0),
            Tachometer() if cutoff is None else Differences(cutoff),
            Drive(limits, delay=numbers["command_delay"] or 0.0),
            seed,
        )
    except InputError as error:
        table.findings.error(str(error), at=table.place())
        return None


def _kept(table: TomlTable | None) -> tuple[tuple[str, ...], float]:
    if table is None:
        return USUAL, EVERY
    given, every = table.strings("columns"), positive(table, "every")
    table.finish()
    if given == ():
        table.wrong("columns", [], f"some of {listing(QUANTITIES)}")
    for name in given or ():
        if name not in QUANTITIES:
            table.findings.unknown(f"unknown column '{name}'", name, list(QUANTITIES), table.place("columns"))
    return tuple(dict.fromkeys(given)) if given else USUAL, every or EVERY


def _named(table: TomlTable, default: str) -> str:
    return table.string("name") or default


def _texts(top: TomlTable, one: str, several: str) -> tuple[str, ...]:
    """One text or a list of them, each under its own key."""
    single, many = top.string(one), top.strings(several)
    if one in top.data and several in top.data:
        top.findings.error(f"both {one} and {several}", "one of them", "", top.place(several))
    if many == ():
        top.wrong(several, [], "a list that is not empty")
    return tuple(many) if many else ((single,) if single else ())
