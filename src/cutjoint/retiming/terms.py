"""The equation of motion along a way: with s the way length, u = s_ddot and x = s_dot^2,

    v = q' s_dot,    a = q' u + q'' x,
    effort = M q' u + (M q'' + h) x + c + f + d s_dot,

M the mass matrix, h the Coriolis vector at the velocity q' (it is quadratic in the velocity), c what holds the posture
against gravity, springs and loads, f dry friction and d damping along the way, both from the friction at two speeds.
The tool point moves with t' = J q' and t'' = J q'' + (dJ/ds) q' (J. E. Bobrow, S. Dubowsky, J. S. Gibson: Time-optimal
control of robotic manipulators along specified paths.  Int. J. Robotics Research 4(3), 1985, 3-17).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from cutjoint.arrays import Array, Frozen
from cutjoint.mechanism import NO_LOADS, Loads, Mechanism
from cutjoint.reprs import line
from cutjoint.retiming.path import WayPiece


@dataclass(frozen=True, eq=False)
class WayTerms(Frozen):
    """What is told above at the k samples of a piece of a way.

    Attributes:
        s: way length, shape (k,).
        rates, bends: q' and q'', shape (k, n).
        mass: M, shape (k, n, n).
        coriolis: h, shape (k, n).
        holding: c, shape (k, n).
        dry, damping: f and d, shape (k, n).
        tool_rates, tool_bends: t' and t'', shape (k, 3); zero without a tool.
    """

    s: Array
    rates: Array
    bends: Array
    mass: Array
    coriolis: Array
    holding: Array
    dry: Array
    damping: Array
    tool_rates: Array
    tool_bends: Array

    __repr__ = line("s", "holding", holding="N or N m")

    @property
    def per_acceleration(self) -> Array:
        """M q', shape (k, n)."""
        return np.asarray(np.einsum("kij,kj->ki", self.mass, self.rates))

    @property
    def per_square(self) -> Array:
        """M q'' + h, shape (k, n)."""
        return np.asarray(np.einsum("kij,kj->ki", self.mass, self.bends) + self.coriolis)

    def rubbed(self, robot: Mechanism, piece: WayPiece, squares: Array) -> WayTerms:
        """The same with the friction that there is about the speeds s_dot^2, shape (k,)."""
        if not robot.dissipates:
            return self
        speeds = np.sqrt(np.maximum(squares, 1e-3 * squares.max()))
        dry, damping = np.zeros_like(self.dry), np.zeros_like(self.damping)
        for i, posture in enumerate(piece.postures):
            slow, quick = (robot.terms(posture, part * speeds[i] * self.rates[i]).friction for part in (0.5, 1.0))
            damping[i] = (quick - slow) / (0.5 * speeds[i])
            dry[i] = quick - damping[i] * speeds[i]
        return replace(self, dry=dry, damping=damping)

    def between(self, s: Array) -> WayTerms:
        """Between the samples, by cubic splines."""
        values = (getattr(self, name) for name in _NAMES)
        return WayTerms(s, *(np.asarray(CubicSpline(self.s, one)(s)) for one in values))


_NAMES = (
    "rates",
    "bends",
    "mass",
    "coriolis",
    "holding",
    "dry",
    "damping",
    "tool_rates",
    "tool_bends",
)


def terms_along(robot: Mechanism, piece: WayPiece, loads: Loads = NO_LOADS) -> WayTerms:
    """The terms at the samples of a piece, without friction.

    Raises:
        SingularError, ActuationError: a posture of the way is singular, or the actuators do not determine the motion.
        InputError, UnknownNameError: the loads are none, or act where the robot has no place.
    """
    rates, bends = piece.at(piece.s, 1), piece.at(piece.s, 2)
    rows = []
    for posture, rate, bend in zip(piece.postures, rates, bends, strict=True):
        terms = robot.terms(posture, rate)
        tool = np.zeros(3), np.zeros(3)
        if has_tool(robot):
            here = robot.tool(posture, rate)
            tool = here.jacobian @ rate, here.jacobian @ bend + here.frame_drift[:3]
        holding = terms.holding if loads is NO_LOADS else terms.holding - robot.load_effort(posture, loads)
        rows.append((terms.mass, terms.coriolis, holding, *tool))
    mass, coriolis, holding, tool_rates, tool_bends = (np.array(one) for one in zip(*rows, strict=True))
    none = np.zeros_like(rates)
    return WayTerms(piece.s, rates, bends, mass, coriolis, holding, none, none, tool_rates, tool_bends)


def has_tool(robot: Mechanism) -> bool:
    """Whether a robot has a tool."""
    description = getattr(robot, "description", None) or getattr(getattr(robot, "chain", None), "description", None)
    return description is None or description.tool is not None
