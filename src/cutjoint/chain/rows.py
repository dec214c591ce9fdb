"""Which rows of the closure are of which kind, read from the equations of the cut types, and where they stand."""

from __future__ import annotations

import numpy as np

from cutjoint.chain.bound import BoundCut
from cutjoint.description.cuts import Kind

_TILTS = ((0, 2), (1, 2))
"""The axes of A that a hinge keeps perpendicular to which axis of B."""


class Rows:
    """The rows of all cuts, one cut after another, and the entries of G that are the same in every posture.

    Attributes:
        starts: first row of every cut.
        points, locks, hinges: cut and first row of each such equation.
        slides: cut, row and axis of A.
        dots: cut, row, axis of A, axis of B; and whether it is of a hinge.
        names, is_length, is_sine: of every row; whether it is a length, or the sine of an angle.
    """

    def __init__(self, cuts: tuple[BoundCut, ...]) -> None:
        counts = [0, *(cut.type.rows for cut in cuts)]
        self.starts = np.cumsum(counts)[:-1].tolist()
        self.count = sum(counts)
        self.names = tuple(f"{cut.name}.{label}" for cut in cuts for label in cut.type.labels)
        equations = [equation for cut in cuts for equation in cut.type.equations]
        self.is_length = [equation.is_length for equation in equations for _ in range(equation.rows)]
        self.is_sine = [equation.kind is Kind.DOT for equation in equations for _ in range(equation.rows)]
        self.points: list[tuple[int, int]] = []
        self.locks: list[tuple[int, int]] = []
        self.hinges: list[tuple[int, int]] = []
        self.slides: list[tuple[int, int, int]] = []
        self.dots: list[tuple[int, int, int, int, bool]] = []
        for index, (cut, row) in enumerate(zip(cuts, self.starts, strict=True)):
            for equation in cut.type.equations:
                match equation.kind:
                    case Kind.POINT:
                        self.points.append((index, row))
                    case Kind.LOCK:
                        self.locks.append((index, row))
                    case Kind.HINGE:
                        self.hinges.append((index, row))
                        self.dots += [(index, row + k, i, j, True) for k, (i, j) in enumerate(_TILTS)]
                    case Kind.SLIDE:
                        self.slides.append((index, row, *equation.axes))
                    case Kind.DOT:
                        self.dots.append((index, row, *equation.axes, False))
                row += equation.rows
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
                for cut, row in self.locks:
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
