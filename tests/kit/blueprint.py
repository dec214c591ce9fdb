"""Robots drawn where they stand closed: bodies, joints and cuts are lines and points of one common frame.

A joint is said by the point and the axis at which it sits at home, whatever the frames of its links are; those get
random orientations, the links random inertias, and the joints random coordinates at home.  So the loops of what is
written close at home, to rounding, by construction.

    plan = Blueprint("crank", rng)
    plan.joint("crank", "continuous", "base", "arm", at=[0, 0, 0], axis=[0, 0, 1])
    plan.joint("rod", "continuous", "arm", "rod", at=[0.3, 0, 0], axis=[0, 0, 1])
    plan.cut("slide", "prismatic", "base", "rod", at=[0.9, 0, 0], axis=[1, 0, 0])
    plan.write(folder)                                  # robot.urdf, loops.toml
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from kit.writing import Mounting, loops_text, urdf_text
from oracles.connections import Pose, turn
from oracles.curves import natural_spline, power_series
from oracles.reading import COORDINATES, rpy_rotation

Array = np.ndarray

Curve = tuple[float, ...] | list[tuple[float, float]]
"""Of a coupling: coefficients of a polynomial, or points of a table."""

WITHOUT_AXIS = ("fixed", "spherical", "floating")


def value_on(curve: Curve, x: float) -> float:
    """A curve of a coupling at a number."""
    return (natural_spline(curve) if isinstance(curve, list) else power_series(*curve))(x)[0]


def unit(vector: Any) -> Array:
    """A vector (3,) of length 1."""
    return np.array(vector, dtype=float) / np.linalg.norm(vector)


def random_rotation(rng: np.random.Generator) -> Array:
    """A rotation (3, 3), evenly over all."""
    w, x, y, z = unit(rng.normal(size=4))
    s = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * s + 2.0 * s @ s


def frame_with(rng: np.random.Generator, axis: Array, column: int) -> Array:
    """A random rotation (3, 3) in which one column is `axis`."""
    first, second = np.linalg.svd(axis[None, :])[2][1:]
    second = np.cross(axis, first)
    angle = rng.uniform(-np.pi, np.pi)
    x = np.cos(angle) * first + np.sin(angle) * second
    columns = [axis, x, np.cross(axis, x)]
    return np.column_stack([columns[(index - column) % 3] for index in range(3)])


@dataclass
class Inertia:
    """Mass [kg], and where it is in its link: placement of the centre of mass's axes, principal moments [kg m2]."""

    mass: float
    position: Array
    rpy: Array
    moments: Array


@dataclass
class PlacedJoint:
    """A joint with its origin in the parent and its axes in the child; `start` is its value at home."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Array
    position: Array
    axis: Array | None
    axis2: Array | None
    start: Any


@dataclass
class PlacedCut:
    """A cut with its two frames in their links."""

    name: str
    kind: str
    a: tuple[str, Array, Array]
    b: tuple[str, Array, Array]
    length: float = 0.0


@dataclass
class PlacedCoupling:
    """A coupling, engaged as its joints stand at home: a curve of every driver."""

    name: str
    joint: str
    curves: dict[str, Curve]
    offset: float


@dataclass
class Blueprint:
    """A robot in the making.  `size` [m] is that of its bodies, `weight` [kg] about their mass."""

    name: str
    rng: np.random.Generator
    size: float = 0.1
    weight: float = 1.0
    poses: dict[str, Pose] = field(default_factory=lambda: {"base": Pose(np.eye(3), np.zeros(3))})
    inertias: dict[str, Inertia | None] = field(default_factory=lambda: {"base": None})
    joints: list[PlacedJoint] = field(default_factory=list)
    cuts: list[PlacedCut] = field(default_factory=list)
    couplings: list[PlacedCoupling] = field(default_factory=list)
    actuators: list[str] = field(default_factory=list)
    tool: tuple[str, Array] | None = None
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))

    def joint(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        at: Any,
        axis: Any = None,
        axis2: Any = None,
        start: Any = None,
        massless: bool = False,
    ) -> None:
        """A joint of the tree and the link that it carries; `axis2` of a universal joint is made perpendicular."""
        at = np.array(at, dtype=float)
        turned, mother = random_rotation(self.rng), self.poses[parent]
        self.poses[child] = Pose(turned, at)
        self.inertias[child] = None if massless else self.random_inertia()
        own = None if axis is None or kind in WITHOUT_AXIS else turned.T @ unit(axis)
        start = self.random_start(kind) if start is None else start
        second = None
        if kind == "universal":
            across = np.array(axis2, dtype=float)
            second = turned.T @ unit(across - (across @ unit(axis)) * unit(axis))
            # the second turn has moved the child against the first axis already
            own = turn(second, start[1]) @ own
        back = value_pose(kind, own, second, start)
        rotation = mother.rotation.T @ turned @ back.rotation.T
        position = mother.rotation.T @ (at - mother.position) - rotation @ back.position
        self.joints.append(PlacedJoint(name, kind, parent, child, rotation, position, own, second, start))

    def cut(
        self,
        name: str,
        kind: str,
        a: str,
        b: str,
        at: Any,
        axis: Any = None,
        axis2: Any = None,
        slip: float | None = None,
    ) -> None:
        """A cut between links a and b at a point.  `axis` is that of a revolute or prismatic cut, or the one of a
        universal cut in a; `axis2` is that in b.  The frames of a prismatic cut stand `slip` apart along the axis."""
        at, rng = np.array(at, dtype=float), self.rng
        first, there = random_rotation(rng), at
        second = first if kind == "fixed" else random_rotation(rng)
        if kind == "revolute":
            first, second = frame_with(rng, unit(axis), 2), frame_with(rng, unit(axis), 2)
        elif kind == "prismatic":
            first = second = frame_with(rng, unit(axis), 2)
            there = at + (self.size * rng.normal() if slip is None else slip) * unit(axis)
        elif kind == "universal":
            across = np.array(axis2, dtype=float)
            across = unit(across - (across @ unit(axis)) * unit(axis))
            first, second = frame_with(rng, unit(axis), 0), frame_with(rng, across, 1)
        frames = []
        for link, rotation, point in ((a, first, at), (b, second, there)):
            pose = self.poses[link]
            frames.append((link, pose.rotation.T @ rotation, pose.rotation.T @ (point - pose.position)))
        self.cuts.append(PlacedCut(name, kind, *frames))

    def couple(self, name: str, joint: str, driver: str, ratio: float) -> None:
        """A gear between two joints of one coordinate, engaged as they stand at home."""
        self.curved(name, joint, {driver: (0.0, ratio)})

    def curved(self, name: str, joint: str, curves: dict[str, Curve]) -> None:
        """A coupling along curves: coefficients of a polynomial, or a list of points; none holds the joint."""
        start = {one.name: one.start for one in self.joints}
        driven = sum(value_on(curve, start[driver]) for driver, curve in curves.items())
        self.couplings.append(PlacedCoupling(name, joint, curves, float(start[joint] - driven)))

    def rod(self, name: str, a: str, b: str, at: Any, to: Any) -> None:
        """A distance between a point of link a and one of link b."""
        ends = []
        for link, point in ((a, np.array(at, dtype=float)), (b, np.array(to, dtype=float))):
            pose = self.poses[link]
            ends.append((link, random_rotation(self.rng), pose.rotation.T @ (point - pose.position)))
        length = float(np.linalg.norm(np.array(to, dtype=float) - np.array(at, dtype=float)))
        self.cuts.append(PlacedCut(name, "distance", *ends, length))

    def random_inertia(self) -> Inertia:
        """Of a body that can exist: eight random points of equal mass."""
        rng = self.rng
        mass = float(self.weight * rng.uniform(0.3, 1.7))
        points = rng.normal(size=(8, 3)) * 0.6 * self.size
        points -= points.mean(axis=0)
        squares = (points**2).sum(axis=0) * mass / 8.0
        moments = squares.sum() - squares
        return Inertia(mass, rng.normal(size=3) * 0.5 * self.size, rng.uniform(-1.2, 1.2, 3), moments)

    def random_start(self, kind: str) -> Any:
        """Coordinates of a joint at home, in the order of loops.toml."""
        rng = self.rng
        numbers = {
            "prismatic": [self.size * rng.normal()],
            "planar": [*(self.size * rng.normal(size=2)), rng.uniform(-1.0, 1.0)],
            "floating": [*(self.size * rng.normal(size=3)), *rng.uniform(-1.0, 1.0, 3)],
        }.get(kind, list(rng.uniform(-1.0, 1.0, COORDINATES[kind])))
        return numbers[0] if len(numbers) == 1 else [float(number) for number in numbers]

    @property
    def scalars(self) -> list[str]:
        """Joints of one coordinate that no gear drives: what can be an actuator."""
        driven = {one.joint for one in self.couplings}
        return [one.name for one in self.joints if COORDINATES[one.kind] == 1 and one.name not in driven]

    def write(self, folder: Path, mounting: Mounting | None = None, scale: float = 1.0, density: float = 1.0) -> Path:
        """robot.urdf and loops.toml in `folder`; lengths times `scale`, masses times `density`."""
        mounting = mounting or Mounting()
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.urdf").write_text(urdf_text(self, mounting, scale, density), encoding="utf-8")
        (folder / "loops.toml").write_text(loops_text(self, mounting, scale), encoding="utf-8")
        return folder


def value_pose(kind: str, axis: Array | None, axis2: Array | None, value: Any) -> Pose:
    """What a joint's value does to its child, in the joint's own frame."""
    from oracles.connections import placed_child
    from oracles.reading import Joint

    if kind == "spherical":
        value = rpy_rotation(value)
    elif kind == "floating":
        placement = np.eye(4)
        placement[:3, :3], placement[:3, 3] = rpy_rotation(value[3:]), value[:3]
        value = placement
    still = np.eye(3), np.zeros(3)
    joint = Joint("", kind, "", "", *still, axis, axis2)
    return placed_child(joint, Pose(*still), value)


def random_mounting(rng: np.random.Generator, distance: float = 1.0, turned: bool | None = None) -> Mounting:
    """A random place of the base; gravity turned along or not, at random where `turned` says neither."""
    along = bool(rng.integers(2)) if turned is None else turned
    return Mounting(rng.uniform(-3.1, 3.1, 3), distance * rng.normal(size=3), along)


__all__ = ["Blueprint", "Mounting", "frame_with", "random_mounting", "random_rotation", "turn", "unit"]
