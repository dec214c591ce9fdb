"""What `ClosedChain.mobility` tells of a robot at a posture: as numbers, and as a table."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from cutjoint.reprs import one_line
from cutjoint.tables import TextTable
from cutjoint.texts import Cell


@dataclass(frozen=True)
class MobilityReport:
    """Mobility of a closed robot at one posture.

    Attributes:
        velocities: velocities of the open tree.
        rows, rank: constraint rows, and how many of them are independent here.
        mobility: velocities - rank.
        redundant_rows: names of rows that depend on the rows before them.
        dropped_rows: those of them that do so only up to rounding, and are not closed.
        actuators: number of actuated coordinates.
        determined: whether the actuators determine the motion but for idle ones, and do not depend on each other.
        idle_mobility: number of idle motions: with all actuators locked, and without moving the tool.
        free: passive joints that move with all actuators locked.
        idle: those of them that do so without moving the tool, such as a rod that spins about itself.
        type1, type2: distance to type-1 and type-2 singularities, dimensionless, 0 = singular; NaN where undefined
            (no tool; motion not determined).
        condition: condition number of the tool's Jacobian, its led rows, lengths in lengths of the robot; NaN where
            undefined.
        gap: worst loop gap ([m], [rad]).
    """

    velocities: int
    rows: int
    rank: int
    mobility: int
    redundant_rows: tuple[str, ...]
    dropped_rows: tuple[str, ...]
    actuators: int
    determined: bool
    idle_mobility: int
    free: tuple[str, ...]
    idle: tuple[str, ...]
    type1: float
    type2: float
    condition: float
    gap: tuple[float, float]

    def __repr__(self) -> str:
        counts = [f"{name}={getattr(self, name)}" for name in ("mobility", "actuators", "determined", "velocities")]
        rows = f"{self.rank} of {self.rows} rows independent"
        distances = [f"type{k}={value:.4g}" for k, value in ((1, self.type1), (2, self.type2)) if isfinite(value)]
        return one_line("MobilityReport", [*counts, rows, *distances])

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def table(self) -> TextTable:
        """What there is, how much, and what that means."""
        state = "good" if self.determined else "caution"
        rows: list[tuple[str, ...]] = [
            ("velocities of the open tree", str(self.velocities), ""),
            ("constraint rows", str(self.rows), f"{self.rank} independent"),
            ("redundant rows", str(len(self.redundant_rows)), Cell(", ".join(self.redundant_rows), "dim")),
            ("mobility", Cell(str(self.mobility), "bold"), ""),
        ]
        if self.idle:
            still = Cell(f"{', '.join(self.idle)}: moves no actuator and no tool", "dim")
            rows.append(("of it idle", str(self.idle_mobility), still))
        rows.append(("actuators", str(self.actuators), Cell(self._verdict(), state)))
        if isfinite(self.type2):
            rows.append(("distance to a type-2 singularity", f"{self.type2:.4f}", "0 = moves with actuators locked"))
        if isfinite(self.type1):
            rows.append(("distance to a type-1 singularity", f"{self.type1:.4f}", "0 = tool cannot move somewhere"))
            rows.append(("condition of the tool Jacobian", f"{self.condition:.4g}", ""))
        rows.append(("loop gap", f"{self.gap[0]:.1e} m", f"{self.gap[1]:.1e} rad"))
        return TextTable("mobility", ("", "", ""), rows)

    def _verdict(self) -> str:
        """Whether the actuators determine the motion."""
        if self.determined:
            return "they determine the motion"
        moving = [joint for joint in self.free if joint not in self.idle]
        if moving:
            return f"locked, these still move: {', '.join(moving)}"
        needed = self.mobility - self.idle_mobility
        if not needed:
            return "they cannot move: the loops hold them"
        if self.actuators <= needed:
            return "they do not determine the motion here: the posture is singular"
        beside = " without what is idle" if self.idle_mobility else ""
        return f"{self.actuators - needed} more than the mobility{beside} (redundant actuation)"
