"""A robot with loops as plain values: the open tree, the cut joints that close it, and how it is driven.

Every file format is read into these types and nothing else; the chain is built from them alone.  Placements are (4, 4)
homogeneous transforms, SI units and radians.  Values are immutable, also after pickling and
copying; `with_...` and `variant` give changed copies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.description.couplings import Coupling as Coupling
from cutjoint.description.couplings import DriverCurve as DriverCurve
from cutjoint.description.cuts import CutType as CutType
from cutjoint.description.joints import JointType as JointType
from cutjoint.description.limits import Limits as Limits
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.findings import NOWHERE
from cutjoint.findings import Place as Place
from cutjoint.mechanism.physics import LARGEST_PAYLOAD, NO_PHYSICS
from cutjoint.mechanism.physics import Bushing as Bushing
from cutjoint.mechanism.physics import JointPhysics as JointPhysics
from cutjoint.reprs import counted, line, one_line, quoted, short

IDENTITY: Array = readonly(np.eye(4))
TASK_NAMES = ("x", "y", "z", "rx", "ry", "rz")
"""What a task is made of: motions of the tool along and about the axes of the task."""
TaskAxes = Literal["world", "tool"]
"""Whose axes these are: the world's, or the tool's at home."""
TASK_AXES: tuple[TaskAxes, ...] = ("world", "tool")


@dataclass(frozen=True, eq=False)
class Inertial(Frozen):
    """Mass [kg], centre of mass (3,) [m] in the link frame, inertia (3, 3) [kg m2] about it, along the link axes."""

    mass: float
    com: Array = field(default_factory=lambda: readonly(np.zeros(3)))
    inertia: Array = field(default_factory=lambda: readonly(np.zeros((3, 3))))

    __repr__ = line(mass="kg", com="m", inertia="kg m2")

    @classmethod
    def of(cls, mass: float, com: npt.ArrayLike, entries: Sequence[float], axes: Array = IDENTITY[:3, :3]) -> Inertial:
        """With the entries xx, yy, zz, xy, xz, yz (or the first three) of the inertia along `axes` (3, 3)."""
        xx, yy, zz, xy, xz, yz = (*entries, 0.0, 0.0, 0.0)[:6]
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if not np.array_equal(axes, np.eye(3)):
            tensor = axes @ tensor @ axes.T
            tensor = 0.5 * (tensor + tensor.T)
        return cls(mass, np.asarray(com, dtype=float), tensor)

    @property
    def entries(self) -> tuple[float, ...]:
        """xx, yy, zz, xy, xz, yz of the inertia."""
        return tuple(float(self.inertia[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


@dataclass(frozen=True, eq=False)
class Shape(Frozen):
    """A visual or collision shape.

    `kind` and `size`: box (x, y, z), cylinder or capsule (radius, length along z), sphere (radius,), mesh (scale x, y,
    z, with `mesh` the file).  `colour` is red, green, blue, opacity from 0 to 1, or None where the file gives none.
    """

    kind: str
    size: tuple[float, ...]
    placement: Array = field(default_factory=lambda: IDENTITY)
    colour: tuple[float, float, float, float] | None = None
    mesh: Path | None = None
    name: str = ""

    __repr__ = line(size="m")


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body.  Without `inertial` it is massless (a mere frame).

    `gravity_compensation` is the share of its weight that something holds up at its centre of mass, wherever it is: 0
    none, 1 all; more, and it rises.
    """

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()
    place: Place = NOWHERE
    gravity_compensation: float = 0.0

    __repr__ = line("name", "inertial", "visuals", "collisions")

    @property
    def held_up(self) -> float:
        """Mass whose weight is compensated [kg]."""
        return 0.0 if self.inertial is None else self.gravity_compensation * self.inertial.mass


@dataclass(frozen=True, eq=False)
class Joint(Frozen):
    """A joint of the open tree; `placement` is the child frame in the parent frame at zero.

    `axis` (3,) is a unit vector in the child frame; `axis2` the second axis of a universal joint.
    """

    name: str
    type: JointType
    parent: str
    child: str
    placement: Array = field(default_factory=lambda: IDENTITY)
    axis: Array = field(default_factory=lambda: readonly([1.0, 0.0, 0.0]))
    axis2: Array = field(default_factory=lambda: readonly([0.0, 1.0, 0.0]))
    limits: Limits = field(default_factory=Limits)
    physics: JointPhysics = NO_PHYSICS
    place: Place = NOWHERE

    __repr__ = line("name", "type", "parent", "child", "axis", "limits", "physics")


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """A frame on a link: `placement` (4, 4) in the link frame."""

    link: str
    placement: Array = field(default_factory=lambda: IDENTITY)

    __repr__ = line()


@dataclass(frozen=True, eq=False)
class CutJoint:
    """A joint that was left out to get a tree: it joins frame `a` to frame `b`.

    The free axis of a revolute or prismatic cut is the z axis of both frames; a universal cut turns about the x axis of
    `a` and the y axis of `b`, which stay perpendicular; a distance keeps the origins `length` [m] apart.
    `physics` is of the motion that it leaves free.  With a
    `bushing` it holds nothing rigidly: it is a spring and damper, and closes no loop.
    """

    name: str
    type: CutType
    a: Frame
    b: Frame
    place: Place = NOWHERE
    physics: JointPhysics = NO_PHYSICS
    bushing: Bushing | None = None
    length: float = 0.0

    __repr__ = line("name", "type", "a", "b", "length", "physics", "bushing", length="m")


@dataclass(frozen=True)
class Home(Frozen):
    """A named start: exact actuated coordinates and rough passive ones that pick the branch.

    A value is a number, or for joints with several coordinates their list: floating x, y, z, roll, pitch, yaw;
    spherical roll, pitch, yaw; universal two angles; planar x, y, angle.
    """

    name: str
    actuated: Mapping[str, float] = field(default_factory=dict)
    passive: Mapping[str, float | tuple[float, ...]] = field(default_factory=dict)
    about: str = ""

    __repr__ = line(actuated="m or rad", passive="m or rad")


@dataclass(frozen=True)
class Variant(Frozen):
    """A named set of inertias that replace those of the tree's own file; the tree stays one."""

    name: str
    about: str = ""
    inertials: Mapping[str, Inertial] = field(default_factory=dict)

    __repr__ = line("name", "about", "inertials")


Named = TypeVar("Named", Link, Joint, Variant)


@dataclass(frozen=True, eq=False)
class RobotDescription(Frozen):
    """A robot with loops.  What `load_description` returns has passed `check()`.

    `task` tells which motions of the tool are led, some of `TASK_NAMES` in that order (in whatever order they are
    given), and `task_axes` along whose axes; where `task` is empty, the robot's mobility at home tells.
    `places` tells where in the files the parts stand that hold no place of their own: "actuators", "tool", "task",
    "gravity", "home.NAME" and "variant.NAME".
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    cuts: tuple[CutJoint, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    actuators: tuple[str, ...] = ()
    tool: Frame | None = None
    task: tuple[str, ...] = ()
    task_axes: TaskAxes = "world"
    gravity: Array = field(default_factory=lambda: readonly([0.0, 0.0, -9.81]))
    homes: tuple[Home, ...] = ()
    variants: tuple[Variant, ...] = ()
    title: str = ""
    source: str = ""
    path: Path | None = None
    variant_name: str = ""
    places: Mapping[str, Place] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        rank = {name: number for number, name in enumerate(TASK_NAMES)}
        ordered = sorted(self.task, key=lambda name: rank.get(name, len(rank)))
        object.__setattr__(self, "task", tuple(ordered))

    def __repr__(self) -> str:
        parts = {"link": self.links, "joint": self.joints, "cut": self.cuts, "coupling": self.couplings}
        counts = [counted(len(found), what) for what, found in parts.items() if found]
        return one_line("RobotDescription", [quoted(self.name), *counts, f"actuators={short(self.actuators)}"])

    @property
    def closing(self) -> tuple[CutJoint, ...]:
        """The cuts that close loops: those without a bushing."""
        return tuple(cut for cut in self.cuts if cut.bushing is None)

    @property
    def acting(self) -> tuple[str, ...]:
        """Names of the joints and cuts that do something by themselves."""
        joints = tuple(one.name for one in self.joints if one.physics != NO_PHYSICS)
        return joints + tuple(one.name for one in self.cuts if one.physics != NO_PHYSICS or one.bushing is not None)

    def ideal(self) -> RobotDescription:
        """A copy whose joints move freely: no damping, friction, springs, rotors or stops, and no bushings.

        Weights are compensated as before: gravity compensation is of links, not of joints.
        """
        joints = tuple(replace(one, physics=NO_PHYSICS) for one in self.joints)
        return replace(
            self, joints=joints, cuts=tuple(replace(one, physics=NO_PHYSICS, bushing=None) for one in self.cuts)
        )

    @property
    def root(self) -> str:
        """Name of the link that no joint moves.

        Raises:
            InputError: there is none.
        """
        children = {joint.child for joint in self.joints}
        root = next((link.name for link in self.links if link.name not in children), None)
        if root is None:
            raise InputError(f"{self.name or 'the robot'} has no link that no joint moves")
        return root

    def link(self, name: str) -> Link:
        """The link called `name`.

        Raises:
            UnknownNameError: there is none.
        """
        return _called(name, "link", self.links)

    def joint(self, name: str) -> Joint:
        """The joint called `name`.

        Raises:
            UnknownNameError: there is none.
        """
        return _called(name, "joint", self.joints)

    def with_inertial(self, link: str, inertial: Inertial) -> RobotDescription:
        """A copy in which `link` has another inertia."""
        self.link(link)
        links = tuple(replace(one, inertial=inertial) if one.name == link else one for one in self.links)
        return replace(self, links=links)

    def variant(self, name: str) -> RobotDescription:
        """A copy with the inertias of the named variant.

        Raises:
            UnknownNameError: the robot has no such variant.
        """
        changed = self
        for link, inertial in _called(name, "variant", self.variants).inertials.items():
            changed = changed.with_inertial(link, inertial)
        return replace(changed, variant_name=name)

    def with_payload(self, mass: float) -> RobotDescription:
        """A copy that carries a point mass [kg] at the tool point, whose weight nothing compensates: on a link whose
        own weight is compensated it is a link by itself.

        Raises:
            InputError: there is no tool, or the mass is not from 0 to `LARGEST_PAYLOAD`.
        """
        if self.tool is None:
            raise InputError(f"{self.name} has no tool frame to carry a payload; name one under [tool]")
        if not 0.0 <= mass <= LARGEST_PAYLOAD:
            raise InputError(f"payload must be a mass from 0 to {LARGEST_PAYLOAD:g} kg, found {mass!r}")
        if mass == 0.0:
            return self
        link = self.link(self.tool.link)
        if link.gravity_compensation:
            return self._carrying(Link(self._unused("payload"), Inertial(mass)), self.tool)
        old = link.inertial or Inertial(0.0)
        point = self.tool.placement[:3, 3]
        total = old.mass + mass
        com = (old.mass * old.com + mass * point) / total
        inertia = old.inertia + _point_inertia(old.mass, old.com - com) + _point_inertia(mass, point - com)
        return self.with_inertial(self.tool.link, Inertial(total, com, inertia))

    def _carrying(self, link: Link, at: Frame) -> RobotDescription:
        """A copy with a further link that is fixed to another."""
        joint = Joint(link.name, JointType.FIXED, at.link, link.name, at.placement)
        return replace(self, links=(*self.links, link), joints=(*self.joints, joint))

    def _unused(self, name: str) -> str:
        """A name like this one that no part has."""
        taken = {one.name for parts in (self.links, self.joints, self.cuts, self.couplings) for one in parts}
        return next(one for one in (name, *(f"{name}_{k}" for k in range(2, len(taken) + 3))) if one not in taken)


def _called(name: str, kind: str, items: Sequence[Named]) -> Named:
    for item in items:
        if item.name == name:
            return item
    raise UnknownNameError(kind, name, [item.name for item in items])


def _point_inertia(mass: float, at: Array) -> Array:
    """Inertia (3, 3) [kg m2] about the origin of a point mass at `at`."""
    return mass * (float(at @ at) * np.eye(3) - np.outer(at, at))
