"""The cut joints as expressions: rows of the constraint Jacobian, their drift, and what is left open.

Rows are written in world axes, for a closed posture: there the relative velocity of the two frames does not depend on
how the residual is written, and the simplest rows serve.  A cut's type says which equations it holds
(`cutjoint.description.cuts`); here is what each kind of them is in expressions:

- point: the three components of the relative velocity of the two origins
- slide: its component along an axis of frame A
- lock: the three components of the relative angular velocity
- hinge: its two components across the free axis
- dot: its component along the cross product of an axis of A with one of B
- distance: its component along the difference of the two origins

Where the free axis of a hinge points the same way in every posture (planar limbs), two constant directions across it
are used, so those rows of the Jacobian are constants.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cutjoint.compile.equations.curves import on_curve
from cutjoint.compile.equations.dynamics import Motion
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions.functions import is_zero
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ZERO, Matrix, Vector, across, add, column, cross, dot, product, sub
from cutjoint.description.cuts import Equation, Kind

if TYPE_CHECKING:
    from cutjoint.chain.bound import BoundCoupling, BoundCut


@dataclass(frozen=True, eq=False)
class ConstraintRow:
    """One scalar constraint: coefficient of every rate, and whether it is a length (else an angle)."""

    coefficients: dict[int, Number]
    drift: Number
    residual: Number
    is_length: bool


class Loops:
    """All cuts and couplings on a tree."""

    def __init__(self, tree: JointTree, cuts: Sequence[BoundCut], couplings: Sequence[BoundCoupling] = ()) -> None:
        self.couplings = tuple(couplings)
        self.cuts = tuple(
            (
                cut.name,
                cut.type.equations,
                cut.length,
                tree.frame(cut.joint_a, cut.placement_a),
                tree.frame(cut.joint_b, cut.placement_b),
            )
            for cut in cuts
        )
        self.count = sum(cut.type.rows for cut in cuts) + len(self.couplings)

    def rows(self, pose: TreePose, motion: Motion | None = None, bias: Motion | None = None) -> list[ConstraintRow]:
        """All rows; the drift is zero without `motion` and `bias` (velocities, and accelerations at constant rates)."""
        found: list[ConstraintRow] = []
        for name, equations, length, a, b in self.cuts:
            ends = CutEnd(pose, pose.frame(f"cuts.{name}.a", a)), CutEnd(pose, pose.frame(f"cuts.{name}.b", b))
            relative = Relative(pose, *ends, motion, bias, pose.given.get(f"cuts.{name}.length", length))
            for equation in equations:
                for coefficients, drift, residual in WRITTEN[equation.kind](relative, equation):
                    kept = {u: c for u, c in coefficients.items() if not is_zero(c)}
                    found.append(ConstraintRow(kept, drift, residual, equation.is_length))
        for one in self.couplings:
            found.append(_coupled(pose, one, motion))
        return found


def _coupled(pose: TreePose, one: BoundCoupling, motion: Motion | None) -> ConstraintRow:
    """The row of a coupling: its coordinate less the curves of its drivers and an offset."""
    ratio, offset = (pose.given.get(f"couplings.{one.name}.{part}") for part in ("ratio", "offset"))
    weights: dict[int, Number] = {one.v_index[0]: 1.0}
    residual: Number = pose.q[one.q_index[0]] - (one.offset if offset is None else offset)
    drift: Number = 0.0
    for curve, index, u in zip(one.curves, one.q_index[1:], one.v_index[1:], strict=True):
        value, slope, bend = on_curve(curve, pose.q[index]) if ratio is None else (ratio * pose.q[index], ratio, 0.0)
        residual, weights[u] = residual - value, -slope
        if motion is not None:
            drift = drift - bend * motion.rates[u] * motion.rates[u]
    return ConstraintRow(weights, drift, residual, one.is_length)


class CutEnd:
    """One frame of a cut: its axes, and per rate the velocity of its origin and its angular velocity."""

    def __init__(self, pose: TreePose, frame: tuple[int, Matrix, Vector]) -> None:
        self.step, rotation, lever = frame
        columns = pose.columns(self.step, lever)
        self.axes = product(pose.rotation[self.step], rotation)
        self.arm = pose.lever(self.step, lever)
        self.velocity = {u: velocity for u, velocity, _ in columns}
        self.angular = {u: angular for u, _, angular in columns}


class Relative:
    """Frame B of a cut as frame A sees it, in world axes.

    Attributes:
        a, b: the frames.
        length: of the cut, where it is a distance.
        apart: from the origin of A to that of B.
        velocity, angular: per rate, relative velocity of the origins and relative angular velocity.
        speed, pull: relative velocity of the origins, and relative acceleration at constant rates.
        swing_a, swing_b, bend_a: angular velocities, and angular acceleration of A at constant rates.
        swing, spin: relative angular velocity, and relative angular acceleration at constant rates.
    """

    def __init__(
        self,
        pose: TreePose,
        a: CutEnd,
        b: CutEnd,
        motion: Motion | None = None,
        bias: Motion | None = None,
        length: Number = 0.0,
    ) -> None:
        self.a, self.b, self.length = a, b, length
        self.apart = _apart(pose, a, b)
        self.velocity = _difference(b.velocity, a.velocity)
        self.angular = _difference(b.angular, a.angular)
        # with a = b and velocities zero these all are zero, and fold away
        self.speed = self.pull = self.spin = self.swing_a = self.bend_a = self.swing_b = ZERO
        if motion is not None and bias is not None:
            self.swing_a, self.swing_b = motion.angular[a.step], motion.angular[b.step]
            self.speed = sub(motion.at(b.step, b.arm), motion.at(a.step, a.arm))
            self.pull = sub(_point(motion, bias, b), _point(motion, bias, a))
            self.bend_a = bias.angular[a.step]
            self.spin = sub(bias.angular[b.step], self.bend_a)
        self.swing = sub(self.swing_b, self.swing_a)

    def turning(self, direction: Vector) -> dict[int, Number]:
        """Component of the relative angular velocity, per rate."""
        return {u: dot(direction, one) for u, one in self.angular.items()}


def _difference(on_b: dict[int, Vector], on_a: dict[int, Vector]) -> dict[int, Vector]:
    return {u: sub(on_b.get(u, ZERO), on_a.get(u, ZERO)) for u in sorted({*on_a, *on_b})}


def _apart(pose: TreePose, a: CutEnd, b: CutEnd) -> Vector:
    """From the origin of frame A to that of frame B.  The common part of the two paths cancels symbolically."""
    up_a, up_b = pose.tree.path(a.step), pose.tree.path(b.step)
    shared = set(up_a) & set(up_b)
    total = sub(b.arm, a.arm)
    for k in up_b:
        if k not in shared:
            total = add(total, pose.offset[k])
    for k in up_a:
        if k not in shared:
            total = sub(total, pose.offset[k])
    return total


def _point(motion: Motion, bias: Motion, end: CutEnd) -> Vector:
    """Acceleration of a frame's origin at constant rates."""
    w = motion.angular[end.step]
    return add(bias.at(end.step, end.arm), cross(w, cross(w, end.arm)))


# -- the kinds of equations ------------------------------------------------------------------------------------------

Written = tuple[dict[int, Number], Number, Number]
"""A row: its coefficients, drift and residual."""


def _point_rows(at: Relative, equation: Equation) -> list[Written]:
    return [({u: one[k] for u, one in at.velocity.items()}, at.pull[k], at.apart[k]) for k in range(3)]


def _slide_rows(at: Relative, equation: Equation) -> list[Written]:
    x = column(at.a.axes, equation.axes[0])
    normal = cross(at.apart, x)
    coefficients = {u: dot(x, one) - dot(normal, at.a.angular.get(u, ZERO)) for u, one in at.velocity.items()}
    turned = cross(at.swing_a, x)
    bent = add(cross(at.bend_a, x), cross(at.swing_a, turned))
    drift = dot(x, at.pull) + 2.0 * dot(turned, at.speed) + dot(bent, at.apart)
    return [(coefficients, drift, dot(x, at.apart))]


def _lock_rows(at: Relative, equation: Equation) -> list[Written]:
    lock = ZERO
    for k in range(3):
        lock = add(lock, cross(column(at.a.axes, k), column(at.b.axes, k)))
    return [({u: one[k] for u, one in at.angular.items()}, at.spin[k], 0.5 * lock[k]) for k in range(3)]


def _hinge_rows(at: Relative, equation: Equation) -> list[Written]:
    x, y, fixed = across(at.a.axes)
    lean = cross(column(at.a.axes, 2), column(at.b.axes, 2))
    rows: list[Written] = []
    for axis in (x, y):
        drift = dot(axis, at.spin)
        if not fixed:
            drift = drift + dot(cross(at.swing_a, axis), at.swing)
        rows.append((at.turning(axis), drift, dot(axis, lean)))
    return rows


def _dot_rows(at: Relative, equation: Equation) -> list[Written]:
    x, y = column(at.a.axes, equation.axes[0]), column(at.b.axes, equation.axes[1])
    normal = cross(y, x)
    drift = dot(normal, at.spin)
    bent = add(cross(cross(at.swing_b, y), x), cross(y, cross(at.swing_a, x)))
    drift = drift + dot(bent, at.swing)
    return [(at.turning(normal), drift, dot(x, y))]


def _distance_rows(at: Relative, equation: Equation) -> list[Written]:
    coefficients = {u: dot(at.apart, one) / at.length for u, one in at.velocity.items()}
    drift = (dot(at.apart, at.pull) + dot(at.speed, at.speed)) / at.length
    return [(coefficients, drift, (dot(at.apart, at.apart) - at.length * at.length) / (2.0 * at.length))]


WRITTEN: Mapping[Kind, Callable[[Relative, Equation], list[Written]]] = {
    Kind.POINT: _point_rows,
    Kind.SLIDE: _slide_rows,
    Kind.LOCK: _lock_rows,
    Kind.HINGE: _hinge_rows,
    Kind.DOT: _dot_rows,
    Kind.DISTANCE: _distance_rows,
}
"""Kind of equation -> its rows."""
