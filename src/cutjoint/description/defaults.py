"""What is actuated and where the tool is, for files that do not say."""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.description.model import Coupling, Frame, Joint, Link


def actuated_by_default(joints: Sequence[Joint], couplings: Sequence[Coupling] = ()) -> tuple[str, ...]:
    """All joints with one coordinate that no coupling drives, in the order of the file."""
    driven = {coupling.joint for coupling in couplings}
    return tuple(joint.name for joint in joints if joint.type.single and joint.name not in driven)


def tool_by_default(links: Sequence[Link], joints: Sequence[Joint]) -> Frame | None:
    """The last link of the file that carries no other and is moved, where all of those are on one moving body.

    A robot with several hands has no tool until its description names one.
    """
    above = {joint.child: joint for joint in joints}
    parents = {joint.parent for joint in joints}
    bodies: dict[str, str] = {}
    for link in links:
        if link.name not in parents:
            body = _moving_body(link.name, above)
            if body is not None:
                bodies[link.name] = body
    return Frame(list(bodies)[-1]) if len(set(bodies.values())) == 1 else None


def _moving_body(link: str, above: dict[str, Joint]) -> str | None:
    """The link at whose root `link` is fixed and which a joint moves, or None where it cannot move."""
    seen: set[str] = set()
    while link in above and link not in seen:
        seen.add(link)
        if above[link].type.moves:
            return link
        link = above[link].parent
    return None
