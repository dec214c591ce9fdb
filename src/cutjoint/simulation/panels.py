"""What can be drawn of a run over time: panels of curves by name, for plots, pages and the player alike.

A new panel: a function of a result and a row in `PANELS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cutjoint.arrays import Array, Values, readonly
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line
from cutjoint.simulation.result import Result


@dataclass(frozen=True, eq=False)
class Panel(Values):
    """Quantities over time.

    Attributes:
        title: what is shown.
        time: shape (m,), [s].
        values: shape (m, n), in `unit`.
        unit: SI unit; small lengths are shown in mm or µm.
        quantity: what the vertical axis measures.
        names: of the n curves.
        bound: a limit to draw at plus and minus this value, in `unit`.
        since: time from which the bound counts [s].
        zoom: stretch of time [s] that is shown again, enlarged, or None.
    """

    title: str
    time: Array
    values: Array
    unit: str
    quantity: str
    names: Sequence[str]
    bound: float | None = None
    since: float = 0.0
    zoom: tuple[float, float] | None = None

    __repr__ = line("title", "quantity", "unit", "names", "time", time="s")

    def __post_init__(self) -> None:
        for name in ("time", "values"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


def _error(result: Result) -> list[Panel]:
    return [Panel("Tool error", result.time, result.error, "m", "desired minus actual", ("x", "y", "z"))]


def _tool(result: Result) -> list[Panel]:
    return [Panel("Tool", result.time, result.tool, "m", "position", ("x", "y", "z"))]


def _of_actuators(title: str, quantity: str, units: tuple[str, str], values: Array, result: Result) -> list[Panel]:
    """A panel for the sliding actuators and one for the turning ones, as far as there are any."""
    actuators = result.about["actuators"]
    panels = []
    for kind, unit in zip(("translation", "rotation"), units, strict=True):
        own = [i for i, (_, other) in enumerate(actuators) if (other == "translation") == (kind == "translation")]
        if own:
            names = [actuators[i][0] for i in own]
            panels.append(Panel(title, result.time, values[:, own], unit, quantity, names))
    return panels


def _effort(result: Result) -> list[Panel]:
    return _of_actuators("Efforts of the actuators", "effort", ("N", "N m"), result.effort, result)


def _joints(result: Result) -> list[Panel]:
    return _of_actuators("Actuated joints", "coordinate", ("m", "rad"), result.q, result)


def _power(result: Result) -> list[Panel]:
    return _of_actuators("Power of the actuators", "power", ("W", "W"), result.effort * result.v, result)


PANELS: Mapping[str, Callable[[Result], list[Panel]]] = {
    "error": _error,
    "effort": _effort,
    "tool": _tool,
    "joints": _joints,
    "power": _power,
}
"""Name, as `--what` has it -> the panels of a run."""


def panels_of(result: Result, what: Sequence[str] = ()) -> list[Panel]:
    """The panels asked for; by default error (where something was followed), tool, effort and power.

    Raises:
        UnknownNameError: there is no panel of that name.
        InputError: the run has nothing to show in it.
    """
    names = what or [
        name for name in ("error", "effort", "tool", "joints", "power") if result.followed or name != "error"
    ]
    for name in names:
        if name not in PANELS:
            raise UnknownNameError("panel", name, tuple(PANELS))
    panels = [panel for name in names for panel in PANELS[name](result)]
    if not panels:
        raise InputError("this run has nothing to plot: no actuators and no tool")
    return panels
