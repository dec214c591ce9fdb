"""What readers gather of a robot besides its cuts, what is taken where a file does not say what is actuated or where
the tool is, and all of it together as one description."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.physics import with_rest
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    Frame,
    Home,
    Joint,
    JointType,
    Limits,
    Link,
    Place,
    RobotDescription,
    TaskAxes,
    Variant,
)
from cutjoint.errors import Problem
from cutjoint.findings import Findings, nearest
from cutjoint.reprs import line


class RobotFindings(Findings):
    """What is wrong with a robot's files, and `closing`: joints of a graph that became cuts, by name, with the
    limits and physics that no cut has."""

    def __init__(self, file: str = "") -> None:
        super().__init__(file)
        self.closing: dict[str, Joint] = {}


@dataclass(frozen=True)
class Reading:
    """What was read, as far as it could be read, and everything that is wrong with the text of the files.

    Attributes:
        description: None where nothing useful was left.  It is not checked yet; `cutjoint.description.check` does that.
        problems: errors and warnings of the syntax, the numbers and the names of elements and keys.
        closing: joints of the file that a reader turned into cuts, by name, with the limits that no cut has.
    """

    description: RobotDescription | None
    problems: tuple[Problem, ...] = ()
    closing: Mapping[str, Joint] = field(default_factory=dict)

    __repr__ = line("description", "problems")


@dataclass(frozen=True, eq=False)
class ToldCut:
    """A cut that the tree's own file tells, unless another cut joins the same links.

    `odd` is what is warned of where it is taken: what was found, what was expected, how to mend it.
    """

    cut: CutJoint
    odd: tuple[str, str, str] | None = None


@dataclass
class OpenTree:
    """Links and joints as a reader gathers them, and the actuators where the tree's own file names some.

    `cuts` are those of the tree's own file; `closings` too, but only between links that no other cut joins: what is
    odd about one is a warning (`ToldCut.odd`) only where it is taken.
    """

    name: str
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    actuators: tuple[str, ...] = ()
    cuts: list[CutJoint] = field(default_factory=list)
    closings: list[ToldCut] = field(default_factory=list)

    def closed_by(self, cuts: Sequence[CutJoint], findings: Findings) -> tuple[CutJoint, ...]:
        """All cuts of the robot: `cuts`, and those of the tree's own file."""
        known = [*cuts, *self.cuts]
        joined = [{cut.a.link, cut.b.link} for cut in known]
        taken = [one for one in self.closings if {one.cut.a.link, one.cut.b.link} not in joined]
        for one in taken:
            if one.odd is not None:
                findings.warn(*one.odd, at=one.cut.place)
        return (*known, *(one.cut for one in taken))


EARTH = readonly([0.0, 0.0, -9.81])
"""m/s2."""


@dataclass(frozen=True, eq=False)
class Change:
    """What [joint.NAME] changes of a joint, because the tree's format cannot say it; None leaves it.

    `physics` holds what it gives of that, by the names in `JointPhysics`.
    """

    name: str
    type: JointType | None
    axis: Array | None
    axis2: Array | None
    velocity: float | None
    effort: float | None
    physics: Mapping[str, float]
    place: Place

    def of(self, joint: Joint) -> Joint:
        """The changed joint.  Limits of one coordinate go where there is another number of coordinates."""
        kind = self.type or joint.type
        lower, upper = joint.limits.lower, joint.limits.upper
        if not kind.single:
            lower = upper = None
        velocity = joint.limits.velocity if self.velocity is None else self.velocity
        effort = joint.limits.effort if self.effort is None else self.effort
        axis = joint.axis if self.axis is None else self.axis
        axis2 = joint.axis2 if self.axis2 is None else self.axis2
        limits = Limits(lower, upper, velocity, effort)
        physics = replace(joint.physics, **self.physics)
        return replace(joint, type=kind, axis=axis, axis2=axis2, limits=limits, physics=physics)


@dataclass(frozen=True)
class Compensated:
    """What [link.NAME] says: the share of its weight that is compensated, and where that stands."""

    share: float
    place: Place

    def of(self, link: Link) -> Link:
        """The link with it."""
        return replace(link, gravity_compensation=self.share)


@dataclass(frozen=True, eq=False)
class Extras:
    """What was read, with None and () where the file is silent.  `fixed`: link -> name of the fixed joint above it."""

    actuators: tuple[str, ...] | None = None
    tool: Frame | None = None
    task: tuple[str, ...] = ()
    task_axes: TaskAxes = "world"
    gravity: Array = field(default_factory=lambda: EARTH)
    cuts: tuple[CutJoint, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    homes: tuple[Home, ...] = ()
    variants: tuple[Variant, ...] = ()
    joints: tuple[Change, ...] = ()
    links: Mapping[str, Compensated] = field(default_factory=dict)
    fixed: dict[str, str] = field(default_factory=dict)
    name: str = ""
    title: str = ""
    source: str = ""
    places: dict[str, Place] = field(default_factory=dict)


def described(
    tree: OpenTree, cuts: Sequence[CutJoint], extras: Extras | None, path: Path, findings: Findings
) -> RobotDescription:
    """Tree, cuts and the rest as one description; the cuts of the tree's own file are added.

    Where a file has no extras, a chain without cuts gets the defaults of a plain URDF, and a robot with cuts the
    actuators that the reader put into the tree, or none.
    """
    extras = extras or Extras()
    cuts = tree.closed_by(cuts, findings)
    _check_named("link", extras.links, {link.name for link in tree.links}, findings)
    joints = _changed(tree.joints, extras, findings)
    couplings = (*tree.couplings, *extras.couplings)
    actuators, tool = extras.actuators, extras.tool
    if actuators is None:
        actuators = tree.actuators if cuts else actuated_by_default(joints, couplings)
    if tool is None and not cuts:
        tool = tool_by_default(tree.links, joints)
    return RobotDescription(
        name=extras.name or tree.name,
        links=tuple(extras.links[one.name].of(one) if one.name in extras.links else one for one in tree.links),
        joints=tuple(joints),
        cuts=cuts,
        couplings=couplings,
        actuators=actuators,
        tool=tool,
        task=extras.task,
        task_axes=extras.task_axes,
        gravity=extras.gravity,
        homes=extras.homes,
        variants=extras.variants,
        title=extras.title,
        source=extras.source,
        path=path,
        places=extras.places,
    )


def _changed(joints: Sequence[Joint], extras: Extras, findings: Findings) -> list[Joint]:
    """The joints with what [joint.NAME] changes of them."""
    changes = {change.name: change for change in extras.joints}
    _check_named("joint", changes, {joint.name for joint in joints}, findings)
    changed = [changes[joint.name].of(joint) if joint.name in changes else joint for joint in joints]
    given = {name: change.physics for name, change in changes.items()}
    return [with_rest(joint, given.get(joint.name, ()), findings) for joint in changed]


def _check_named(
    kind: str, changes: Mapping[str, Change] | Mapping[str, Compensated], known: Collection[str], findings: Findings
) -> None:
    """Note tables [joint.NAME] or [link.NAME] of what the tree does not have."""
    for name, change in changes.items():
        if name not in known:
            found = f"[{kind}.{name}] is for a {kind} that the tree does not have"
            findings.error(found, f"a {kind} of the tree", nearest(name, known), change.place)


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
