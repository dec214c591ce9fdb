"""What a paper claims, what was found, and the verdict; and the tables that both papers' parts have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from cutjoint.crosscheck import Cost
from cutjoint.papers.publication import Erratum
from cutjoint.tables import TextTable
from cutjoint.texts import Cell


class Verdict(StrEnum):
    """Whether a claim holds."""

    HOLDS = "holds"
    EQUATION = "holds with equation (39) only"
    INFERRED = "holds with the inferred code only"
    FAILS = "does not hold"

    @classmethod
    def of(cls, equations: bool, inferred: bool | None = None) -> Verdict:
        """From what the paper's equations say and what the inferred code says; None where only the equations judge."""
        if inferred is None or inferred == equations:
            return cls.HOLDS if equations else cls.FAILS
        return cls.EQUATION if equations else cls.INFERRED

    @property
    def cell(self) -> Cell:
        """As it stands in a table."""
        return Cell(self.value, {Verdict.HOLDS: "good", Verdict.FAILS: "bad"}.get(self, "half"))


@dataclass(frozen=True)
class Claim:
    """A claim of a paper in our own words: where it stands, the figures that decide, and whether it holds."""

    where: str
    text: str
    found: str
    verdict: Verdict


def claims_table(title: str, claims: Sequence[Claim]) -> TextTable:
    """Claims with their verdicts."""
    return TextTable(
        title,
        ("where", "claim", "found", "verdict"),
        [(one.where, one.text, one.found, one.verdict.cell) for one in claims],
    )


def errata_table(title: str, errata: Sequence[Erratum]) -> TextTable:
    """Errata as they are used in this project."""
    return TextTable(
        title,
        ("where", "printed", "what holds", "shown by"),
        [(one.equation, one.printed, one.corrected, one.shown) for one in errata],
    )


def cost_table(title: str, cost: Cost) -> TextTable:
    """What a hypothesis costs along a path."""
    columns = ("actuator", "peak effort", "largest difference", "of the peak", "of the inertial part's peak")
    return TextTable(title, columns, cost.rows, right=columns[1:])
