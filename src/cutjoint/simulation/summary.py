"""What a run comes to: how it was made, how well it followed, and what tells whether it can be believed, as figures and
as rows of words.  Results that do not tell all of it, as of old files, have fewer rows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.simulation.hardware.telling import told
from cutjoint.simulation.result import FREE, Result

SETTINGS = (
    *("plant", "not_compiled", "law", "gains", "trajectory", "locked", "loads", "integrator"),
    *("rate", "limits", "hardware", "stopped"),
)


def figures_of(result: Result) -> dict[str, object]:
    """What a run comes to, as plain values; units are in the names."""
    gap = result.loop_gap()
    ending = {"loop_gap_before_projection_m": "strayed"}, {"steps": "steps", "evaluations": "evaluations"}
    strayed, counts = (
        {name: result.about[key] for name, key in names.items() if key in result.about}  # type: ignore[literal-required]
        for names in ending
    )
    return {
        **{key: value for key, value in result.about.items() if key in SETTINGS},
        "samples": len(result),
        "duration_s": float(result.time[-1]),
        **(_errors(result) if result.followed else {}),
        "effort_peak": {name: peak for name, _, peak in peaks_of(result)},
        "loop_gap_m": gap[0],
        "loop_gap_rad": gap[1],
        **strayed,
        "energy_drift": result.energy_drift(),
        **counts,
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


def actuators_of(result: Result) -> list[tuple[str, str]]:
    """Name and kind ("translation" or "rotation") of every actuator; q1, q2, ... where a result does not tell."""
    named = result.about.get("actuators") or [[f"q{i + 1}", "rotation"] for i in range(result.q.shape[1])]
    return [(name, kind) for name, kind in named]


def peaks_of(result: Result) -> list[tuple[str, str, float]]:
    """Name, unit of its effort, and largest effort of every actuator."""
    rows = zip(actuators_of(result), result.peak_effort(), strict=True)
    return [(name, "N" if kind == "translation" else "N m", float(peak)) for (name, kind), peak in rows]


def effort_tops(result: Result) -> Array | None:
    """The largest effort that each actuator may give, shape (n,), [N] or [N m]; None of a run without limits."""
    told, n = result.about.get("limits"), result.q.shape[1]
    if told is None or n == 0 or np.size(told) not in (1, n):
        return None
    return np.broadcast_to(np.abs(np.asarray(told, dtype=np.float64)).ravel(), n)


def setting_rows(result: Result) -> list[tuple[str, str]]:
    """How a run was made, besides the robot, the law and the trajectory."""
    about = result.about
    rate = about.get("rate")
    limits = about.get("limits")
    loads = about.get("loads")
    rows = [
        ("gains", ", ".join(f"{name} {_gain(value)}" for name, value in about.get("gains", {}).items()) or "none"),
        ("control", "continuous" if rate is None else f"{rate:g} Hz, held in between"),
    ]
    if "not_compiled" in about:
        rows.append(("not compiled", about["not_compiled"]))
    rows += [(f"  {name}", words) for name, words in told(about.get("hardware", {})) if name != "clock"]
    if limits is not None and "hardware" not in about:
        rows.append(("effort limits", " ".join(f"{one:g}" for one in np.atleast_1d(limits))))
    if loads:
        rows.append(("loads", loads if isinstance(loads, str) else "; ".join(map(_load, loads))))
    if "integrator" in about:
        counts = ", ".join(f"{about[key]} {key}" for key in ("steps", "evaluations") if key in about)
        rows.append(("integrator", f"{about['integrator']}{counts and f': {counts}'}"))
    if "locked" in about:
        rows.append(("locked", ", ".join(about["locked"])))
    return rows


def figure_rows(result: Result, figures: Mapping[str, object]) -> list[tuple[str, str]]:
    """What a run came to, of its `figures_of`."""
    rows = [("stopped early", result.about["stopped"])] if "stopped" in result.about else []
    rows += _error_rows(figures) if result.followed else []
    if "load_work" in result.columns:
        rows.append(("work of loads", f"{result.load_work[-1]:.3g} J"))
    if peaks := peaks_of(result):
        rows.append(("peak effort", ", ".join(f"{name} {peak:.4g} {unit}" for name, unit, peak in peaks)))
    rows.append(("loops", f"closed to {figures['loop_gap_m']:.1e} m, {figures['loop_gap_rad']:.1e} rad"))
    if "loop_gap_before_projection_m" in figures:
        strayed = f"{figures['loop_gap_before_projection_m']:.1e}"
        rows.append(("", f"steps strayed by up to {strayed} m before they were put back"))
    return [*rows, ("energy balance", f"off by {figures['energy_drift']:.1e} of the energy turned over")]


def title_of(result: Result) -> str:
    """Which robot under which law does what."""
    about = result.about
    robot = about.get("plant", about.get("robot", "a robot"))
    return f"{robot}: {about.get('law', 'unknown law')}, {about.get('trajectory', FREE)}{early(result)}"


def early(result: Result) -> str:
    """Words to put behind the title of a run that did not go on to its end."""
    return f" (stopped at {result.time[-1]:.4g} s)" if "stopped" in result.about else ""


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


def _gain(gain: object) -> str:
    """A gain in short; words where a file has something else there."""
    try:
        values = np.atleast_2d(np.asarray(gain, dtype=np.float64))
        rows = [" ".join(f"{value:g}" for value in row) for row in values]
    except (TypeError, ValueError):
        return str(gain)[:60]
    return rows[0] if len(rows) == 1 else f"[{'; '.join(rows)}]"


def _load(load: Mapping[str, object]) -> str:
    """A constant load as `about` has it."""
    words = []
    for name, unit in (("force", "N"), ("moment", "N m")):
        values = np.asarray(load.get(name, 0.0), dtype=np.float64)
        if values.any():
            words.append(f"{' '.join(f'{value:g}' for value in values.ravel())} {unit}")
    return f"{' and '.join(words) or 'nothing'} on {load.get('link') or 'the tool'}"
