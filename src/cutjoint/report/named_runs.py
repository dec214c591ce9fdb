"""Runs with the names that legends and tables give them, of one robot, and that robot where it can be found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, cast

from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.simulation.result import Result
from cutjoint.simulation.result_file import load as load_result
from cutjoint.simulation.summary import actuators_of

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain

Runs: TypeAlias = Result | Sequence[Result] | Mapping[str, Result]
SUFFIX = ".npz"


def named_runs(runs: Runs) -> dict[str, Result]:
    """Runs by name, all of one robot.

    Raises:
        InputError: there is none, something else is among them, or they are of different robots.
    """
    if isinstance(runs, Result):
        named = {"run": runs}
    elif isinstance(runs, Mapping):
        named = {str(name): run for name, run in runs.items()}
    elif isinstance(runs, Sequence) and not isinstance(runs, str | bytes):
        named = {f"run {number}": run for number, run in enumerate(runs, 1)}
    else:
        raise InputError(f"expected a result, several, or results by name; found {type(runs).__name__}")
    if not named:
        raise InputError("there is no run to show; give at least one result")
    for name, run in named.items():
        if not isinstance(run, Result):
            raise InputError(f"expected a result as '{name}', found {type(run).__name__}; simulation.load reads files")
    _check_same(named)
    return named


def runs_of_files(paths: Sequence[Path]) -> dict[str, Result]:
    """The runs in result files, by the names of the files without suffix; by more of their paths where these are alike.

    Raises:
        InputError: a file is no .npz, the same file is given twice, or the runs are of different robots.
        ResultFileError: a file holds no result.
    """
    for path in paths:
        if path.suffix == ".csv":
            raise InputError(
                f"{path}: CSV files are not read; give the {SUFFIX} that `cutjoint simulate --save` writes"
            )
        if path.suffix != SUFFIX:
            raise InputError(f"{path} is no result file; give a {SUFFIX} that `cutjoint simulate --save` wrote")
    names = [path.stem for path in paths]
    if len(set(names)) < len(names):
        names = [str(path.with_suffix("")) for path in paths]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{twice}{SUFFIX} is given twice; give each run once")
    return named_runs({name: load_result(path) for name, path in zip(names, paths, strict=True)})


def _check_same(named: Mapping[str, Result]) -> None:
    (first, one), *others = named.items()
    for name, other in others:
        robots = [str(run.about.get("robot", "")).partition(" ")[0] for run in (one, other)]
        if actuators_of(one) != actuators_of(other) or (all(robots) and robots[0] != robots[1]):
            told = [
                f"{run_name} of {robot or 'a robot'} ({', '.join(actuator for actuator, _ in actuators_of(run))})"
                for run_name, robot, run in ((first, robots[0], one), (name, robots[1], other))
            ]
            raise InputError(f"runs of different robots cannot be laid over each other: {', '.join(told)}")


def robots_of(named: Mapping[str, Result], robot: ClosedChain | None) -> tuple[dict[str, ClosedChain | None], str]:
    """The robots of runs by the names of these, and why there is none of those that have none: the given robot, else
    each the one that it was made with.

    Raises:
        InputError: `robot` is another one.
    """
    if robot is not None:
        for run in named.values():
            check_robot(run, robot)
        return dict.fromkeys(named, robot), ""
    found: dict[str, ClosedChain | None] = {}
    known: dict[str, ClosedChain] = {}
    why = ""
    for name, run in named.items():
        words = repr([run.about.get(one) for one in ("robot", "file", "fingerprint", "options", "joints")])
        try:
            found[name] = known[words] if words in known else robot_of(run)
            known[words] = found[name] or known[words]
        except CutjointError as error:
            found[name], why = None, why or str(error)
    return found, why


def robot_of(result: Result, variant: str | None = None, *, lenient: bool = False) -> ClosedChain:
    """The robot that a result was made with: from the file that the result tells, else by its name.

    Args:
        result: the run.
        variant: named set of inertias; default that which the run was made with.
        lenient: as `robots.load` has it; a run that was made so needs no telling.

    Raises:
        InputError: it is not found, or what is there is another one.
        UnknownNameError: it has no such variant.
        DescriptionError: its files are wrong now.
    """
    where = _place(result)
    first = None
    for chain in _as_made(result, where, variant, lenient):
        first = first or chain
        if variant is not None or _is_as_made(result, chain):
            check_robot(result, chain)
            return chain
    assert first is not None
    check_robot(result, first)
    raise InputError(
        f"the robot of this run is not the one that {where} is now: masses, lengths, limits or joint physics differ; "
        f"simulate again, or take it as it is: {MEND}"
    )


MEND = "name it with --robot, or give robot= in Python"


def _place(result: Result) -> Path | str:
    """The file or the name of a result's robot.

    Raises:
        InputError: the result tells none, or what it tells is not there.
    """
    from cutjoint.description.catalogue import example_names, names

    name = str(result.about.get("robot", "")).partition(" ")[0]
    if not name:
        raise InputError(f"the result does not tell its robot; {MEND}")
    file = result.about.get("file")
    if file is not None and Path(file).is_file():
        return Path(file)
    own = name in (*names(), *example_names()) or Path(name).exists()
    if file is not None and not (own and "fingerprint" in result.about):
        raise InputError(f"the result was made with '{name}' of {file}, which is not there; {MEND}")
    return name


def _as_made(result: Result, where: Path | str, variant: str | None, lenient: bool) -> Iterator[ClosedChain]:
    """The robot as the run had it, as far as the result tells; else as it may have had it."""
    from cutjoint.robots import load

    named = str(result.about.get("robot", ""))
    options = result.about.get("options")
    told = options or {}
    lenient = lenient or bool(told.get("lenient", False))
    try:
        chain = load(where, variant, lenient=lenient)
    except UnknownNameError as error:
        if error.kind == "variant":
            raise
        raise InputError(f"the result was made with '{named}', which is no robot here; {MEND}") from error
    made_with = str(told.get("variant", named.partition(" ")[2].strip("()")))
    if variant is None and made_with in {one.name for one in chain.description.variants}:
        chain = load(where, made_with, lenient=lenient)
    payload = float(cast("float", told.get("payload", 0.0)))
    for ideal in (False, True) if options is None else (bool(told.get("ideal", False)),):
        made = chain.rebuilt(chain.description.ideal()) if ideal else chain
        yield made.with_payload(payload) if payload else made


def _is_as_made(result: Result, chain: ClosedChain) -> bool:
    """Whether a robot moves as that of a result; results of earlier versions do not tell."""
    from cutjoint.description.fingerprint import fingerprint

    own = fingerprint(chain.description)
    return result.about.get("fingerprint", own) == own


def check_robot(result: Result, chain: ClosedChain) -> None:
    """That a result can be one of `chain`, as far as actuators and joints tell.

    Raises:
        InputError: it cannot.
    """
    from cutjoint.simulation.coordinates import joints_of

    own = [(one.name, one.kind) for one in chain.actuators]
    joints = result.about.get("joints")
    same = actuators_of(result) == own if "actuators" in result.about else result.q.shape[1] == chain.n
    if not same or (joints is not None and [list(one) for one in joints] != joints_of(chain)):
        raise InputError(
            f"the result is of a robot with the actuators {', '.join(name for name, _ in actuators_of(result))}, and "
            f"{chain.name} has {', '.join(name for name, _ in own)}, or other joints; give the robot it was made with"
        )
