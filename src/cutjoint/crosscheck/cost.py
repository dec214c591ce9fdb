"""What a simplifying hypothesis costs: the effort that a robot without it needs along a path, against the effort the
simplified model predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.mechanism import Mechanism, Posture


@dataclass(frozen=True, eq=False)
class Cost(Values):
    """Largest effort error per actuator along a path.

    Attributes:
        actuators: their names, n of them.
        units: units of their efforts.
        peak: largest effort of the model without the hypothesis, shape (n,).
        error: largest difference, shape (n,).
        inertial_peak: largest effort less gravity, shape (n,).
    """

    actuators: tuple[str, ...]
    units: tuple[str, ...]
    peak: Array
    error: Array
    inertial_peak: Array

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """As text, an actuator each: name, peak effort, error, and it in percent of the two peaks."""
        columns = (self.actuators, self.units, self.peak, self.error, self.percent, self.percent_inertial)
        return [
            (name, f"{peak:.4g} {unit}", f"{error:.3g} {unit}", f"{of_peak:.2f} %", f"{of_inertial:.2f} %")
            for name, unit, peak, error, of_peak, of_inertial in zip(*columns, strict=True)
        ]

    @property
    def percent(self) -> Array:
        """Error in percent of the peak effort, shape (n,)."""
        return _percent(self.error, self.peak)

    @property
    def percent_inertial(self) -> Array:
        """Error in percent of the peak of the inertial part, shape (n,)."""
        return _percent(self.error, self.inertial_peak)


def effort_along(mechanism: Mechanism, path: Sequence[tuple[Array, Array, Array]]) -> tuple[Array, Array]:
    """Effort and its gravity part along tool positions, velocities and accelerations, (3,) each.

    Returns:
        efforts, gravity, shape (len(path), n) each.

    Raises:
        UnreachableError: the path leaves the workspace.
    """
    efforts, gravity = [], []
    near: Posture | None = None
    for position, velocity, acceleration in path:
        near = mechanism.reach(position, near)
        jacobian = mechanism.tool(near).jacobian
        v = np.linalg.lstsq(jacobian, velocity, rcond=None)[0]
        a = np.linalg.lstsq(jacobian, acceleration - mechanism.tool(near, v).drift, rcond=None)[0]
        efforts.append(mechanism.inverse_dynamics(near, v, a))
        gravity.append(mechanism.terms(near).gravity)
    return np.array(efforts), np.array(gravity)


def hypothesis_cost(simplified: Mechanism, physical: Mechanism, path: Sequence[tuple[Array, Array, Array]]) -> Cost:
    """Effort of `physical` along `path` against what `simplified` predicts."""
    predicted, _ = effort_along(simplified, path)
    needed, gravity = effort_along(physical, path)
    return Cost(
        tuple(actuator.name for actuator in physical.actuators),
        tuple(actuator.effort_unit for actuator in physical.actuators),
        readonly(np.abs(needed).max(axis=0)),
        readonly(np.abs(needed - predicted).max(axis=0)),
        readonly(np.abs(needed - gravity).max(axis=0)),
    )


def _percent(error: Array, peak: Array) -> Array:
    """Error in percent of the peak; an actuator that is never wrong has none, also where it does nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(error > 0.0, 100.0 * error / peak, 0.0)
