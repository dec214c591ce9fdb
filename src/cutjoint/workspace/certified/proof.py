"""Proofs on sub-boxes: for every goal in one there is exactly one posture near by, and none of them is singular.

With t the goals of a sub-box and p(t) a polynomial of second order that the postures nearly follow, they are looked
for in

    x = p(t) + e,    |e_i| <= E_i

With F the equations, J their derivative over all of these x and t (`cutjoint.workspace.certified.forms`), C(t) nearly
its inverse, A a bound of |1 - C J| and b one of |C F(p(t), t)|, Krawczyk's test for every t

    b + A E < E

proves a posture for every t, and no second one within E.  As A E < E, the spectral radius of A is below 1, so that J
is regular: no type-1 singularity.  The same with the actuators held instead of the tool, A' v < v for some v > 0,
excludes type 2.  Margins are 1 less the larger of the two spectral radii, or rather of bounds of these.

C follows J: with K the inverse of J in the middle and K J = 1 + M(t) + N(t) + R, of first and second order and a rest,

    C = (1 - M + D) K,    D = M M - N,    |1 - C J| <= (1 + |M| + |D|) |R| + |D| |M| + |M| |N| + |D| |N|

After R. Krawczyk: Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken.  Computing 4 (1969) 187-201;
and A. Neumaier: Interval methods for systems of equations.  Cambridge 1990, section 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.workspace.certified.forms import EPS, UP, Form, FormTerms, form, terms_of
from cutjoint.workspace.certified.system import LedSystem

Flags = npt.NDArray[np.bool_]
NEWTON = 8
"""Steps of Newton's method in the middle of a sub-box."""
STILL = 1e-9
"""Steps smaller than this, in radians or lengths of the robot, leave rounding alone."""
FARTHEST = 0.5
"""Longest step of Newton's method."""
ROOM, LEAST = 0.005, 1e-11
"""Room for a posture beside what is needed: part of its way over the sub-box; in radians or lengths of the robot."""
TRIES = 3
CLEARLY = 1.0 - 1e-12
"""Factor of what is to be clearly larger."""


@dataclass(frozen=True, eq=False)
class Proofs:
    """What was found on N sub-boxes.

    Attributes:
        line: the polynomial that the postures follow, a row a term of the shares, (terms, N, size).
        room, tight: half the room in which there is one posture alone, and in which that is, (N, size).
        good: whether all is proven, (N,).
        margin: see the module, (N,); not above 0 where nothing is proven.
        limited: whether only joint limits are in question, (N,).
        closed: whether there is a posture in the middle at all, as far as Newton's method can tell.
        signs: of the determinants in the middle, led by the tool and by the actuators, (2, N).
        scores: which axis to split, the largest, (shares, N).
    """

    line: Array
    room: Array
    tight: Array
    good: Flags
    margin: Array
    limited: Flags
    closed: Flags
    signs: Array
    scores: Array

    @property
    def q(self) -> Array:
        """Postures in the middle, (N, size)."""
        return np.asarray(self.line[0])

    @property
    def reached(self) -> Array:
        """Bound of how far postures are from those in the middle, (N, size)."""
        return np.asarray((np.abs(self.line[1:]).sum(axis=0) + self.tight) * UP)

    def near(self, place: int, shares: Array) -> Array:
        """The polynomial of one sub-box at shares (shares,), (size,)."""
        return np.asarray(terms_of(len(shares)).values(shares) @ self.line[:, place])


def settled(system: LedSystem, q: Array, goals: Array) -> tuple[Array, Flags]:
    """Postures (N, size) by Newton's method from near ones, and which arrived."""
    q, arrived = q.copy(), np.zeros(len(q), dtype=bool)
    going = np.arange(len(q))
    for _ in range(NEWTON):
        open_by = system.residuals(q[going], goals[going])
        matrix = system.matrices(q[going], goals[going])[0]
        step = np.asarray(_inverses(matrix * system.units) @ open_by[:, :, None])[:, :, 0]
        size = np.abs(step).max(axis=1)
        usable = size < FARTHEST
        q[going[usable]] -= step[usable] * system.units
        arrived[going[size < STILL]] = True
        going = going[usable & ~(size < STILL)]
        if not len(going):
            break
    return q, arrived


def prove(system: LedSystem, middles: Array, halves: Array, guesses: Array) -> Proofs:
    """Look at sub-boxes, middles and half edges of the led coordinates (N, led), from postures near those in their
    middles (N, size)."""
    goals = system.goals.numbers(middles)
    q, closed = settled(system, guesses, goals)
    closed &= system.left_open(q, goals) < 1e3 * tolerances.CLOSURE.value
    led, driven = system.matrices(q, goals)
    signs = np.array([np.linalg.slogdet(np.nan_to_num(one * system.units))[0] for one in (led, driven)])
    with np.errstate(all="ignore"):
        followed = _followed(system, q, (middles, halves), _inverses(led))
        return _krawczyk(system, followed, closed, signs, _inverses(driven))


class Followed(NamedTuple):
    """Postures over sub-boxes to second order.

    Attributes:
        terms: of the polynomials.
        goal: forms of the goals.
        line: the polynomials, (terms, N, size).
        need: bound of what a step of Newton's method still changes, with the inverse in the middle, (N, size).
        inverse: that inverse, (N, size, size).
    """

    terms: FormTerms
    goal: list[Form]
    line: Array
    need: Array
    inverse: Array


def _followed(system: LedSystem, q: Array, boxes: tuple[Array, Array], inverse: Array) -> Followed:
    """The polynomials: Newton's method on those of the equations, an order more each time; what the equations are open
    by along them is found to third order."""
    shares = len(system.goals.axes)
    terms, more = terms_of(shares), terms_of(shares, 3)
    goal, line = system.goals.forms(*boxes), np.zeros((terms.size, *q.shape))
    line[0] = q
    for _ in range(2):
        part, _ = _open(system, terms, line, goal)
        line[1:] -= (inverse @ part[1:, :, :, None])[..., 0]
    longer = np.concatenate([line, np.zeros((len(more.triples), *q.shape))])
    part, rest = _open(system, more, longer, system.goals.forms(*boxes, more.order))
    loose = np.abs(inverse) @ (rest + 2.0 * (system.size + 2) * EPS * np.abs(part).sum(axis=0))[..., None]
    need = (np.abs(inverse @ part[..., None]).sum(axis=0) + loose)[..., 0] * (UP + 4.0 * more.size * EPS)
    return Followed(terms, goal, line, need, inverse)


def _open(system: LedSystem, terms: FormTerms, line: Array, goal: list[Form]) -> tuple[Array, Array]:
    """What the equations are open by along polynomials."""
    thin = [form(terms, line[:, :, k], np.zeros(line.shape[1])) for k in range(system.size)]
    return system.residual_forms(thin, goal, line.shape[1])


def _krawczyk(system: LedSystem, seen: Followed, closed: Flags, signs: Array, other_inverse: Array) -> Proofs:
    line, q = seen.line, seen.line[0]
    way = np.abs(line[1:]).sum(axis=0)
    spare = ROOM * way + LEAST * system.units
    room = 2.0 * seen.need + spare
    exists = np.zeros(len(q), dtype=bool)
    for attempt in range(TRIES):
        forms = [form(seen.terms, line[:, :, k], room[:, k]) for k in range(system.size)]
        led, driven = system.matrix_forms(forms, seen.goal, len(q))
        bound, grown, shares = _apart(seen.terms, seen.inverse, *led)
        need = (grown @ seen.need[:, :, None])[:, :, 0] * UP
        found = (need + (bound @ room[:, :, None])[:, :, 0]) * UP
        exists = (found < CLEARLY * room).all(axis=1)
        if exists.all() or attempt == TRIES - 1:
            break
        larger = 1.1 * np.abs(_solved(bound, need + 0.5 * spare))
        room = np.where(exists[:, None] | ~np.isfinite(larger), room, larger)
    tight = np.where(exists[:, None], np.minimum(found, room), room)
    for _ in range(2):
        tight = np.minimum(tight, (need + (bound @ tight[:, :, None])[:, :, 0]) * UP)
    other, _, other_shares = _apart(seen.terms, other_inverse, *driven)
    weight = np.abs(_solved(other, np.broadcast_to(system.units, q.shape)))
    regular = ((other @ weight[:, :, None])[:, :, 0] * UP < CLEARLY * weight).all(axis=1)
    reached = (way + tight) * UP
    beyond = np.maximum(system.lower - (q - reached), (q + reached) - system.upper)
    within, proven = (beyond <= 0.0).all(axis=1), exists & regular & closed
    margin = 1.0 - np.maximum(_radius(bound, room), _radius(other, weight))
    scores = np.maximum(_share(shares, room), _share(other_shares, weight))
    limited = np.flatnonzero(proven & ~within)
    if len(limited):
        linear = line[1 : 1 + len(scores)]
        scores[:, limited] = np.abs(linear[:, limited, beyond[limited].argmax(axis=1)])
    margin = np.where(np.isfinite(margin), margin, -1.0)
    return Proofs(line, room, tight, proven & within, margin, proven & ~within, closed, signs, scores)


def _apart(terms: FormTerms, inverse: Array, line: Array, rest: Array) -> tuple[Array, Array, Array]:
    """Of matrices J (terms, N, size, size), see the module: bounds of |1 - C J| and of |C J_0|, and the part that every
    share has in M."""
    size, first = inverse.shape[-1], 1 + terms.shares
    loose = np.abs(inverse) @ (rest + 2.0 * (size + 2) * EPS * np.abs(line).sum(axis=0)) + 2.0 * EPS
    loose += np.abs(np.eye(size) - inverse @ line[0])
    turned = inverse @ line[1:]
    linear, square = turned[: first - 1], turned[first - 1 :]
    shares = np.abs(linear)
    once, twice = shares.sum(axis=0), np.abs(square).sum(axis=0)
    left = np.zeros_like(once)
    for (i, j), half, bent in zip(terms.pairs, terms.half[:, 0], square, strict=True):
        left += np.abs(half * (linear[i] @ linear[j] + linear[j] @ linear[i]) - bent)
    loose += 4.0 * (size + len(terms.pairs)) * EPS * (once @ once + twice)
    grown = np.eye(size) + once + left
    bound = grown @ loose + left @ (once + twice) + once @ twice
    return bound * (UP + 8.0 * (len(line) + size) * EPS), grown * (UP + 8.0 * len(line) * EPS), shares


def _radius(bound: Array, weight: Array) -> Array:
    """Bound of spectral radii."""
    for _ in range(3):
        weight = (bound @ weight[:, :, None])[:, :, 0] + 1e-3 * weight
    return np.asarray(((bound @ weight[:, :, None])[:, :, 0] / weight).max(axis=1))


def _share(shares: Array, weight: Array) -> Array:
    return np.asarray(((shares @ weight[:, :, None])[..., 0] / weight).max(axis=-1))


def _solved(bound: Array, right: Array) -> Array:
    """(1 - A)^-1 times a vector, NaN where that is singular."""
    return np.asarray(_inverses(np.eye(bound.shape[-1]) - bound) @ right[:, :, None])[:, :, 0]


def _inverses(matrices: Array) -> Array:
    """Of matrices (N, k, k), NaN where there is none."""
    usable = np.isfinite(matrices).all(axis=(1, 2))
    found = np.full_like(matrices, np.nan)
    try:
        found[usable] = np.linalg.inv(matrices[usable])
    except np.linalg.LinAlgError:
        for k in np.flatnonzero(usable).tolist():
            try:
                found[k] = np.linalg.inv(matrices[k])
            except np.linalg.LinAlgError:
                continue
    return found
