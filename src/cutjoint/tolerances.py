"""Every tolerance of cutjoint in one table, each with its reason.  docs/tolerances.md shows it to readers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """A number, its unit and why it is what it is."""

    value: float
    unit: str
    reason: str


CLOSURE = Tolerance(
    1e-12, "m, rad", "a posture is closed to the rounding of coordinates of about a metre, times a thousand"
)
RANK = Tolerance(
    1e-7,
    "-",
    "singular values below this fraction of the largest are redundancy; CAD rounding stays below, real motion above",
)
SINGULAR = Tolerance(1e-6, "-", "below this distance to a singularity accelerations lose more than six digits")
STRIDE = Tolerance(
    0.2, "rad or link lengths", "largest predicted joint motion of one continuation step; keeps Newton on its branch"
)
SMALLEST_STEP = Tolerance(
    1e-7, "of the way", "shortest continuation step; the end of a branch is found as exactly as that"
)
TURN = Tolerance(0.5, "relative", "largest change of direction over a continuation step; a jump means another branch")
CROSSING = Tolerance(
    5e-5, "-", "at the shortest step branches that cross are nearer than this to singular, one that ends is further"
)
REGULARISATION = Tolerance(
    1e-8, "of the compliance", "of the proximal method for redundant rows: far above rounding, far below what moves"
)
DYNAMICS = Tolerance(1e-7, "relative", "constraint residual of forward dynamics against the size of its terms")
AGREEMENT = Tolerance(
    1e-10, "relative", "two independent formulations of one robot; 2e-13 is typical, the rest is conditioning"
)
ENGINE_MATRIX = Tolerance(1e-9, "relative", "the same matrices from another engine, which bounds small masses at 1e-12")
ENGINE_HARD = Tolerance(1e-6, "relative", "J_dot v by central differences of the other engine's Jacobian")
PLACEMENT = Tolerance(1e-12, "m, -", "link placements of two readers: rounding along a few joints of about a metre")
ROUNDING = Tolerance(
    1e-3, "-", "singular values and gaps at home below this are rounding of exported lengths, where they are not zero"
)
