"""docs/corpus.md of what was found."""

from __future__ import annotations

from collections.abc import Sequence


def page(found: Sequence[dict[str, object]]) -> str:
    """The document."""
    return ""
