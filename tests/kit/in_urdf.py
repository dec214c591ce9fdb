"""One loop of a robot in every dialect of URDF, beside the same robot with a loops.toml.

The robots stand closed at zero, so that dialects which say a joint by where it is at zero can say it too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from kit.blueprint import Blueprint, random_rotation, unit
from oracles.connections import Pose

Array = np.ndarray
END = "</robot>"


@dataclass
class Loop:
    """A cut of a kind between links a and b, at a point and along axes of the world at zero."""

    kind: str
    a: str
    b: str
    at: Array
    axis: Array
    axis2: Array
    poses: dict[str, Pose]
    rng: np.random.Generator

    def point(self, link: str) -> str:
        """The point in a link, as text."""
        pose = self.poses[link]
        return words(pose.rotation.T @ (self.at - pose.position))

    def along(self, link: str, axis: Array | None = None) -> str:
        """An axis (that of the loop) in a link, as text."""
        return words(self.poses[link].rotation.T @ (self.axis if axis is None else axis))

    def frames(self) -> tuple[Array, Array]:
        """Rotations (3, 3) in the world of two frames in which the axis has the same coordinates."""
        first = random_rotation(self.rng)
        angle = self.rng.uniform(-3.0, 3.0)
        x, y, z = self.axis
        s = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        about = np.eye(3) + np.sin(angle) * s + (1.0 - np.cos(angle)) * s @ s
        return first, (first if self.kind in ("prismatic", "fixed") else about @ first)

    def rpy(self, link: str, rotation: Array) -> str:
        """A frame of the world in a link, as roll, pitch, yaw."""
        return words(rpy_of(self.poses[link].rotation.T @ rotation))


def words(values: Array) -> str:
    """Numbers as text, exact."""
    return " ".join(repr(float(value)) for value in values)


def rpy_of(r: Array) -> Array:
    """Roll, pitch, yaw of a rotation (3, 3) away from the poles."""
    return np.array([np.arctan2(r[2, 1], r[2, 2]), np.arcsin(-r[2, 0]), np.arctan2(r[1, 0], r[0, 0])])


def tree(rng: np.random.Generator, links: int = 5) -> Blueprint:
    """Two branches of so many random joints that stand at zero: a loop between their ends still moves."""
    plan = Blueprint("tree", rng)
    for branch in "ab":
        parent = "base"
        for index in range(1, links + 1):
            kind = str(rng.choice(["continuous", "continuous", "prismatic"]))
            name, at, axis = f"{branch}{index}", 0.4 * rng.normal(size=3), rng.normal(size=3)
            plan.joint(f"j{name}", kind, parent, name, at, axis, start=0.0)
            parent = name
    plan.actuators = ["ja1"]
    return plan


def random_loop(plan: Blueprint, kind: str, dialect: str) -> Loop:
    """A loop between the ends of two branches; where a dialect asks for it, at the origin of its second link."""
    rng = plan.rng
    a, b = "a5", "b5"
    at = plan.poses[b].position if dialect == "parents" else 0.4 * rng.normal(size=3)
    axis, across = unit(rng.normal(size=3)), rng.normal(size=3)
    loop = Loop(kind, a, b, at, axis, unit(across - (across @ axis) * axis), plan.poses, rng)
    plan.cut("tip", kind, a, b, at, axis, loop.axis2, slip=0.0)
    return loop


def gazebo(loop: Loop) -> str:
    turn, kind = loop.frames()[0], {"spherical": "ball"}.get(loop.kind, loop.kind)
    rows = "".join(
        f"<{tag}><xyz>{words(turn.T @ axis)}</xyz></{tag}>"
        for tag, axis in (("axis", loop.axis), ("axis2", loop.axis2))[: {"universal": 2}.get(loop.kind, 1)]
        if kind not in ("ball", "fixed")
    )
    pose = f"<pose>{loop.point(loop.b)} {loop.rpy(loop.b, turn)}</pose>"
    ends = f"<parent>{loop.a}</parent><child>{loop.b}</child>"
    return f'<gazebo><joint name="tip" type="{kind}">{ends}{pose}{rows}</joint></gazebo>'


def gazebo_in_model(loop: Loop) -> str:
    """The pose relative to the first link, the axes in the model's frame."""
    kind = {"spherical": "ball"}.get(loop.kind, loop.kind)
    rows = "".join(
        f'<{tag}><xyz expressed_in="__model__">{words(axis)}</xyz></{tag}>'
        for tag, axis in (("axis", loop.axis), ("axis2", loop.axis2))[: {"universal": 2}.get(loop.kind, 1)]
        if kind not in ("ball", "fixed")
    )
    pose = f'<pose relative_to="{loop.a}">{loop.point(loop.a)} 0.1 -0.2 0.3</pose>'
    ends = f"<parent>{loop.a}</parent><child>{loop.b}</child>"
    return f'<gazebo><joint name="tip" type="{kind}">{ends}{pose}{rows}</joint></gazebo>'


def loop_joint(loop: Loop) -> str:
    first, second = loop.frames()
    kind = {"revolute": "continuous"}.get(loop.kind, loop.kind)
    ends = "".join(
        f'<{tag} link="{link}" xyz="{loop.point(link)}" rpy="{loop.rpy(link, frame)}"/>'
        for tag, link, frame in (("link1", loop.a, first), ("link2", loop.b, second))
    )
    return f'<loop_joint name="tip" type="{kind}">{ends}<axis xyz="{words(first.T @ loop.axis)}"/></loop_joint>'


def plus(loop: Loop) -> str:
    first, second = loop.frames()
    ends = "".join(
        f'<{tag} link="{link}"><origin xyz="{loop.point(link)}" rpy="{loop.rpy(link, frame)}"/></{tag}>'
        for tag, link, frame in (("predecessor", loop.a, first), ("successor", loop.b, second))
    )
    return f'<loop name="tip" type="{loop.kind}">{ends}<axis xyz="{words(first.T @ loop.axis)}"/></loop>'


def closing(loop: Loop) -> str:
    z = np.array([0.0, 0.0, 1.0])
    turn = np.eye(3) if loop.kind == "spherical" else aligned(z, loop.axis)
    text = ""
    for number, link in ((1, loop.a), (2, loop.b)):
        pose = loop.poses[link]
        for tail, shift in (("", 0.0), ("_z", 0.1))[: 1 if loop.kind == "spherical" else 2]:
            name, at = f"closing_tip_{number}{tail}", loop.at + shift * (turn @ z)
            xyz = words(pose.rotation.T @ (at - pose.position))
            text += f'<link name="{name}"/><joint name="{name}_frame" type="fixed"><parent link="{link}"/>'
            text += f'<child link="{name}"/><origin xyz="{xyz}" rpy="{loop.rpy(link, turn)}"/></joint>'
    return text


def aligned(a: Array, b: Array) -> Array:
    """A rotation (3, 3) that turns the unit vector a into b."""
    v, c = np.cross(a, b), float(a @ b)
    s = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + s + s @ s / (1.0 + c)


def drake(loop: Loop) -> str:
    parts = "".join(
        f'<drake:ball_constraint_body_{end} name="{link}"/>'
        f'<drake:ball_constraint_p_{point} value="{loop.point(link)}"/>'
        for end, point, link in (("A", "AP", loop.a), ("B", "BQ", loop.b))
    )
    return f"<drake:ball_constraint>{parts}</drake:ball_constraint>"


def parents(loop: Loop) -> str:
    kind = {"revolute": "continuous"}.get(loop.kind, loop.kind)
    origin = f'<origin xyz="{loop.point(loop.a)}" rpy="{loop.rpy(loop.a, loop.poses[loop.b].rotation)}"/>'
    ends = f'<parent link="{loop.a}"/><child link="{loop.b}"/>'
    return f'<joint name="tip" type="{kind}">{ends}{origin}<axis xyz="{loop.along(loop.b)}"/></joint>'


DIALECTS: dict[str, tuple[Callable[[Loop], str], tuple[str, ...]]] = {
    "gazebo": (gazebo, ("revolute", "prismatic", "universal", "spherical", "fixed")),
    "gazebo in the model": (gazebo_in_model, ("revolute", "prismatic", "universal", "spherical", "fixed")),
    "loop_joint": (loop_joint, ("revolute", "prismatic", "spherical", "fixed")),
    "plus": (plus, ("revolute", "prismatic", "spherical", "fixed")),
    "closing": (closing, ("revolute", "spherical")),
    "drake": (drake, ("spherical",)),
    "parents": (parents, ("revolute", "prismatic", "fixed")),
}
"""Dialect -> how it writes a loop, and which kinds it has."""
PAIRS = [(dialect, kind) for dialect, (_, kinds) in DIALECTS.items() for kind in kinds]


def write(dialect: str, kind: str, rng: np.random.Generator, folder: Path) -> tuple[Path, Path]:
    """A random robot with a loops.toml, and in a dialect."""
    plan = tree(rng)
    loop = random_loop(plan, kind, dialect)
    native = plan.write(folder / "native")
    text = (native / "robot.urdf").read_text(encoding="utf-8")
    other = folder / "dialect.urdf"
    other.write_text(text.replace(END, DIALECTS[dialect][0](loop) + END), encoding="utf-8")
    return native, other
