"""What a section of a benchmark run is: how much work, and the table that comes out."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Size:
    """How much work: `full` for the document, small for a check that everything runs."""

    rounds: int = 7
    states: int = 20_000
    calls: int = 2_000
    span: float = 4.0
    steps: tuple[float, ...] = (5e-3, 2.5e-3, 2e-3, 1e-3, 5e-4)
    peer_steps: tuple[float, ...] = (2e-3, 1e-3, 5e-4, 2.5e-4)
    sweep: int = 1000
    sweep_sample: int = 8
    built: int = 10_000
    inverse: int = 100_000
    loops: tuple[int, ...] = (2, 5, 10, 20, 30)
    study: int = 10_000


SMALL = Size(2, 64, 3, 0.02, (1e-3,), (1e-3,), 16, 2, 16, 100, (2, 3), 1100)


@dataclass
class Section:
    """A table, and the ratios and differences that came out."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]] = field(default_factory=list)
    ratios: dict[str, float] = field(default_factory=dict)
    differences: dict[str, float] = field(default_factory=dict)
    points: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    """Work and precision: contender -> (CPU seconds, error)."""
