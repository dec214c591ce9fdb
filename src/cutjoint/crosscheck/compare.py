"""Every quantity of one model against the same quantity of another, at the same states.

The error of a sample is the largest difference of any entry, relative to the largest entry of that quantity in that
sample, with sliding actuators counted in characteristic lengths of the robot: otherwise the entries of a robot that
turns and slides would outweigh one another by its size.  Three quantities may vanish while their terms do not (J_dot v
of a robot whose Jacobian is constant, C v, and gravity at balance); they are measured against the accelerations or
efforts of the same sample where those are larger.  Positions are measured against the robot, not against their distance
from the origin.  Jacobian and J_dot v are of the tool's frame, its angular velocity counted at the arm of a length of
the robot; which axes two models call those of the tool is their own choice, so turns are compared since home.

What a simplifying hypothesis costs is a comparison along a path: the effort that a robot without it needs, against the
effort that the simplified model predicts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array, Values, readonly
from cutjoint.crosscheck.sampling import REFUSED, Reacher, SampledState, frame_jacobian, length_of, units_of
from cutjoint.doors import door, of_type
from cutjoint.errors import ToleranceError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.reprs import clipped, line, one_line
from cutjoint.tables import TextTable

FAR = 1e-4
"""From 1 / FAR characteristic lengths from the origin on the tool position is measured against this part of its
distance: there the rounding of coordinates shows."""

QUANTITIES = (
    "actuated coordinates",
    "tool position",
    "tool orientation",
    "Jacobian",
    "J_dot v",
    "mass matrix",
    "Coriolis C v",
    "gravity",
    "inverse dynamics",
    "forward dynamics",
)


@dataclass(frozen=True)
class ComparisonRow:
    """Worst relative error of one quantity over all samples, its tolerance, and the number of that sample, from 0."""

    quantity: str
    error: float
    tolerance: float
    sample: int

    __repr__ = line("quantity", "error", "tolerance", "sample")

    @property
    def passes(self) -> bool:
        """Whether the error is within the tolerance (a NaN is not)."""
        return self.error <= self.tolerance


@dataclass(frozen=True)
class Comparison:
    """What came out of comparing `checked` with `reference`.

    Attributes:
        refused: states that `checked` could not take up although the reference could, with the reason of the first.
    """

    checked: str
    reference: str
    samples: int
    rows: tuple[ComparisonRow, ...]
    refused: int = 0
    reason: str = ""

    def __repr__(self) -> str:
        verdict = "agrees" if self.passes else "differs"
        worst = max(self.rows, key=lambda row: row.error / row.tolerance, default=None)
        told = [] if worst is None else [f"worst: {worst.quantity} {worst.error:.2g} of {worst.tolerance:.0e}"]
        names = f"{clipped(self.checked, 24)} against {clipped(self.reference, 24)}"
        return one_line("Comparison", [names, verdict, f"{self.samples} states", *told])

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def table(self) -> TextTable:
        """A row a quantity: worst relative error, tolerance, verdict."""
        rows = [
            (row.quantity, f"{row.error:.1e}", f"{row.tolerance:.0e}", "agrees" if row.passes else "differs")
            for row in self.rows
        ]
        refused = f"{self.refused} states refused ({self.reason})" if self.refused else ""
        title = f"{clipped(self.checked)} against {clipped(self.reference)}: {self.samples} states"
        return TextTable(
            title, ("quantity", "worst error", "tolerance", ""), rows, ("worst error", "tolerance"), refused
        )

    @property
    def passes(self) -> bool:
        """Whether every quantity agrees, in at least one state, and no state was refused."""
        return self.refused == 0 and bool(self.rows) and all(row.passes for row in self.rows)

    def require(self) -> None:
        """Raise where the models do not agree.

        Raises:
            ToleranceError: names every quantity that is off, with its error and tolerance.
        """
        if self.passes:
            return
        worst = {row.quantity: (row.error, row.tolerance) for row in self.rows if not row.passes}
        text = ", ".join(f"{name} {error:.2e} (allowed {allowed:.0e})" for name, (error, allowed) in worst.items())
        if self.refused:
            text = f"{self.refused} of {self.samples} states refused ({self.reason}); {text}".rstrip("; ")
        if not self.samples:
            text = "there was no state to compare them at"
        raise ToleranceError(f"{self.checked} and {self.reference} disagree: {text}", worst=worst)


@door
def compare(
    checked: Mechanism,
    reference: Mechanism,
    states: Iterable[SampledState],
    progress: Callable[[int], None] | None = None,
) -> Comparison:
    """Compare two models of one robot at `states`, which were sampled from `reference`."""
    errors: dict[int, dict[str, tuple[float, float]]] = {}
    refused, reason, count = 0, "", 0
    reacher = Reacher(checked)
    units, length = units_of(reference), length_of(reference)
    for count, state in enumerate(states, start=1):
        of_type("each of the states", state, SampledState)
        try:
            at = reacher.take_up(state)
            found = _evaluate(checked, at, state, units, length)
        except REFUSED as error:
            refused, reason = refused + 1, reason or str(error)
            continue
        wanted = _evaluate(reference, state.at, state, units, length)
        natural = _natural_sizes(reference, state, units, length)
        sizes = {name: max(float(np.abs(wanted[name]).max()), natural.get(name, 0.0)) for name in QUANTITIES}
        sizes["tool position"] = max(length, FAR * float(np.abs(wanted["tool position"]).max()))
        errors[count - 1] = {
            name: (float(np.abs(found[name] - wanted[name]).max()), sizes[name]) for name in QUANTITIES
        }
        if progress is not None:
            progress(count)
    return Comparison(checked.name, reference.name, count, _rows(errors), refused, reason)


def _rows(errors: dict[int, dict[str, tuple[float, float]]]) -> tuple[ComparisonRow, ...]:
    numbers, rows = list(errors), []
    for name in QUANTITIES if errors else ():
        table = np.array([sample[name] for sample in errors.values()])
        relative = table[:, 0] / np.maximum(table[:, 1], 1e-300)
        relative[np.isnan(relative)] = np.inf
        worst = int(np.argmax(relative))
        rows.append(ComparisonRow(name, float(relative[worst]), tolerances.AGREEMENT.value, numbers[worst]))
    return tuple(rows)


def _evaluate(mechanism: Mechanism, at: Posture, state: SampledState, units: Array, length: float) -> dict[str, Array]:
    tool, terms = mechanism.tool(at, state.v), mechanism.terms(at, state.v)
    scale = np.repeat([1.0, length], 3)
    return {
        "actuated coordinates": at.q / units,
        "tool position": tool.position,
        "tool orientation": tool.rotation @ mechanism.tool(mechanism.home).rotation.T,
        "Jacobian": frame_jacobian(tool, units, length),
        "J_dot v": tool.frame_drift * scale,
        "mass matrix": terms.mass * np.outer(units, units),
        "Coriolis C v": terms.coriolis * units,
        "gravity": terms.gravity * units,
        "inverse dynamics": mechanism.inverse_dynamics(at, state.v, state.a) * units,
        "forward dynamics": mechanism.forward_dynamics(at, state.v, state.effort) / units,
    }


def _natural_sizes(reference: Mechanism, state: SampledState, units: Array, length: float) -> dict[str, float]:
    """Sizes that vanishing quantities are measured against: a radian or a length, accelerations of the tool, inertial
    efforts."""
    tool, terms = reference.tool(state.at), reference.terms(state.at, state.v)
    inertial = float(np.abs(terms.mass @ state.a * units).max())
    jacobian = np.repeat([1.0, length], 3)[:, None] * tool.frame_jacobian
    turning = jacobian @ np.linalg.solve(terms.mass, terms.coriolis)
    return {
        "actuated coordinates": 1.0,
        "J_dot v": max(float(np.abs(jacobian @ state.a).max()), float(np.abs(turning).max())),
        "Coriolis C v": inertial,
        "gravity": inertial,
    }


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

    __repr__ = line(peak="N or N m", error="N or N m", inertial_peak="N or N m")

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


@door
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


@door
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
