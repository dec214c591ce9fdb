"""The guides for those who add something keep to what they show."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

import cutjoint


def fenced(text: str, language: str) -> str:
    found = re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    assert len(found) == 1, f"{len(found)} blocks of {language}"
    return str(found[0])


@pytest.fixture
def slider_crank(root: Path, tmp_path: Path) -> Path:
    guide = (root / "docs/adding-a-robot.md").read_text()
    (tmp_path / "robot.urdf").write_text(fenced(guide, "xml"))
    (tmp_path / "loops.toml").write_text(fenced(guide, "toml"))
    return tmp_path


def test_robot_of_the_guide_is_sound(slider_crank: Path) -> None:
    assert cutjoint.check(slider_crank) == ()


def test_robot_of_the_guide_has_the_mobility_that_it_states(slider_crank: Path) -> None:
    report = cutjoint.load(slider_crank).mobility()
    assert (report.velocities, report.rows, report.rank, report.mobility) == (3, 5, 2, 1)
    assert len(report.redundant_rows) == 3


def test_robot_of_the_guide_moves_as_a_slider_crank_does(slider_crank: Path) -> None:
    from math import cos, sin, sqrt

    chain = cutjoint.load(slider_crank)
    for angle in (1.0, 1.2, 0.7):
        at = chain.close([angle])
        x = 0.1 * cos(angle) + sqrt(0.3**2 - (0.1 * sin(angle)) ** 2)
        assert chain.tool(at).position == pytest.approx([x, 0.0, 0.0], abs=1e-12)


def test_table_of_tolerances_is_up_to_date(root: Path) -> None:
    page = runpy.run_path(str(root / "tools/tolerances.py"))["page"]()
    assert (root / "docs/tolerances.md").read_text() == page, "run tools/tolerances.py"
    assert page.count("\n| `") >= 6
