"""What a paper claims, what was found, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Whether a claim holds."""

    HOLDS = "holds"
    INFERRED = "holds with the inferred code only"
    FAILS = "does not hold"

    @classmethod
    def of(cls, equations: bool, inferred: bool = False) -> Verdict:
        """From what the paper's equations say and what the inferred code says."""
        return cls.HOLDS if equations else cls.INFERRED if inferred else cls.FAILS


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
