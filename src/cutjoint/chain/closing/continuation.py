"""Closing the loops: Newton on the closure equations together with what drives them.

A driver says what is prescribed: the actuated coordinates, the tool point or the tool's pose.  `follow` walks from a
closed posture to the target with predictor steps that are short against the links, each corrected by Newton.  A step is
taken back where the determinant of the equations changes its sign or the direction of the motion jumps, because then a
singular posture was stepped over: so it stays on the branch it started from.  `assemble` takes any start
(Levenberg-Marquardt) and makes no promise about the branch.  Steps are minimum-norm solutions with the rank cut off, so
redundant rows do no harm; configurations move on their manifold (`pin.integrate`), so free-flying and spherical joints
need no special case.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import rank_of, threshold

RESTARTS = 8
"""Starts around a configuration that are tried where none is found from itself."""

NEWTON_STEPS = 12
MOST_STEPS = 2000


class Driver(Protocol):
    """What is prescribed besides the closure."""

    @property
    def is_length(self) -> Array:
        """Whether each row is a length, shape (rows,)."""
        ...

    def error(self, placed: Placed, fraction: float) -> Array:
        """Present minus wanted value at this fraction of the way, shape (rows,)."""
        ...

    def jacobian(self, placed: Placed) -> Array:
        """Derivative of the error, shape (rows, nv)."""
        ...

    def put(self, q: Array, fraction: float) -> None:
        """Write the coordinates that are prescribed themselves into a configuration that nearly has them."""
        ...


class ActuatedDriver:
    """Prescribes the actuated coordinates, on a straight line from `start` to `target`, shape (n,)."""

    def __init__(self, q_index: Array, selection: Array, is_length: Array, start: Array, target: Array) -> None:
        self._q_index, self._selection, self.is_length = q_index, selection, is_length
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.asarray(placed.q[self._q_index] - self._wanted(fraction))

    def jacobian(self, placed: Placed) -> Array:
        return self._selection

    def put(self, q: Array, fraction: float) -> None:
        q[self._q_index] = self._wanted(fraction)

    def _wanted(self, fraction: float) -> Array:
        return self._target if fraction == 1.0 else self._start + fraction * (self._target - self._start)


class ToolDriver:
    """Prescribes the tool point in the model, on a straight line from `start` to `target`, shape (3,) [m]."""

    is_length = np.ones(3, dtype=bool)

    def __init__(self, start: Array, target: Array) -> None:
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        wanted = self._target if fraction == 1.0 else self._start + fraction * (self._target - self._start)
        return np.asarray(placed.tool_position - wanted)

    def jacobian(self, placed: Placed) -> Array:
        return placed.tool_jacobian[:3]

    def put(self, q: Array, fraction: float) -> None:
        """No coordinate is prescribed."""


class PoseDriver:
    """Prescribes the tool's placement in the model; on the way the position runs straight, the rotation at once."""

    is_length = np.array([True] * 3 + [False] * 3)

    def __init__(self, start: pin.SE3, target: pin.SE3) -> None:
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        wanted = self._target if fraction == 1.0 else pin.SE3.Interpolate(self._start, self._target, fraction)
        pose = placed.tool
        turn = wanted.rotation @ pin.log3(wanted.rotation.T @ pose.rotation)
        return np.concatenate([pose.translation - wanted.translation, turn])

    def jacobian(self, placed: Placed) -> Array:
        return placed.tool_jacobian

    def put(self, q: Array, fraction: float) -> None:
        """No coordinate is prescribed."""


UNBOUND = "the joints would have to move without bound"
MEETING = "branches meet"


@dataclass(frozen=True)
class Stopped:
    """How far `follow` came: fraction of the way, the last closed configuration, and why it stopped.

    Attributes:
        singular: whether it stopped where branches cross, so that the robot could go on, but on more than one of them.
        far: whether it was given up for its length.
        measure: smallest singular value of the equations there, dimensionless.
    """

    fraction: float
    q: Array
    why: str
    singular: bool = False
    far: bool = False
    measure: float = 0.0


class Scales(NamedTuple):
    """What all systems of equations with a kind of driver have in common.

    Attributes:
        is_length: whether each row is a length (else an angle), shape (rows,).
        scale: factor per row that makes errors dimensionless, shape (rows,).
        driven: the same for the driver's rows, and for the velocities of its Jacobian, shape (driver's rows, nv).
        rounded: distance [m] to which the driver's lengths are rounded.
        closed: one over what counts as closed, of every row, where that is the same everywhere.
    """

    is_length: Array
    scale: Array
    driven: Array
    rounded: Array
    closed: Array | None

    @staticmethod
    def of(kinematics: Kinematics, driver: Driver | None) -> Scales:
        """Of a driver; made once for each kind."""
        k = kinematics
        kind = None if driver is None else (type(driver), driver.is_length.tobytes())
        found: Scales | None = k.scales.get(kind)
        if found is None:
            lengths = k.closure.is_length if driver is None else np.concatenate([k.closure.is_length, driver.is_length])
            scale = np.where(lengths, 1.0 / k.length, 1.0)
            driven = scale[k.closure.rows :, None] * k.column_scale
            rounded = k.rounded if isinstance(driver, ToolDriver) else 0.0
            far = np.where(np.arange(len(lengths)) >= k.closure.rows, rounded, 0.0)
            found = Scales(lengths, scale, driven, far, None)
            if not k.travels:
                found = found._replace(closed=found.closed_by(k.closed_length))
            k.scales[kind] = found
        return found

    def closed_by(self, length: float) -> Array:
        """One over what counts as closed, of every row, for a length."""
        return np.asarray(1.0 / (np.where(self.is_length, length, tolerances.CLOSURE.value) + self.rounded))


class System:
    """The rows of closure and driver as one system of equations."""

    def __init__(self, kinematics: Kinematics, driver: Driver | None) -> None:
        self.k, self.driver, self.scales = kinematics, driver, Scales.of(kinematics, driver)

    def at(self, placed: Placed, fraction: float = 1.0) -> Equations:
        """The equations at one configuration, this fraction of the driver's way."""
        raw, scales = placed.residual, self.scales
        if self.driver is not None:
            raw = np.concatenate([raw, self.driver.error(placed, fraction)])
        closed = scales.closed_by(self.k.closed_within(placed.q)) if scales.closed is None else scales.closed
        left = raw * closed
        return Equations(self, placed, scales.scale * raw, sqrt(left.dot(left)))


class Equations(NamedTuple):
    """Closure and driver at one configuration.

    Attributes:
        placed: the configuration.
        error: of all rows, dimensionless, shape (rows,).
        openness: norm of the errors in units of what counts as closed; 1 is closed.
    """

    system: System
    placed: Placed
    error: Array
    openness: float

    @property
    def matrix(self) -> Array:
        """Derivative of the error, dimensionless, shape (rows, nv)."""
        if self.system.driver is None:
            return self.placed.scaled
        driven = self.system.driver.jacobian(self.placed) * self.system.scales.driven
        return np.concatenate([self.placed.scaled, driven])


@dataclass(frozen=True, eq=False)
class _Linear:
    """Dimensionless equations at one configuration by their singular values: left (m, k), values (k,), right (k, nv).

    Attributes:
        free: motions that the equations leave free at nearly every posture.
    """

    left: Array
    values: Array
    right: Array
    free: int = 0

    @staticmethod
    def of(matrix: Array, free: int = 0) -> _Linear:
        return _Linear(*np.linalg.svd(matrix, full_matrices=False), free)

    def solve(self, error: Array) -> Array:
        """Minimum-norm step that removes the error to first order, shape (nv,)."""
        kept = self.values > threshold(self.values)
        return np.asarray(-self.right[kept].T @ ((self.left[:, kept].T @ error) / self.values[kept]))

    @property
    def count(self) -> int:
        """Rank where the equations leave no motions but the usual ones free."""
        return int(self.right.shape[1]) - self.free

    @property
    def least(self) -> float:
        """The singular value that vanishes at a singular posture; infinite where there are no equations."""
        if self.count == 0:
            return float("inf")
        return float(self.values[self.count - 1]) if len(self.values) >= self.count else 0.0

    @property
    def regular(self) -> bool:
        """Whether the equations leave no more motions free than usual."""
        return self.least > threshold(self.values)

    def flips(self, other: _Linear) -> bool:
        """Whether the determinants here and at `other`, a step further on, differ in sign."""
        r = self.count
        turned = other.right[:r] @ self.right[:r].T
        between = (self.left[:, :r].T @ other.left[:, :r]) @ (other.values[:r, None] * turned)
        return bool(np.linalg.det(between / self.values[:r, None]) <= 0.0)


class Assembler:
    """Solves the closure of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics

    def freedom(self, placed: Placed, driver: Driver) -> int:
        """Number of motions that closure and driver leave free at a configuration."""
        matrix = System(self._k, driver).at(placed).matrix
        return int(matrix.shape[1]) - rank_of(matrix)

    def follow(self, q: Array, driver: Driver, free: int = 0) -> Array | Stopped:
        """Walk from the closed configuration `q`, shape (nq,), to the driver's target on the same branch.

        Args:
            free: motions that closure and driver leave free at nearly every posture.
        """
        k, fraction, step = self._k, 0.0, 1.0
        converged = refused = False
        placed, system = k.at(q), System(k, driver)
        end = system.at(placed)
        rate = end.error - system.at(placed, 0.0).error
        if end.openness <= 1.0:
            nearer = self._newton(q, system, 1.0, tolerances.STRIDE.value)
            return q if nearer is None else nearer
        here = _Linear.of(end.matrix, free)
        if not here.regular:
            return Stopped(0.0, q, MEETING, singular=True, measure=here.least)
        direction = here.solve(rate)
        for _ in range(MOST_STEPS):
            step = min(step, 1.0 - fraction)
            goal = 1.0 if fraction + step > 1.0 - 1e-12 else fraction + step
            motion = here.solve(system.at(placed, goal).error)
            size = float(np.abs(motion).max(initial=0.0))
            if not np.isfinite(size):
                return Stopped(fraction, q, "the equations are singular")
            if size > 1.01 * tolerances.STRIDE.value:
                step *= max(tolerances.STRIDE.value / size, 0.1)
                converged = False
            else:
                corrected = self._newton(k.integrate(q, motion * k.column_scale), system, goal, 0.5 * size + 1e-9)
                converged = corrected is not None
                if corrected is not None:
                    arrived = k.at(corrected)
                    there = _Linear.of(system.at(arrived, goal).matrix, free)
                    onward = there.solve(rate)
                    if _same_branch(here, direction, there, onward):
                        q, placed, fraction, here, direction = corrected, arrived, goal, there, onward
                        if fraction == 1.0:
                            return q
                        step, refused = step if refused else 2.0 * step, False
                        continue
                step, refused = 0.5 * step, True
            if step < tolerances.SMALLEST_STEP.value:
                crossing = converged and here.least < tolerances.CROSSING.value
                return Stopped(fraction, q, MEETING if crossing else UNBOUND, singular=crossing, measure=here.least)
        return Stopped(fraction, q, f"{MOST_STEPS} steps were not enough; go there by way of nearer postures", far=True)

    def assemble(self, q: Array, driver: Driver | None, iterations: int = 100) -> Array | None:
        """A closed configuration from any start `q`, shape (nq,), or None; damped least squares, then Newton."""
        near, cost = self.nearest(q, driver, iterations)
        return self._newton(near, System(self._k, driver), 1.0, np.inf) if cost < 1e-12 else None

    def assemble_around(self, q: Array, driver: Driver | None) -> Array | None:
        """As `assemble`, from starts around `q` at growing distance (always the same ones): a straight limb pulled
        along itself does not know which way to bend."""
        for start in self.around(q, np.geomspace(0.05, 1.5, RESTARTS)):
            found = self.assemble(start, driver)
            if found is not None:
                return found
        return None

    def around(self, q: Array, reaches: Array) -> list[Array]:
        """Configurations around `q`, shape (nq,), at most as far as each of `reaches`; always the same ones."""
        k, random = self._k, np.random.default_rng(0)
        return [
            k.integrate(q, k.column_scale * random.uniform(-reach, reach, k.model.nv)) for reach in reaches.tolist()
        ]

    def nearest(self, q: Array, driver: Driver | None, iterations: int = 100) -> tuple[Array, float]:
        """Where damped least squares comes to rest from `q`, shape (nq,), and the sum of squared scaled errors."""
        k, damping = self._k, 1e-3
        system = System(k, driver)
        here = system.at(k.at(q))
        cost = float(here.error @ here.error)
        for _ in range(iterations):
            if cost < 1e-12:
                break
            matrix = here.matrix
            normal, gradient = matrix.T @ matrix, matrix.T @ here.error
            while damping < 1e8:
                motion = -np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
                motion *= min(1.0, 1.0 / float(np.abs(motion).max(initial=1e-12)))
                trial = k.integrate(q, motion * k.column_scale)
                there = system.at(k.at(trial))
                trial_cost = float(there.error @ there.error)
                if trial_cost < cost:
                    break
                damping *= 4.0
            else:
                break
            if trial_cost > cost * (1.0 - 1e-4) and damping < 1e-3:
                break
            q, here, cost = trial, there, trial_cost
            damping = max(damping * 0.2, 1e-12)
        return q, cost

    def settle(self, q: Array, driver: Driver | None, reach: float = tolerances.STRIDE.value) -> Array | None:
        """The closed configuration next to `q`, shape (nq,), or None where Newton's method does not find one within
        `reach` (radians or characteristic lengths)."""
        return self._newton(q, System(self._k, driver), 1.0, reach)

    def _newton(self, q: Array, system: System, fraction: float, reach: float) -> Array | None:
        """Newton's method from near by; None if it does not converge or moves further than `reach` (scaled)."""
        k, moved, last = self._k, 0.0, np.inf
        for _ in range(NEWTON_STEPS):
            here = system.at(k.at(q), fraction)
            worst = here.openness
            if not np.isfinite(worst) or (worst > 0.5 * last and worst > 1.0):
                return None
            if worst < 1e-3 or (worst < 1.0 and worst > 0.1 * last):
                return q
            last = worst
            motion = _Linear.of(here.matrix).solve(here.error)
            moved += float(np.abs(motion).max(initial=0.0))
            if moved > reach:
                return None
            q = k.integrate(q, motion * k.column_scale)
            if system.driver is not None:
                system.driver.put(q, fraction)
        return None


def _same_branch(here: _Linear, direction: Array, there: _Linear, onward: Array) -> bool:
    """Whether a step from `here` to `there` stayed clear of singular postures, by the equations and by the directions
    of the motion at both ends."""
    turn = float(np.abs(onward - direction).max(initial=0.0))
    size = max(float(np.abs(direction).max(initial=0.0)), float(np.abs(onward).max(initial=0.0)))
    return there.least > tolerances.SINGULAR.value and turn <= tolerances.TURN.value * size and not here.flips(there)
