"""Where a robot may be cut: its file read, pairs of frames found, types told, closed, and what comes out of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import kinematic_problems
from cutjoint.chain.mobility import MobilityReport
from cutjoint.description import catalogue, read_checked
from cutjoint.description.findings import Findings
from cutjoint.description.formats import format_of
from cutjoint.description.formats.urdf.plain import read_robot
from cutjoint.description.formats.urdf.transmission import driven
from cutjoint.description.model import CutJoint, CutType, RobotDescription
from cutjoint.drafting.cutting.closing import closed, home_of, motors_of, with_cuts
from cutjoint.drafting.cutting.kinds import Choice, choices_of, loose_cut, with_cut
from cutjoint.drafting.cutting.pairs import Pair, between, pairs_of
from cutjoint.drafting.cutting.respan import instead_of, respan
from cutjoint.drafting.cutting.tree import Tree
from cutjoint.errors import ClosureError, DescriptionError, InputError, Problem

Found = tuple[Pair, Sequence[CutJoint], Sequence[Choice]]


@dataclass(frozen=True)
class Proposed:
    """A cut that is proposed.

    Attributes:
        name, type: of the cut.
        frames: the links that its frames are on.
        why: the file's own cut, the names of its frames, or their place at zero.
        distance, angle: between the frames at zero [m], [rad].
        choices: types that it may have instead, itself first; empty where the file says the type.
        instead: joints of its loop that may be cut instead, the best first.
    """

    name: str
    type: str
    frames: tuple[str, str]
    why: str
    distance: float
    angle: float
    choices: tuple[Choice, ...]
    instead: tuple[str, ...]


@dataclass(frozen=True)
class Proposal:
    """What comes of a file.

    Attributes:
        robot: closed as proposed, with actuators and home; None where nothing is there to close.
        cuts: what is proposed.
        report: mobility of the robot at home; None with the robot.
        told: what was found and not used, or could not be told, a sentence each.
        ends: a link of each body that carries no other: where a loop may be open.
        chose_motors: whether the actuators are chosen here, since the file does not say them.
    """

    robot: RobotDescription | None
    cuts: tuple[Proposed, ...]
    report: MobilityReport | None
    told: tuple[str, ...]
    ends: tuple[str, ...]
    chose_motors: bool


def propose(source: str | os.PathLike[str], cut: Sequence[str] = (), lenient: bool = False) -> Proposal:
    """Where to cut the robot of a file, and what comes out of it.

    Args:
        source: any file or folder that can be read, or the name of a robot.
        cut: joints that shall be cut; others of their loops go into the tree instead.
        lenient: as in `load_description`.

    Raises:
        DescriptionError: the file cannot be read.
        UnknownNameError, InputError: a joint of `cut` cannot be cut.
        ClosureError: the loops cannot be closed.
    """
    path = catalogue.resolve(source)
    reading = read_checked(source, lenient)
    if reading.description is None:
        raise DescriptionError(reading.problems)
    robot, told = reading.description, [_sentence(one) for one in reading.problems]
    robot = _untyped(robot, path)
    tree = Tree(robot)
    pairs, alone = pairs_of(tree)
    told += alone
    if not (robot.closing or pairs):
        return Proposal(None, (), None, tuple(told), _ends(tree), False)
    if cut:
        robot, lost = _recut(robot, cut)
        told += [_sentence(one) for one in lost]
    declared = _declared(path) if not robot.cuts else robot.actuators
    given = robot.cuts
    robot, found, locked = _with_pairs(replace(robot, actuators=() if not given else robot.actuators), pairs)
    told += locked
    if not robot.closing:
        return Proposal(None, (), None, tuple(told), _ends(tree), False)
    chain = _closed(robot)
    chose = not robot.actuators or not chain.mobility().determined and not given
    if chose:
        robot = replace(chain.description, actuators=motors_of(chain, declared))
        chain = _closed(replace(robot, homes=(home_of(chain),)))
        chain = _closed(replace(robot, homes=(home_of(chain),)))
    elif not robot.homes:
        chain = _closed(replace(chain.description, homes=(home_of(chain),)))
    problems, _ = kinematic_problems(chain.description)
    told += [_sentence(one) for one in problems]
    cuts = _proposed(chain.description, {one.name for one in given}, found)
    return Proposal(chain.description, cuts, chain.mobility(), tuple(dict.fromkeys(told)), _ends(tree), chose)


def _recut(robot: RobotDescription, names: Sequence[str]) -> tuple[RobotDescription, Sequence[Problem]]:
    """The robot on another tree, with all of its homes."""
    chain = _closed(robot)
    chains = {one.name: ClosedChain(robot, one.name) for one in robot.homes} or {"default": chain}
    homes = tuple(home_of(one, name) for name, one in chains.items())
    places = {name: one.link_placements(one.home) for name, one in chains.items()}
    return respan(replace(robot, homes=homes), names, places)


def _ends(tree: Tree) -> tuple[str, ...]:
    """The last link of each body that carries no other: frames come after what they are fixed to."""
    return tuple({tree.body(one): one for one in tree.ends}.values())


def _sentence(problem: Problem) -> str:
    """A problem in one sentence, with how to mend it."""
    return f"{problem.found} ({problem.mend})" if problem.mend else problem.found


def _untyped(robot: RobotDescription, path: Path) -> RobotDescription:
    """Without the cuts between closing frames whose type a URDF does not say, which are held at a point: they are pairs
    of frames like others."""
    if not _is_urdf(path):
        return robot
    return with_cuts(
        robot,
        [
            one
            for one in robot.cuts
            if one.type is not CutType.SPHERICAL or (one.a.link, one.b.link) != (f"{one.name}_1", f"{one.name}_2")
        ],
    )


def _is_urdf(path: Path) -> bool:
    return not path.is_dir() and format_of(path).name == "URDF"


def _declared(path: Path) -> tuple[str, ...]:
    """The joints that the transmissions of a URDF drive."""
    if not _is_urdf(path):
        return ()
    root = read_robot(path, Findings(str(path)))
    return () if root is None else driven(root)


def _closed(robot: RobotDescription) -> ClosedChain:
    chain = closed(robot)
    if chain is None:
        ClosedChain(robot)  # says where it fails
        raise ClosureError(f"the loops of {robot.name} were not closed; give a home posture in a loops.toml")
    return chain


def _with_pairs(robot: RobotDescription, pairs: Sequence[Pair]) -> tuple[RobotDescription, list[Found], list[str]]:
    """The robot closed at the pairs of frames too, what was tried for each, and pairs that are left out."""
    told = []
    kept: list[Pair] = []
    for pair in pairs:
        chain = closed(with_cuts(robot, [*robot.cuts, *map(loose_cut, kept), loose_cut(pair)]))
        if chain is not None and chain.mobility().mobility > 0:
            kept.append(pair)
        elif pair.why == "names":
            what = "the loops do not close" if chain is None else "nothing moves any more"
            raise InputError(f"with frames '{pair.a}' and '{pair.b}' held together at a point {what}; if they are no "
                             "loop, rename them")  # fmt: skip
        else:
            what = "do not close with it" if chain is None else "lock the robot"
            told.append(f"frames '{pair.a}' and '{pair.b}' are in one place at zero, but they {what}: not proposed")
    robot = with_cuts(robot, [*robot.cuts, *map(loose_cut, kept)])
    found: list[Found] = []
    for pair in kept:
        chain = _closed(robot)
        cuts, choices = choices_of(chain, pair)
        robot = with_cut(replace(chain.description, homes=(home_of(chain),)), cuts[0])
        found.append((pair, cuts, choices))
    return robot, found, told


def _proposed(robot: RobotDescription, given: set[str], found: Sequence[Found]) -> tuple[Proposed, ...]:
    tree, instead = Tree(robot), instead_of(robot)
    tried: Mapping[str, Found] = {pair.name: (pair, cuts, choices) for pair, cuts, choices in found}
    rows = []
    for cut in robot.closing:
        ends = tree.at_zero[cut.a.link] @ cut.a.placement, tree.at_zero[cut.b.link] @ cut.b.placement
        why = "the file" if cut.name in given else tried[cut.name][0].why
        choices = () if cut.name in given else tuple(tried[cut.name][2])
        frames = (cut.a.link, cut.b.link)
        rows.append(
            Proposed(cut.name, cut.type.value, frames, why, *between(*ends), choices, instead.get(cut.name, ()))
        )
    return tuple(rows)
