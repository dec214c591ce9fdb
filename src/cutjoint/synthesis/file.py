"""A synthesis in a TOML file: which robot, what may be chosen, what is wanted.

robot = "omega3"
designs = 200
seed = 1

[[vary]]
name = "rods"
stretch = ["rod1a", "rod1b", "rod2a", "rod2b", "rod3a", "rod3b"]
along = "z"
range = [0.8, 1.3]

[[want]]
quantity = "workspace"
goal = "most"
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line
from cutjoint.robots import load, named_trajectory
from cutjoint.settings import Settings, read_settings
from cutjoint.synthesis.judging import DesignProblem
from cutjoint.synthesis.quantities import QUANTITIES
from cutjoint.synthesis.variables import Kind, Variable
from cutjoint.synthesis.wants import Want

MOST_DESIGNS = 100_000


@dataclass(frozen=True)
class SynthesisOrder:
    """What a file asks for.

    Attributes:
        problem: what may be chosen and what is wanted.
        designs: how many designs are judged.
        seed: of the search.
    """

    problem: DesignProblem
    designs: int
    seed: int

    __repr__ = line("problem", "designs", "seed")


def read_order(path: str | os.PathLike[str]) -> SynthesisOrder:
    """A synthesis as a file asks for it, with all in it looked at.

    Raises:
        FileError: it cannot be read.
        InputError: no TOML, a wrong value, or a key that is not known.
        UnknownNameError: no such robot, link, path, quantity or trajectory.
        CutjointError: the robot cannot be loaded.
    """
    file = read_settings(path)
    name = file.text("robot")
    variant, home = file.text("variant", None), file.text("home", None)
    designs, seed = file.whole("designs", 200, least=2), file.whole("seed", 1)
    variables = tuple(map(_variable, file.tables("vary")))
    wants = tuple(map(_want, file.tables("want")))
    file.finish()
    if designs > MOST_DESIGNS:
        raise InputError(f"{file.where}: designs must be at most {MOST_DESIGNS}, found {designs}")
    robot = load(name, variant, home=home)
    return SynthesisOrder(problem_of(robot, variables, wants, home), designs, seed)


def problem_of(
    robot: ClosedChain, variables: Sequence[Variable], wants: Sequence[Want], home: str | None = None
) -> DesignProblem:
    """Variables and wants of a robot, looked at before a search begins.

    Raises:
        UnknownNameError: the robot has not what may be chosen, or there is no such trajectory.
        InputError: nothing to choose or to want, one of them twice, an empty range.
    """
    if not variables:
        raise InputError("there is nothing to choose: name what may vary, in [[vary]]")
    if not wants:
        raise InputError("nothing is wanted: name a quantity, in [[want]]")
    for names, what in (([one.name for one in variables], "variable"), ([one.name for one in wants], "want")):
        if len(set(names)) < len(names):
            raise InputError(f"a {what} is there twice: {next(one for one in names if names.count(one) > 1)}")
    for one in variables:
        one.check(robot.description)
        one.now(robot.description)
    specs = {str(one.options["trajectory"]) for one in wants if "trajectory" in one.options}
    return DesignProblem(
        robot.description,
        tuple(variables),
        tuple(wants),
        {spec: named_trajectory(spec, robot) for spec in sorted(specs)},
        home,
    )


def _variable(table: Settings) -> Variable:
    kinds: Mapping[str, Kind] = {"path": "path", "stretch": "stretch", "mount": "mount"}
    given = [kind for key, kind in kinds.items() if key in table]
    if len(given) != 1:
        raise InputError(f"{table.where}: name one of path, stretch (links) and mount (roll or pitch)")
    kind = given[0]
    if kind == "path":
        what = tuple(part.strip() for text in table.texts("path") for part in text.split("="))
    else:
        what = table.texts(kind)
    low, high = table.numbers("range", size=2)
    along = table.text("along", choices=("x", "y", "z")) if kind == "stretch" else "x"
    name = table.text("name", what[0] if kind != "stretch" else f"length of {what[0]}")
    return Variable(name, kind, what, low, high, along)


def _want(table: Settings) -> Want:
    quantity = table.text("quantity")
    if quantity not in QUANTITIES:
        raise UnknownNameError("quantity", quantity, tuple(QUANTITIES))
    options: dict[str, float | str] = {}
    for key, (_, default) in QUANTITIES[quantity].options.items():
        if key not in table:
            table.text(key, None)
            continue
        options[key] = table.text(key) if isinstance(default, str) else table.number(key, above=0.0)
    goal = table.text("goal", None, choices=("most", "least"))
    least, most = table.number("at_least", None), table.number("at_most", None)
    if goal is None and least is None and most is None:
        goal = QUANTITIES[quantity].goal
    return Want(quantity, options, "most" if goal == "most" else "least" if goal == "least" else None, least, most)
