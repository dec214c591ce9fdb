"""Cut joints and couplings bound to a model: joint indices and placements in place of the names of links and joints,
and which rows of the closure are of which kind, read from the equations of the cut types."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import bind_frame
from cutjoint.chain.joints import support, type_of
from cutjoint.description.curves import Curve, CurvePoint
from cutjoint.description.cuts import Kind, slide
from cutjoint.description.model import Coupling, CutJoint, CutType
from cutjoint.errors import UnknownNameError

_TILTS = ((0, 2), (1, 2))
"""The axes of A that a hinge keeps perpendicular to which axis of B."""


@dataclass(frozen=True, eq=False)
class BoundCut:
    """A cut joint: the joints that carry its frames, the frames in them, and what moves these, shape (nv,) each."""

    name: str
    type: CutType
    joint_a: int
    placement_a: pin.SE3
    joint_b: int
    placement_b: pin.SE3
    support_a: Array
    support_b: Array
    length: float = 0.0

    @staticmethod
    def of(model: pin.Model, cut: CutJoint) -> BoundCut:
        """A cut of the description that the model was built from."""
        (joint_a, placement_a), (joint_b, placement_b) = bind_frame(model, cut.a), bind_frame(model, cut.b)
        supports = support(model, joint_a), support(model, joint_b)
        return BoundCut(cut.name, cut.type, joint_a, placement_a, joint_b, placement_b, *supports, cut.length)


@dataclass(frozen=True)
class BoundCoupling:
    """A coupling: the first coordinate, less the curves of the others and an offset, is zero.

    Attributes:
        q_index, v_index: of the coordinates in a configuration, and of their velocities.
        curves: of each coordinate after the first.
        offset: [m] or [rad].
        is_length: whether the sum is a length; it is measured like the first coordinate.
        linear: whether all curves are straight lines.
    """

    name: str
    q_index: tuple[int, ...]
    v_index: tuple[int, ...]
    curves: tuple[Curve, ...]
    offset: float
    is_length: bool
    linear: bool

    @staticmethod
    def of(model: pin.Model, coupling: Coupling) -> BoundCoupling:
        """A coupling of the description that the model was built from.

        Raises:
            UnknownNameError: a joint of it does not move, or is not there.
        """
        known = list(model.names)[1:]
        for name in (coupling.joint, *coupling.drivers):
            if name not in known:
                raise UnknownNameError(f"joint of coupling '{coupling.name}'", name, known)
        joints = [model.getJointId(name) for name in (coupling.joint, *coupling.drivers)]
        curves = tuple(one.curve for one in coupling.drives)
        return BoundCoupling(
            coupling.name,
            tuple(int(model.idx_qs[joint]) for joint in joints),
            tuple(int(model.idx_vs[joint]) for joint in joints),
            curves,
            coupling.offset,
            type_of(model, joints[0]).slides,
            all(len(one.pieces) == 1 and not any(one.pieces[0].coefficients[2:]) for one in curves),
        )

    def residual(self, q: Array) -> float:
        """What the sum is at a configuration (nq,), [m] or [rad]."""
        return float(q[self.q_index[0]] - sum(one.value for one in self._driven(q)) - self.offset)

    def row(self, q: Array, nv: int) -> Array:
        """Its derivative, shape (nv,)."""
        row = np.zeros(nv)
        np.add.at(row, list(self.v_index), [1.0, *(-one.slope for one in self._driven(q))])
        return row

    def drift(self, q: Array, v: Array) -> float:
        """Time derivative of the row times v, [m/s2] or [rad/s2]."""
        bends = (one.bend for one in self._driven(q))
        return -float(sum(bend * v[i] ** 2 for bend, i in zip(bends, self.v_index[1:], strict=True)))

    def _driven(self, q: Array) -> list[CurvePoint]:
        return [curve.at(float(q[i])) for curve, i in zip(self.curves, self.q_index[1:], strict=True)]


class Rows:
    """The rows of all cuts, one cut after another, and the entries of G that are the same in every posture.

    Attributes:
        starts: first row of every cut.
        points, locks, hinges: cut and first row of each such equation.
        slides: cut, row and axis of A.
        dots: cut, row, axis of A, axis of B; and whether it is of a hinge.
        distances: cut, row and length.
        names, is_length, is_sine: of every row; whether it is a length, or the sine of an angle.
        along_a: whether rows of points and locks are components along the axes of frame A, not along those of the
            world: points are three slides then.
    """

    def __init__(self, cuts: tuple[BoundCut, ...], along_a: bool = False) -> None:
        self.along_a = along_a
        instead = {Kind.POINT: tuple(map(slide, range(3)))} if along_a else {}
        counts = [0, *(cut.type.rows for cut in cuts)]
        self.starts = np.cumsum(counts)[:-1].tolist()
        self.names = tuple(f"{cut.name}.{label}" for cut in cuts for label in cut.type.labels)
        equations = [
            (index, equation)
            for index, cut in enumerate(cuts)
            for one in cut.type.equations
            for equation in instead.get(one.kind, (one,))
        ]
        *first, self.count = np.cumsum([0, *(equation.rows for _, equation in equations)]).tolist()
        self.is_length = [equation.is_length for _, equation in equations for _ in equation.labels]
        self.is_sine = [equation.kind is Kind.DOT for _, equation in equations for _ in equation.labels]
        at = [(cut, row, equation) for (cut, equation), row in zip(equations, first, strict=True)]
        self.points, self.locks, self.hinges = (
            [(cut, row) for cut, row, equation in at if equation.kind is kind]
            for kind in (Kind.POINT, Kind.LOCK, Kind.HINGE)
        )
        self.slides = [(cut, row, *one.axes) for cut, row, one in at if one.kind is Kind.SLIDE]
        self.dots = [(cut, row + k, *tilt, True) for cut, row in self.hinges for k, tilt in enumerate(_TILTS)]
        self.dots += [(cut, row, *one.axes, False) for cut, row, one in at if one.kind is Kind.DOT]
        self.distances = [(cut, row, cuts[cut].length) for cut, row, one in at if one.kind is Kind.DISTANCE]
        self.point_cuts = np.array([cut for cut, _ in self.points], dtype=int)
        self.all_points = self.point_cuts.tolist() == list(range(len(cuts)))
        self.point_rows = np.array([row + k for _, row in self.points for k in range(3)], dtype=int)
        self.lock_cuts = np.array([cut for cut, _ in self.locks], dtype=int)
        self.lock_rows = np.array([row + k for _, row in self.locks for k in range(3)], dtype=int)
        self._fill(len(cuts))

    def _fill(self, cuts: int) -> None:
        """The constant entries of G, and which entries are arms of points, of which coordinate, with which sign."""
        width = 12 * cuts
        self.constant = np.zeros((self.count, width))
        for side, sign in ((0, -1.0), (6 * cuts, 1.0)):
            for k in range(3):
                for cut, row in self.points:
                    self.constant[row + k, side + 6 * cut + k] = sign
                for cut, row in () if self.along_a else self.locks:
                    self.constant[row + k, side + 6 * cut + 3 + k] = sign
        # row r of the point's velocity u + w x p has p[b] w[a] - p[a] w[b], (r, a, b) in cyclic order
        arms = [
            ((row + r) * width + 6 * (cut + half) + 3 + turn, 3 * (cut + half) + arm, sign * way)
            for half, sign in ((0, -1.0), (cuts, 1.0))
            for cut, row in self.points
            for r in range(3)
            for turn, arm, way in (((r + 1) % 3, (r + 2) % 3, 1.0), ((r + 2) % 3, (r + 1) % 3, -1.0))
        ]
        self.arm_entries = np.array([entry for entry, _, _ in arms], dtype=int)
        self.arm_of = np.array([arm for _, arm, _ in arms], dtype=int)
        self.arm_sign = np.array([sign for _, _, sign in arms])
