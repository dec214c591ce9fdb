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
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.robots import load, named_trajectory
from cutjoint.synthesis.judging import DesignProblem
from cutjoint.synthesis.quantities import QUANTITIES
from cutjoint.synthesis.variables import Kind, Variable
from cutjoint.synthesis.wants import Want
from cutjoint.toml.reading import read_settings
from cutjoint.toml.table import TomlTable
from cutjoint.toml.taking import one_of, positive, texts, whole

MOST_DESIGNS = 100_000
LARGEST_SEED = 2**32 - 1


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
        SettingsError: no such file, no TOML, keys that are missing or unknown, values that are wrong: all of them, with
            their lines.
        UnknownNameError: no such robot, link, path or trajectory.
        CutjointError: the robot cannot be loaded.
    """
    asked = read_settings(path, _asked)
    robot = load(asked.robot, asked.variant, home=asked.home)
    return SynthesisOrder(problem_of(robot, asked.variables, asked.wants, asked.home), asked.designs, asked.seed)


class _Asked(NamedTuple):
    """What stands in the file."""

    robot: str
    variant: str | None
    home: str | None
    designs: int
    seed: int
    variables: tuple[Variable, ...]
    wants: tuple[Want, ...]


def _asked(top: TomlTable) -> _Asked:
    designs, seed = whole(top, "designs", 2, MOST_DESIGNS), whole(top, "seed", 0, LARGEST_SEED)
    variables = [_variable(table) for table in top.tables("vary")]
    wants = [_want(table) for table in top.tables("want")]
    found = _Asked(
        top.string("robot", required=True),
        top.string("variant") or None,
        top.string("home") or None,
        200 if designs is None else designs,
        1 if seed is None else seed,
        tuple(one for one in variables if one is not None),
        tuple(one for one in wants if one is not None),
    )
    top.finish()
    return found


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


def _variable(table: TomlTable) -> Variable | None:
    kinds: Mapping[str, Kind] = {"path": "path", "stretch": "stretch", "mount": "mount"}
    given = {key: texts(table, key) for key in kinds if table.take(key) is not None}
    along = one_of(table, "along", ("x", "y", "z"), "x") if "stretch" in given else "x"
    ends = table.vector("range", 2, required=True, largest=sys.float_info.max)
    name = table.string("name")
    table.finish()
    if len(given) != 1:
        found = " and ".join(given) or "nothing"
        expected = "one of path, stretch (links) and mount (roll or pitch)"
        table.findings.error(f"{found} to choose in {table.name}", expected, "", table.place())
        return None
    ((key, what),) = given.items()
    if key == "path":
        what = tuple(part.strip() for text in what for part in text.split("="))
    if not what or ends is None:
        return None
    default = f"length of {what[0]}" if key == "stretch" else what[0]
    return Variable(name or default, kinds[key], what, ends[0], ends[1], along)


def _want(table: TomlTable) -> Want | None:
    quantity = table.string("quantity", required=True)
    goal = one_of(table, "goal", ("", "most", "least"), "")
    least, most = (table.number(key, None, largest=sys.float_info.max) for key in ("at_least", "at_most"))
    row = QUANTITIES.get(quantity)
    if row is None:
        if quantity:
            found = f"unknown quantity '{quantity}' in {table.name}"
            table.findings.unknown(found, quantity, tuple(QUANTITIES), table.place("quantity"))
        return None
    options: dict[str, float | str] = {}
    for key, (_, default) in row.options.items():
        value = table.string(key) if isinstance(default, str) else positive(table, key)
        if value is not None and value != "":
            options[key] = value
    table.finish()
    if not goal and least is None and most is None:
        goal = row.goal
    try:
        return Want(quantity, options, "most" if goal == "most" else "least" if goal == "least" else None, least, most)
    except InputError as error:
        table.findings.error(str(error), at=table.place())
        return None
