"""What a paper claims, what was found, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


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


@dataclass(frozen=True)
class Claim:
    """A claim of a paper.

    Attributes:
        where: section, table or equation.
        text: the claim, in our own words.
        found: the figures that decide.
        verdict: whether it holds.
    """

    where: str
    text: str
    found: str
    verdict: Verdict
