"""What cuts do by themselves: along what they leave free, and along their equations where they are bushings.

The rows of a bushing are the exact gradient of half their sum of squares however far its frames are apart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cutjoint.compile.equations.acting import Acting, Coefficients, OnBall, OnCoordinate, OnRow
from cutjoint.compile.equations.cut_rows import WRITTEN, Relative
from cutjoint.compile.equations.turning import between, leaning, size_of
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import maximum
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import column, dot, scale
from cutjoint.description.cuts import Equation, Freedom, Kind, slide
from cutjoint.description.model import CutJoint

Strained = tuple[Acting, Number]
"""What acts along a freedom, and the strain of it."""
Row = dict[int, Number]


def free(at: Relative, cut: CutJoint, numbers: Coefficients) -> tuple[list[Acting], Number]:
    """What acts along the motion that a rigid cut leaves free, and the strain of it."""
    found = [FREE[freedom](at, numbers) for freedom in cut.type.freedoms]
    return [one for one, _ in found], _worst([strain for _, strain in found])


def bushed(at: Relative, cut: CutJoint, given: Mapping[str, Number]) -> tuple[list[Acting], Number]:
    """What a bushing does, and the strain of it."""
    acting: list[Acting] = []
    strains: list[Number] = []
    for equation in cut.type.equations:
        first = "" if equation.is_length else "turning_"
        stiffness, damping = (
            given.get(f"cuts.{cut.name}.bushing.{name}", float(getattr(cut.bushing, name)))
            for name in (f"{first}stiffness", f"{first}damping")
        )
        rows, strain = _stretched(at, equation)
        acting += [OnRow(row, left, stiffness, damping) for row, left in rows]
        strains.append(strain)
    return acting, _worst(strains)


def _worst(strains: list[Number]) -> Number:
    worst: Number = 0.0
    for strain in strains:
        worst = maximum(worst, strain)
    return worst


def _stretched(at: Relative, equation: Equation) -> tuple[list[tuple[Row, Number]], Number]:
    """Rows of an equation, by how much each is open, and the strain of it."""
    match equation.kind:
        case Kind.LOCK:
            turned, strain = between(at.a.axes, at.b.axes)
            return [({u: one[k] for u, one in at.angular.items()}, turned[k]) for k in range(3)], strain
        case Kind.HINGE:
            lean, strain = leaning(column(at.a.axes, 2), column(at.b.axes, 2))
            return [
                (at.turning(axis), dot(axis, lean)) for axis in (column(at.a.axes, 0), column(at.a.axes, 1))
            ], strain
        case Kind.DISTANCE:
            size = size_of(at.apart)
            along = scale(1.0 / size, at.apart)
            # where the ends meet, the spring has no direction
            return [({u: dot(along, one) for u, one in at.velocity.items()}, size - at.length)], at.length / size
        case _:
            return [(row, left) for row, _, left in WRITTEN[equation.kind](at, equation)], 0.0


# -- the freedoms ----------------------------------------------------------------------------------------------------


def _slide(at: Relative, numbers: Coefficients) -> Strained:
    ((row, _, travel),) = WRITTEN[Kind.SLIDE](at, slide(2))
    return OnCoordinate(row, travel, numbers), 0.0


def _turn(at: Relative, numbers: Coefficients) -> Strained:
    x, y, z = (column(at.a.axes, k) for k in range(3))
    of_b = column(at.b.axes, 0)
    return OnCoordinate(at.turning(z), functions.atan2(dot(y, of_b), dot(x, of_b)), numbers), 0.0


def _turn_of_a(at: Relative, numbers: Coefficients) -> Strained:
    x, y, z = (column(at.a.axes, k) for k in range(3))
    of_b = column(at.b.axes, 1)
    return OnCoordinate(at.turning(x), functions.atan2(dot(z, of_b), dot(y, of_b)), numbers), 0.0


def _turn_of_b(at: Relative, numbers: Coefficients) -> Strained:
    x, y, z = (column(at.b.axes, k) for k in range(3))
    of_a = column(at.a.axes, 0)
    return OnCoordinate(at.turning(y), functions.atan2(dot(of_a, z), dot(of_a, x)), numbers), 0.0


def _ball(at: Relative, numbers: Coefficients) -> Strained:
    turned, strain = between(at.a.axes, at.b.axes)
    return OnBall(at.angular, turned, numbers), 0.0 if functions.is_zero(numbers.stiffness) else strain


FREE: Mapping[Freedom, Callable[[Relative, Coefficients], Strained]] = {
    Freedom.SLIDE: _slide,
    Freedom.TURN: _turn,
    Freedom.TURN_OF_A: _turn_of_a,
    Freedom.TURN_OF_B: _turn_of_b,
    Freedom.BALL: _ball,
}
"""What a cut may leave free -> what acts along it."""
