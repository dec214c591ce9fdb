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
from typing import Protocol

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, ToolPoint

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

    def error(self, data: pin.Data, q: Array, fraction: float) -> Array:
        """Present minus wanted value at this fraction of the way, shape (rows,)."""
        ...

    def jacobian(self, data: pin.Data) -> Array:
        """Derivative of the error, shape (rows, nv)."""
        ...


class ActuatedDriver:
    """Prescribes the actuated coordinates, on a straight line from `start` to `target`, shape (n,)."""

    def __init__(self, q_index: Array, selection: Array, is_length: Array, start: Array, target: Array) -> None:
        self._q_index, self._selection, self.is_length = q_index, selection, is_length
        self._start, self._target = start, target

    def error(self, data: pin.Data, q: Array, fraction: float) -> Array:
        wanted = self._target if fraction == 1.0 else self._start + fraction * (self._target - self._start)
        return np.asarray(q[self._q_index] - wanted)

    def jacobian(self, data: pin.Data) -> Array:
        return self._selection


class ToolDriver:
    """Prescribes the tool point, on a straight line from `start` to `target`, shape (3,) [m]."""

    def __init__(self, tool: ToolPoint, start: Array, target: Array) -> None:
        self._tool, self._start, self._target = tool, start, target
        self.is_length = np.ones(3, dtype=bool)

    def error(self, data: pin.Data, q: Array, fraction: float) -> Array:
        wanted = self._target if fraction == 1.0 else self._start + fraction * (self._target - self._start)
        return np.asarray(self._tool.pose(data).translation - wanted)

    def jacobian(self, data: pin.Data) -> Array:
        return self._tool.jacobian(data)[:3]


class PoseDriver:
    """Prescribes position and orientation of the tool; on the way the position runs straight, the rotation at once."""

    def __init__(self, tool: ToolPoint, start: pin.SE3, target: pin.SE3) -> None:
        self._tool, self._start, self._target = tool, start, target
        self.is_length = np.array([True] * 3 + [False] * 3)

    def error(self, data: pin.Data, q: Array, fraction: float) -> Array:
        wanted = self._target if fraction == 1.0 else pin.SE3.Interpolate(self._start, self._target, fraction)
        pose = self._tool.pose(data)
        turn = wanted.rotation @ pin.log3(wanted.rotation.T @ pose.rotation)
        return np.concatenate([pose.translation - wanted.translation, turn])

    def jacobian(self, data: pin.Data) -> Array:
        return self._tool.jacobian(data)


UNBOUND = "the joints would have to move without bound"


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


@dataclass(frozen=True, eq=False)
class _Linear:
    """Scaled equations at one configuration by their singular values: left (m, k), values (k,), right (k, nv)."""

    left: Array
    values: Array
    right: Array

    @staticmethod
    def of(matrix: Array) -> _Linear:
        return _Linear(*np.linalg.svd(matrix, full_matrices=False))

    def solve(self, error: Array) -> Array:
        """Minimum-norm step that removes the error to first order, shape (nv,)."""
        kept = self.values > tolerances.RANK.value * self.values.max(initial=0.0)
        return np.asarray(-self.right[kept].T @ ((self.left[:, kept].T @ error) / self.values[kept]))

    @property
    def regular(self) -> bool:
        """Whether the equations leave no motion free."""
        full = len(self.values) == self.right.shape[1]
        return full and bool(self.values[-1] > tolerances.RANK.value * self.values[0])

    def flips(self, other: _Linear) -> bool:
        """Whether the determinants here and at `other`, a step further on, differ in sign."""
        between = (self.left.T @ other.left) @ (other.values[:, None] * (other.right @ self.right.T))
        return bool(np.linalg.det(between / self.values[:, None]) <= 0.0)


class Assembler:
    """Solves the closure of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics

    def follow(self, q: Array, driver: Driver) -> Array | Stopped:
        """Walk from the closed configuration `q`, shape (nq,), to the driver's target on the same branch."""
        k, fraction, step = self._k, 0.0, 1.0
        converged = refused = False
        scale = self._scale(driver)
        k.update(q)
        here = _Linear.of(self._matrix(driver))
        rate = scale * (self._error(q, driver, 1.0) - self._error(q, driver, 0.0))
        direction = here.solve(rate)
        for _ in range(MOST_STEPS):
            step = min(step, 1.0 - fraction)
            end = 1.0 if fraction + step > 1.0 - 1e-12 else fraction + step
            k.update(q)
            motion = here.solve(scale * self._error(q, driver, end))
            size = float(np.abs(motion).max(initial=0.0))
            if not np.isfinite(size):
                return Stopped(fraction, q, "the equations are singular")
            if size > 1.01 * tolerances.STRIDE.value:
                step *= max(tolerances.STRIDE.value / size, 0.1)
                converged = False
            else:
                corrected = self._newton(
                    pin.integrate(k.model, q, motion * k.column_scale), driver, end, 0.5 * size + 1e-9
                )
                converged = corrected is not None
                if corrected is not None:
                    k.update(corrected)
                    there = _Linear.of(self._matrix(driver))
                    onward = there.solve(rate)
                    if _same_branch(here, direction, there, onward):
                        q, fraction, here, direction = corrected, end, there, onward
                        if fraction == 1.0:
                            return q
                        step, refused = step if refused else 2.0 * step, False
                        continue
                step, refused = 0.5 * step, True
            if step < tolerances.SMALLEST_STEP.value:
                crossing = converged and here.regular and bool(here.values[-1] < tolerances.CROSSING.value)
                why = "branches meet" if crossing else UNBOUND
                return Stopped(fraction, q, why, singular=crossing, measure=float(here.values.min(initial=np.inf)))
        return Stopped(fraction, q, f"{MOST_STEPS} steps were not enough; go there by way of nearer postures", far=True)

    def assemble(self, q: Array, driver: Driver | None, iterations: int = 100) -> Array | None:
        """A closed configuration from any start `q`, shape (nq,), or None; damped least squares, then Newton."""
        near, cost = self.nearest(q, driver, iterations)
        return self._newton(near, driver, 1.0, np.inf) if cost < 1e-12 else None

    def assemble_around(self, q: Array, driver: Driver | None) -> Array | None:
        """As `assemble`, from starts around `q` at growing distance (always the same ones): a straight limb pulled
        along itself does not know which way to bend."""
        k, random = self._k, np.random.default_rng(0)
        for reach in np.geomspace(0.05, 1.5, RESTARTS):
            shift = k.column_scale * random.uniform(-reach, reach, k.model.nv)
            found = self.assemble(k.integrate(q, shift), driver)
            if found is not None:
                return found
        return None

    def nearest(self, q: Array, driver: Driver | None, iterations: int = 100) -> tuple[Array, float]:
        """Where damped least squares comes to rest from `q`, shape (nq,), and the sum of squared scaled errors."""
        damping = 1e-3
        self._k.update(q)
        scale = self._scale(driver)
        matrix, error = self._matrix(driver), scale * self._error(q, driver, 1.0)
        cost = float(error @ error)
        for _ in range(iterations):
            if cost < 1e-12:
                break
            normal, gradient = matrix.T @ matrix, matrix.T @ error
            while damping < 1e8:
                motion = -np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
                motion *= min(1.0, 1.0 / float(np.abs(motion).max(initial=1e-12)))
                trial = pin.integrate(self._k.model, q, motion * self._k.column_scale)
                self._k.update(trial)
                trial_error = scale * self._error(trial, driver, 1.0)
                trial_cost = float(trial_error @ trial_error)
                if trial_cost < cost:
                    break
                damping *= 4.0
            else:
                break
            if trial_cost > cost * (1.0 - 1e-4) and damping < 1e-3:
                break
            q, matrix, error, cost = trial, self._matrix(driver), trial_error, trial_cost
            damping = max(damping * 0.2, 1e-12)
        return q, cost

    def settle(self, q: Array, driver: Driver | None) -> Array | None:
        """The closed configuration next to `q`, shape (nq,), or None where Newton's method does not find one."""
        return self._newton(q, driver, 1.0, tolerances.STRIDE.value)

    def _newton(self, q: Array, driver: Driver | None, fraction: float, reach: float) -> Array | None:
        """Newton's method from near by; None if it does not converge or moves further than `reach` (scaled)."""
        k, moved, last = self._k, 0.0, np.inf
        for _ in range(NEWTON_STEPS):
            k.update(q)
            error = self._error(q, driver, fraction)
            worst = float(np.abs(error).max(initial=0.0))
            if not np.isfinite(worst) or (worst > 0.5 * last and worst > tolerances.CLOSURE.value):
                return None
            if worst < 1e-15 or (worst < tolerances.CLOSURE.value and worst > 0.1 * last):
                return q
            last = worst
            motion = _Linear.of(self._matrix(driver)).solve(self._scale(driver) * error)
            moved += float(np.abs(motion).max(initial=0.0))
            if moved > reach:
                return None
            q = pin.integrate(k.model, q, motion * k.column_scale)
        return None

    def _matrix(self, driver: Driver | None) -> Array:
        """Scaled Jacobian of closure and driver at the updated configuration."""
        k = self._k
        matrix = k.closure.jacobian(k.data)
        if driver is not None:
            matrix = np.concatenate([matrix, driver.jacobian(k.data)])
        return np.asarray(self._scale(driver)[:, None] * matrix * k.column_scale)

    def _error(self, q: Array, driver: Driver | None, fraction: float) -> Array:
        """Error of closure and driver at the updated configuration, [m] and [rad]."""
        residual = self._k.closure.residual(self._k.data, q)
        return residual if driver is None else np.concatenate([residual, driver.error(self._k.data, q, fraction)])

    def _scale(self, driver: Driver | None) -> Array:
        """Factor per row that makes errors dimensionless."""
        k = self._k
        if driver is None:
            return k.row_scale
        return np.concatenate([k.row_scale, np.where(driver.is_length, 1.0 / k.length, 1.0)])


def _same_branch(here: _Linear, direction: Array, there: _Linear, onward: Array) -> bool:
    """Whether a step from `here` to `there` stayed clear of singular postures, by the equations and by the directions
    of the motion at both ends; where the equations leave motions free, nothing can be told."""
    if not here.regular:
        return True
    turn = float(np.abs(onward - direction).max(initial=0.0))
    size = max(float(np.abs(direction).max(initial=0.0)), float(np.abs(onward).max(initial=0.0)))
    return (
        bool(there.values[-1] > tolerances.SINGULAR.value)
        and turn <= tolerances.TURN.value * size
        and not here.flips(there)
    )
