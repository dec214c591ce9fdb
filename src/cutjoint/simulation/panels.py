"""What can be drawn of a run over time: panels of curves by name, for plots, pages and the player alike.

A new panel: a function of a `Shown` and a row in `PANELS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.reprs import told
from cutjoint.simulation.panel import Panel, Shown, between, scaled
from cutjoint.simulation.result import Result
from cutjoint.simulation.summary import effort_tops

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain

__all__ = ["PANELS", "USUAL", "Panel", "PanelRow", "Shown", "all_panels", "between", "panels_of", "scaled"]

REACTION_SAMPLES = 1000
"""Samples of a run of which reactions are computed: one to three milliseconds each."""


PLACE, SPEED, EFFORT, POWER = ("m", "rad"), ("m/s", "rad/s"), ("N", "N m"), ("W", "W")
AXES = ("x", "y", "z")


def _of_actuators(
    shown: Shown, title: str, quantity: str, units: tuple[str, str], values: Array, limits: Array | None = None
) -> list[Panel]:
    """A panel for the sliding actuators and one for the turning ones, as far as there are any."""
    panels = []
    for slides, unit in ((True, units[0]), (False, units[1])):
        own = [i for i, (_, kind) in enumerate(shown.actuators) if (kind == "translation") == slides]
        if own:
            names = [shown.actuators[i][0] for i in own]
            bounds = None if limits is None else limits[own]
            panels.append(Panel(title, shown.run.time, values[:, own], unit, quantity, names, limits=bounds))
    return panels


def _error(shown: Shown) -> list[Panel]:
    return [shown.panel("Tool error", shown.run.error, "m", "desired minus actual", AXES)] if shown.run.followed else []


def _orientation(shown: Shown) -> list[Panel]:
    angle = shown.run.more.get("orientation_error")
    return [] if angle is None else [shown.panel("Orientation error of the tool", angle, "rad", "angle", ("angle",))]


def _tool(shown: Shown) -> list[Panel]:
    return [shown.panel("Tool", shown.run.tool, "m", "position", AXES)]


def _tool_velocity(shown: Shown) -> list[Panel]:
    return [shown.panel("Velocity of the tool", shown.run.tool_velocity, "m/s", "velocity", AXES)]


def _joints(shown: Shown) -> list[Panel]:
    limits = _joint_limits(shown.robot, [name for name, _ in shown.actuators])
    return _of_actuators(shown, "Actuated joints", "coordinate", PLACE, shown.run.q, limits)


def _joint_limits(robot: ClosedChain | None, names: Sequence[str]) -> Array | None:
    """Lower and upper limits of joints that have one coordinate, shape (n, 2); None where the robot is unknown."""
    if robot is None:
        return None
    found = {joint.name: joint.limits.ends for joint in robot.description.joints if joint.type.limited}
    return np.array([found.get(name, (-np.inf, np.inf)) for name in names])


def _velocity(shown: Shown) -> list[Panel]:
    return _of_actuators(shown, "Speeds of the actuated joints", "speed", SPEED, shown.run.v)


def _effort_limits(run: Result) -> Array | None:
    """Plus and minus the limit of each actuator, shape (n, 2)."""
    top = effort_tops(run)
    return None if top is None else np.column_stack([-top, top])


def _effort(shown: Shown) -> list[Panel]:
    limits = _effort_limits(shown.run)
    return _of_actuators(shown, "Efforts of the actuators", "effort", EFFORT, shown.run.effort, limits)


def _power(shown: Shown) -> list[Panel]:
    return _of_actuators(shown, "Power of the actuators", "power", POWER, shown.run.effort * shown.run.v)


def _command(shown: Shown) -> list[Panel]:
    """For each actuator what the law asked for, the command, and what came to the joint."""
    run = shown.run
    if "asked" not in run.more or "command" not in run.more:
        return []
    stages = (("asked for", run.more["asked"]), ("command", run.more["command"]), ("at the joint", run.effort))
    limits = _effort_limits(run)
    panels = []
    for i, (name, kind) in enumerate(shown.actuators):
        values = np.column_stack([column[:, i] for _, column in stages])
        bounds = None if limits is None else np.array([[-np.inf, np.inf]] * 2 + [limits[i].tolist()])
        unit = EFFORT[kind != "translation"]
        names = [stage for stage, _ in stages]
        panels.append(Panel(f"Effort of {name}", run.time, values, unit, "effort", names, limits=bounds))
    return panels


def _measured(shown: Shown) -> list[Panel]:
    run, panels = shown.run, []
    for name, title, units, true in (
        ("measured_q", "Measured minus actual coordinate", PLACE, run.q),
        ("measured_v", "Measured minus actual speed", SPEED, run.v),
    ):
        if name in run.more:
            panels += _of_actuators(shown, title, "difference", units, run.more[name] - true)
    return panels


def _passive(shown: Shown) -> list[Panel]:
    """All joints that no actuator drives, lengths and angles apart."""
    from cutjoint.simulation.coordinates import coordinates, joints_of

    run = shown.run
    joints = run.about.get("joints") or joints_of(shown.robot)
    if joints is None:
        return []
    driven = {name for name, _ in shown.actuators}
    found = [one for one in coordinates(run.q_full, joints) if one.joint not in driven]
    panels = []
    for unit in ("m", "rad"):
        own = [one for one in found if one.unit == unit]
        if own:
            values, names = np.column_stack([one.values for one in own]), [one.name for one in own]
            limits = _joint_limits(shown.robot, [one.joint for one in own])
            panels.append(Panel("Passive joints", run.time, values, unit, "coordinate", names, limits=limits))
    return panels


def _energy(shown: Shown) -> list[Panel]:
    run = shown.run
    parts = {
        "kinetic": run.kinetic,
        "change of potential": run.potential - run.potential[0],
        "work of actuators": run.work,
    }
    for name, column in (("work of loads", "load_work"), ("taken by friction", "dissipated")):
        if column in run.more:
            parts[name] = run.more[column]
    lost = run.unaccounted
    return [
        Panel("Energy", run.time, np.column_stack(list(parts.values())), "J", "energy", list(parts)),
        shown.panel("Energy that came from nowhere", lost, "J", "energy", ("balance",)),
    ]


def _gap(shown: Shown) -> list[Panel]:
    gap = shown.run.gap
    panels = [
        shown.panel("Loop gap", gap[:, 0], "m", "distance", ("worst distance",)),
        shown.panel("Loop gap, turning", gap[:, 1], "rad", "angle", ("worst angle",)),
    ]
    return panels if gap[:, 1].any() else panels[:1]


def _reactions(shown: Shown) -> list[Panel]:
    """Size of force and moment in every joint and cut; of long runs at even steps."""
    from cutjoint.simulation.reaction_samples import sampled_reactions

    if shown.robot is None:
        return []
    found = sampled_reactions(shown.run, shown.robot, REACTION_SAMPLES)
    return [
        Panel(
            f"{title} in the joints, at {REACTION_SAMPLES} samples at most",
            found.time,
            np.linalg.norm(values, axis=2),
            unit,
            quantity,
            found.names,
        )
        for title, values, unit, quantity in (
            ("Forces", found.force, "N", "size of the force"),
            ("Moments", found.moment, "N m", "size of the moment"),
        )
    ]


class PanelRow(NamedTuple):
    """What can be asked for: its panels of a run (none where the run has no such thing), what it shows, and what is
    said where it is asked for in vain."""

    make: Callable[[Shown], list[Panel]]
    about: str
    lacks: str = "the robot has no actuators"

    def __repr__(self) -> str:
        return told(self, "about", "lacks")


PANELS: Mapping[str, PanelRow] = {
    "error": PanelRow(_error, "desired minus actual position of the tool", "the run followed nothing"),
    "orientation": PanelRow(
        _orientation,
        "angle between desired and actual orientation",
        "the run followed nothing, or its tool cannot turn",
    ),
    "tool": PanelRow(_tool, "position of the tool"),
    "tool_velocity": PanelRow(_tool_velocity, "velocity of the tool"),
    "joints": PanelRow(_joints, "actuated coordinates"),
    "velocity": PanelRow(_velocity, "actuated velocities"),
    "effort": PanelRow(_effort, "efforts at the joints"),
    "power": PanelRow(_power, "effort times speed"),
    "command": PanelRow(_command, "effort asked for, commanded and acting", "it was made without hardware"),
    "measured": PanelRow(_measured, "what sensors were off", "it was made without hardware"),
    "passive": PanelRow(
        _passive,
        "coordinates that no actuator drives",
        "its file does not name the joints (give the robot), or all of them are driven",
    ),
    "energy": PanelRow(_energy, "energies, works, and what is left over"),
    "gap": PanelRow(_gap, "how far the loops are open"),
    "reactions": PanelRow(
        _reactions,
        "forces and moments in joints and cuts",
        "the robot is not at hand (name it with --robot, or give robot=)",
    ),
}
"""Name, as `--what` has it -> the panels of a run."""
USUAL = ("error", "orientation", "tool", "joints", "effort", "power")
"""What is shown unasked, as far as a run has it."""


def panels_of(result: Result, what: Sequence[str] = (), robot: ClosedChain | None = None) -> list[Panel]:
    """The panels asked for; by default those of `USUAL` that the run has.

    Args:
        result: the run.
        what: names of `PANELS`.
        robot: that it was made with: limits of its joints are drawn, and reactions need it.

    Raises:
        UnknownNameError: there is no panel of that name.
        InputError: the run has nothing to show in it.
    """
    for name in what:
        if name not in PANELS:
            raise UnknownNameError("panel", name, tuple(PANELS))
    shown = Shown(result, robot)
    panels = []
    for name in dict.fromkeys(what or USUAL):
        found = PANELS[name].make(shown)
        if what and not found:
            raise InputError(f"this run has no {name} to show: {PANELS[name].lacks}")
        panels += found
    return panels


def all_panels(result: Result, robot: ClosedChain | None = None) -> tuple[dict[str, list[Panel]], dict[str, str]]:
    """Every panel that a run has, by the names of `PANELS`, and by name why the others are left out."""
    shown = Shown(result, robot)
    panels: dict[str, list[Panel]] = {}
    left: dict[str, str] = {}
    for name, row in PANELS.items():
        try:
            found = row.make(shown)
        except CutjointError as error:
            left[name] = str(error)
            continue
        if found:
            panels[name] = found
        else:
            left[name] = row.lacks
    return panels, left
