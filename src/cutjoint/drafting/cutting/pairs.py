"""Pairs of frames at which a tree is meant to be closed: by their names, and by lying in one place at zero.

Names as exporters and people use them: `closing_knee_1` and `closing_knee_2` (onshape-to-robot), `knee_closed_1` and
`knee_closed_2`, `loop_a` and `loop_b`: alike but for their end, with a word that speaks of closing in them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.drafting.cutting.tree import Tree

SAME_PLACE = 1e-5
"""Distance of two frames in one place, in sizes of the robot: exporters round to six digits."""
SAME_DIRECTION = 1e-4
"""Angle between axes that are the same [rad]."""
_WORDS = re.compile(r"clos|loop|cut|constraint|weld|connect", re.IGNORECASE)
_ENDS = re.compile(r"(?P<stem>.*[^A-Za-z0-9])(?P<end>1|2|a|b|A|B|parent|child)(?P<tail>_frame|_link)?")
_COUPLES = ({"1", "2"}, {"a", "b"}, {"A", "B"}, {"parent", "child"})


BY_NAME, BY_PLACE = "names", "in one place at zero"
"""What tells that two frames belong together."""


@dataclass(frozen=True)
class Pair:
    """Two frames that a cut would join.

    Attributes:
        name: of the cut.
        a, b: the links that are the frames.
        why: what tells that they belong together.
        distance, angle: between them at zero [m], [rad].
    """

    name: str
    a: str
    b: str
    why: str
    distance: float
    angle: float


def pairs_of(tree: Tree) -> tuple[list[Pair], list[str]]:
    """The pairs of frames of a tree that no cut joins yet, and sentences about frames that stay alone."""
    frames = [one for one in tree.links if tree.is_frame(one)]
    joined = {frozenset((tree.body(cut.a.link), tree.body(cut.b.link))) for cut in tree.robot.cuts}
    taken = {one for cut in tree.robot.cuts for one in (cut.a.link, cut.b.link)}
    by_name, told = _by_name(tree, [one for one in frames if one not in taken])
    found = [*by_name]
    taken |= {one for pair in found for one in (pair.a, pair.b)}
    joined |= {frozenset((tree.body(pair.a), tree.body(pair.b))) for pair in found}
    places: list[Array] = []
    for pair in _in_one_place(tree, taken):
        bodies, place = frozenset((tree.body(pair.a), tree.body(pair.b))), tree.at_zero[pair.a][:3, 3]
        near = any(np.linalg.norm(place - one) <= SAME_PLACE * tree.size for one in places)
        if bodies not in joined or not near:
            joined.add(bodies)
            places.append(place)
            found.append(pair)
    return found, told


def apart(tree: Tree, a: str, b: str) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two frames at zero."""
    return between(tree.at_zero[a], tree.at_zero[b])


def between(a: Array, b: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two placements (4, 4)."""
    rotation = a[:3, :3].T @ b[:3, :3]
    skew = rotation - rotation.T
    sine = 0.5 * float(np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]]))
    return float(np.linalg.norm(a[:3, 3] - b[:3, 3])), float(np.arctan2(sine, 0.5 * (np.trace(rotation) - 1.0)))


def _pair(tree: Tree, name: str, a: str, b: str, why: str) -> Pair:
    return Pair(name, a, b, why, *apart(tree, a, b))


def _by_name(tree: Tree, frames: list[str]) -> tuple[list[Pair], list[str]]:
    groups: dict[tuple[str, str], dict[str, str]] = {}
    for frame in frames:
        match = _ENDS.fullmatch(frame)
        if match is not None and _WORDS.search(match["stem"]):
            groups.setdefault((match["stem"], match["tail"] or ""), {})[match["end"]] = frame
    pairs, told = [], []
    for (stem, _), ends in groups.items():
        name = re.sub(r"^closing_|[^A-Za-z0-9]+$", "", stem) or stem
        for couple in _COUPLES:
            here = [ends[one] for one in sorted(couple & set(ends), reverse="parent" in couple)]
            if len(here) == 2 and tree.body(here[0]) != tree.body(here[1]):
                pairs.append(_pair(tree, name, here[0], here[1], BY_NAME))
            elif len(here) == 2:
                told.append(f"frames '{here[0]}' and '{here[1]}' are on one body, so nothing is closed between them")
            elif len(here) == 1:
                told.append(f"frame '{here[0]}' is named like an end of a loop, and the other end is not there")
    return pairs, told


def _in_one_place(tree: Tree, taken: set[str]) -> Iterator[Pair]:
    """Links of the base and of bodies that carry no other, in one place at zero, at least one of them a mere frame."""
    links = [one for one in (*tree.ends, *tree.on_base) if one not in taken]
    ends = sorted(links, key=lambda one: not tree.is_frame(one))
    for a, b in combinations(ends, 2):
        if not tree.is_frame(a) or tree.body(a) == tree.body(b) or len(tree.between(a, b)) < 2:
            continue
        if np.linalg.norm(tree.at_zero[a][:3, 3] - tree.at_zero[b][:3, 3]) <= SAME_PLACE * tree.size:
            yield _pair(tree, f"{a}_to_{b}", a, b, BY_PLACE)
