"""Curves and couplings as values: how they read, and what is wrong with some."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.curved import random_curve
from kit.two_bodies import two_bodies
from oracles.curves import natural_spline, power_series

from cutjoint.description import CutType, check, load_description, with_values
from cutjoint.description.curves import Polynomial, Table
from cutjoint.description.model import Coupling, DriverCurve
from cutjoint.errors import DescriptionError, InputError


@pytest.mark.parametrize("seed", range(12))
def test_a_curve_is_that_of_numpy_or_scipy(seed: int) -> None:
    """Value, slope and bend, beyond the ends of a table too; the same in other units."""
    rng = np.random.default_rng(seed)
    given = random_curve(rng, rng.normal(), rng.normal())
    own = Table(tuple(given)) if isinstance(given, list) else Polynomial(given)
    wanted = natural_spline(given) if isinstance(given, list) else power_series(*given)
    scaled = own.scaled(0.01, 1000.0)
    for x in rng.uniform(-3.0, 3.0, 20):
        size = 1.0 + np.abs(wanted(x)).max()
        np.testing.assert_allclose(own.at(x), wanted(x), rtol=0, atol=1e-11 * size)
        np.testing.assert_allclose(
            np.array(scaled.at(x / 0.01)) * [1000.0, 1000.0 / 0.01, 1000.0 / 0.01**2], own.at(x), atol=1e-9 * size
        )


@pytest.mark.parametrize(
    ("drives", "offset", "formula"),
    [
        ((), 0.0, "j = 0"),
        ((), -0.25, "j = -0.25"),
        ((DriverCurve("a"),), 0.0, "j = a"),
        ((DriverCurve("a", Polynomial((0.0, -1.0))),), 0.5, "j = -a + 0.5"),
        (
            (DriverCurve("a", Polynomial((0.125, 0.5))), DriverCurve("b", Polynomial((0.25, -0.5, 0.0, 1.0)))),
            -0.375,
            "j = 0.5 a - 0.5 b + b^3",
        ),
        ((DriverCurve("a", Table(((0.0, 0.0), (1.0, 2.0)))),), 1.0, "j = spline of 2 points(a) + 1"),
    ],
)  # fmt: skip
def test_a_coupling_reads_as_a_formula(drives: tuple[DriverCurve, ...], offset: float, formula: str) -> None:
    assert Coupling("c", "j", drives, offset).formula == formula


def loops(coupling: str, folder: Path) -> Path:
    joints = "".join(
        f'<link name="{name}"/><joint name="j{name}" type="continuous"><parent link="base"/>'
        f'<child link="{name}"/></joint>'
        for name in "abc"
    )
    (folder / "robot.urdf").write_text(f'<robot name="r"><link name="base"/>{joints}</robot>', encoding="utf-8")
    head = 'schema = 1\nname = "r"\nurdf = "robot.urdf"\nactuators = []\n'
    text = f'[[coupling]]\nname = "c"\njoint = "jc"\n{coupling}\n'
    (folder / "loops.toml").write_text(head + text, encoding="utf-8")
    return folder / "loops.toml"


@pytest.mark.parametrize(
    ("coupling", "words"),
    [
        ('driver = "ja"\npolynomial = []', "coefficients"),
        ('driver = "ja"\npolynomial = 2.0', "coefficients"),
        ('driver = "ja"\npolynomial = [0.0, nan]', "finite"),
        ('driver = "ja"\npolynomial = [0.0, 1e200]', "at most"),
        ('driver = "ja"\ntable = [[0.0, 1.0]]', "two or more points"),
        ('driver = "ja"\ntable = [[0.0, 1.0], [0.0, 2.0]]', "growing x"),
        ('driver = "ja"\ntable = [[1.0, 1.0], [0.0, 2.0]]', "growing x"),
        ('driver = "ja"\nratio = 1.0\npolynomial = [0.0, 1.0]', "one of"),
        ('driver = ["ja", "jb"]\nratio = [1.0]', "2 numbers"),
        ('driver = ["ja", "ja"]', "each driver once"),
        ('driver = ["ja", "jc"]', "to itself"),
        ('driver = ["ja", "jx"]', "jx"),
        ('driver = "ja"\ndrives = [{ driver = "jb" }]', "either drives"),
        ('drives = [{ driver = "ja", rato = 2.0 }]', "rato"),
        ("drives = []", "at least one joint"),
        ("driver = []", "at least one joint"),
        ('driver = "ja"\ntable = [[0.0, 0.0], [1e-300, 1.0]]', "slope"),
        ("", "driver"),
    ],
)
def test_what_is_no_coupling_is_refused(coupling: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=words):
        load_description(loops(coupling, tmp_path))


def test_small_robots_have_large_coefficients(tmp_path: Path) -> None:
    """A cubic between lengths of millimetres."""
    robot = load_description(loops('driver = "ja"\npolynomial = [0.0, 1.0, 0.0, 2e7]', tmp_path))
    assert robot.couplings[0].formula == "jc = ja + 2e+07 ja^3"


def test_a_distance_of_nothing_is_a_spherical_cut() -> None:
    robot = two_bodies("distance")
    with pytest.raises(InputError, match=r"cuts\.cut\.length must be > 0 m, found 0; a spherical cut"):
        with_values(robot, {"cuts.cut.length": 0.0})
    flat = replace(robot, cuts=(replace(robot.cuts[0], length=0.0),))
    assert [(one.expected, one.mend) for one in check(flat)] == [
        ("a length > 0 m", "a spherical cut holds two points together")
    ]
    wrong = replace(robot, cuts=(replace(robot.cuts[0], type=CutType.SPHERICAL),))
    assert "of type spherical has the length 0.25" in str(check(wrong)[0])
