"""Closing the loops: Newton on the closure equations together with what drives them.

A driver says what is prescribed: the actuated coordinates, the tool point or the tool's pose.  `follow` walks from a
closed posture to the target with predictor steps that are short against the links, each corrected by Newton, so it
stays on the branch it started from.  `assemble` takes any start (Levenberg-Marquardt) and makes no promise about the
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
    """How far `follow` came: fraction of the way, the last closed configuration, and why it stopped."""

    fraction: float
    q: Array
    why: str


class Assembler:
    """Solves the closure of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics

    def follow(self, q: Array, driver: Driver) -> Array | Stopped:
        """Walk from the closed configuration `q`, shape (nq,), to the driver's target on the same branch."""
        fraction, step = 0.0, 1.0
        while fraction < 1.0:
            step = min(step, 1.0 - fraction)
            end = 1.0 if fraction + step > 1.0 - 1e-12 else fraction + step
            self._k.update(q)
            motion = self._step(q, driver, end)
            size = float(np.abs(motion / self._k.column_scale).max(initial=0.0))
            if not np.isfinite(size):
                return Stopped(fraction, q, "the equations are singular")
            if size > 1.01 * tolerances.STRIDE.value:
                step *= max(tolerances.STRIDE.value / size, 0.1)
            else:
                corrected = self._newton(pin.integrate(self._k.model, q, motion), driver, end, 0.5 * size + 1e-9)
                if corrected is not None:
                    q, fraction = corrected, end
                    step *= 2.0
                    continue
                step *= 0.5
            if step < SMALLEST_STEP:
                return Stopped(fraction, q, "the joints would have to move without bound")
        return q

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
        matrix, error = k.scaled_jacobian(), k.row_scale * k.closure.residual(k.data, q)
        if driver is None:
            return matrix, error
        scale = np.where(driver.is_length, 1.0 / k.length, 1.0)
        rows = scale[:, None] * driver.jacobian(k.data) * k.column_scale
        return np.concatenate([matrix, rows]), np.concatenate([error, scale * driver.error(k.data, q, fraction)])

    def _step(self, q: Array, driver: Driver | None, fraction: float) -> Array:
        matrix, error = self._system(q, driver, fraction)
        motion = np.linalg.lstsq(matrix, -error, rcond=tolerances.RANK.value)[0]
        return np.asarray(motion * self._k.column_scale)
