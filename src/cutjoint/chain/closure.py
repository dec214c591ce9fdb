"""The cut joints as equations: residual, Jacobian and drift of every row, for all cut types.

Each cut joins frame A on one body to frame B on another.  Its rows are built from four kinds of scalar equation:

- point (all but prismatic): the three components of p_B - p_A vanish
- slide (prismatic): x_A . (p_B - p_A) = 0 and y_A . (p_B - p_A) = 0
- lock (fixed, prismatic): the rotation vector log(R_A' R_B) vanishes
- dot: an axis of A stays perpendicular to one of B (revolute: x_A and y_A to z_B; universal: x_A to y_B)

Jacobians come from Pinocchio's joint Jacobians in world axes (`data.J`, twist about the world origin): the relative
twist of two bodies is the difference of the columns that support them.  The drift (Jacobian's time derivative times v)
comes from `data.dJ` in the same way, so nothing here is a finite difference.  Couplings add one linear row each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.description.model import CutJoint, CutType, Frame, RobotDescription

_LOCKED = (CutType.FIXED, CutType.PRISMATIC)
_DOTS: dict[CutType, tuple[tuple[int, int], ...]] = {
    CutType.REVOLUTE: ((0, 2), (1, 2)),
    CutType.UNIVERSAL: ((0, 1),),
}


@dataclass(frozen=True, eq=False)
class Cut:
    """A cut joint bound to a model: joint indices and placements of its frames in those joints."""

    name: str
    type: CutType
    joint_a: int
    placement_a: pin.SE3
    joint_b: int
    placement_b: pin.SE3
    support_a: Array
    support_b: Array

    @property
    def rows(self) -> int:
        """Number of constraint rows."""
        return self.type.rows


@dataclass(frozen=True)
class Ratio:
    """A coupling bound to a model: v[joint] - ratio v[driver] = 0."""

    name: str
    q_joint: int
    q_driver: int
    v_joint: int
    v_driver: int
    ratio: float
    offset: float


def bind_frame(model: pin.Model, frame: Frame) -> tuple[int, pin.SE3]:
    """Joint index and placement in that joint of a frame on a link."""
    link = model.frames[model.getFrameId(frame.link, pin.FrameType.BODY)]
    return link.parentJoint, link.placement * pin.SE3(np.array(frame.placement))


class Closure:
    """All cuts and couplings of a robot as one system of equations.

    Methods take a `pin.Data` on which `computeJointJacobians` (for `drift`: `computeJointJacobiansTimeVariation`) has
    been called; they write nothing into it.
    """

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        self.nv = int(model.nv)
        self.cuts = tuple(self._bind(model, cut) for cut in description.cuts)
        self.ratios = tuple(
            Ratio(
                coupling.name,
                model.idx_qs[model.getJointId(coupling.joint)],
                model.idx_qs[model.getJointId(coupling.driver)],
                model.idx_vs[model.getJointId(coupling.joint)],
                model.idx_vs[model.getJointId(coupling.driver)],
                coupling.ratio,
                coupling.offset,
            )
            for coupling in description.couplings
        )
        self.rows = sum(cut.rows for cut in self.cuts) + len(self.ratios)
        names = [f"{cut.name}[{i}]" for cut in self.cuts for i in range(cut.rows)]
        self.row_names = (*names, *(ratio.name for ratio in self.ratios))
        self.is_length = np.array(
            [flag for cut in self.cuts for flag in _length_rows(cut.type)] + [False] * len(self.ratios)
        )
        self._ratio_rows = np.zeros((len(self.ratios), self.nv))
        for row, ratio in zip(self._ratio_rows, self.ratios, strict=True):
            row[ratio.v_joint], row[ratio.v_driver] = 1.0, -ratio.ratio

    @staticmethod
    def _bind(model: pin.Model, cut: CutJoint) -> Cut:
        joint_a, placement_a = bind_frame(model, cut.a)
        joint_b, placement_b = bind_frame(model, cut.b)
        return Cut(
            cut.name,
            cut.type,
            joint_a,
            placement_a,
            joint_b,
            placement_b,
            support(model, joint_a),
            support(model, joint_b),
        )

    def placements(self, data: pin.Data) -> list[tuple[str, pin.SE3, pin.SE3]]:
        """Name and world placements of both frames of every cut."""
        return [
            (cut.name, data.oMi[cut.joint_a] * cut.placement_a, data.oMi[cut.joint_b] * cut.placement_b)
            for cut in self.cuts
        ]

    def residual(self, data: pin.Data, q: Array) -> Array:
        """Residual of all rows, shape (rows,), [m] and [rad] (dot rows: sine of the angle)."""
        parts: list[Array] = []
        for cut, (_, a, b) in zip(self.cuts, self.placements(data), strict=True):
            apart = b.translation - a.translation
            if cut.type is CutType.PRISMATIC:
                parts.append(a.rotation[:, :2].T @ apart)
            else:
                parts.append(apart)
            if cut.type in _LOCKED:
                parts.append(a.rotation @ pin.log3(a.rotation.T @ b.rotation))
            parts.extend(np.array([a.rotation[:, i] @ b.rotation[:, j]]) for i, j in _DOTS.get(cut.type, ()))
        parts.extend(np.array([q[r.q_joint] - r.ratio * q[r.q_driver] - r.offset]) for r in self.ratios)
        return np.concatenate(parts) if parts else np.zeros(0)

    def jacobian(self, data: pin.Data) -> Array:
        """Time derivative of the residual per velocity, shape (rows, nv); exact also while the loops are open, but for
        the lock rows, which are exact where they are closed."""
        twist = np.asarray(data.J)
        blocks: list[Array] = []
        for cut, (_, a, b) in zip(self.cuts, self.placements(data), strict=True):
            on_a, on_b = twist * cut.support_a, twist * cut.support_b
            pa, pb = a.translation, b.translation
            velocity = on_b[:3] - _cross(pb, on_b[3:]) - on_a[:3] + _cross(pa, on_a[3:])
            turning = on_b[3:] - on_a[3:]
            if cut.type is CutType.PRISMATIC:
                axes = a.rotation[:, :2].T
                blocks.append(axes @ velocity - np.cross(axes, pb - pa) @ on_a[3:])
            else:
                blocks.append(velocity)
            if cut.type in _LOCKED:
                blocks.append(turning)
            blocks.extend(
                np.cross(b.rotation[:, j], a.rotation[:, i])[None, :] @ turning for i, j in _DOTS.get(cut.type, ())
            )
        blocks.append(self._ratio_rows)
        return np.concatenate(blocks)

    def drift(self, data: pin.Data, v: Array) -> Array:
        """Time derivative of the Jacobian times v, shape (rows,), [m/s2] and [rad/s2], for a closed posture."""
        twist, rate = np.asarray(data.J), np.asarray(data.dJ)
        parts: list[Array] = []
        for cut, (_, a, b) in zip(self.cuts, self.placements(data), strict=True):
            pa, pb = a.translation, b.translation
            speed_a, accel_a = twist @ (cut.support_a * v), rate @ (cut.support_a * v)
            speed_b, accel_b = twist @ (cut.support_b * v), rate @ (cut.support_b * v)
            wa, wb = speed_a[3:], speed_b[3:]
            va, vb = speed_a[:3] + np.cross(wa, pa), speed_b[:3] + np.cross(wb, pb)
            point_a = accel_a[:3] + np.cross(accel_a[3:], pa) + np.cross(wa, va)
            point_b = accel_b[:3] + np.cross(accel_b[3:], pb) + np.cross(wb, vb)
            turning, spinning = wb - wa, accel_b[3:] - accel_a[3:]
            if cut.type is CutType.PRISMATIC:
                for axis in a.rotation[:, :2].T:
                    swing = np.cross(wa, axis)
                    bend = np.cross(accel_a[3:], axis) + np.cross(wa, swing)
                    along = axis @ (point_b - point_a) + 2.0 * swing @ (vb - va) + bend @ (pb - pa)
                    parts.append(np.array([along]))
            else:
                parts.append(point_b - point_a)
            if cut.type in _LOCKED:
                parts.append(spinning)
            for i, j in _DOTS.get(cut.type, ()):
                x, y = a.rotation[:, i], b.rotation[:, j]
                normal = np.cross(y, x)
                normal_rate = np.cross(np.cross(wb, y), x) + np.cross(y, np.cross(wa, x))
                parts.append(np.array([normal_rate @ turning + normal @ spinning]))
        parts.append(np.zeros(len(self.ratios)))
        return np.concatenate(parts)

    def gaps(self, data: pin.Data, q: Array) -> list[tuple[str, float, float]]:
        """Name, distance [m] and angle [rad] by which every cut and coupling is open."""
        found: list[tuple[str, float, float]] = []
        for cut, (_, a, b) in zip(self.cuts, self.placements(data), strict=True):
            apart = b.translation - a.translation
            if cut.type is CutType.PRISMATIC:
                apart = a.rotation[:, :2].T @ apart
            angle = float(np.linalg.norm(pin.log3(a.rotation.T @ b.rotation))) if cut.type in _LOCKED else 0.0
            if cut.type is CutType.REVOLUTE:
                cross = np.cross(a.rotation[:, 2], b.rotation[:, 2])
                angle = float(np.arctan2(np.linalg.norm(cross), a.rotation[:, 2] @ b.rotation[:, 2]))
            if cut.type is CutType.UNIVERSAL:
                angle = abs(float(np.arcsin(np.clip(a.rotation[:, 0] @ b.rotation[:, 1], -1.0, 1.0))))
            found.append((cut.name, float(np.linalg.norm(apart)), angle))
        found.extend((r.name, 0.0, abs(float(q[r.q_joint] - r.ratio * q[r.q_driver] - r.offset))) for r in self.ratios)
        return found


def support(model: pin.Model, joint: int) -> Array:
    """1 for every velocity coordinate that moves `joint`, else 0; shape (nv,)."""
    mask = np.zeros(model.nv)
    while joint > 0:
        mask[model.idx_vs[joint] : model.idx_vs[joint] + model.nvs[joint]] = 1.0
        joint = model.parents[joint]
    mask.setflags(write=False)
    return mask


def _length_rows(kind: CutType) -> list[bool]:
    """Whether each row of a cut of this type is a length (else an angle)."""
    lengths = 2 if kind is CutType.PRISMATIC else 3
    return [True] * lengths + [False] * (kind.rows - lengths)


def _cross(point: Array, columns: Array) -> Array:
    """point x column for every column of a (3, nv) array."""
    x, y, z = point
    return np.stack([y * columns[2] - z * columns[1], z * columns[0] - x * columns[2], x * columns[1] - y * columns[0]])
