"""The cut joints as expressions: rows of the constraint Jacobian, their drift, and what is left open.

Rows are written in world axes, for a closed posture: there the relative velocity of the two frames does not depend on
how the residual is written, and the simplest rows serve.

- point: the three components of the relative velocity of the two origins    (all types but prismatic)
- slide: its components along x and y of frame A                              (prismatic)
- lock: the three components of the relative angular velocity                 (fixed, prismatic)
- hinge: its two components across the free axis                              (revolute)
- cross: its component along x_A x y_B                                        (universal)

Where the free axis of a hinge points the same way in every posture (planar limbs), two constant directions across it
are used, so those rows of the Jacobian are constants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.compile.equations.tree import Motion, Pose, Tree
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Expression, Number, is_zero
from cutjoint.compile.expressions.vectors import ZERO, Matrix, Vector
from cutjoint.description.model import CutType


@dataclass(frozen=True, eq=False)
class CutFrames:
    """A cut joint in terms of the model: joints and placements of its two frames in them."""

    name: str
    type: CutType
    joint_a: int
    placement_a: pin.SE3
    joint_b: int
    placement_b: pin.SE3


@dataclass(frozen=True)
class Gear:
    """A coupling in terms of the model: q[joint] = ratio q[driver] + offset."""

    name: str
    q_joint: int
    q_driver: int
    v_joint: int
    v_driver: int
    ratio: float
    offset: float
    is_length: bool = False


@dataclass(frozen=True, eq=False)
class Row:
    """One scalar constraint: coefficient of every rate, and whether it is a length (else an angle)."""

    coefficients: dict[int, Number]
    drift: Number
    residual: Number
    is_length: bool


class Loops:
    """All cuts and couplings on a tree."""

    def __init__(self, tree: Tree, cuts: Sequence[CutFrames], gears: Sequence[Gear] = ()) -> None:
        self.tree, self.gears = tree, tuple(gears)
        self.cuts = tuple(
            (cut.type, tree.frame(cut.joint_a, cut.placement_a), tree.frame(cut.joint_b, cut.placement_b))
            for cut in cuts
        )
        self.names = tuple(f"{cut.name}[{k}]" for cut in cuts for k in range(cut.type.rows)) + tuple(
            gear.name for gear in self.gears
        )

    def rows(self, pose: Pose, motion: Motion | None = None, bias: Motion | None = None) -> list[Row]:
        """All rows; the drift is zero without `motion` and `bias` (velocities, and accelerations at constant rates)."""
        found: list[Row] = []
        for kind, a, b in self.cuts:
            found.extend(_cut_rows(pose, kind, a, b, motion, bias))
        for gear in self.gears:
            residual = pose.q[gear.q_joint] - gear.ratio * pose.q[gear.q_driver] - gear.offset
            found.append(Row({gear.v_joint: 1.0, gear.v_driver: -gear.ratio}, 0.0, residual, gear.is_length))
        return found


@dataclass(frozen=True, eq=False)
class _End:
    """One frame of a cut: its axes, and per rate the velocity of its origin and its angular velocity."""

    axes: Matrix
    step: int
    arm: Vector
    velocity: dict[int, Vector]
    angular: dict[int, Vector]


def _end(pose: Pose, frame: tuple[int, Matrix, Vector]) -> _End:
    step, rotation, lever = frame
    columns = pose.columns(step, lever)
    return _End(
        vectors.product(pose.rotation[step], rotation),
        step,
        pose.lever(step, lever),
        {u: velocity for u, velocity, _ in columns},
        {u: angular for u, _, angular in columns},
    )


def _difference(on_b: dict[int, Vector], on_a: dict[int, Vector]) -> dict[int, Vector]:
    return {u: vectors.sub(on_b.get(u, ZERO), on_a.get(u, ZERO)) for u in sorted({*on_a, *on_b})}


def _apart(pose: Pose, a: _End, b: _End) -> Vector:
    """From the origin of frame A to that of frame B.  The common part of the two paths cancels symbolically."""
    steps = pose.tree.steps
    up_a, up_b = _path(pose.tree, a.step), _path(pose.tree, b.step)
    shared = set(up_a) & set(up_b)
    total = vectors.sub(b.arm, a.arm)
    for k in up_b:
        if k not in shared:
            total = vectors.add(total, pose.offset[k])
    for k in up_a:
        if k not in shared:
            total = vectors.sub(total, pose.offset[k])
    assert steps[0].parent == -1
    return total


def _path(tree: Tree, step: int) -> list[int]:
    found = []
    while step > 0:
        found.append(step)
        step = tree.steps[step].parent
    return found


def _is_constant(vector: Vector) -> bool:
    return all(not isinstance(x, Expression) or x.constant is not None for x in vector)


def _across(axes: Matrix) -> tuple[Vector, Vector, bool]:
    """Two directions across the z axis, and whether they are constants."""
    z = vectors.column(axes, 2)
    if not _is_constant(z):
        return vectors.column(axes, 0), vectors.column(axes, 1), False
    numbers = np.array([x.constant if isinstance(x, Expression) else x for x in z], dtype=np.float64)
    across = vectors.constant_rotation(vectors.rotation_onto(numbers / np.linalg.norm(numbers)))
    return vectors.column(across, 0), vectors.column(across, 1), True


def _cut_rows(
    pose: Pose,
    kind: CutType,
    frame_a: tuple[int, Matrix, Vector],
    frame_b: tuple[int, Matrix, Vector],
    motion: Motion | None,
    bias: Motion | None,
) -> list[Row]:
    a, b = _end(pose, frame_a), _end(pose, frame_b)
    apart = _apart(pose, a, b)
    velocity = _difference(b.velocity, a.velocity)
    angular = _difference(b.angular, a.angular)
    # with a = b and velocities zero these all are zero, and fold away
    speed = pull = spin = swing_a = bend_a = swing_b = ZERO
    if motion is not None and bias is not None:
        swing_a, swing_b = motion.angular[a.step], motion.angular[b.step]
        speed = vectors.sub(motion.at(b.step, b.arm), motion.at(a.step, a.arm))
        pull = vectors.sub(_point(motion, bias, b), _point(motion, bias, a))
        bend_a = bias.angular[a.step]
        spin = vectors.sub(bias.angular[b.step], bend_a)
    relative = vectors.sub(swing_b, swing_a)

    rows: list[Row] = []
    if kind is CutType.PRISMATIC:
        for k in range(2):
            x = vectors.column(a.axes, k)
            normal = vectors.cross(apart, x)
            coefficients = {
                u: vectors.dot(x, one) - vectors.dot(normal, a.angular.get(u, ZERO)) for u, one in velocity.items()
            }
            turned = vectors.cross(swing_a, x)
            bent = vectors.add(vectors.cross(bend_a, x), vectors.cross(swing_a, turned))
            drift = vectors.dot(x, pull) + 2.0 * vectors.dot(turned, speed) + vectors.dot(bent, apart)
            rows.append(_row(coefficients, drift, vectors.dot(x, apart), True))
    else:
        for k in range(3):
            rows.append(_row({u: one[k] for u, one in velocity.items()}, pull[k], apart[k], True))

    match kind:
        case CutType.FIXED | CutType.PRISMATIC:
            lock = ZERO
            for k in range(3):
                lock = vectors.add(lock, vectors.cross(vectors.column(a.axes, k), vectors.column(b.axes, k)))
            for k in range(3):
                rows.append(_row({u: one[k] for u, one in angular.items()}, spin[k], 0.5 * lock[k], False))
        case CutType.REVOLUTE:
            x, y, fixed = _across(a.axes)
            lean = vectors.cross(vectors.column(a.axes, 2), vectors.column(b.axes, 2))
            for axis in (x, y):
                drift = vectors.dot(axis, spin)
                if not fixed:
                    drift = drift + vectors.dot(vectors.cross(swing_a, axis), relative)
                coefficients = {u: vectors.dot(axis, one) for u, one in angular.items()}
                rows.append(_row(coefficients, drift, vectors.dot(axis, lean), False))
        case CutType.UNIVERSAL:
            x, y = vectors.column(a.axes, 0), vectors.column(b.axes, 1)
            normal = vectors.cross(y, x)
            drift = vectors.dot(normal, spin) + vectors.dot(
                vectors.add(vectors.cross(vectors.cross(swing_b, y), x), vectors.cross(y, vectors.cross(swing_a, x))),
                relative,
            )
            coefficients = {u: vectors.dot(normal, one) for u, one in angular.items()}
            rows.append(_row(coefficients, drift, vectors.dot(x, y), False))
    return rows


def _point(motion: Motion, bias: Motion, end: _End) -> Vector:
    """Acceleration of a frame's origin at constant rates."""
    w = motion.angular[end.step]
    return vectors.add(bias.at(end.step, end.arm), vectors.cross(w, vectors.cross(w, end.arm)))


def _row(coefficients: dict[int, Number], drift: Number, residual: Number, is_length: bool) -> Row:
    return Row({u: c for u, c in coefficients.items() if not is_zero(c)}, drift, residual, is_length)
