"""What leads a robot whose actuators do not determine its motion about home: see `cutjoint.control.led`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from cutjoint import tolerances
from cutjoint.arrays import Array, positive
from cutjoint.chain import ClosedChain
from cutjoint.control.led import LedActuators
from cutjoint.errors import ActuationError, CutjointError
from cutjoint.mechanism import Posture

SIZE = 0.03
"""How far the actuators go out, in lengths of the robot or radians."""
PARTS = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25, 1 / 16, -1 / 16)
"""Of that way, tried one after the other."""
DEGREE = 6
"""Of the polynomials along the way, whose error is far below the way where actuators depend on each other."""


class Leading(NamedTuple):
    """A law, and what it does in words, a sentence each."""

    law: LedActuators
    told: tuple[str, ...]


class _Way(NamedTuple):
    """A way of the actuators and the efforts along it, polynomials of shape (k, n) each."""

    way: Array
    holding: Array
    words: str


def led(chain: ClosedChain, seconds: float, kp: float, kd: float, size: float = SIZE) -> Leading:
    """What leads the actuators of `chain` about home, out by `size` (lengths of the robot or radians) and back in
    `seconds` [s].

    Raises:
        InputError: `size` or `seconds` is not > 0.
        ActuationError: there is no actuator.
        DynamicsError: home is no regular posture.
    """
    positive("size", size, "robot lengths or rad")
    positive("seconds", seconds, "s")
    report = chain.mobility()
    freedoms = report.mobility - report.idle_mobility
    if chain.n == 0:
        raise ActuationError(f"{chain.name} has no actuator", mobility=freedoms, actuators=0, free=report.free)
    answer, falling = _answer(chain)
    inertia = np.asarray(np.linalg.pinv(answer, rcond=tolerances.RANK.value, hermitian=True), dtype=np.float64)
    driven = int(np.linalg.matrix_rank(answer, tol=tolerances.RANK.value * np.linalg.norm(answer, 2), hermitian=True))
    least = -inertia @ falling
    found = _dependent(chain, size) if driven < chain.n else _independent(chain, least, size)
    way = found or _Way(chain.home.q[None], least[None], "held at home")
    told = [f"actuators {way.words}"]
    if driven < freedoms:
        free = ", ".join(report.free[:4]) + (", ..." if len(report.free) > 4 else "")
        told.append(f"{driven} of {freedoms} freedoms are driven, so the rest moves as it likes ({free})")
    if driven < chain.n:
        told.append(f"{chain.n} actuators do the work of {driven}, so their efforts are the least that do")
    return Leading(LedActuators(way.way, way.holding, inertia, kp, kd, seconds), tuple(told))


def _answer(chain: ClosedChain) -> tuple[Array, Array]:
    """G, the accelerations of the actuators by unit efforts, shape (n, n), and a_0, those without any, shape (n,)."""
    still = np.zeros(chain.nv)

    def accelerations(effort: Array) -> Array:
        full = chain.full_forward_dynamics(chain.home, still, chain.full_effort(effort)).acceleration
        return chain.actuated_velocity(full)

    falling = accelerations(np.zeros(chain.n))
    columns = [accelerations(one) - falling for one in np.eye(chain.n)]
    answer = np.column_stack(columns)
    return 0.5 * (answer + answer.T), falling


def _independent(chain: ClosedChain, holding: Array, size: float) -> _Way | None:
    """All actuators, which do not depend on each other, straight out, each to the side where its limits let it."""
    model, home = chain.model, chain.home.q
    units = np.array([1.0 if one.kind == "rotation" else chain.length for one in chain.actuators])
    rows = np.rint(chain.actuated_velocity(np.arange(chain.nv, dtype=np.float64))).astype(int)
    places = {int(model.idx_vs[joint]): int(model.idx_qs[joint]) for joint in range(1, model.njoints)}
    lower, upper = (
        np.array([bounds[places[row]] if row in places else far for row in rows])
        for bounds, far in ((model.lowerPositionLimit, -np.inf), (model.upperPositionLimit, np.inf))
    )
    way = np.zeros(chain.n)
    for k in range(chain.n):
        ways = (part * size * units[k] for part in PARTS)
        way[k] = next(
            (one for one in ways if lower[k] <= home[k] <= upper[k] and lower[k] <= home[k] + one <= upper[k]), 0.0
        )
    if not way.any():
        return None
    return _Way(np.array([home, way]), holding[None], _words(way, units))


def _dependent(chain: ClosedChain, size: float) -> _Way | None:
    """Actuators that depend on each other: led by those of them that tell the rest; None where that cannot be."""
    try:
        minimal = chain.minimal()
        own = np.abs(minimal.effort_map(chain.home)).sum(axis=1) > 0.0
        units = np.array([1.0 if unit == "rad" else chain.length for unit in minimal.units])
        for part in PARTS:
            end = own * part * size * units
            parts = 0.5 - 0.5 * np.cos(np.pi * (np.arange(DEGREE + 3) + 0.5) / (DEGREE + 3))
            postures = _along(chain, [minimal.moved(chain.home, s * end) for s in parts])
            if postures is None:
                continue
            still = np.zeros(minimal.n)
            efforts = [minimal.efforts(at, still, still).effort for at in postures]
            way = np.asarray(polynomial.polyfit(parts, np.array([at.q for at in postures]), DEGREE), dtype=np.float64)
            holding = np.asarray(polynomial.polyfit(parts, np.array(efforts), DEGREE), dtype=np.float64)
            return _Way(way, holding, _words(end, units))
    except CutjointError:
        return None
    return None


def _along(chain: ClosedChain, postures: list[Posture]) -> list[Posture] | None:
    """The postures where no joint is beyond its limits."""
    return None if any(chain.limit_violations(at) for at in postures) else postures


def _words(way: Array, units: Array) -> str:
    most = float(np.abs(way / units).max())
    return f"led out by {most:.3g} rad or robot lengths and back"
