"""Joints and cuts as rows on the relative twist of two bodies, and the rates at which these rows turn.

The relative twist of body b against body a is taken at a point x that moves with b:

    r = [v_b + w_b x (x - x_b) - v_a - w_a x (x - x_a);  w_b - w_a]            (6,), world axes

A row c of a connection forbids or measures c . r.  It turns with a, with b, or, for the normal of a universal joint's
axes, with both; its rate is c' = w x c, and its acceleration is c . r' + c' . r.  With the bodies' accelerations
(a, alpha), r' is the same linear function of them as r is of the twists, plus

    [w_b x (w_b x (x - x_b)) - w_a x (x' - v_a);  0]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracles.reading import Array, Cut, Joint


def skew(r: Array) -> Array:
    """[r x], shape (3, 3)."""
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


def turn(axis: Array, angle: float) -> Array:
    """Rotation (3, 3) about a unit axis (Rodrigues)."""
    k = skew(axis)
    return np.eye(3) + np.sin(angle) * k + 2.0 * np.sin(0.5 * angle) ** 2 * (k @ k)


def shortest_turn(axis: Array) -> Array:
    """The rotation (3, 3) by the smallest angle that brings z to the unit vector `axis`."""
    across = np.array([-axis[1], axis[0], 0.0])
    sine = float(np.hypot(axis[0], axis[1]))
    if sine == 0.0:
        return np.diag([1.0, axis[2], axis[2]])
    return turn(across / sine, float(np.arctan2(sine, axis[2])))


@dataclass(frozen=True)
class Pose:
    """A body or a frame in the world: rotation (3, 3) and position (3,)."""

    rotation: Array
    position: Array

    def of(self, rotation: Array, position: Array) -> Pose:
        """A frame that this one carries."""
        return Pose(self.rotation @ rotation, self.position + self.rotation @ position)


@dataclass(frozen=True)
class Rows:
    """Rows (k, 6) on the relative twist of b against a at a point of b.

    Attributes:
        a, b: names of the bodies.
        point: x, shape (3,).
        matrix: the rows; those of lengths act on its first three components only.
        carrier: for each row the body that it turns with, 'a' or 'b'; 'ab' for the normal of a universal joint.
        axes: the two axes of a universal joint, the first in a, the second in b.
    """

    a: str
    b: str
    point: Array
    matrix: Array
    carrier: tuple[str, ...]
    axes: tuple[Array, Array] | None = None
    length: float = 0.0

    @property
    def is_length(self) -> Array:
        """Which rows are lengths, shape (k,)."""
        return np.abs(self.matrix[:, :3]).max(axis=1, initial=0.0) > 0.0

    def rates(self, w_a: Array, w_b: Array, relative: Array) -> Array:
        """Time derivative of the rows where the bodies turn with w_a and w_b and have a relative twist, shape (k, 6)."""
        rates = np.zeros_like(self.matrix)
        for row, (values, carrier) in enumerate(zip(self.matrix, self.carrier, strict=True)):
            if carrier == "ab":
                first, second = self.axes
                rates[row, 3:] = np.cross(np.cross(w_a, first), second) + np.cross(first, np.cross(w_b, second))
            elif carrier == "line":
                along, speed = values[:3], relative[:3]
                rates[row, :3] = np.cross(w_a, along) + (speed - (along @ speed) * along) / self.length
            else:
                w = w_a if carrier == "a" else w_b
                rates[row] = np.r_[np.cross(w, values[:3]), np.cross(w, values[3:])]
        return rates


def _rows(a: str, b: str, point: Array, forces: Array, moments: Array, carrier: str) -> Rows:
    """Rows of directions (m, 3) of lengths and (n, 3) of angles that one body carries."""
    matrix = np.zeros((len(forces) + len(moments), 6))
    matrix[: len(forces), :3], matrix[len(forces) :, 3:] = forces, moments
    return Rows(a, b, point, matrix, (carrier,) * len(matrix))


NONE = np.zeros((0, 3))


def across(axis: Array) -> Array:
    """Two unit vectors perpendicular to `axis` and to each other, shape (2, 3)."""
    return np.linalg.svd(axis[None, :])[2][1:]


def _universal(a: str, b: str, point: Array, first: Array, second: Array) -> Rows:
    normal = np.cross(first, second)
    matrix = np.zeros((4, 6))
    matrix[:3, :3], matrix[3, 3:] = np.eye(3), normal
    return Rows(a, b, point, matrix, ("a", "a", "a", "ab"), (first, second))


def placed_child(joint: Joint, parent: Pose, value: Array) -> Pose:
    """The child at a value of the joint: a number; two for universal; x, y and angle for planar; a rotation (3, 3) for
    spherical; a placement (4, 4) for floating."""
    zero = np.zeros(3)
    at = parent.of(joint.rotation, joint.position)
    match joint.kind:
        case "fixed":
            return at
        case "revolute" | "continuous":
            return at.of(turn(joint.axis, float(value)), zero)
        case "prismatic":
            return at.of(np.eye(3), joint.axis * float(value))
        case "universal":
            return at.of(turn(joint.axis, value[0]) @ turn(joint.axis2, value[1]), zero)
        case "spherical":
            return at.of(np.asarray(value), zero)
        case "planar":
            to = shortest_turn(joint.axis)
            return at.of(turn(joint.axis, value[2]), to @ np.array([value[0], value[1], 0.0]))
    placement = np.asarray(value)
    return at.of(placement[:3, :3], placement[:3, 3])


def joint_rows(joint: Joint, parent: Pose, child: Pose) -> tuple[Rows, Rows]:
    """What a joint forbids, and what it measures: the rows whose values are its velocities.

    These are those of docs/chain.md: spherical, planar and floating joints have theirs along the child's axes.  The
    measuring rows are orthonormal, so they are also the twists that unit velocities make.
    """
    a, b, x = joint.parent, joint.child, child.position
    axis = parent.rotation @ joint.rotation @ joint.axis
    match joint.kind:
        case "fixed":
            return _rows(a, b, x, np.eye(3), np.eye(3), "a"), _rows(a, b, x, NONE, NONE, "a")
        case "revolute" | "continuous":
            return _rows(a, b, x, np.eye(3), across(axis), "a"), _rows(a, b, x, NONE, axis[None], "a")
        case "prismatic":
            return _rows(a, b, x, across(axis), np.eye(3), "a"), _rows(a, b, x, axis[None], NONE, "a")
        case "universal":
            second = child.rotation @ joint.axis2
            matrix = np.zeros((2, 6))
            matrix[:, 3:] = axis, second
            return _universal(a, b, x, axis, second), Rows(a, b, x, matrix, ("a", "b"))
        case "spherical":
            return _rows(a, b, x, np.eye(3), NONE, "a"), _rows(a, b, x, NONE, child.rotation.T, "b")
        case "planar":
            own = (child.rotation @ shortest_turn(joint.axis)).T
            return _rows(a, b, x, own[2:], own[:2], "b"), _rows(a, b, x, own[:2], own[2:], "b")
    return _rows(a, b, x, NONE, NONE, "a"), _rows(a, b, x, child.rotation.T, child.rotation.T, "b")


def cut_rows(cut: Cut, a: Pose, b: Pose) -> Rows:
    """What a cut forbids where it is closed, with a and b the placements of its frames; the point is b's origin."""
    names, x, everything = (cut.a.link, cut.b.link), b.position, np.eye(3)
    match cut.kind:
        case "fixed":
            return _rows(*names, x, everything, everything, "a")
        case "revolute":
            return _rows(*names, x, everything, a.rotation[:, :2].T, "a")
        case "prismatic":
            return _rows(*names, x, a.rotation[:, :2].T, everything, "a")
        case "universal":
            return _universal(*names, x, a.rotation[:, 0], b.rotation[:, 1])
        case "distance":
            apart = x - a.position
            length = float(np.linalg.norm(apart))
            return Rows(*names, x, np.r_[apart / length, np.zeros(3)][None], ("line",), length=length)
    assert cut.kind == "spherical", cut.kind
    return _rows(*names, x, everything, NONE, "a")


def cut_gap(cut: Cut, a: Pose, b: Pose) -> tuple[float, float]:
    """By how much a cut is open, [m] and [rad]."""
    apart = b.position - a.position
    relative = a.rotation.T @ b.rotation
    lean = float(np.linalg.norm(np.cross(a.rotation[:, 2], b.rotation[:, 2])))
    chord = float(np.linalg.norm(relative - np.eye(3)) / np.sqrt(8.0))
    angle = {
        "fixed": 2.0 * np.arcsin(min(chord, 1.0)),
        "prismatic": 2.0 * np.arcsin(min(chord, 1.0)),
        "revolute": np.arctan2(lean, a.rotation[:, 2] @ b.rotation[:, 2]),
        "universal": abs(np.arcsin(np.clip(a.rotation[:, 0] @ b.rotation[:, 1], -1.0, 1.0))),
        "spherical": 0.0,
        "distance": 0.0,
    }[cut.kind]
    if cut.kind == "distance":
        return abs(float(np.linalg.norm(apart)) - cut.length), 0.0
    if cut.kind == "prismatic":
        apart = a.rotation[:, :2].T @ apart
    return float(np.linalg.norm(apart)), float(angle)
