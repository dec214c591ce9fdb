"""The cut joints as equations: residual, Jacobian and drift of every row, for all cut types.

Each cut joins frame A on one body to frame B on another.  Its rows are built from four kinds of scalar equation:

- point (all but prismatic): the three components of p_B - p_A vanish
- slide (prismatic): x_A . (p_B - p_A) = 0 and y_A . (p_B - p_A) = 0
- lock (fixed, prismatic): the rotation vector log(R_A' R_B) vanishes
- dot: an axis of A stays perpendicular to one of B (revolute: x_A and y_A to z_B; universal: x_A to y_B).  A revolute
  cut's two are stretched from the sine to the angle between z_A and z_B, so that opposite axes do not count as closed.

Every row is linear in the twists of the bodies that it joins (about the world origin, in world axes), so one matrix G
over the twists of all cut frames says it all: K = G J with J the joint Jacobians of those bodies, and the drift is
G (dJ/dt v) plus what the turning of G adds.  Nothing here is a finite difference.  Couplings add one linear row each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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


@dataclass(frozen=True, eq=False)
class CutFrames:
    """World axes (cuts, 3, 3) and origins (cuts, 3) of the frames a and b of all cuts, in the order of the cuts."""

    axes_a: Array
    axes_b: Array
    at_a: Array
    at_b: Array


def bind_frame(model: pin.Model, frame: Frame) -> tuple[int, pin.SE3]:
    """Joint index and placement in that joint of a frame on a link."""
    link = model.frames[model.getFrameId(frame.link, pin.FrameType.BODY)]
    return link.parentJoint, link.placement * pin.SE3(np.array(frame.placement))


class Closure:
    """All cuts and couplings of a robot as one system of equations; a value, it holds no workspace.

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
        self._all_lengths = np.array(lengths + [ratio.is_length for ratio in self.ratios], dtype=bool)
        self.is_length = self._all_lengths[self.trusted]
        self.names = (*(cut.name for cut in self.cuts), *(ratio.name for ratio in self.ratios))
        self._is_sine = np.zeros(self.all_rows, dtype=bool)
        self._layout = _Layout(self.cuts)
        self._is_sine[[row for cut, row, _, _ in self._layout.dots if self.cuts[cut].type is CutType.UNIVERSAL]] = True
        self.support = np.array([cut.support_a for cut in self.cuts] + [cut.support_b for cut in self.cuts])
        self.support = self.support.reshape(2 * len(self.cuts), 1, self.nv)
        self.moved = self.support[:, 0]
        self.turns = any(cut.type is not CutType.FIXED for cut in self.cuts)
        self.holds_points = all(cut.type in (CutType.FIXED, CutType.SPHERICAL) for cut in self.cuts)
        self._has_sines = bool(self._is_sine.any())
        self._starts = np.array(
            self._layout.starts + list(range(self.all_rows - len(self.ratios), self.all_rows)), dtype=int
        )
        self._ratio_rows = np.zeros((len(self.ratios), self.nv))
        for row, ratio in zip(self._ratio_rows, self.ratios, strict=True):
            row[ratio.v_joint], row[ratio.v_driver] = 1.0, -ratio.ratio

    @cached_property
    def apart(self) -> Array:
        """Differences of the origins of frames b and a as rows of the cuts, shape (cut rows, 6 cuts)."""
        found = np.zeros((self._layout.constant.shape[0], 6 * len(self.cuts)))
        for cut, row in self._layout.points:
            found[row : row + 3, 3 * cut : 3 * cut + 3] = -np.eye(3)
            found[row : row + 3, 3 * (len(self.cuts) + cut) :][:, :3] = np.eye(3)
        return found

    def residual(self, frames: CutFrames, q: Array) -> Array:
        """Residual of all rows, trusted or not, shape (all rows,), [m] and [rad] (universal: sine of the angle)."""
        rows = self._layout
        residual = np.empty(self.all_rows)
        apart = frames.at_b - frames.at_a
        residual[rows.point_rows] = (apart if rows.all_points else apart.take(rows.point_cuts, 0)).ravel()
        if rows.locks:
            residual[rows.lock_rows] = _rotation_vectors(frames.axes_a[rows.lock_cuts], frames.axes_b[rows.lock_cuts])
        for cut, row, i in rows.slides:
            residual[row] = frames.axes_a[cut, :, i] @ apart[cut]
        for cut, row, i, j in rows.dots:
            residual[row] = frames.axes_a[cut, :, i] @ frames.axes_b[cut, :, j]
        for cut, row in rows.hinges:
            cosine = float(frames.axes_a[cut, :, 2] @ frames.axes_b[cut, :, 2])
            residual[row : row + 2] = _turned(residual[row : row + 2], cosine)
        for row, r in enumerate(self.ratios, start=self.all_rows - len(self.ratios)):
            residual[row] = q[r.q_joint] - r.ratio * q[r.q_driver] - r.offset
        return residual

    def gather(self, frames: CutFrames) -> Array:
        """G: the rows of the cuts over the twists of their frames a, then b, shape (cut rows, 12 cuts).

        Exact also while the loops are open, but for the lock rows and those of revolute cuts, which are exact where
        they are closed and elsewhere still have the exact gradient of their sum of squares.
        """
        rows, count = self._layout, len(self.cuts)
        gather = rows.constant.copy()
        if len(rows.point_cuts):
            arms = np.concatenate([frames.at_a, frames.at_b]).ravel()
            gather.reshape(-1)[rows.arm_entries] = arms[rows.arm_of] * rows.arm_sign
        for cut, row, i, j in rows.dots:
            axis = (frames.axes_a if self.cuts[cut].type is CutType.REVOLUTE else frames.axes_b)[cut, :, j]
            normal = cross(axis, frames.axes_a[cut, :, i])
            gather[row, 6 * cut + 3 : 6 * cut + 6] = -normal
            gather[row, 6 * (count + cut) + 3 : 6 * (count + cut) + 6] = normal
        for cut, row, i in rows.slides:
            axis = frames.axes_a[cut, :, i]
            gather[row, 6 * cut : 6 * cut + 3] = -axis
            gather[row, 6 * cut + 3 : 6 * cut + 6] = -cross(frames.at_b[cut], axis)
            gather[row, 6 * (count + cut) : 6 * (count + cut) + 3] = axis
            gather[row, 6 * (count + cut) + 3 : 6 * (count + cut) + 6] = cross(frames.at_b[cut], axis)
        return gather

    def jacobian(self, gather: Array, twists: Array) -> Array:
        """Time derivative of the residual per velocity, shape (rows, nv), from G and the joint Jacobians (6, nv)."""
        of_cuts = gather.dot((self.support * twists).reshape(12 * len(self.cuts), self.nv))
        return self.kept(np.concatenate([of_cuts, self._ratio_rows]) if self.ratios else of_cuts)

    def drift(self, frames: CutFrames, gather: Array, twists: Array, rates: Array, v: Array) -> Array:
        """Time derivative of the Jacobian times v, shape (rows,), [m/s2] and [rad/s2], for a closed posture.

        Args:
            twists, rates: joint Jacobians and their time derivatives, shape (6, nv).
            v: velocity, shape (nv,), with which the loops stay closed.
        """
        moving = self.moved * v
        of_cuts = gather.dot(moving.dot(rates.T).ravel())
        self._add_turning(of_cuts, frames, moving @ twists.T)
        return self.kept(np.concatenate([of_cuts, np.zeros(len(self.ratios))]) if self.ratios else of_cuts)

    def _add_turning(self, drift: Array, frames: CutFrames, twists: Array) -> None:
        """What the turning of G adds to the drift, from the twists (2 cuts, 6) of the frames."""
        rows, half = self._layout, len(self.cuts)
        w = twists[:, 3:]
        points = np.concatenate([frames.at_a, frames.at_b])
        velocity = twists[:, :3] + cross(w, points)
        inward = cross(w, velocity)
        drift[rows.point_rows] += (inward[half:] - inward[:half])[rows.point_cuts].ravel()
        for cut, row, i, j in rows.dots:
            x, y = frames.axes_a[cut, :, i], frames.axes_b[cut, :, j]
            w_a, w_b = w[cut], w[half + cut]
            drift[row] += (cross(cross(w_b, y), x) + cross(y, cross(w_a, x))) @ (w_b - w_a)
        for cut, row, i in rows.slides:
            axis, w_a = frames.axes_a[cut, :, i], w[cut]
            swing = cross(w_a, axis)
            drift[row] += (
                axis @ (inward[half + cut] - inward[cut])
                + 2.0 * swing @ (velocity[half + cut] - velocity[cut])
                + cross(w_a, swing) @ (frames.at_b[cut] - frames.at_a[cut])
            )

    def kept_rows(self, of_cuts: Array) -> Array:
        """Rows of all cuts, shape (cut rows, k), as trusted rows, those of couplings being zero, shape (rows, k)."""
        none = np.zeros((len(self.ratios), of_cuts.shape[1]))
        return self.kept(np.concatenate([of_cuts, none]))

    def spread(self, multipliers: Array) -> Array:
        """Multipliers of the trusted rows among those of all rows, which get none, shape (all rows,)."""
        spread = np.zeros(self.all_rows)
        spread[self.trusted] = multipliers
        return spread

    def kept(self, values: Array) -> Array:
        """The trusted rows among all."""
        return values if self.rows == self.all_rows else values[self.trusted]

    def gaps(self, residual: Array) -> tuple[Array, Array]:
        """Distance [m] and angle [rad] by which every cut and coupling is open, from the residual of all rows."""
        if not self.names:
            return np.zeros(0), np.zeros(0)
        if self._has_sines:
            residual = np.where(self._is_sine, np.arcsin(np.clip(residual, -1.0, 1.0)), residual)
        size = residual * residual
        lengths = np.sqrt(np.add.reduceat(size * self._all_lengths, self._starts))
        return lengths, np.sqrt(np.add.reduceat(size * ~self._all_lengths, self._starts))


class _Layout:
    """Which rows are of which kind, and the entries of G that are the same in every posture."""

    def __init__(self, cuts: tuple[Cut, ...]) -> None:
        starts = self.starts = [sum(cut.rows for cut in cuts[:index]) for index in range(len(cuts))]
        points = [i for i, cut in enumerate(cuts) if cut.type is not CutType.PRISMATIC]
        self.points = [(i, starts[i]) for i in points]
        self.point_cuts = np.array(points, dtype=int)
        self.all_points = len(points) == len(cuts)
        self.point_rows = np.array([starts[i] + k for i in points for k in range(3)], dtype=int)
        self.locks = [(i, starts[i] + cut.rows - 3) for i, cut in enumerate(cuts) if cut.type in _LOCKED]
        self.lock_cuts = np.array([i for i, _ in self.locks], dtype=int)
        self.lock_rows = np.array([row + k for _, row in self.locks for k in range(3)], dtype=int)
        self.dots = [
            (index, starts[index] + 3 + k, i, j)
            for index, cut in enumerate(cuts)
            for k, (i, j) in enumerate(_DOTS.get(cut.type, ()))
        ]
        self.hinges = [(i, starts[i] + 3) for i, cut in enumerate(cuts) if cut.type is CutType.REVOLUTE]
        self.slides = [
            (index, starts[index] + i, i)
            for index, cut in enumerate(cuts)
            if cut.type is CutType.PRISMATIC
            for i in range(2)
        ]
        self.constant = np.zeros((sum(cut.rows for cut in cuts), 12 * len(cuts)))
        # row r of the point's velocity u + w x p has p[b] w[a] - p[a] w[b], (r, a, b) in cyclic order
        width = 12 * len(cuts)
        arms = [
            ((starts[i] + r) * width + 6 * (i + half) + 3 + turn, 3 * (i + half) + arm, sign * way)
            for half, sign in ((0, -1.0), (len(cuts), 1.0))
            for i in points
            for r in range(3)
            for turn, arm, way in (((r + 1) % 3, (r + 2) % 3, 1.0), ((r + 2) % 3, (r + 1) % 3, -1.0))
        ]
        self.arm_entries = np.array([entry for entry, _, _ in arms], dtype=int)
        self.arm_of = np.array([arm for _, arm, _ in arms], dtype=int)
        self.arm_sign = np.array([sign for _, _, sign in arms])
        for side, sign in ((0, -1.0), (6 * len(cuts), 1.0)):
            for i in points:
                for k in range(3):
                    self.constant[starts[i] + k, side + 6 * i + k] = sign
            for i, row in self.locks:
                for k in range(3):
                    self.constant[row + k, side + 6 * i + 3 + k] = sign


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


_LOWER, _UPPER = np.array([7, 2, 3]), np.array([5, 6, 1])
_TRACE = np.eye(3).ravel()


def _rotation_vectors(a: Array, b: Array) -> Array:
    """Rotation vectors in world axes that turn the axes a into b, shape (k, 3, 3) each, one after another, (3 k,)."""
    turn = b @ a.transpose(0, 2, 1)
    entries = turn.reshape(-1, 9)
    twice = entries.take(_LOWER, 1) - entries.take(_UPPER, 1)
    if np.vdot(twice, twice) < 1e-8 and min(entries.dot(_TRACE).tolist()) > 0.0:
        return np.asarray(0.5 * twice.ravel())  # sines of small angles, right to 1e-14, as a rule
    return np.concatenate([pin.log3(one) for one in turn])


_FIRST = np.eye(3)[:, [1, 2, 0, 2, 0, 1]]
_SECOND = np.eye(3)[:, [2, 0, 1, 1, 2, 0]]


def cross(x: Array, y: Array) -> Array:
    """Cross product of vectors, shape (3,) or (k, 3); quicker than numpy's on arrays as small as these."""
    products = x.dot(_FIRST) * y.dot(_SECOND)
    return np.asarray(products[..., :3] - products[..., 3:])
