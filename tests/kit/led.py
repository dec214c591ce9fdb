"""Robots whose inverse kinematics is known in closed form, of any size, standing anywhere, with any frame as tool.

`LED` has a builder for each: it draws a random shape that is regular at home and around it.  `stand` puts a robot on
the ground as a description; what it gives tells poses, coordinates and joints as the closed form knows them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from kit.blueprint import Blueprint
from kit.sized import Size
from oracles.closed_form import ClosedForm, OutOfReachError

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.description.model import Frame, RobotDescription

Array = np.ndarray
Rng = np.random.Generator

LENGTH = 0.3
"""About the size of the robots [m], which sets lengths against angles."""

REGULAR = (0.15, 6.0)
"""Actuators move at least and at most so much for the tool's motion, lengths in robot lengths."""


@dataclass(frozen=True)
class Led:
    """A robot in the axes of its base.

    Attributes:
        task: names of what it leads in the axes of its base.
        slides: whether its actuators are lengths.
        spread: how far to go from home along each freedom, [m] or [rad].
    """

    plan: Blueprint
    form: ClosedForm
    task: tuple[str, ...]
    slides: bool
    spread: Array

    def leverage(self, x: Array) -> Array:
        """Singular values of the actuators' motion for the freedoms' one, lengths in robot lengths."""
        unit = np.eye(len(x))
        at = np.array([self.form.joints(*self.form.pose(x + step)) for step in 1e-5 * np.r_[unit, -unit]])
        rates = (at[: len(x)] - at[len(x) :]).T / 2e-5
        lengths = np.array([LENGTH if name in "xyz" else 1.0 for name in self.form.freedoms])
        return np.linalg.svd(rates * lengths / (LENGTH if self.slides else 1.0), compute_uv=False)

    def is_regular(self, x: Array) -> bool:
        """Whether the robot is regular all the way from home to there."""
        try:
            sizes = [self.leverage(part * x) for part in (0.0, 0.33, 0.67, 1.0)]
        except OutOfReachError:
            return False
        return min(map(np.min, sizes)) > REGULAR[0] and max(map(np.max, sizes)) < REGULAR[1]

    def freedoms(self, rng: Rng, reach: float = 1.0) -> Array:
        """A random motion from home along the freedoms, regular all the way."""
        for _ in range(200):
            x = reach * self.spread * rng.uniform(-1.0, 1.0, len(self.spread))
            if self.is_regular(x):
                return x
        raise AssertionError(f"{self.plan.name} has no regular surroundings")


@dataclass(frozen=True)
class Standing:
    """A robot on the ground.

    Attributes:
        description: what cutjoint reads.
        size: lengths, and where the base stands.
        axes: of the tool as columns, at home, in the axes of the base.
    """

    led: Led
    description: RobotDescription
    size: Size
    axes: Array

    @cached_property
    def chain(self) -> ClosedChain:
        """The robot."""
        return ClosedChain(self.description)

    @property
    def length(self) -> float:
        """Its size [m]."""
        return LENGTH * self.size.length

    def pose(self, x: Array) -> Array:
        """Pose of the tool in the world after the freedoms have moved by `x` of the robot at size 1, shape (4, 4)."""
        position, rotation = self.led.form.pose(x)
        found = np.eye(4)
        found[:3, :3], found[:3, 3] = self.size.rotation @ rotation @ self.axes, self.size.place(position)
        return found

    def joints(self, x: Array) -> Array:
        """Actuated coordinates there, shape (n,)."""
        return self.joints_at(self.pose(x))

    def joints_at(self, pose: Array) -> Array:
        """Actuated coordinates of a pose of the tool in the world (4, 4), within half a turn of home, shape (n,)."""
        turned = self.size.rotation.T
        position = turned @ (pose[:3, 3] - self.size.offset) / self.size.length
        found = self.led.form.joints(position, turned @ pose[:3, :3] @ self.axes.T)
        if self.led.slides:
            return found * self.size.length
        home = self.led.form.joints(self.led.form.centre, np.eye(3))
        return found + 2.0 * np.pi * np.round((home - found) / (2.0 * np.pi))

    def missed(self, q: Array, x: Array) -> float:
        """How far actuated coordinates are from the closed form's, in robot lengths and radians, whole turns aside."""
        away = q - self.joints(x)
        away = away / self.length if self.led.slides else np.arctan2(np.sin(away), np.cos(away))
        return float(np.abs(away).max())

    def off(self, pose: Any, x: Array) -> float:
        """How far a `Pose` is from where the tool should be, in robot lengths and radians."""
        wanted = self.pose(x)
        shift = np.abs(pose.position - wanted[:3, 3]).max() / self.length
        return max(float(shift), float(np.abs(pose.rotation - wanted[:3, :3]).max()))

    def named(self, x: Array, names: Sequence[str], axes: str) -> dict[str, float]:
        """Coordinates by name, in the world's axes or the tool's at home; turns that are named must be freedoms."""
        wanted, home = self.pose(x), self.pose(0.0 * x)
        along = home[:3, :3] if axes == "tool" else np.eye(3)
        place = along.T @ (wanted[:3, 3] - (home[:3, 3] if axes == "tool" else 0.0))
        values = dict(zip("xyz", place.tolist(), strict=True))
        moved = dict(zip(self.led.form.freedoms, x.tolist(), strict=True))
        turns = [moved.get(name, 0.0) for name in ("rx", "ry", "rz")]
        turned = along.T @ self.size.rotation @ np.array(turns)
        values.update(zip(("rx", "ry", "rz"), turned.tolist(), strict=True))
        return {name: values[name] for name in names}


def stand(led: Led, folder: Path, size: Size | None = None, axes: Array | None = None, **changes: Any) -> Standing:
    """The robot as a description of this size, its tool turned by `axes` in the axes of the base (default: along)."""
    size, axes = size or Size(), np.eye(3) if axes is None else axes
    plain = load_description(led.plan.write(folder))
    assert led.plan.tool is not None
    link, point = led.plan.tool
    body, placement = led.plan.poses[link], np.eye(4)
    placement[:3, :3] = body.rotation.T @ axes
    placement[:3, 3] = body.rotation.T @ (np.asarray(point) - body.position)
    standing = size.of(replace(plain, tool=Frame(link, placement)))
    return Standing(led, replace(standing, **changes), size, axes)


def with_limits(description: RobotDescription, limits: Mapping[str, tuple[float, float]]) -> RobotDescription:
    """A copy with these limits of joints, lower and upper; hinges that turned without end become limited ones."""
    from cutjoint.description.model import JointType, Limits

    joints: Sequence[Any] = [
        replace(
            one,
            type=JointType.REVOLUTE if one.type is JointType.CONTINUOUS else one.type,
            limits=Limits(*limits[one.name]),
        )
        if one.name in limits
        else one
        for one in description.joints
    ]
    return replace(description, joints=tuple(joints))
