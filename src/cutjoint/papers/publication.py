"""What a paper prints, as data: figures with the digits they were printed with, and the errata found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal


@dataclass(frozen=True)
class PrintedNumber:
    """A number as printed, its digits in Python notation (`0.0027`, `3.4804e-4`)."""

    text: str

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def resolution(self) -> float:
        """One unit of the last printed digit."""
        return float(Decimal(1).scaleb(int(Decimal(self.text).as_tuple().exponent)))

    def agrees(self, value: float) -> bool:
        """Whether `value` rounds to the printed digits."""
        return abs(value - self.value) <= 0.5 * self.resolution * (1.0 + 1e-9)

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Erratum:
    """Something a paper misprints, leaves open or claims against its own equations.

    Attributes:
        key: short name; `test_<key>` in the tests shows the row.
        equation: where in the paper: equation, table or section.
        printed: what stands there, in our own words.
        corrected: what holds and is used here.
        shown: how it was shown.
        computed: whether the tests show it by computing (otherwise it is seen by reading).
    """

    key: str
    equation: str
    printed: str
    corrected: str
    shown: str
    computed: bool = True


def errata_table(rows: Sequence[Erratum]) -> str:
    """The rows as a Markdown table: where, as printed, what holds, how it was shown."""
    lines = ["| where | as printed | what holds | shown by |", "|---|---|---|---|"]
    for row in rows:
        cells = (row.equation, row.printed, row.corrected, row.shown)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"
