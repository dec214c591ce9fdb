"""The `<coupling>` of URDF+: ratio times the sum of the joints on the predecessor's side is the sum of those on the
successor's, both from the nearest common ancestor of the two links on (as in explicitRollingConstraint of
https://github.com/ROAM-Lab-ND/generalized_rbda, the paper's own implementation).

One joint of each follows the others: the one that is marked `independent="false"` and follows no other coupling, the
successor's side first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.model import Coupling, Joint, Place
from cutjoint.description.numbers import read_numbers
from cutjoint.description.xml import Element, check_known, name_of, only_child
from cutjoint.findings import Findings, listing

_NONE: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Sum:
    """A coupling before it is known which joint follows: the sum of factor x coordinate is 0."""

    name: str
    factors: dict[str, float]
    successors: tuple[str, ...]
    place: Place


def read_end(element: Element, tag: str, name: str, findings: Findings) -> tuple[str | None, Element | None]:
    """The link that the `<predecessor>` or `<successor>` of `element` names, and the element itself."""
    end = only_child(element, tag, findings)
    link = str(end.get("link") or "").strip() if end is not None else ""
    if not link:
        line = element.sourceline if end is None else end.sourceline
        findings.error(f"<{element.tag}> '{name}' without {tag} link", f'<{tag} link="...">', "", line)
        return None, end
    check_known(end, frozenset({"link"}), frozenset({"origin"}), _NONE, findings)
    return link, end


def read_sum(element: Element, tree: OpenTree, findings: Findings) -> Sum | None:
    """A `<coupling>`, or None after noting what is wrong with it."""
    check_known(element, frozenset({"name", "type"}), frozenset({"predecessor", "successor", "ratio"}), _NONE, findings)
    name = name_of(element, findings)
    before, _ = read_end(element, "predecessor", name or "?", findings)
    after, _ = read_end(element, "successor", name or "?", findings)
    ratio_element = only_child(element, "ratio", findings)
    ratio: tuple[float, ...] | None = (1.0,)
    if ratio_element is not None:
        check_known(ratio_element, frozenset({"value"}), _NONE, _NONE, findings)
        what = f"ratio of <{element.tag}> '{name}'"
        ratio = read_numbers(ratio_element.get("value"), 1, what, findings, ratio_element.sourceline)
    if name is None or before is None or after is None or ratio is None:
        return None
    line = element.sourceline
    first, second = _sides(tree, before, after)
    if not first or not second:
        ties = [listing(joint.name for joint in side) for side in (first, second)]
        found = f"<{element.tag}> '{name}' ties {ties[0]} to {ties[1]}"
        findings.error(found, "moving joints on both sides of the nearest common ancestor", "", line)
        return None
    if ratio[0] == 0.0:
        findings.error(f"ratio of <{element.tag}> '{name}' is 0", "a number other than 0", "", line)
        return None
    factors = {joint.name: ratio[0] for joint in first} | {joint.name: -1.0 for joint in second}
    return Sum(name, factors, tuple(joint.name for joint in second), Place(findings.file, line))


def solved(sums: Sequence[Sum], dependent: set[str], tree: OpenTree, findings: Findings) -> list[Coupling]:
    """The couplings, each with a joint of its own that follows."""
    taken = {coupling.joint for coupling in tree.couplings}
    followers: dict[str, int] = {}
    choices = [_choices(one, dependent, taken) for one in sums]
    for index in range(len(sums)):
        if not _assigned(index, choices, followers, set()):
            names = listing(sums[index].factors)
            found = f"<coupling> '{sums[index].name}' ties {names}, which other couplings drive already"
            findings.error(found, 'a joint that follows it: independent="false"', "", sums[index].place)
    couplings = []
    for joint, index in sorted(followers.items(), key=lambda item: item[1]):
        one = sums[index]
        own = one.factors[joint]
        ratios = {name: -factor / own for name, factor in one.factors.items() if name != joint}
        couplings.append(Coupling.summed(one.name, joint, ratios, 0.0, one.place))
    return couplings


def _choices(one: Sum, dependent: set[str], taken: set[str]) -> list[str]:
    """The joints that may follow, best first: those that are dependent, of the successor's side, near its link."""
    order = [*one.successors, *(name for name in one.factors if name not in one.successors)]
    marked = [name for name in order if name in dependent]
    free = [*marked, *(name for name in order if name not in dependent)]
    return [name for name in free if name not in taken]


def _assigned(index: int, choices: Sequence[Sequence[str]], followers: dict[str, int], tried: set[str]) -> bool:
    """Give coupling `index` a joint of its own; others make way where they can."""
    for name in choices[index]:
        if name in tried:
            continue
        tried.add(name)
        if name not in followers or _assigned(followers[name], choices, followers, tried):
            followers[name] = index
            return True
    return False


def _sides(tree: OpenTree, before: str, after: str) -> tuple[list[Joint], list[Joint]]:
    """The moving joints from the nearest common ancestor down to each of two links."""
    above = {joint.child: joint for joint in tree.joints}

    def way(link: str) -> list[Joint]:
        joints: list[Joint] = []
        while link in above and len(joints) <= len(tree.joints):
            joints.append(above[link])
            link = above[link].parent
        return joints

    first, second = way(before), way(after)
    shared = {joint.name for joint in first} & {joint.name for joint in second}
    first = [joint for joint in first if joint.name not in shared and joint.type.moves]
    second = [joint for joint in second if joint.name not in shared and joint.type.moves]
    return first, second
