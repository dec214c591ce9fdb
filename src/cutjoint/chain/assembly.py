"""Closing the loops: Newton on the closure equations together with what drives them.

A driver says what is prescribed: the actuated coordinates, the tool point or the tool's pose.  `follow` walks from a
closed posture to the target with predictor steps that are short against the links, each corrected by Newton, and does
not step across a posture where the equations are singular, so it stays on the branch it started from.  `assemble` takes any start (Levenberg-Marquardt) and makes no promise about the
branch.  Steps are minimum-norm solutions with the rank cut off, so redundant rows do no harm; configurations move on
their manifold (`pin.integrate`), so free-flying and spherical joints need no special case.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, ToolPoint

NEWTON_STEPS = 12
SMALLEST_STEP = 1e-6
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


@dataclass(frozen=True)
class Stopped:
    """How far `follow` came: fraction of the way, the last closed configuration, and why it stopped.

    Attributes:
        singular: whether the way could go on, but only through a posture where branches meet.
        far: whether it was given up for its length.
    """

    fraction: float
    q: Array
    why: str
    singular: bool = False
    far: bool = False


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

    def change(self, matrix: Array) -> float:
        """Determinant of the equations `matrix` a step further on, relative to here: negative where a singular posture
        lies between; 1 where the equations leave the robot free, so that nothing can be told."""
        if len(self.values) < self.right.shape[1] or self.values[-1] <= tolerances.RANK.value * self.values[0]:
            return 1.0
        return float(np.linalg.det((self.left.T / self.values[:, None]) @ matrix @ self.right.T))


class Assembler:
    """Solves the closure of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics

    def follow(self, q: Array, driver: Driver) -> Array | Stopped:
        """Walk from the closed configuration `q`, shape (nq,), to the driver's target on the same branch."""
        fraction, step, singular = 0.0, 1.0, False
        self._k.update(q)
        here = _Linear.of(self._system(q, driver, 0.0)[0])
        for _ in range(MOST_STEPS):
            step = min(step, 1.0 - fraction)
            end = 1.0 if fraction + step > 1.0 - 1e-12 else fraction + step
            self._k.update(q)
            motion = here.solve(self._error(q, driver, end)) * self._k.column_scale
            size = float(np.abs(motion / self._k.column_scale).max(initial=0.0))
            if not np.isfinite(size):
                return Stopped(fraction, q, "the equations are singular")
            if size > 1.01 * tolerances.STRIDE.value:
                step *= max(tolerances.STRIDE.value / size, 0.1)
                singular = False
            else:
                corrected = self._newton(pin.integrate(self._k.model, q, motion), driver, end, 0.5 * size + 1e-9)
                matrix = None if corrected is None else self._system(corrected, driver, end)[0]
                singular = matrix is not None and not self._passable(here, matrix)
                if corrected is not None and matrix is not None and not singular:
                    q, fraction = corrected, end
                    if fraction == 1.0:
                        return q
                    here = _Linear.of(matrix)
                    step *= 2.0
                    continue
                step *= 0.5
            if step < SMALLEST_STEP:
                why = (
                    "branches meet in a singular posture" if singular else "the joints would have to move without bound"
                )
                return Stopped(fraction, q, why, singular=singular)
        return Stopped(fraction, q, f"{MOST_STEPS} steps were not enough; go there by way of nearer postures", far=True)

    @staticmethod
    def _passable(here: _Linear, matrix: Array) -> bool:
        """Whether the equations are regular here or stay as they are: no singular posture within the step."""
        change = here.change(matrix)
        if change > 1e-3:
            return True
        return change > 0.0 and bool(np.linalg.svd(matrix, compute_uv=False)[-1] > tolerances.SINGULAR.value)

    def assemble(self, q: Array, driver: Driver | None, iterations: int = 100) -> Array | None:
        """A closed configuration from any start `q`, shape (nq,), or None; damped least squares, then Newton."""
        damping = 1e-3
        self._k.update(q)
        matrix, error = self._system(q, driver, 1.0)
        cost = float(error @ error)
        for _ in range(iterations):
            if cost < 1e-12:
                return self._newton(q, driver, 1.0, np.inf)
            normal, gradient = matrix.T @ matrix, matrix.T @ error
            while damping < 1e8:
                motion = -np.linalg.solve(normal + damping * np.eye(len(normal)), gradient)
                motion *= min(1.0, 1.0 / max(float(np.abs(motion).max()), 1e-12))
                trial = pin.integrate(self._k.model, q, motion * self._k.column_scale)
                self._k.update(trial)
                trial_matrix, trial_error = self._system(trial, driver, 1.0)
                trial_cost = float(trial_error @ trial_error)
                if trial_cost < cost:
                    break
                damping *= 4.0
            else:
                return None
            if trial_cost > cost * (1.0 - 1e-4) and damping < 1e-3:
                return None
            q, matrix, error, cost = trial, trial_matrix, trial_error, trial_cost
            damping = max(damping * 0.2, 1e-12)
        return None

    def settle(self, q: Array, driver: Driver | None) -> Array | None:
        """The closed configuration next to `q`, shape (nq,), or None where Newton's method does not find one."""
        return self._newton(q, driver, 1.0, tolerances.STRIDE.value)

    def _newton(self, q: Array, driver: Driver | None, fraction: float, reach: float) -> Array | None:
        """Newton's method from near by; None if it does not converge or moves further than `reach` (scaled)."""
        moved, last = 0.0, np.inf
        for _ in range(NEWTON_STEPS):
            self._k.update(q)
            worst = self._worst(q, driver, fraction)
            if not np.isfinite(worst) or (worst > 0.5 * last and worst > tolerances.CLOSURE.value):
                return None
            if worst < 1e-15 or (worst < tolerances.CLOSURE.value and worst > 0.1 * last):
                return q
            last = worst
            motion = self._step(q, driver, fraction)
            moved += float(np.abs(motion / self._k.column_scale).max(initial=0.0))
            if moved > reach:
                return None
            q = pin.integrate(self._k.model, q, motion)
        return None

    def _worst(self, q: Array, driver: Driver | None, fraction: float) -> float:
        closure = np.abs(self._k.closure.residual(self._k.data, q)).max(initial=0.0)
        if driver is None:
            return float(closure)
        return float(max(closure, np.abs(driver.error(self._k.data, q, fraction)).max(initial=0.0)))

    def _system(self, q: Array, driver: Driver | None, fraction: float) -> tuple[Array, Array]:
        """Scaled Jacobian and error of closure and driver at the updated configuration."""
        k = self._k
        matrix = k.scaled_jacobian()
        if driver is not None:
            rows = self._driver_scale(driver)[:, None] * driver.jacobian(k.data) * k.column_scale
            matrix = np.concatenate([matrix, rows])
        return matrix, self._error(q, driver, fraction)

    def _error(self, q: Array, driver: Driver | None, fraction: float) -> Array:
        """Scaled error of closure and driver at the updated configuration."""
        k = self._k
        error = k.row_scale * k.closure.residual(k.data, q)
        if driver is None:
            return np.asarray(error)
        return np.concatenate([error, self._driver_scale(driver) * driver.error(k.data, q, fraction)])

    def _driver_scale(self, driver: Driver) -> Array:
        return np.where(driver.is_length, 1.0 / self._k.length, 1.0)

    def _step(self, q: Array, driver: Driver | None, fraction: float) -> Array:
        matrix, error = self._system(q, driver, fraction)
        return np.asarray(_Linear.of(matrix).solve(error) * self._k.column_scale)
