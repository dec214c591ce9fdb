"""Where a robot may be cut: its file read, pairs of frames found, types told, closed, and what comes out of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import chain_problems, usual_mobility
from cutjoint.description.check import check_description
from cutjoint.description.model import Frame, Joint, RobotDescription
from cutjoint.drafting.cutting.closing import beside, closed, home_of, motors_of, with_cuts
from cutjoint.drafting.cutting.kinds import TypeChoice, choices_of, loose_cut, sliding_cut, with_cut
from cutjoint.drafting.cutting.pairs import BY_NAME, BY_PLACE, Pair, between, pairs_of
from cutjoint.drafting.cutting.proposal import Proposal, Proposed
from cutjoint.drafting.cutting.respan import instead_of, respan
from cutjoint.drafting.cutting.source import read_source, sentence
from cutjoint.drafting.cutting.tree import Tree
from cutjoint.errors import InputError, Problem, UnknownNameError

Found = tuple[Pair, Sequence[TypeChoice]]


def propose(
    source: str | os.PathLike[str],
    cut: Sequence[str] = (),
    types: Mapping[str, str] | None = None,
    lenient: bool = False,
) -> Proposal:
    """Where to cut the robot of a file, and what comes out of it.

    Args:
        source: any file or folder that can be read, or the name of a robot.
        cut: joints that shall be cut; others of their loops go into the tree instead.
        types: cut at a pair of frames -> the type that it shall have.
        lenient: as in `load_description`.

    Raises:
        DescriptionError: the file cannot be read.
        UnknownNameError, InputError: a joint of `cut` cannot be cut, a cut cannot have the type that is asked for, or
            frames whose names belong together do not close.
        ClosureError: the loops cannot be closed.
    """
    file = read_source(source, lenient)
    robot, told, given = file.robot, [*file.told], {one.name for one in file.robot.cuts}
    tree = Tree(robot)
    pairs, alone = pairs_of(tree)
    robot, found, locked = _with_pairs(robot, pairs, types or {})
    told += [*alone, *locked]
    if not robot.closing:
        return Proposal(None, (), None, tuple(told), _ends(tree), False)
    chain = _closed(robot)
    chose = not robot.actuators
    if chose:
        robot = replace(robot, homes=(home_of(chain), *chain.description.homes[1:]))
        chain = _closed(replace(robot, actuators=motors_of(chain, file.preferred)))
    robot, more = _with_tool(chain.description)
    if cut:
        before = {one.name for one in robot.cuts}
        robot, lost = _recut(robot, cut, file.originals)
        back = before - {one.name for one in robot.cuts}
        told = [one for one in told if not any(f"'{name}'" in one and name in file.originals for name in back)]
        told += [sentence(one) for one in lost]
        given |= {one.name for one in robot.cuts} - {pair.name for pair, _ in found}
    if chose or not robot.homes:
        chain = _closed(robot)
        robot = replace(robot, homes=(home_of(chain), *robot.homes[1:]))
    wrong = [sentence(one) for one in check_description(robot) if one.severity == "error" and not one.tolerable]
    if wrong:
        raise InputError(f"cut so, {robot.name} is no robot that can be computed with: {'; '.join(wrong)}")
    chain = chain if robot is chain.description else _closed(robot)
    report = chain.mobility()
    problems = chain_problems(chain, report)
    told += [*more, *_limits_lost(robot, file.originals), *map(sentence, problems)]
    cuts = _proposed(robot, given, found)
    return Proposal(robot, cuts, report, tuple(dict.fromkeys(told)), _ends(tree), chose)


def _with_pairs(
    robot: RobotDescription, pairs: Sequence[Pair], types: Mapping[str, str]
) -> tuple[RobotDescription, list[Found], list[str]]:
    """The robot closed at the pairs of frames too, what was tried for each, and pairs that are left out."""
    told = []
    kept: list[Pair] = []
    for pair in pairs:
        ways = (loose_cut(pair), sliding_cut(pair)) if pair.why == BY_NAME else (loose_cut(pair),)
        before = closed(robot) if pair.why == BY_PLACE else None
        most = usual_mobility(before) if before is not None else np.inf
        chains = ((way, closed(with_cuts(robot, [*robot.cuts, way]))) for way in ways)
        mobile = ((way, usual_mobility(chain)) for way, chain in chains if chain is not None)
        moves = next(((way, mobility) for way, mobility in mobile if mobility > 0), None)
        if moves is not None and moves[1] < most:
            kept.append(pair)
            robot = with_cuts(robot, [*robot.cuts, moves[0]])
        elif pair.why == BY_NAME:
            raise InputError(
                f"frames '{pair.a}' and '{pair.b}' are named like ends of a loop, but held together at a point, or "
                "along their z axes, they do not close it or nothing moves any more; if they are no loop, rename them"
            )
        else:
            told.append(
                f"frames '{pair.a}' and '{pair.b}' are in one place at zero, but a cut there "
                f"{'would lock the robot' if moves is None else 'holds nothing that is not held already'}: not proposed"
            )
    for name in types:
        if name not in [pair.name for pair in kept]:
            raise UnknownNameError("cut at a pair of frames", name, [pair.name for pair in kept])
    robot, singular = _off_singular(robot)
    told += singular
    found: list[Found] = []
    for pair in kept:
        chain = _closed(robot)
        cuts, choices = choices_of(chain, pair)
        wanted = _wanted(pair.name, choices, types)
        robot = with_cut(replace(chain.description, homes=(home_of(chain), *chain.description.homes[1:])), cuts[wanted])
        found.append((pair, [choices[wanted], *choices[:wanted], *choices[wanted + 1 :]]))
    return robot, found, told


def _off_singular(robot: RobotDescription) -> tuple[RobotDescription, list[str]]:
    """The robot with a home beside zero where that is singular and the file says no home, and what is told of it."""
    chain = closed(robot) if robot.closing and not robot.homes else None
    home = None if chain is None else beside(chain)
    if chain is None or home is None:
        return robot, []
    told = (
        f"the loops are singular at zero: they allow {chain.mobility().mobility} independent motions there, "
        f"{usual_mobility(chain)} around it; home is a posture beside it, on one of the branches that meet there"
    )
    return replace(robot, homes=(home,)), [told]


def _wanted(name: str, choices: Sequence[TypeChoice], types: Mapping[str, str]) -> int:
    """The number of the choice that is asked for, else the first."""
    if name not in types:
        return 0
    possible = [one.type for one in choices if one.closes]
    if types[name] not in possible:
        raise InputError(f"cut '{name}' cannot be '{types[name]}': with these frames it may be {', '.join(possible)}")
    return [one.type for one in choices].index(types[name])


def _recut(
    robot: RobotDescription, names: Sequence[str], originals: Mapping[str, Joint]
) -> tuple[RobotDescription, Sequence[Problem]]:
    """The robot on another tree, with all of its homes."""
    chain = _closed(robot)
    chains = {one.name: ClosedChain(robot, one.name) for one in robot.homes} or {"default": chain}
    homes = tuple(home_of(one, name) for name, one in chains.items())
    places = {name: one.link_placements(one.home) for name, one in chains.items()}
    return respan(replace(robot, homes=homes), names, places, originals)


def _closed(robot: RobotDescription) -> ClosedChain:
    """The chain, closed somewhere; where that fails, the error says how far it came from the robot's own home."""
    return closed(robot) or ClosedChain(robot)


def _with_tool(robot: RobotDescription) -> tuple[RobotDescription, list[str]]:
    """With the only frame that is no end of a cut as tool, where the file names none."""
    if robot.tool is not None:
        return robot, []
    tree = Tree(robot)
    ends = {one for cut in robot.cuts for one in (cut.a.link, cut.b.link)}
    free = [one for one in tree.links if one not in ends and tree.is_frame(one) and tree.body(one) != robot.root]
    if len(free) == 1:
        return replace(robot, tool=Frame(free[0])), [f"the only frame left, '{free[0]}', is taken as the tool"]
    some = f", such as {', '.join(free[:5])}" if free else ""
    return robot, [f"the file names no tool: say a frame{some} under [tool] of the loops.toml"]


def _limits_lost(robot: RobotDescription, originals: Mapping[str, Joint]) -> list[str]:
    """Cuts that were joints with limits, where another joint of the loop has none to lose."""
    told, instead = [], instead_of(robot)
    for cut in robot.closing:
        was, others = originals.get(cut.name), instead.get(cut.name, ())
        if was is None or not was.limits.bounded or not others:
            continue
        if not robot.joint(others[0]).limits.bounded:
            told.append(f"'{cut.name}' has limits, which a cut cannot have: --cut {others[0]} keeps them")
    return told


def _ends(tree: Tree) -> tuple[str, ...]:
    """The last link of each body that carries no other: frames come after what they are fixed to."""
    return tuple({tree.body(one): one for one in tree.ends}.values())


def _proposed(robot: RobotDescription, given: set[str], found: Sequence[Found]) -> tuple[Proposed, ...]:
    tree, instead = Tree(robot), instead_of(robot)
    tried: Mapping[str, Found] = {pair.name: (pair, choices) for pair, choices in found}
    rows = []
    for cut in robot.closing:
        ends = tree.at_zero[cut.a.link] @ cut.a.placement, tree.at_zero[cut.b.link] @ cut.b.placement
        why = "the file" if cut.name in given else tried[cut.name][0].why
        choices = () if cut.name in given else tuple(tried[cut.name][1])
        frames = (cut.a.link, cut.b.link)
        rows.append(
            Proposed(cut.name, cut.type.value, frames, why, *between(*ends), choices, instead.get(cut.name, ()))
        )
    return tuple(rows)
