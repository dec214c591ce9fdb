"""Numbers in words, with what is rounding beside the others left out."""

from __future__ import annotations

from collections.abc import Sequence


def told(values: Sequence[float], size: float = 0.0, digits: int = 4) -> str:
    """Numbers with commas; what is rounding beside the largest, or beside `size`, is 0."""
    largest = max([size, *map(abs, values)])
    return ", ".join("0" if abs(one) <= 1e-9 * largest else f"{one:.{digits}g}" for one in values)
