"""The cut joints as equations: residual, Jacobian and drift of every row, for all cut types.

Each cut joins frame A on one body to frame B on another.  Its rows are built from four kinds of scalar equation:

- point (all but prismatic): the three components of p_B - p_A vanish
- slide (prismatic): x_A . (p_B - p_A) = 0 and y_A . (p_B - p_A) = 0
- lock (fixed, prismatic): the rotation vector log(R_A' R_B) vanishes
- dot: an axis of A stays perpendicular to one of B (revolute: x_A and y_A to z_B; universal: x_A to y_B).  A revolute
  cut's two are stretched from the sine to the angle between z_A and z_B, so that opposite axes do not count as closed.

Jacobians come from Pinocchio's joint Jacobians in world axes (`data.J`, twist about the world origin): the relative
twist of two bodies is the difference of the columns that support them.  The drift (Jacobian's time derivative times v)
comes from `data.dJ` in the same way, so nothing here is a finite difference.  Couplings add one linear row each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.description.model import Coupling, CutJoint, CutType, Frame, RobotDescription

_LOCKED = (CutType.FIXED, CutType.PRISMATIC)
ROW_LABELS: dict[CutType, tuple[str, ...]] = {
    CutType.FIXED: ("x", "y", "z", "rx", "ry", "rz"),
    CutType.REVOLUTE: ("x", "y", "z", "tilt_x", "tilt_y"),
    CutType.PRISMATIC: ("x", "y", "rx", "ry", "rz"),
    CutType.UNIVERSAL: ("x", "y", "z", "twist"),
    CutType.SPHERICAL: ("x", "y", "z"),
}
"""What each row of a cut holds: a displacement along an axis, a rotation about it, or an angle between two axes."""
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
    is_length: bool


def bind_frame(model: pin.Model, frame: Frame) -> tuple[int, pin.SE3]:
    """Joint index and placement in that joint of a frame on a link."""
    link = model.frames[model.getFrameId(frame.link, pin.FrameType.BODY)]
    return link.parentJoint, link.placement * pin.SE3(np.array(frame.placement))


class Closure:
    """All cuts and couplings of a robot as one system of equations.

    Methods take a `pin.Data` on which `computeJointJacobians` (for `drift`: `computeJointJacobiansTimeVariation`) has
    been called; they write nothing into it.  All cuts are worked on at once, as arrays over cuts.

    Args:
        trusted: indices of the rows to work with; default all.  The others are left to be met by the geometry.
    """

    def __init__(self, model: pin.Model, description: RobotDescription, trusted: Array | None = None) -> None:
        self.nv = int(model.nv)
        self.cuts = tuple(_bind_cut(model, cut) for cut in description.cuts)
        self.ratios = tuple(_bind_ratio(model, coupling) for coupling in description.couplings)
        self.all_rows = sum(cut.rows for cut in self.cuts) + len(self.ratios)
        self.trusted = np.arange(self.all_rows) if trusted is None else np.array(trusted, dtype=int)
        self.rows = len(self.trusted)
        names = [f"{cut.name}.{label}" for cut in self.cuts for label in ROW_LABELS[cut.type]]
        every = (*names, *(ratio.name for ratio in self.ratios))
        self.row_names = tuple(every[i] for i in self.trusted)
        self.left_out = tuple(every[i] for i in range(self.all_rows) if i not in set(self.trusted.tolist()))
        lengths = [flag for cut in self.cuts for flag in _length_rows(cut.type)]
        self.is_length = np.array(lengths + [ratio.is_length for ratio in self.ratios], dtype=bool)[self.trusted]
        self._layout = _Layout(self.cuts)
        self._on_a = np.array([cut.support_a for cut in self.cuts]).reshape(len(self.cuts), self.nv)
        self._on_b = np.array([cut.support_b for cut in self.cuts]).reshape(len(self.cuts), self.nv)
        self._on_both = np.concatenate([self._on_a, self._on_b])
        self._ratio_rows = np.zeros((len(self.ratios), self.nv))
        for row, ratio in zip(self._ratio_rows, self.ratios, strict=True):
            row[ratio.v_joint], row[ratio.v_driver] = 1.0, -ratio.ratio

    def placements(self, data: pin.Data) -> list[tuple[str, pin.SE3, pin.SE3]]:
        """Name and world placements of both frames of every cut."""
        return [
            (cut.name, data.oMi[cut.joint_a] * cut.placement_a, data.oMi[cut.joint_b] * cut.placement_b)
            for cut in self.cuts
        ]

    def residual(self, data: pin.Data, q: Array) -> Array:
        """Residual of all rows, shape (rows,), [m] and [rad] (universal: sine of the angle)."""
        placed, rows = self.placements(data), self._layout
        residual = np.empty(self.all_rows)
        for (_, a, b), cut, start in zip(placed, self.cuts, rows.starts, strict=True):
            apart = b.translation - a.translation
            if cut.type is CutType.PRISMATIC:
                residual[start : start + 2] = a.rotation[:, :2].T @ apart
            else:
                residual[start : start + 3] = apart
            if cut.type in _LOCKED:
                residual[start + cut.rows - 3 : start + cut.rows] = a.rotation @ pin.log3(a.rotation.T @ b.rotation)
        for cut_index, row, i, j in rows.dots:
            _, a, b = placed[cut_index]
            residual[row] = a.rotation[:, i] @ b.rotation[:, j]
        for cut_index, row in rows.hinges:
            _, a, b = placed[cut_index]
            residual[row : row + 2] = _turned(residual[row : row + 2], a.rotation[:, 2] @ b.rotation[:, 2])
        for row, r in enumerate(self.ratios, start=self.all_rows - len(self.ratios)):
            residual[row] = q[r.q_joint] - r.ratio * q[r.q_driver] - r.offset
        return self._kept(residual)

    def jacobian(self, data: pin.Data) -> Array:
        """Time derivative of the residual per velocity, shape (rows, nv); exact also while the loops are open, but for
        the lock rows and those of revolute cuts, which are exact where they are closed and elsewhere still have the
        exact gradient of their sum of squares."""
        jacobian = np.empty((self.all_rows, self.nv))
        jacobian[self.all_rows - len(self.ratios) :] = self._ratio_rows
        if not self.cuts:
            return self._kept(jacobian)
        placed, rows = self.placements(data), self._layout
        twist = np.asarray(data.J)
        linear, angular = twist[:3], twist[3:]
        pa, pb = _positions(placed)
        velocity = (linear - _skew(pb) @ angular) * self._on_b[:, None] - (linear - _skew(pa) @ angular) * self._on_a[
            :, None
        ]
        turning = angular * (self._on_b - self._on_a)[:, None]
        jacobian[rows.point_rows] = velocity[rows.point_cuts].reshape(-1, self.nv)
        jacobian[rows.lock_rows] = turning[rows.lock_cuts].reshape(-1, self.nv)
        for cut_index, row, i, j in rows.dots:
            _, a, b = placed[cut_index]
            axis = (a if self.cuts[cut_index].type is CutType.REVOLUTE else b).rotation[:, j]
            jacobian[row] = _cross(axis, a.rotation[:, i]) @ turning[cut_index]
        for cut_index, row, i in rows.slides:
            _, a, b = placed[cut_index]
            swing = _cross(a.rotation[:, i], b.translation - a.translation)
            jacobian[row] = a.rotation[:, i] @ velocity[cut_index] + swing @ (angular * self._on_a[cut_index])
        return self._kept(jacobian)

    def drift(self, data: pin.Data, v: Array) -> Array:
        """Time derivative of the Jacobian times v, shape (rows,), [m/s2] and [rad/s2], for a closed posture."""
        drift = np.zeros(self.all_rows)
        if not self.cuts:
            return self._kept(drift)
        placed, rows = self.placements(data), self._layout
        twist, rate = np.asarray(data.J), np.asarray(data.dJ)
        pa, pb = _positions(placed)
        on, points = self._on_both * v, np.concatenate([pa, pb])
        w, velocity, alpha, point = _point_motion(on @ twist.T, on @ rate.T, points)
        half = len(self.cuts)
        wa, wb, va, vb = w[:half], w[half:], velocity[:half], velocity[half:]
        alpha_a, alpha_b, point_a, point_b = alpha[:half], alpha[half:], point[:half], point[half:]
        drift[rows.point_rows] = (point_b - point_a)[rows.point_cuts].ravel()
        drift[rows.lock_rows] = (alpha_b - alpha_a)[rows.lock_cuts].ravel()
        for cut_index, row, i, j in rows.dots:
            _, a, b = placed[cut_index]
            x, y, w_a, w_b = a.rotation[:, i], b.rotation[:, j], wa[cut_index], wb[cut_index]
            normal_rate = _cross(_cross(w_b, y), x) + _cross(y, _cross(w_a, x))
            drift[row] = normal_rate @ (w_b - w_a) + _cross(y, x) @ (alpha_b[cut_index] - alpha_a[cut_index])
        for cut_index, row, i in rows.slides:
            _, a, b = placed[cut_index]
            axis, w = a.rotation[:, i], wa[cut_index]
            swing = _cross(w, axis)
            bend = _cross(alpha_a[cut_index], axis) + _cross(w, swing)
            drift[row] = (
                axis @ (point_b[cut_index] - point_a[cut_index])
                + 2.0 * swing @ (vb[cut_index] - va[cut_index])
                + bend @ (pb[cut_index] - pa[cut_index])
            )
        return self._kept(drift)

    def spread(self, multipliers: Array) -> Array:
        """Multipliers of the trusted rows among those of all rows, which get none, shape (all rows,)."""
        spread = np.zeros(self.all_rows)
        spread[self.trusted] = multipliers
        return spread

    def _kept(self, values: Array) -> Array:
        return values if self.rows == self.all_rows else values[self.trusted]

    def gaps(self, data: pin.Data, q: Array) -> list[tuple[str, float, float]]:
        """Name, distance [m] and angle [rad] by which every cut and coupling is open."""
        found: list[tuple[str, float, float]] = []
        for cut, (_, a, b) in zip(self.cuts, self.placements(data), strict=True):
            apart = b.translation - a.translation
            if cut.type is CutType.PRISMATIC:
                apart = a.rotation[:, :2].T @ apart
            angle = 0.0
            if cut.type in _LOCKED:
                angle = float(np.linalg.norm(pin.log3(a.rotation.T @ b.rotation)))
            elif cut.type is CutType.REVOLUTE:
                sine = _cross(a.rotation[:, 2], b.rotation[:, 2])
                angle = float(np.arctan2(np.linalg.norm(sine), a.rotation[:, 2] @ b.rotation[:, 2]))
            elif cut.type is CutType.UNIVERSAL:
                angle = abs(float(np.arcsin(np.clip(a.rotation[:, 0] @ b.rotation[:, 1], -1.0, 1.0))))
            found.append((cut.name, float(np.linalg.norm(apart)), angle))
        for r in self.ratios:
            apart = abs(float(q[r.q_joint] - r.ratio * q[r.q_driver] - r.offset))
            found.append((r.name, apart, 0.0) if r.is_length else (r.name, 0.0, apart))
        return found


class _Layout:
    """Which rows are of which kind: point and lock rows by cut, dot and slide rows one by one."""

    def __init__(self, cuts: tuple[Cut, ...]) -> None:
        self.starts = [sum(cut.rows for cut in cuts[:index]) for index in range(len(cuts))]
        points = [i for i, cut in enumerate(cuts) if cut.type is not CutType.PRISMATIC]
        locks = [i for i, cut in enumerate(cuts) if cut.type in _LOCKED]
        self.point_cuts, self.lock_cuts = np.array(points, dtype=int), np.array(locks, dtype=int)
        self.point_rows = np.array([self.starts[i] + k for i in points for k in range(3)], dtype=int)
        self.lock_rows = np.array([self.starts[i] + cuts[i].rows - 3 + k for i in locks for k in range(3)], dtype=int)
        self.dots = [
            (index, self.starts[index] + 3 + k, i, j)
            for index, cut in enumerate(cuts)
            for k, (i, j) in enumerate(_DOTS.get(cut.type, ()))
        ]
        self.hinges = [(i, self.starts[i] + 3) for i, cut in enumerate(cuts) if cut.type is CutType.REVOLUTE]
        self.slides = [
            (index, self.starts[index] + i, i)
            for index, cut in enumerate(cuts)
            if cut.type is CutType.PRISMATIC
            for i in range(2)
        ]


def _bind_cut(model: pin.Model, cut: CutJoint) -> Cut:
    joint_a, placement_a = bind_frame(model, cut.a)
    joint_b, placement_b = bind_frame(model, cut.b)
    supports = support(model, joint_a), support(model, joint_b)
    return Cut(cut.name, cut.type, joint_a, placement_a, joint_b, placement_b, *supports)


def _bind_ratio(model: pin.Model, coupling: Coupling) -> Ratio:
    joint, driver = model.getJointId(coupling.joint), model.getJointId(coupling.driver)
    return Ratio(
        coupling.name,
        model.idx_qs[joint],
        model.idx_qs[driver],
        model.idx_vs[joint],
        model.idx_vs[driver],
        coupling.ratio,
        coupling.offset,
        model.joints[joint].shortname().startswith("JointModelP"),
    )


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


def _turned(sines: Array, cosine: float) -> Array:
    """The two components of the sine of the angle between two unit vectors, stretched to the angle, shape (2,)."""
    sine = float(np.hypot(sines[0], sines[1]))
    if sine > 1e-12:
        return sines * (float(np.arctan2(sine, cosine)) / sine)
    return sines if cosine > 0.0 else np.array([np.pi, 0.0])


def _cross(x: Array, y: Array) -> Array:
    """Cross product of vectors, shape (3,) or (k, 3); quicker than numpy's on arrays as small as these."""
    x0, x1, x2 = x.T
    y0, y1, y2 = y.T
    return np.array([x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0]).T


def _skew(points: Array) -> Array:
    """Matrices [p x] of points (k, 3), shape (k, 3, 3)."""
    skew = np.zeros((len(points), 3, 3))
    skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0] = points.T
    skew[:, 1, 2], skew[:, 2, 0], skew[:, 0, 1] = -points.T
    return skew


def _positions(placed: list[tuple[str, pin.SE3, pin.SE3]]) -> tuple[Array, Array]:
    """Origins of all frames a and b, shape (cuts, 3) each."""
    return np.array([a.translation for _, a, _ in placed]), np.array([b.translation for _, _, b in placed])


def _point_motion(speed: Array, rate: Array, points: Array) -> tuple[Array, Array, Array, Array]:
    """From twists and their rates about the world origin (k, 6): angular velocity, velocity of the point, angular
    acceleration and classical acceleration of the point, shape (k, 3) each."""
    w, alpha = speed[:, 3:], rate[:, 3:]
    velocity = speed[:, :3] + _cross(w, points)
    return w, velocity, alpha, rate[:, :3] + _cross(alpha, points) + _cross(w, velocity)
