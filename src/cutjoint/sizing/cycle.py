"""One trajectory, sized: peaks, root mean squares and energies of every actuator, and how well the energies balance.

The work of the actuators must be what kinetic and potential energy gain, friction takes, and the loads do not give:

    sum of the integrals of effort v = change of (kinetic + potential) + integral of friction v - integral of load v

The energies are told by the model on their own, so the difference, looked at after every piece of the way, tells how
exact both the efforts and their integrals are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import Actuator, kinetic_energy
from cutjoint.motion import Reference
from cutjoint.sizing.breaks import breaks_of, is_fine
from cutjoint.sizing.moving import Mover
from cutjoint.sizing.pieces import FINE_RELATIVE, RELATIVE, SmoothPiece, SmoothWay, way_of
from cutjoint.sizing.values import Course, Duty, Extreme, SizedCycle

NOISE = 1e-6
"""Beside a radian (or the robot's length) in the time of the way: slower than that is rest."""
STILL = 1e-11
"""Likewise; slower than that is rounding."""
KINDS = 11
"""Integrands of an actuator, see `integrands`."""


class Integrals(NamedTuple):
    """Of one trajectory, shape (n,) each: efforts e, efforts without rotors b, velocities v, accelerations a;
    `returned` counts only where the motion drives the motor, so b v < 0."""

    ee: Array
    vv: Array
    power: Array
    given: Array
    bb: Array
    bb_returned: Array
    ba: Array
    ba_returned: Array
    aa: Array
    lost: Array
    received: Array


@dataclass(frozen=True, eq=False)
class LoadCycle:
    """What a motor of any inertia behind any gear is judged by: integrals, and the course looked at closely.

    Attributes:
        name: of the trajectory.
        duration: [s].
        integrals: over it.
        v, a, bare: dense courses, shape (m, n).
        mass: largest inertia at each actuator, without its rotor, shape (n,).
        holding: largest effort at rest, shape (n,).
    """

    name: str
    duration: float
    integrals: Integrals
    v: Array
    a: Array
    bare: Array
    mass: Array
    holding: Array


def integrands(course: Course, rest: Array) -> Array:
    """What is integrated over a piece, shape (m, 11 n); losses and loads once, under the first actuator.  Where it is
    never faster than `rest`, shape (n,), an actuator rests, and its motor is not driven."""
    e, b, v, a, power = course.effort, course.bare, course.v, course.a, course.power
    returns = (b * v < 0.0) & (np.abs(v).max(axis=0) > rest)
    first = np.zeros_like(v)
    lost, received = first.copy(), first.copy()
    lost[:, 0], received[:, 0] = course.lost, course.received
    parts = (e * e, v * v, power, np.maximum(power, 0.0), b * b, returns * b * b, b * a, returns * b * a, a * a)
    return np.hstack([*parts, lost, received])


def sized_cycle(mover: Mover, reference: Reference, name: str) -> tuple[SizedCycle, LoadCycle]:
    """One trajectory, called by its name, and what its motors are judged by."""
    trajectory, duration = reference.trajectory, reference.duration
    actuators = mover.robot.actuators
    units = _units(mover)

    def scales(course: Course) -> Array:
        return _scales(course, actuators, units, duration)

    rest = STILL * units / duration
    way = way_of(
        lambda times: mover.course(reference, times),
        lambda course: integrands(course, rest),
        scales,
        breaks_of(trajectory, duration),
        duration,
        FINE_RELATIVE if is_fine(trajectory) else RELATIVE,
    )
    course = Course.joined([piece.course for piece in way.pieces])
    n = len(actuators)
    found = Integrals(*way.integrals.reshape(KINDS, n))
    duties = _duties(mover, reference, name, way, found)
    lost, received = float(found.lost[0]), float(found.received[0])
    balance, gained = _balance(mover, reference, way, units)
    highest = course.mass.max(axis=0)
    cycle = SizedCycle(name, duration, duties, lost, received, gained, balance, way.error, course, highest)
    fine = _dense(way)
    held = np.array([abs(one.holding.value) for one in duties])
    return cycle, LoadCycle(name, duration, found, *fine, highest, held)


def _units(mover: Mover) -> Array:
    """A radian, or the length of the robot [m], shape (n,)."""
    length = float(getattr(mover.robot, "length", None) or getattr(mover.plain, "length", None) or 1.0)
    return np.array([length if one.kind == "translation" else 1.0 for one in mover.robot.actuators])


def _scales(course: Course, actuators: tuple[Actuator, ...], units: Array, duration: float) -> Array:
    """The greatest sizes that the integrands might have, shape (11 n,): actuators of a kind have one size."""
    kinds = np.array([one.kind for one in actuators])
    v = np.maximum(np.abs(course.v).max(axis=0), NOISE * units / duration)
    a = np.maximum(np.abs(course.a).max(axis=0), NOISE * units / duration**2)
    e = np.maximum(np.abs(course.effort).max(axis=0), course.mass.max(axis=0) * NOISE * units / duration**2)
    for kind in set(kinds.tolist()):
        own = kinds == kind
        for size in (v, a, e):
            size[own] = size[own].max()
    b = np.maximum(e, np.abs(course.bare).max(axis=0))
    power = np.full_like(v, float((e * v).sum()))
    parts = (e * e, v * v, power, power, b * b, b * b, b * a, b * a, a * a, power, power)
    return np.concatenate([np.maximum(one, 1e-300) for one in parts])


def _duties(mover: Mover, reference: Reference, name: str, way: SmoothWay, found: Integrals) -> tuple[Duty, ...]:
    """What the actuators must do, with peaks between the points too."""
    duration = reference.duration
    course = Course.joined([piece.course for piece in way.pieces])
    near = mover.course(reference, _summits(way.pieces))
    both = Course.joined([course, near])
    duties = []
    for i, actuator in enumerate(mover.robot.actuators):

        def most(values: Array) -> Extreme:
            k = int(np.argmax(np.abs(values)))
            return Extreme(float(values[k]), float(both.t[k]), name)

        power = both.power[:, i]
        given, net = float(found.given[i]), float(found.power[i])
        duties.append(
            Duty(
                actuator,
                most(both.effort[:, i]),
                float(np.sqrt(found.ee[i] / duration)),
                most(both.v[:, i]),
                float(np.sqrt(found.vv[i] / duration)),
                most(np.maximum(power, 0.0)),
                most(np.maximum(-power, 0.0)),
                given,
                max(given - net, 0.0),
                most(both.holding[:, i]),
            )
        )
    return tuple(duties)


def _summits(pieces: tuple[SmoothPiece, ...]) -> Array:
    """Instants of the largest and least efforts, speeds, powers and holding efforts, by parabolas through the
    interpolated course, shape (8 n,) [s]."""
    best: dict[int, tuple[float, float]] = {}
    for piece in pieces:
        t, v, effort, _ = piece.close_up
        held = piece.close_up_of(piece.course.holding)
        values = np.hstack([effort, v, effort * v, held])
        values = np.hstack([values, -values])
        for j, k in enumerate(np.argmax(values, axis=0).tolist()):
            if j not in best or values[k, j] > best[j][0]:
                best[j] = float(values[k, j]), _vertex(t, values[:, j], k)
    return np.array([best[j][1] for j in sorted(best)])


def _vertex(t: Array, y: Array, k: int) -> float:
    """Where the parabola through a largest value and its neighbours has its summit [s]."""
    if k in (0, len(t) - 1) or not t[k - 1] < t[k] < t[k + 1]:
        return float(t[k])
    left, right = t[k] - t[k - 1], t[k + 1] - t[k]
    fall_left, fall_right = (y[k] - y[k - 1]) / left, (y[k] - y[k + 1]) / right
    bend = fall_left + fall_right
    if not bend > 0.0:
        return float(t[k])
    shift = 0.5 * (fall_left * right - fall_right * left) / bend
    return float(np.clip(t[k] + shift, t[k - 1], t[k + 1]))


def _balance(mover: Mover, reference: Reference, way: SmoothWay, units: Array) -> tuple[float, float]:
    """By how much work and energies miss each other, relative, and the energy that is gained [J]."""
    pieces = way.pieces
    edges = [0.0, *(piece.high for piece in pieces)]
    energies = []
    for t in edges:
        desired = reference.at(t)
        at = mover.posture(desired)
        energies.append(mover.plain.potential_energy(at) + kinetic_energy(mover.plain, at, desired.v))
    gained = np.array(energies) - energies[0]
    moved = missed = turned = 0.0
    for k, piece in enumerate(pieces):
        course = piece.course
        moved += float(piece.integral(course.power.sum(axis=1) - course.lost + course.received))
        turned += float(piece.integral(np.abs(course.power).sum(axis=1)))
        missed = max(missed, abs(moved - float(gained[k + 1])))
    largest = max(float((np.abs(one.course.effort) * units).max()) for one in pieces)
    size = max(turned, float(np.ptp(gained)), NOISE * largest, 1e-300)
    return missed / size, float(gained[-1])


def _dense(way: SmoothWay) -> tuple[Array, Array, Array]:
    """Velocities, accelerations and efforts without rotors, close up."""
    v, a, bare = (
        np.concatenate([piece.close_up_of(getattr(piece.course, name)) for piece in way.pieces])
        for name in ("v", "a", "bare")
    )
    return v, a, bare
