"""`synthesise`: a robot, what of it may be chosen and what is wanted, to designs."""

from __future__ import annotations

from cutjoint.doors import door
from cutjoint.errors import InputError, Interrupted
from cutjoint.synthesis.judging import DesignProblem, check_problem
from cutjoint.synthesis.result import Synthesis
from cutjoint.synthesis.search import Told, searched


@door
def synthesise(problem: DesignProblem, designs: int = 200, seed: int = 1, told: Told | None = None) -> Synthesis:
    """Search designs that do what is wanted; see `cutjoint.synthesis.search`.

    Args:
        problem: what may be chosen and what is wanted (`problem_of`).
        designs: how many are judged, at least 2; the first is the robot as it is.
        seed: of the search; the same one gives the same designs.
        told: is told how many are judged.

    Raises:
        InputError: fewer than 2 designs, or the wanted has no meaning for the robot.
        MissingPackageError: there are several goals, and optuna is not installed.
        Interrupted: a `KeyboardInterrupt` came; `result` is the `Synthesis` of what is judged.
    """
    if designs < 2:
        raise InputError(f"designs must be at least 2, found {designs}")
    check_problem(problem)
    try:
        found, sentences = searched(problem, designs, seed, told)
    except Interrupted as stop:
        if not isinstance(stop.result, list) or not stop.result:
            raise
        told_too = f"stopped after {len(stop.result)} of {designs} designs"
        stop.result = Synthesis(problem, tuple(stop.result), (told_too,))
        raise
    return Synthesis(problem, tuple(found), tuple(sentences))
