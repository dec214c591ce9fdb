"""What a run leaves behind: samples over time, and the checks that tell whether to believe them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np

from cutjoint.arrays import Array, Values, readonly, readonly_mapping
from cutjoint.errors import InputError


class Rmse(NamedTuple):
    """Root mean square error of the tool: position [m] and velocity [m/s]."""

    position: float
    velocity: float


@dataclass(frozen=True, eq=False)
class Result(Values):
    """A run: m samples of a robot with n actuators.  Read-only.

    Attributes:
        time: strictly increasing, shape (m,), [s].
        q, v: actuated coordinates and velocities, shape (m, n).
        desired_q, desired_v: what they should have been, shape (m, n).
        tool, tool_velocity: shape (m, 3), [m] and [m/s].
        desired_tool, desired_tool_velocity: shape (m, 3).
        effort: of the actuators from each sample on, shape (m, n), [N] or [N m].
        gap: worst loop residual, shape (m, 2), [m] and [rad].
        kinetic, potential: energy of the plant, shape (m,), [J].
        work: of the actuators since the start, shape (m,), [J].
        q_full: full configuration, shape (m, nq).
        about: how it was made: robot, plant, law, gains, trajectory, integrator, and so on; plain JSON values.
    """

    time: Array
    q: Array
    v: Array
    desired_q: Array
    desired_v: Array
    tool: Array
    tool_velocity: Array
    desired_tool: Array
    desired_tool_velocity: Array
    effort: Array
    gap: Array
    kinetic: Array
    potential: Array
    work: Array
    q_full: Array
    about: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ARRAYS:
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "about", readonly_mapping(self.about))
        wrong = [f"{name} {getattr(self, name).shape}" for name in ARRAYS if not self._fits(name)]
        if wrong:
            raise InputError(f"a result of {self.time.size} samples has arrays that do not fit: {', '.join(wrong)}")
        if not all(np.isfinite(getattr(self, name)).all() for name in ARRAYS):
            raise InputError("a result holds finite numbers only")
        if (np.diff(self.time) <= 0.0).any():
            raise InputError("the times of a result must increase strictly")

    def _fits(self, name: str) -> bool:
        shape = getattr(self, name).shape
        if self.time.ndim != 1 or self.time.size == 0 or not shape or shape[0] != self.time.size:
            return False
        if name in ("q", "v", "desired_q", "desired_v", "effort"):
            return len(shape) == 2 and shape == self.q.shape
        if name in ("tool", "tool_velocity", "desired_tool", "desired_tool_velocity"):
            return bool(shape[1:] == (3,))
        if name == "gap":
            return bool(shape[1:] == (2,))
        return len(shape) == (2 if name == "q_full" else 1)

    def __len__(self) -> int:
        return int(self.time.size)

    def __repr__(self) -> str:
        what = self.about
        return (
            f"Result({what.get('plant', '?')}, {what.get('law', '?')}, {what.get('trajectory', '?')}: "
            f"{len(self)} samples over {self.time[-1] - self.time[0]:g} s)"
        )

    @property
    def error(self) -> Array:
        """Desired minus actual position of the tool, shape (m, 3), [m]."""
        return readonly(self.desired_tool - self.tool)

    @property
    def velocity_error(self) -> Array:
        """Desired minus actual velocity of the tool, shape (m, 3), [m/s]."""
        return readonly(self.desired_tool_velocity - self.tool_velocity)

    def rmse(self) -> Rmse:
        """Root of the mean over the samples of |error|^2 (Elkady et al. 2008, equations 48 and 49).

        It depends on where the samples lie: steps of an adaptive solver crowd where the motion is fast.
        """
        return Rmse(*(float(np.sqrt(np.mean(_squares(e)))) for e in (self.error, self.velocity_error)))

    def rmse_over_time(self) -> Rmse:
        """Root of the mean over time of |error|^2, by the trapezoidal rule; it does not depend on the samples."""
        span = self.time[-1] - self.time[0]
        if span == 0.0:
            return self.rmse()
        means = (np.trapezoid(_squares(e), self.time) / span for e in (self.error, self.velocity_error))
        return Rmse(*(float(np.sqrt(mean)) for mean in means))

    def worst_error(self, after: float = 0.0) -> float:
        """Largest |error| of the tool from time `after` [s] on [m]."""
        return float(np.sqrt(_squares(self.error[self._from(after)]).max()))

    def worst_axis_error(self, after: float = 0.0) -> float:
        """Largest error of the tool along any one axis from time `after` [s] on [m]."""
        return float(np.abs(self.error[self._from(after)]).max())

    def _from(self, after: float) -> slice:
        first = int(np.searchsorted(self.time, after))
        if first == len(self):
            raise InputError(f"the run ends at {self.time[-1]:g} s, before {after:g} s")
        return slice(first, None)

    def peak_effort(self) -> Array:
        """Largest |effort| of each actuator, shape (n,), [N] or [N m]."""
        return readonly(np.abs(self.effort).max(axis=0))

    @property
    def energy(self) -> Array:
        """Kinetic and potential energy, shape (m,), [J]."""
        return readonly(self.kinetic + self.potential)

    def energy_drift(self) -> float:
        """Energy that came from nowhere, relative to the energy that was turned over.

        The largest |change of energy - work of the actuators|, over the largest of: kinetic energy, range of the
        potential energy, |work|.  0 for a robot that did not move.
        """
        lost = np.abs(self.energy - self.energy[0] - self.work).max()
        turned = max(self.kinetic.max(), np.ptp(self.potential), np.abs(self.work).max())
        return float(lost / turned) if turned > 0.0 else float(lost)

    def loop_gap(self) -> tuple[float, float]:
        """Worst loop residual of the run, ([m], [rad])."""
        return float(self.gap[:, 0].max()), float(self.gap[:, 1].max())


ARRAYS = tuple(one.name for one in fields(Result) if one.name != "about")


def _squares(error: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", error, error))
