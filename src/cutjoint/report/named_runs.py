"""Runs with the names that legends and tables give them, of one robot, and that robot where it can be found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

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


def robot_of(result: Result, variant: str | None = None, *, lenient: bool = False) -> ClosedChain:
    """The robot that a result names, where it is one that is found by name.

    Args:
        result: the run.
        variant: named set of inertias; default that which the result names.
        lenient: as `robots.load` has it.

    Raises:
        InputError: it is not found, or the robot of that name is another one.
        UnknownNameError: it has no such variant.
    """
    from cutjoint.robots import load

    named = str(result.about.get("robot", ""))
    name, _, rest = named.partition(" ")
    mend = "name it with --robot, or give robot= in Python"
    if not name:
        raise InputError(f"the result does not tell its robot; {mend}")
    try:
        chain = load(name, variant, lenient=lenient)
    except UnknownNameError as error:
        if error.kind == "variant":
            raise
        raise InputError(f"the result was made with '{named}', which is no robot here; {mend}") from error
    made_with = rest.strip("()")
    if variant is None and made_with in {one.name for one in chain.description.variants}:
        chain = load(name, made_with, lenient=lenient)
    check_robot(result, chain)
    return chain


def robot_of_runs(
    named: Mapping[str, Result], robot: ClosedChain | None
) -> tuple[ClosedChain | None, CutjointError | None]:
    """The robot that runs were made with: `robot` where it is given, else the one that the first run names; where that
    is not found, None and the error that says why.

    Raises:
        InputError: a run cannot be one of the robot that is given.
    """
    if robot is None:
        try:
            return robot_of(next(iter(named.values()))), None
        except CutjointError as error:
            return None, error
    for run in named.values():
        check_robot(run, robot)
    return robot, None


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
