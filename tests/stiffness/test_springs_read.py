"""Springs and quantities as people write them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cutjoint.description import load_description
from cutjoint.errors import InputError, SettingsError
from cutjoint.stiffness import Beam
from cutjoint.stiffness.reading import both, springs_from_file, springs_of
from cutjoint.stiffness.telling import told
from cutjoint.units import handy, in_si

FILE = """
[actuators]
"*" = "3e4 N m/rad"
[joints]
tip = "50 N/um"
"left_elbow.rx" = "2 kNm/rad"
right_elbow = [1e6, "1 N/um", 1e6, 100, 200, "0.3 kN m/rad"]
[rods]
left_distal = "20 N/mm"
[rods.right_distal]
young = 7e10
shear = 2.6e10
outer = "20 mm"
inner = 0.016
"""


def test_a_file_says_it_all(tmp_path: Path) -> None:
    (tmp_path / "stiffness.toml").write_text(FILE)
    found = springs_from_file(tmp_path / "stiffness.toml", load_description("fivebar"))
    assert found.actuators["*"] == 3e4
    assert found.joints["tip"] == pytest.approx(5e7)
    assert found.joints["left_elbow.rx"] == 2000.0
    assert found.joints["right_elbow"] == [1e6, pytest.approx(1e6), 1e6, 100.0, 200.0, 300.0]
    assert found.rods["left_distal"] == pytest.approx(2e4)
    assert found.rods["right_distal"] == Beam.tube(7e10, 2.6e10, 0.02, 0.016)
    over = both(found, springs_of(load_description("fivebar"), {"*": "1"}, {}, {}))
    assert over.actuators["*"] == 1.0
    assert over.rods == found.rods


@pytest.mark.parametrize(
    ("text", "told_of"),
    [
        ("[actuator]\n'*' = 1", "did you mean 'actuators'"),
        ("[actuators]\nleft = 1", "left_shoulder"),
        ("[actuators]\n'*' = '1 N/m'", "turning stiffness"),
        ("[actuators]\n'*' = true", "turning stiffness"),
        ("[joints]\ntip = [1, 2]", "one number or six"),
        ("[joints]\n'tip.x' = '3 N m/rad'", "stiffness"),
        ("[rods.left_distal]\nyoung = 1", "lacks shear"),
        ("[rods.left_distal]\nyoung = 1\nshear = 1\nouter = 1\ninnr = 1", "did you mean 'inner'"),
        ("[rods.left_distal]\nyoung = 1\nshear = 1\nouter = 1\ninner = 1", "inner diameter"),
        ("actuators = 3", "expected a table"),
        ("[actuators\nx = 1", "does not parse"),
    ],
)
def test_what_is_wrong_in_a_file(text: str, told_of: str, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(SettingsError, match=rf"x\.toml:\d: (?s:.*){told_of}"):
        springs_from_file(tmp_path / "x.toml", load_description("fivebar"))


def test_units() -> None:
    assert in_si("it", "0.1 mm", "length") == pytest.approx(1e-4)
    assert in_si("it", "3", "angle") == 3.0
    assert in_si("it", 2, "angle") == 2.0
    assert in_si("it", "180deg", "angle") == pytest.approx(math.pi)
    assert in_si("it", "1 arcmin", "angle") == pytest.approx(math.pi / 10800)
    assert in_si("it", "2 N·m/mrad", "turning stiffness") == pytest.approx(2000.0)
    for given, kind in (("1 inch", "length"), ("mm", "length"), ("1 mm", "angle"), (True, "length"), (None, "length")):
        with pytest.raises(InputError, match="it must be a"):
            in_si("it", given, kind)  # type: ignore[arg-type]
    assert handy(3e-5, "m") == (pytest.approx(1e6), "µm")
    assert handy(5e7, "N/m") == (pytest.approx(1e-6), "N/µm")
    assert handy(0.0, "m") == (1.0, "m")
    assert told([1.0, 1e-17, -2.5]) == "1, 0, -2.5"
