"""How far off the tool is for deviations of many numbers at once: ranked, at worst, and drawn at random.

Bound and spread are those of the linear law, error = S deviation, with S the sensitivities:

    worst    sum of |S| bound            all deviations at their worst for that direction
    sigma    sqrt(sum of S^2 sigma^2)    independent deviations (root of the sum of squares)

Samples go through the same law, or, where asked for, each through loops closed anew by compiled code.  How far the law
is off is tried at a few samples with chains that are built anew.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.accuracy.deviations import Deviation, Deviations, ErrorSource, deviating
from cutjoint.accuracy.sensitivity import LoopFollower, Sensitivity
from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, compiled
from cutjoint.description.values import number, with_values
from cutjoint.doors import door
from cutjoint.errors import CompileError, CutjointError, InputError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.rotations import vector_of
from cutjoint.reprs import line
from cutjoint.stiffness import Springs

MOST_SAMPLES = 10_000_000
TRIED = 3
"""Samples at which the linear law is tried."""
SHUT = 1e-9
"""Postures of compiled code and chain that are further apart, in robot lengths, are on different branches."""


@dataclass(frozen=True, eq=False)
class Cause(Frozen):
    """What one number does to the tool.

    Attributes:
        name: of the number.
        deviation: how far it may be off, in its own unit.
        unit: that unit.
        bound: displacement [m] and rotation [rad] of the tool at its bound, world axes, shape (6,).
        share: part of the variance of the place of the tool that is due to it.
        turning_share: the same of its rotation.
        play: how far the joint that gives most must give at the bound [m]; 0 where the joints follow by themselves.
        turn: the same of rotations [rad].
        strained: that joint or cut.
    """

    name: str
    deviation: Deviation
    unit: str
    bound: Array
    share: float
    turning_share: float
    play: float
    turn: float
    strained: str

    __repr__ = line("name", "deviation", "share", "bound", bound="m, rad")


@dataclass(frozen=True, eq=False)
class Accuracy(Frozen):
    """How far off the tool is in one posture.

    Attributes:
        robot: its name.
        at: the posture.
        position: of the tool point without deviations, shape (3,) [m].
        sensitivity: how the tool follows every number.
        deviations: how far each may be off.
        worst: bound of the error of the tool, displacement [m] and rotation [rad] along and about the axes of the
            world, shape (6,).
        sigma: standard deviation of the error, shape (6,).
        errors: of the samples, shape (samples, 6).
        exact: whether the loops were closed anew for every sample; else they follow the linear law.
        nonlinear: how far the linear law is off at some samples: displacement [m] and rotation [rad]; not a number
            where it could not be tried.
    """

    robot: str
    at: Posture
    position: Array
    sensitivity: Sensitivity
    deviations: tuple[Deviation, ...]
    worst: Array
    sigma: Array
    errors: Array
    exact: bool
    nonlinear: tuple[float, float]

    __repr__ = line("robot", "numbers", "sigma", "worst", sigma="m, rad", worst="m, rad")

    @property
    def numbers(self) -> int:
        """How many may be off."""
        return len(self.deviations)

    @property
    def ranked(self) -> tuple[Cause, ...]:
        """The numbers by their share of the variance of the tool's place, the largest first."""
        matrix, found = self.sensitivity.matrix, []
        spread = matrix * np.array([one.sigma for one in self.deviations])
        squares = [(spread[few] ** 2).sum(axis=0) for few in (slice(0, 3), slice(3, 6))]
        shares = [one / one.sum() if one.sum() else one for one in squares]
        for k in np.lexsort((-shares[1], -shares[0])):
            source, own = self.sensitivity.sources[k], self.deviations[k]
            size, given = own.bound, self.sensitivity
            found.append(
                Cause(
                    source.name,
                    own,
                    source.unit,
                    matrix[:, k] * size,
                    float(shares[0][k]),
                    float(shares[1][k]),
                    float(given.play[k]) * size,
                    float(given.turn[k]) * size,
                    given.strained[k],
                )
            )
        return tuple(found)

    @property
    def covariance(self) -> Array:
        """Of the linear law, shape (6, 6): blocks [m2], [m rad], [rad2]."""
        spread = self.sensitivity.matrix * np.array([one.sigma for one in self.deviations])
        return readonly(spread @ spread.T)

    def within(self, percent: float = 95.0) -> tuple[float, float]:
        """Distance [m] and angle [rad] that this part of the samples stays within.

        Raises:
            InputError: no part, or there are no samples.
        """
        if not 0.0 < percent <= 100.0:
            raise InputError(f"a part of the samples is from 0 to 100 %, found {percent!r}")
        if not len(self.errors):
            raise InputError("no samples were drawn; ask for some by samples=")
        sizes = np.linalg.norm(self.errors.reshape(-1, 2, 3), axis=2)
        away, turned = np.percentile(sizes, percent, axis=0)
        return float(away), float(turned)


# long: each of its arguments and errors is told
@door
def accuracy(
    chain: ClosedChain,
    tolerances: Deviations,
    at: Posture | None = None,
    *,
    samples: int = 100_000,
    seed: int = 0,
    exact: bool = False,
    springs: Springs | None = None,
) -> Accuracy:
    """How far off the tool is, its actuators held, in a posture (default home).

    Args:
        tolerances: path, pattern or joined paths -> how far that may be off, see `cutjoint.accuracy.deviations`.
        samples: how many are drawn; 0 draws none.
        seed: of the draws; the same one draws the same numbers.
        exact: close the loops anew for every sample, with compiled code, instead of following the linear law.
        springs: what gives where the joints alone cannot follow; default all joints and cuts alike.

    Raises:
        UnknownNameError: nothing is called so; the nearest is named.
        InputError: a number that does not say where the tool is or is named twice, no tolerance, no tool, no posture of
            this robot, or with `exact` one on another branch than home.
        ActuationError: the tool can move while the actuators hold.
        CompileError: with `exact`, a number that the loops do not let be: only the linear law has it.
    """
    if not 0 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples must be from 0 to {MOST_SAMPLES}, found {samples}")
    if not 0 <= seed < 2**64:
        raise InputError(f"a seed is from 0 to 2^64 - 1, found {seed}")
    found, sized = deviating(chain.description, tolerances)
    where = chain.home if at is None else chain.posture(at)
    follower = LoopFollower(chain, where, springs)
    told = follower.sensitivity(found)
    draws = drawn(sized, samples, seed)
    errors = _closed_anew(chain, where, found, told, draws) if exact else draws @ told.matrix.T
    bounds, sigmas = (np.array([getattr(one, name) for one in sized]) for name in ("bound", "sigma"))
    placed = follower.displaced.placed
    return Accuracy(
        chain.name,
        where,
        placed.tool_position + follower.displaced.kinematics.origin,
        told,
        sized,
        np.abs(told.matrix) @ bounds,
        np.sqrt(told.matrix**2 @ sigmas**2),
        errors,
        exact,
        _nonlinear(chain, where, found, told, drawn(sized, TRIED, seed + 1)),
    )


def drawn(deviations: tuple[Deviation, ...], samples: int, seed: int) -> Array:
    """Independent draws of deviations, shape (samples, k)."""
    random = np.random.default_rng(seed)
    normal = np.array([one.normal for one in deviations], dtype=bool)
    sizes = np.array([one.size for one in deviations])
    found = random.uniform(-1.0, 1.0, (samples, len(deviations)))
    if normal.any():
        found[:, normal] = random.normal(size=(samples, int(normal.sum())))
    return np.asarray(found * sizes)


def _closed_anew(
    chain: ClosedChain, at: Posture, found: tuple[ErrorSource, ...], told: Sensitivity, draws: Array
) -> Array:
    """Errors of samples whose loops are closed anew, shape (samples, 6)."""
    stuck = [name for name, play, turn in zip(told.names, told.play, told.turn, strict=True) if play or turn]
    if stuck:
        more = f" and {len(stuck) - 1} more" if len(stuck) > 1 else ""
        raise CompileError(
            f"the loops of {chain.name} do not close with '{stuck[0]}'{more} off unless joints give, so they cannot be "
            "closed anew for every sample; the linear law has such numbers, or join those that must fit by '='"
        )
    numbers = [k for k, one in enumerate(found) if one.places[0].part != "actuators"]
    names = [found[k].name for k in numbers]
    robot = compiled(chain, parameters=names)
    assert isinstance(robot, CompiledChain)
    own = (
        robot.tool(robot.close(at.q))
        if not numbers
        else robot.tool(robot.home if at is chain.home else robot.close(at.q))
    )
    there = chain.tool(at)
    if np.linalg.norm(own.position - there.position) > SHUT * max(1.0, float(np.abs(chain.origin).max())) + (
        1e-6 * chain.length
    ):
        raise InputError(f"this posture of {chain.name} is on another branch than home, where loops are closed anew")
    if not len(draws):
        return np.zeros((0, 6))
    values = np.array([number(chain.description, found[k].places[0]) for k in numbers])
    given = {name: value + draws[:, k] for name, value, k in zip(names, values, numbers, strict=True)}
    q = np.tile(at.q, (len(draws), 1)) if len(numbers) < len(found) else np.array(at.q)
    actuators = [one.name for one in chain.actuators]
    for k, one in enumerate(found):
        if k not in numbers:
            for path in one.places:
                q[:, actuators.index(path.name)] += draws[:, k]
    tools = robot.batch.tool(q, parameters=given)
    return _errors(tools.position, tools.rotation, there.position, there.rotation)


def _errors(position: Array, rotation: Array, place: Array, axes: Array) -> Array:
    """Displacements and rotation vectors of N tools against one, shape (N, 6)."""
    turn = rotation @ axes.T
    twice = np.stack([turn[:, i, j] - turn[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
    sine = 0.5 * np.linalg.norm(twice, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0))
    factor = np.where(sine > 1e-9, 0.5 * angle / np.maximum(sine, 1e-9), 0.5)
    return np.concatenate([position - place, factor[:, None] * twice], axis=1)


def _nonlinear(
    chain: ClosedChain, at: Posture, found: tuple[ErrorSource, ...], told: Sensitivity, draws: Array
) -> tuple[float, float]:
    """Largest displacement [m] and rotation [rad] between the linear law and chains that are built anew."""
    if told.play.any() or told.turn.any():
        return float("nan"), float("nan")
    worst = [0.0, 0.0]
    actuated = {
        one.name: int(np.flatnonzero(column)[0]) for one, column in zip(chain.actuators, chain.actuation.T, strict=True)
    }
    try:
        now = chain.tool(at)
        for draw in draws:
            changes: dict[str, float] = {}
            moved = np.zeros(chain.nv)
            for source, change in zip(found, draw, strict=True):
                for path in source.places:
                    if path.part == "actuators":
                        moved[actuated[path.name]] += change
                    else:
                        changes[str(path)] = number(chain.description, path) + float(change)
            other = chain.rebuilt(with_values(chain.description, changes)) if changes else chain
            there = other.tool(other.assemble(chain.integrate(at.q_full, moved)))
            linear = told.matrix @ draw
            worst[0] = max(worst[0], float(np.linalg.norm(there.position - now.position - linear[:3])))
            worst[1] = max(worst[1], float(np.linalg.norm(vector_of(there.rotation @ now.rotation.T) - linear[3:])))
    except CutjointError:
        return float("nan"), float("nan")
    return worst[0], worst[1]
