"""What a run comes to, as `cutjoint simulate` tells it: how well it followed, and whether it can be believed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from cutjoint.commands import built, output
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cutjoint.simulation import Result

SETTINGS = (
    *("plant", "not_compiled", "law", "gains", "trajectory", "locked", "loads", "integrator"),
    *("rate", "limits", "hardware"),
)


def figures_of(result: Result) -> dict[str, object]:
    """What a run comes to."""
    gap = result.loop_gap()
    return {
        **{key: value for key, value in result.about.items() if key in SETTINGS},
        "samples": len(result),
        "duration_s": float(result.time[-1]),
        **(_errors(result) if result.followed else {}),
        "effort_peak": {name: peak for name, _, peak in _peaks(result)},
        "loop_gap_m": gap[0],
        "loop_gap_rad": gap[1],
        "loop_gap_before_projection_m": result.about["strayed"],
        "energy_drift": result.energy_drift(),
        "steps": result.about["steps"],
        "evaluations": result.about["evaluations"],
    }


def _errors(result: Result) -> dict[str, object]:
    """How well a robot followed."""
    rms, over_time, end = result.rmse(), result.rmse_over_time(), float(result.time[-1])
    turning = "orientation_error" in result.columns
    return {
        "error_rms_m": rms.position,
        "error_rms_m_per_s": rms.velocity,
        "error_rms_over_time_m": over_time.position,
        "error_worst_m": result.worst_error(),
        "error_last_m": result.worst_error(end),
        **({"error_worst_rad": result.worst_turn(), "error_last_rad": result.worst_turn(end)} if turning else {}),
    }


def _peaks(result: Result) -> list[tuple[str, str, float]]:
    """Name, unit of its effort, and largest effort of every actuator."""
    rows = zip(result.about["actuators"], result.peak_effort(), strict=True)
    return [(name, "N" if kind == "translation" else "N m", float(peak)) for (name, kind), peak in rows]


def show(result: Result, figures: Mapping[str, object]) -> None:
    """Print them."""
    from cutjoint.simulation.result import FREE

    gains = ", ".join(f"{name} {_short(value)}" for name, value in result.about["gains"].items()) or "none"
    rate = "continuous" if figures["rate"] is None else f"{figures['rate']:g} Hz, held in between"
    rows = [
        ("gains", gains),
        ("control", rate),
        *([("not compiled", str(figures["not_compiled"]))] if "not_compiled" in figures else ()),
        *((f"  {name}", words) for name, words in built.told(result.about.get("hardware", {})) if name != "clock"),
        ("integrator", f"{figures['integrator']}: {figures['steps']} steps, {figures['evaluations']} evaluations"),
        *(_error_rows(figures) if result.followed else ()),
        *([("locked", ", ".join(result.about["locked"]))] if "locked" in result.about else ()),
        *([("work of loads", f"{result.load_work[-1]:.3g} J")] if "load_work" in result.columns else ()),
        ("peak effort", ", ".join(f"{name} {peak:.4g} {unit}" for name, unit, peak in _peaks(result))),
        ("loops", f"closed to {figures['loop_gap_m']:.1e} m, {figures['loop_gap_rad']:.1e} rad"),
        ("", f"steps strayed by up to {figures['loop_gap_before_projection_m']:.1e} m before they were put back"),
        ("energy balance", f"off by {figures['energy_drift']:.1e} of the energy turned over"),
    ]
    if "saved" in figures:
        rows.append(("saved", str(figures["saved"])))
    title = f"{figures['plant']}: {figures['law']}, {figures.get('trajectory', FREE)}"
    output.show(TextTable(title, ("", ""), rows))


def _error_rows(figures: Mapping[str, object]) -> list[tuple[str, str]]:
    rows = [
        ("tool error", f"{figures['error_rms_m']:.4g} m rms of {figures['samples']} samples"),
        ("", f"{figures['error_rms_over_time_m']:.4g} m rms over time"),
        ("", f"{figures['error_worst_m']:.4g} m at worst, {figures['error_last_m']:.4g} m at the end"),
        ("tool velocity error", f"{figures['error_rms_m_per_s']:.4g} m/s rms of the samples"),
    ]
    if "error_worst_rad" in figures:
        turned = f"{figures['error_worst_rad']:.4g} rad at worst, {figures['error_last_rad']:.4g} rad at the end"
        rows.append(("orientation error", turned))
    return rows


def _short(gain: npt.ArrayLike) -> str:
    rows = [" ".join(f"{value:g}" for value in row) for row in np.atleast_2d(np.asarray(gain, dtype=np.float64))]
    return rows[0] if len(rows) == 1 else f"[{'; '.join(rows)}]"
