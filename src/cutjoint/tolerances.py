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
    1e-12,
    "of the longest way, rad",
    "a posture is closed to the rounding of its coordinates, times a thousand; lengths by the longest way to a frame",
)
RANK = Tolerance(
    1e-7,
    "-",
    "singular values below this fraction of the largest (or of 1) are redundancy: rounding of closed loops lies below",
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
    1e-6, "of the compliance", "of the proximal method for redundant rows: far above rounding, far below what moves"
)
CONVERGED = Tolerance(1e-11, "relative", "what the proximal method may leave of K a + gamma; more is solved directly")
DYNAMICS = Tolerance(
    1e-9, "relative", "residuals of both equations of forward dynamics against the sum of the sizes of their terms"
)
ROUNDED = Tolerance(
    1e-12, "of the loads", "forces that cancel leave rounding of what was added up, times a few thousand"
)
STRESSED = Tolerance(
    1e-8, "-", "internal stresses of size 1 that do less to a reaction do nothing: rounding by the smallest rank"
)
REACHED = Tolerance(
    1e-7, "relative", "part of a motion or force that may stay out of the actuators' or the tool's reach"
)
AGREEMENT = Tolerance(
    1e-10, "relative", "two independent formulations of one robot; 2e-13 is typical, the rest is conditioning"
)
ENGINE_MATRIX = Tolerance(
    1e-9, "relative", "the same matrices from another engine, which lifts masses below 1e-12 of the heaviest"
)
ENGINE_HARD = Tolerance(1e-6, "relative", "J_dot v by central differences of the other engine's Jacobian")
ENGINE_SOLVER = Tolerance(
    1e-7, "relative", "a soft solver at its impedance of 0.9999: 1e-11 of the mass matrix, times the 1e4 of 1 / (1 - d)"
)
ENGINE_LEAK = Tolerance(
    0.02, "relative", "of what constraints stop a soft solver lets 1e-4 through a row, to 6e-3 where rows work together"
)
PLACEMENT = Tolerance(
    1e-12, "lengths, -", "link placements of two readers: rounding along a few joints of about a length of the robot"
)
ROUNDING = Tolerance(
    1e-3, "-", "rows whose singular values are above this are never dropped as rounding of exported lengths"
)
ROUNDED_GAP = Tolerance(
    1e-4,
    "of the longest way",
    "rounding of exported lengths leaves loops no further open than this; beyond, frames are wrong",
)
RESTING = Tolerance(
    1e-6, "lengths, rad", "joints that start at or beyond a limit and are to rest there go as far by errors of a run"
)
COMMANDED = Tolerance(
    1e-2, "of the fastest", "directions in which a tool moves less are side effects, or rounding; tasks are not as slow"
)
DISTINCT = Tolerance(
    1e-5, "link lengths, -", "postures closed to CLOSURE scatter by its root, 1e-6, near a double one; modes are apart"
)
RUN_GAP = Tolerance(
    1e-8, "robot's lengths", "loops of a run: states are put back to CLOSURE, between them to the error of a step"
)
RUN_OPEN = Tolerance(
    1e-5, "robot's lengths", "loops open by more are as if links were longer or shorter than any machine is built to"
)
RUN_STRAYED = Tolerance(
    1e-5, "robot's lengths", "what putting back a step moves: less is below what any machine is built to"
)
RUN_DRIFT = Tolerance(
    1e-5,
    "of the energy turned over",
    "runs at default tolerances stay below 1e-8, near singular postures 1e-6; what keeps to this is right to 1e-3",
)
RUN_WRONG = Tolerance(
    1e-2, "of the energy turned over", "a run that loses or makes so much energy shows another motion"
)
RUN_AGREE = Tolerance(
    1e-3, "of their sizes", "columns of one run agree up to what samples leave open, which is taken off; this is room"
)
RUN_SATURATED = Tolerance(
    1e-2, "of the time", "a short start at the limits is usual; longer, the law's own behaviour is not what is seen"
)
