"""The cut joints as equations: residual, Jacobian and drift of every row, for all cut types.

Each cut joins frame A on one body to frame B on another.  Its type says which equations it holds
(`cutjoint.description.cuts`); here is what each kind of them is in numbers:

- point: the three components of p_B - p_A vanish
- slide: an axis of A . (p_B - p_A) = 0
- lock: the rotation vector log(R_A' R_B) vanishes
- dot: an axis of A stays perpendicular to one of B
- hinge: x_A and y_A stay perpendicular to z_B, stretched from the sine to the angle between z_A and z_B, so that
  opposite axes do not count as closed
- distance: the length of p_B - p_A is that of the cut

Every row is linear in the twists of the bodies that it joins (about the world origin, in world axes), so one matrix G
over the twists of all cut frames says it all: K = G J with J the joint Jacobians of those bodies, and the drift is
G (dJ/dt v) plus what the turning of G adds.  Nothing here is a finite difference.  Couplings add one row each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.bound import BoundCoupling, BoundCut, Rows
from cutjoint.description.cuts import Kind
from cutjoint.description.model import RobotDescription


@dataclass(frozen=True, eq=False)
class CutFrames:
    """World axes (cuts, 3, 3) and origins (cuts, 3) of the frames a and b of all cuts, in the order of the cuts."""

    axes_a: Array
    axes_b: Array
    at_a: Array
    at_b: Array


class Closure:
    """All cuts and couplings of a robot as one system of equations; a value, it holds no workspace.

    The cuts are those that close loops; bushings do not.

    Args:
        trusted: indices of the rows to work with; default all.  The others are left to be met by the geometry.  Where
            they are given, rows of points and locks are components along the axes of frame A, which go along where the
            robot moves: what is left out must be the same direction in every posture.
    """

    def __init__(self, model: pin.Model, description: RobotDescription, trusted: Array | None = None) -> None:
        self.nv = int(model.nv)
        self.cuts = tuple(BoundCut.of(model, cut) for cut in description.closing)
        self.couplings = tuple(BoundCoupling.of(model, coupling) for coupling in description.couplings)
        self.along_a = trusted is not None
        self._rows = rows = Rows(self.cuts, self.along_a)
        self.all_rows = rows.count + len(self.couplings)
        self.trusted = np.arange(self.all_rows) if trusted is None else np.array(trusted, dtype=int)
        self.rows = len(self.trusted)
        gears = tuple(coupling.name for coupling in self.couplings)
        every = (*rows.names, *gears)
        self.row_names = tuple(every[i] for i in self.trusted)
        self.left_out = tuple(every[i] for i in range(self.all_rows) if i not in set(self.trusted.tolist()))
        self.all_lengths = np.array(rows.is_length + [one.is_length for one in self.couplings], dtype=bool)
        self.is_length = self.all_lengths[self.trusted]
        self.names = (*(cut.name for cut in self.cuts), *gears)
        self._is_sine = np.array([*rows.is_sine, *(False for _ in gears)], dtype=bool)
        self._has_sines = bool(self._is_sine.any())
        self.support = np.array([cut.support_a for cut in self.cuts] + [cut.support_b for cut in self.cuts])
        self.support = self.support.reshape(2 * len(self.cuts), 1, self.nv)
        self.moved = self.support[:, 0]
        self.turns = any(Kind.LOCK not in cut.type.kinds for cut in self.cuts)
        self.linear = all(one.linear for one in self.couplings)
        self.holds_points = not (rows.slides or rows.dots or rows.distances) and self.linear
        self._starts = np.array([*rows.starts, *range(rows.count, self.all_rows)], dtype=int)
        self._coupled = self._coupled_rows(np.zeros(int(model.nq)))

    def told(self, name: str) -> str:
        """A cut or coupling in words, as messages have it."""
        return f"{'cut' if any(one.name == name for one in self.cuts) else 'coupling'} '{name}'"

    @cached_property
    def apart(self) -> Array:
        """Differences of the origins of frames b and a as rows of the cuts, shape (cut rows, 6 cuts)."""
        found = np.zeros((self._rows.count, 6 * len(self.cuts)))
        for cut, row in self._rows.points:
            found[row : row + 3, 3 * cut : 3 * cut + 3] = -np.eye(3)
            found[row : row + 3, 3 * (len(self.cuts) + cut) :][:, :3] = np.eye(3)
        return found

    def residual(self, frames: CutFrames, q: Array) -> Array:
        """Residual of all rows, trusted or not, shape (all rows,), [m] and [rad] (dot: sine of the angle)."""
        rows = self._rows
        residual = np.empty(self.all_rows)
        apart = frames.at_b - frames.at_a
        residual[rows.point_rows] = (apart if rows.all_points else apart.take(rows.point_cuts, 0)).ravel()
        if rows.locks:
            axes_a = frames.axes_a[rows.lock_cuts]
            turned = _rotation_vectors(axes_a, frames.axes_b[rows.lock_cuts])
            if self.along_a:
                turned = np.einsum("kji,kj->ki", axes_a, turned.reshape(-1, 3)).ravel()
            residual[rows.lock_rows] = turned
        for cut, row, i in rows.slides:
            residual[row] = frames.axes_a[cut, :, i] @ apart[cut]
        for cut, row, i, j, _ in rows.dots:
            residual[row] = frames.axes_a[cut, :, i] @ frames.axes_b[cut, :, j]
        for cut, row in rows.hinges:
            cosine = float(frames.axes_a[cut, :, 2] @ frames.axes_b[cut, :, 2])
            residual[row : row + 2] = _stretched(residual[row : row + 2], cosine)
        for cut, row, length in rows.distances:
            residual[row] = float(np.linalg.norm(apart[cut])) - length
        for row, coupling in enumerate(self.couplings, start=rows.count):
            residual[row] = coupling.residual(q)
        return residual

    def gather(self, frames: CutFrames) -> Array:
        """G: the rows of the cuts over the twists of their frames a, then b, shape (cut rows, 12 cuts).

        Exact also while the loops are open, but for those of locks and hinges, which are exact where
        they are closed and elsewhere still have the exact gradient of their sum of squares.
        """
        rows, count = self._rows, len(self.cuts)
        gather = rows.constant.copy()
        if len(rows.point_cuts):
            arms = np.concatenate([frames.at_a, frames.at_b]).ravel()
            gather.reshape(-1)[rows.arm_entries] = arms[rows.arm_of] * rows.arm_sign
        for cut, row in rows.locks if self.along_a else ():
            for side, sign in ((cut, -1.0), (count + cut, 1.0)):
                gather[row : row + 3, 6 * side + 3 : 6 * side + 6] = sign * frames.axes_a[cut].T
        for cut, row, i, j, of_hinge in rows.dots:
            axis = (frames.axes_a if of_hinge else frames.axes_b)[cut, :, j]
            normal = cross(axis, frames.axes_a[cut, :, i])
            gather[row, 6 * cut + 3 : 6 * cut + 6] = -normal
            gather[row, 6 * (count + cut) + 3 : 6 * (count + cut) + 6] = normal
        for cut, row, i in rows.slides:
            axis = frames.axes_a[cut, :, i]
            line = np.concatenate([axis, cross(frames.at_b[cut], axis)])
            gather[row, 6 * cut : 6 * cut + 6] = -line
            gather[row, 6 * (count + cut) : 6 * (count + cut) + 6] = line
        for cut, row, _ in rows.distances:
            along = direction(frames.at_b[cut] - frames.at_a[cut])
            for at, side, sign in ((frames.at_a, cut, -1.0), (frames.at_b, count + cut, 1.0)):
                gather[row, 6 * side : 6 * side + 6] = sign * np.concatenate([along, cross(at[cut], along)])
        return gather

    def jacobian(self, gather: Array, twists: Array, q: Array) -> Array:
        """Time derivative of the residual per velocity, shape (rows, nv), from G, the joint Jacobians (6, nv) and the
        configuration (nq,)."""
        return self.kept(self.jacobian_of_all(gather, twists, q))

    def jacobian_of_all(self, gather: Array, twists: Array, q: Array) -> Array:
        """The same of all rows, trusted or not, shape (all rows, nv)."""
        of_cuts = gather.dot((self.support * twists).reshape(12 * len(self.cuts), self.nv))
        if not self.couplings:
            return np.asarray(of_cuts)
        return np.concatenate([of_cuts, self._coupled if self.linear else self._coupled_rows(q)])

    def _coupled_rows(self, q: Array) -> Array:
        return np.array([one.row(q, self.nv) for one in self.couplings]).reshape(len(self.couplings), self.nv)

    def drift(self, frames: CutFrames, gather: Array, twists: Array, rates: Array, q: Array, v: Array) -> Array:
        """Time derivative of the Jacobian times v, shape (rows,), [m/s2] and [rad/s2], for a closed posture.

        Args:
            twists, rates: joint Jacobians and their time derivatives, shape (6, nv).
            q: configuration, shape (nq,).
            v: velocity, shape (nv,), with which the loops stay closed.
        """
        moving = self.moved * v
        of_cuts = gather.dot(moving.dot(rates.T).ravel())
        self._add_turning(of_cuts, frames, moving @ twists.T)
        if not self.couplings:
            return self.kept(of_cuts)
        return self.kept(np.concatenate([of_cuts, [one.drift(q, v) for one in self.couplings]]))

    def _add_turning(self, drift: Array, frames: CutFrames, twists: Array) -> None:
        """What the turning of G adds to the drift, from the twists (2 cuts, 6) of the frames."""
        rows, half = self._rows, len(self.cuts)
        w = twists[:, 3:]
        points = np.concatenate([frames.at_a, frames.at_b])
        velocity = twists[:, :3] + cross(w, points)
        inward = cross(w, velocity)
        drift[rows.point_rows] += (inward[half:] - inward[:half])[rows.point_cuts].ravel()
        for cut, row in rows.locks if self.along_a else ():
            drift[row : row + 3] -= frames.axes_a[cut].T @ cross(w[cut], w[half + cut])
        for cut, row, i, j, _ in rows.dots:
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
        for cut, row, _ in rows.distances:
            apart, speed = frames.at_b[cut] - frames.at_a[cut], velocity[half + cut] - velocity[cut]
            along = direction(apart)
            across = speed - (along @ speed) * along
            drift[row] += along @ (inward[half + cut] - inward[cut]) + across @ across / np.linalg.norm(apart)

    def travelled(self, frames: CutFrames, twists: Array, q: Array, motion: Array) -> Array:
        """How far a motion (nv,) of the joints, each added up by itself, moves frame B of every row's cut against frame
        A, shape (rows,), [m] and [rad]: what cancels in a row that depends on others."""
        loop, turns = self.moved[: len(self.cuts)] != self.moved[len(self.cuts) :], np.abs(motion)
        places = np.concatenate([frames.at_a, frames.at_b])[:, None]
        arms = np.linalg.norm(twists[:3].T + np.cross(twists[3:].T, places), axis=2).reshape(2, *loop.shape)
        length, angle = (arms.max(axis=0) * loop) @ turns, (np.linalg.norm(twists[3:], axis=0) * loop) @ turns
        ends = np.diff([*self._starts[: len(self.cuts)], self._rows.count])
        of_cuts = np.where(self.all_lengths[: self._rows.count], np.repeat(length, ends), np.repeat(angle, ends))
        return self.kept(np.concatenate([of_cuts, np.abs(self._coupled_rows(q)) @ turns]))

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
        lengths = np.sqrt(np.add.reduceat(size * self.all_lengths, self._starts))
        return lengths, np.sqrt(np.add.reduceat(size * ~self.all_lengths, self._starts))


_FIRST = np.eye(3)[:, [1, 2, 0, 2, 0, 1]]
_SECOND = np.eye(3)[:, [2, 0, 1, 1, 2, 0]]
_LOWER, _UPPER = np.array([7, 2, 3]), np.array([5, 6, 1])
_TRACE = np.eye(3).ravel()


def cross(x: Array, y: Array) -> Array:
    """Cross product of vectors, shape (3,) or (k, 3); quicker than numpy's on arrays as small as these."""
    products = x.dot(_FIRST) * y.dot(_SECOND)
    return np.asarray(products[..., :3] - products[..., 3:])


def direction(apart: Array) -> Array:
    """The unit vector along a difference of points, shape (3,); along x where they coincide."""
    length = float(np.linalg.norm(apart))
    return apart / length if length > 0.0 else np.eye(3)[0]


def _stretched(sines: Array, cosine: float) -> Array:
    """The two components of the sine of the angle between two unit vectors, stretched to the angle, shape (2,)."""
    sine = float(np.hypot(sines[0], sines[1]))
    if sine > 1e-12:
        return sines * (float(np.arctan2(sine, cosine)) / sine)
    return sines if cosine > 0.0 else np.array([np.pi, 0.0])


def _rotation_vectors(a: Array, b: Array) -> Array:
    """Rotation vectors in world axes that turn the axes a into b, shape (k, 3, 3) each, one after another, (3 k,)."""
    turn = b @ a.transpose(0, 2, 1)
    entries = turn.reshape(-1, 9)
    twice = entries.take(_LOWER, 1) - entries.take(_UPPER, 1)
    if np.vdot(twice, twice) < 1e-8 and min(entries.dot(_TRACE).tolist()) > 0.0:
        return np.asarray(0.5 * twice.ravel())  # sines of small angles, right to 1e-14, as a rule
    return np.concatenate([pin.log3(one) for one in turn])
