"""What the control panel shows of a puppet: sliders, working modes, and the figures of its posture, as JSON."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from cutjoint.errors import ActuationError, InputError, SingularError
from cutjoint.mechanism.task import NAMES
from cutjoint.viewer.hand.coordinates import at_limits, coordinates_of
from cutjoint.viewer.hand.lead import POINT, UNITS
from cutjoint.viewer.hand.puppet import Puppet
from cutjoint.viewer.hand.sampling import FURTHEST_TURN
from cutjoint.viewer.picture.figure import Figure
from cutjoint.viewer.picture.limbs import limb_of

UNKNOWN_TURN = math.radians(45.0)
"""Range of a rotation to either side before it was sampled."""


@dataclass(frozen=True)
class Slider:
    """A slider of the panel: what it moves (an actuator or a coordinate of the tool, by number), its unit and range."""

    index: int
    name: str
    unit: str
    lower: float
    upper: float
    colour: str = ""


class ControlPanel:
    """The panel of one puppet, whose robot `figure` shows."""

    def __init__(self, puppet: Puppet, figure: Figure) -> None:
        self._puppet, self._chain, self._figure = puppet, puppet.chain, figure

    def actuated_sliders(self) -> list[Slider]:
        """A slider per actuator."""
        return [
            Slider(i, one.name, one.unit, *self._puppet.span(i), self._figure.colour_of(one.name))
            for i, one in enumerate(self._chain.actuators)
        ]

    def tool_sliders(self) -> list[Slider]:
        """A slider per coordinate of the tool that can be led at home, over what was sampled of the workspace and a
        little more."""
        lead, found = self._puppet.lead, []
        here, ranges = lead.coordinates(self._puppet.at), self._puppet.workspace.ranges
        for row in lead.rows:
            low, high = ranges.get(row, (here[row], here[row]))
            if low == high:
                half = 0.5 * self._puppet.radius if row in POINT else UNKNOWN_TURN
                low, high = here[row] - half, here[row] + half
            margin = 0.1 * (high - low)
            low, high = low - margin, high + margin
            if row not in POINT:
                low, high = max(low, -FURTHEST_TURN), min(high, FURTHEST_TURN)
            found.append(Slider(row, NAMES[row], UNITS[row], low, high))
        return found

    def passive_coordinates(self) -> list[dict[str, str]]:
        """Name, joint and unit of every coordinate of the joints without an actuator, as `state` lists their values."""
        actuated = {actuator.name for actuator in self._chain.actuators}
        return [
            {
                "name": joint.name if joint.type.single else f"{joint.name} {one.name}",
                "joint": joint.name,
                "unit": one.unit,
            }
            for joint in self._chain.description.joints
            if joint.name not in actuated
            for one in joint.type.coordinates
        ]

    def mode_names(self) -> list[str]:
        """A name per working mode: the limbs whose joints stand otherwise than at home."""
        owners = limb_of(self._chain.description)
        home = self._chain.home.q_full
        names = ["1: as at home"]
        for number, mode in enumerate(self._puppet.modes[1:], start=2):
            limbs: dict[str, None] = {}
            for joint in self._chain.description.joints:
                if joint.type.turns and joint.child in owners:
                    i = self._chain.model.idx_qs[self._chain.model.getJointId(joint.name)]
                    if abs(math.remainder(mode.q_full[i] - home[i], 2 * math.pi)) > 1e-3:
                        limbs[owners[joint.child]] = None
            names.append(f"{number}: other {', '.join(limbs) or 'assembly'}")
        return names

    def controls(self) -> dict[str, object]:
        """Sliders, passive joints, modes and toggles, as JSON."""
        task = self._puppet.lead.task
        return {
            "type": "controls",
            "title": self._chain.description.title or self._chain.name,
            "source": self._chain.description.source,
            "actuated": [asdict(slider) for slider in self.actuated_sliders()],
            "tool": [asdict(slider) for slider in self.tool_sliders()],
            "tool_axes": "" if task is None or task.axes == "world" else "along the axes of the tool at home",
            "draggable": self._puppet.lead.draggable,
            "passive": self.passive_coordinates(),
            "note": self._note(),
            "modes": self.mode_names(),
            "labels": self._figure.labels(),
            "toggles": [{"title": t, "paths": p, "shown": s} for t, (p, s) in self._figure.toggles.items()],
        }

    def _note(self) -> str:
        """What a user should know about how the actuators move this robot."""
        report = self._chain.mobility(self._chain.home)
        if report.determined or not self._chain.n:
            return ""
        if report.actuators > report.mobility:
            return "The actuators depend on each other: one alone cannot move. Pull the tool instead."
        return f"With all actuators locked, {', '.join(report.free)} can still move; they move as little as they can."

    def state(self) -> dict[str, object]:
        """The posture and its live figures, as JSON; None where a figure is not defined."""
        stop = self._puppet.stop
        report = self._chain.mobility(self._puppet.at)
        position = self._puppet.tool_position(self._puppet.at)
        joints = coordinates_of(self._chain, self._puppet.at)
        actuated = {actuator.name for actuator in self._chain.actuators}
        effort: list[float] | None = None
        try:
            effort = [float(x) for x in self._chain.terms(self._puppet.at).holding]
        except (ActuationError, SingularError, InputError):
            effort = None
        return {
            "type": "state",
            "q": [float(x) for x in self._puppet.at.q],
            "tool": None if position is None else [float(x) for x in position],
            "coordinates": self._puppet.lead.coordinates(self._puppet.at),
            "passive": [value for name, values in joints.items() if name not in actuated for value in values],
            "at_limit": at_limits(self._chain, joints),
            "gap": [_number(x) for x in self._puppet.at.gap],
            "mobility": report.mobility,
            "rank": report.rank,
            "rows": report.rows,
            "type1": _number(report.type1),
            "type2": _number(report.type2),
            "condition": _number(report.condition),
            "effort": effort,
            "effort_units": [actuator.effort_unit for actuator in self._chain.actuators],
            "mode": self._puppet.mode,
            "stop": None if stop is None else {"kind": stop.kind, "text": stop.text},
        }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
