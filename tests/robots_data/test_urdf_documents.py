"""The table of docs/robots.md says what the files say."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
TABLE = [
    [cell.strip(" `") for cell in line.strip("|").split("|")]
    for line in (ROOT / "docs" / "robots.md").read_text(encoding="utf-8").splitlines()
    if line.startswith("| `")
]


def test_every_robot_is_in_the_table() -> None:
    assert sorted(row[0] for row in TABLE) == sorted(path.parent.name for path in ROOT.glob("urdf/*/loops.toml"))


@pytest.mark.parametrize("row", TABLE, ids=[row[0] for row in TABLE])
def test_table_is_fresh(row: list[str], tree: Callable[..., Any]) -> None:
    name, *cells = row
    robot = tree(name)
    jacobian = robot.gap(robot.close(robot.home()))[1]
    rank = int(np.linalg.matrix_rank(jacobian, tol=1e-6))
    nv, rows, mass = robot.model.nv, jacobian.shape[0], sum(body.mass for body in robot.model.inertias)
    assert [int(cell) for cell in cells[:5]] == [nv, rows, rank, nv - rank, len(robot.actuated)]
    assert float(cells[5]) == pytest.approx(mass, rel=1e-9)
