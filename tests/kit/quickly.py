"""Which cases of a family run in the quick suite: the others are marked slow."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def few(values: Iterable[Any], *quick: Any) -> list[Any]:
    """All values as parameters of a test; those that are not among `quick` are slow."""
    return [one if one in quick else pytest.param(one, marks=pytest.mark.slow) for one in values]
