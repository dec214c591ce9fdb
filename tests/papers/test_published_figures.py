"""The figures that the papers print, with their digits."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.cpm.published import CIRCLE, TABLE_3
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.papers.omega3.published import CURVE
from cutjoint.papers.publication import PrintedNumber, errata_table


@pytest.mark.parametrize(
    ("text", "value", "resolution"), [("0.0027", 0.0027, 1e-4), ("3.4804e-4", 3.4804e-4, 1e-8), ("101", 101.0, 1.0)]
)
def test_a_figure_knows_its_digits(text, value, resolution):
    figure = PrintedNumber(text)
    assert figure.value == value
    assert figure.resolution == pytest.approx(resolution, rel=1e-12)
    for part, agrees in ((0.0, True), (0.49, True), (-0.49, True), (0.51, False), (-0.51, False)):
        assert figure.agrees(value + part * resolution) == agrees
    assert str(figure) == text


def test_table_3_as_printed():
    gains = [(row.controller, row.k_p, row.k_d) for row in TABLE_3]
    assert gains == [
        ("pd", 12691, 436),
        ("pd_gravity", 8507, 436),
        ("feedforward", 7053, 436),
        ("computed_torque", 2550.25, 101),
    ]
    errors = [float(x) for row in TABLE_3 for x in (row.position_error.text, row.velocity_error.text)]
    assert errors == [2.7e-3, 2.23e-2, 3.4804e-4, 2.1e-2, 3.0256e-4, 1.82e-2, 2.3469e-4, 1.61e-2]


def test_the_paths_lie_in_the_workspaces():
    assert CIRCLE.omega * CIRCLE.duration == pytest.approx(2 * np.pi)
    assert CURVE.omega * CURVE.duration == pytest.approx(2 * np.pi)
    cpm, omega3 = CpmModel(), Omega3Model()
    circle, eight = cpm.home, omega3.home
    for turn in np.linspace(0.0, 2 * np.pi, 101):
        x, y, z = CIRCLE.centre
        circle = cpm.reach([x + CIRCLE.radius * np.cos(turn), y + CIRCLE.radius * np.sin(turn), z], circle)
        eight = omega3.reach([CURVE.x, CURVE.y * np.cos(turn), CURVE.z * np.sin(2 * turn)], eight)
    assert cpm.branch(circle) == (1, -1, 1)
    assert omega3.branch(eight) == ((-1, -1, -1), 1)


@pytest.mark.parametrize("robot", ["cpm", "omega3"])
def test_the_documented_errata_are_the_data(robot):
    rows = importlib.import_module(f"cutjoint.papers.{robot}.errata").ERRATA
    document = (Path(__file__).parents[2] / "docs/errata.md").read_text()
    assert errata_table(rows) in document
