"""A robot whose parts give way, as another description: what is elastic becomes slides and hinges of their own.

A bearing of a joint gives way behind the joint, along and about the axes of the child's frame, in the order x, y, z,
then about x, y, z; that of a cut on its frame b; a rod at its far end.  Between them stand links without mass.  So the
loops, the weights and all second derivatives of an elastic robot are those of an ordinary one.

The method of virtual joints: A. Pashkevich, D. Chablat, P. Wenger: Stiffness analysis of overconstrained parallel
manipulators.  Mechanism and Machine Theory 44 (2009) 966-982.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.cuts import CutType, Freedom
from cutjoint.description.model import CutJoint, Frame, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import frame_along, from_rotation, inverse
from cutjoint.errors import InputError
from cutjoint.stiffness.springs import DIRECTIONS, Beam, Springs, by_pattern

_SAME = 1e-9
"""Points nearer than this, in robot lengths, are one."""
_FREE_CUTS = {
    Freedom.SLIDE: ("z",),
    Freedom.TURN: ("rz",),
    Freedom.TURN_OF_A: (),
    Freedom.TURN_OF_B: ("ry",),
    Freedom.BALL: ("rx", "ry", "rz"),
}
"""What a cut leaves free along the axes of its frame b."""


@dataclass(frozen=True, eq=False)
class Give:
    """One part that gives way.

    Attributes:
        name: of the actuator, joint, cut or link.
        kind: `actuator`, `joint`, `cut` or `rod`.
        joints: the joints of the soft robot whose coordinates are its strains.
        matrix: their stiffness, shape (m, m), [N/m], [N], [N m/rad].
    """

    name: str
    kind: str
    joints: tuple[str, ...]
    matrix: Array


@dataclass(frozen=True, eq=False)
class SoftRobot:
    """A description with all that gives way as joints of its own, and these."""

    description: RobotDescription
    gives: tuple[Give, ...]


def soften(robot: RobotDescription, springs: Springs, length: float) -> SoftRobot:
    """The robot with its springs; `length` [m] is its characteristic one.

    Raises:
        UnknownNameError: springs name what the robot does not have.
        InputError: springs that do nothing, given twice, or of a link that is no rod.
    """
    softer = _Softer(robot)
    drives = by_pattern(springs.actuators, list(robot.actuators), f"actuator of {robot.name}")
    for name in robot.actuators:
        if name in drives:
            softer.gives.append(Give(name, "actuator", (name,), np.array([[drives[name]]])))
    closing = {cut.name: cut for cut in robot.closing}
    joints = {joint.name: joint for joint in robot.joints}
    known = {name: free_of_joint(one) for name, one in joints.items()}
    known |= {name: free_of_cut(one) for name, one in closing.items()}
    for name, stated in springs.of_joints(known, length, robot.name).items():
        if name in closing and name in joints:
            raise InputError(f"'{name}' names both a joint and a cut of {robot.name}")
        few = {which: stated[which] for which in DIRECTIONS if stated.get(which, np.inf) < np.inf}
        if not few and not any(np.isinf(one) for one in stated.values()):
            raise InputError(f"'{name}' of {robot.name} moves freely every way, so it has no stiffness")
        if few:
            ways = _ways(few)
            if name in robot.actuators and not known[name]:
                ways = _beside(joints[name], ways)
            softer.bearing(name, ways, joints.get(name), closing.get(name))
    distances = [cut.name for cut in robot.closing if cut.type is CutType.DISTANCE]
    every = [*(link.name for link in robot.links), *distances]
    for name, rod in by_pattern(springs.rods, every, f"link of {robot.name}").items():
        if name in distances:
            softer.distance(closing[name], rod)
        else:
            softer.rod(name, rod, _SAME * length)
    return SoftRobot(softer.robot, tuple(softer.gives))


@dataclass(frozen=True, eq=False)
class _Yield:
    """A slide or a turn: what it is called, along or about which axis (3,), and its stiffness [N/m] or [N m/rad]."""

    name: str
    axis: Array
    hard: float

    @property
    def turns(self) -> bool:
        return self.name.startswith("r")


def _ways(stated: Mapping[str, float]) -> list[_Yield]:
    return [_Yield(name, np.eye(3)["xyz".index(name[-1])], k) for name, k in stated.items()]


def _beside(joint: Joint, ways: list[_Yield]) -> list[_Yield]:
    """Ways without that along which an actuator drives a joint whose axis is none of its child's frame.

    Raises:
        InputError: they are not as hard all around, so that nobody can tell what is across the axis.
    """
    own = [way for way in ways if way.turns is joint.type.turns]
    if not own:
        return ways
    if len(own) < 3 or len({way.hard for way in own}) > 1:
        raise InputError(
            f"'{joint.name}' is driven along or about an axis that is none of x, y, z of its child's frame; state its "
            f"{'turning ' if joint.type.turns else ''}stiffness all around by one number, '{joint.name}'"
        )
    across = frame_along(joint.axis)
    beside = [_Yield(f"{own[0].name[:-1]}{k + 1}", across[:, k], own[0].hard) for k in (0, 1)]
    return [*(way for way in ways if not way.turns), *beside] if joint.type.turns else [*beside, *ways[3:]]


def free_of_joint(joint: Joint) -> tuple[str, ...]:
    """Directions of the child's frame that a joint leaves free."""
    kind = joint.type
    if kind is JointType.FLOATING:
        return DIRECTIONS
    if kind is JointType.SPHERICAL:
        return DIRECTIONS[3:]
    axis = joint.axis2 if kind is JointType.UNIVERSAL else joint.axis
    along = [i for i in range(3) if abs(abs(float(axis[i])) - 1.0) < 1e-12]
    if not along or not kind.moves:
        return ()
    if kind is JointType.PLANAR:
        return (*(DIRECTIONS[i] for i in range(3) if i not in along), DIRECTIONS[3 + along[0]])
    return (DIRECTIONS[along[0] + (0 if kind.slides else 3)],)


def free_of_cut(cut: CutJoint) -> tuple[str, ...]:
    """Directions of frame b that a cut leaves free; of a distance all, its stiffness is that of a rod."""
    if cut.type is CutType.DISTANCE:
        return DIRECTIONS
    return tuple(one for freedom in cut.type.freedoms for one in _FREE_CUTS[freedom])


class _Softer:
    """A description on its way to a softer one.

    Attributes:
        robot: as it is now.
        gives: what gives way so far.
    """

    def __init__(self, robot: RobotDescription) -> None:
        self.robot, self.gives = robot, list[Give]()

    def bearing(self, name: str, ways: list[_Yield], joint: Joint | None, cut: CutJoint | None) -> None:
        """Lets a joint or cut give way."""
        if joint is not None:
            first = self._unused(f"{name}~")
            changed = replace(self.robot.joint(name), child=first)
            joints = tuple(changed if one.name == name else one for one in self.robot.joints)
            self.robot = replace(self.robot, joints=joints)
            self._add_links([first])
            self._string(name, "joint", first, ways, np.diag([way.hard for way in ways]), joint.child)
        elif cut is not None:
            self._cut_end(cut, "cut", ways, np.diag([way.hard for way in ways]))

    def distance(self, cut: CutJoint, rod: float | Beam) -> None:
        """Lets a cut that is a rod give way: as hard in all directions at its end, of which it only pulls along one."""
        if isinstance(rod, Beam):
            raise InputError(f"'{cut.name}' is a rod that only pulls; give its stiffness along its axis [N/m]")
        self._cut_end(cut, "rod", _ways(dict.fromkeys(DIRECTIONS[:3], rod)), rod * np.eye(3))

    def rod(self, name: str, rod: float | Beam, same: float) -> None:
        """Lets a link give way at its far end: all joints and cuts that are there go with it."""
        place = self._far_end(name, same)
        matrix = rod.stiffness(float(np.linalg.norm(place[:3, 3]))) if isinstance(rod, Beam) else np.array([[rod]])
        ways = _ways(dict.fromkeys(DIRECTIONS[: len(matrix)], 1.0))
        tip = self._unused(f"{name}~tip")
        back, robot = inverse(place), self.robot

        def there(frame: Frame) -> Frame:
            near = np.linalg.norm(frame.placement[:3, 3] - place[:3, 3]) <= same
            return Frame(tip, back @ frame.placement) if frame.link == name and near else frame

        def moved(joint: Joint) -> Joint:
            end = there(Frame(joint.parent, joint.placement))
            return joint if end.link != tip else replace(joint, parent=tip, placement=end.placement)

        self.robot = replace(
            robot,
            joints=tuple(map(moved, robot.joints)),
            cuts=tuple(replace(cut, a=there(cut.a), b=there(cut.b)) for cut in robot.cuts),
            tool=None if robot.tool is None else there(robot.tool),
        )
        self._string(name, "rod", name, ways, matrix, tip, place)
        self._add_links([tip])

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _cut_end(self, cut: CutJoint, kind: str, ways: list[_Yield], matrix: Array) -> None:
        now = next(one for one in self.robot.cuts if one.name == cut.name)
        end = self._unused(f"{cut.name}~end")
        self._string(cut.name, kind, now.b.link, ways, matrix, end, now.b.placement)
        self._add_links([end])
        cuts = (replace(one, b=Frame(end)) if one.name == cut.name else one for one in self.robot.cuts)
        self.robot = replace(self.robot, cuts=tuple(cuts))

    def _string(
        self,
        name: str,
        kind: str,
        start: str,
        ways: list[_Yield],
        matrix: Array,
        end: str,
        place: Array | None = None,
    ) -> None:
        """Slides and hinges from link `start` to link `end`, which is there or will be."""
        made, parent = list[Joint](), start
        for number, way in enumerate(ways):
            last = number == len(ways) - 1
            child = end if last else self._unused(f"{name}~{kind}~{way.name}~")
            made.append(
                Joint(
                    self._unused(f"{name}~{kind}~{way.name}"),
                    JointType.CONTINUOUS if way.turns else JointType.PRISMATIC,
                    parent,
                    child,
                    from_rotation(np.eye(3), np.zeros(3)) if number or place is None else place,
                    way.axis,
                )
            )
            if not last:
                self._add_links([child])
            parent = child
        self.robot = replace(self.robot, joints=(*self.robot.joints, *made))
        self.gives.append(Give(name, kind, tuple(one.name for one in made), matrix))

    def _add_links(self, names: list[str]) -> None:
        self.robot = replace(self.robot, links=(*self.robot.links, *(Link(name) for name in names)))

    def _unused(self, name: str) -> str:
        taken = {one.name for parts in (self.robot.links, self.robot.joints, self.robot.cuts) for one in parts}
        while name in taken:
            name += "~"
        return name

    def _far_end(self, name: str, same: float) -> Array:
        """Placement on a link of its only end apart from its own origin, x along the rod.

        Raises:
            InputError: there is none, or there are several.
        """
        robot, ends = self.robot, list[Array]()
        for at in _ends(robot, name):
            apart = float(np.linalg.norm(at)) > same
            if apart and all(np.linalg.norm(at - one) > same for one in ends):
                ends.append(at)
        if name == robot.root:
            raise InputError(f"'{name}' is the base of {robot.name}, and rigid; let the joints on it give way")
        if len(ends) != 1:
            found = ", ".join(f"({', '.join(f'{x:.4g}' for x in one)})" for one in ends[:4]) or "none"
            raise InputError(
                f"link '{name}' of {robot.name} is no rod: one has a single end apart from its own origin, found ends "
                f"[m] at {found}; let its joints give way instead"
            )
        return from_rotation(end_axes(ends[0]), ends[0])


def end_axes(end: Array) -> Array:
    """Axes (3, 3) of a rod from the origin to `end` (3,) [m]: x along it, y across it and across that axis of the link
    that is most across it."""
    z = frame_along(end)
    return np.column_stack([z[:, 2], z[:, 0], z[:, 1]])


def _ends(robot: RobotDescription, link: str) -> Iterator[Array]:
    """Where moving joints and cuts are on a link; what is fixed to it elsewhere goes with its near end."""
    for joint in robot.joints:
        if joint.parent == link and joint.type.moves:
            yield joint.placement[:3, 3]
    for cut in robot.closing:
        for frame in (cut.a, cut.b):
            if frame.link == link:
                yield frame.placement[:3, 3]
