"""The files under urdf/ are what the generator writes, and the generator refuses bodies that cannot exist."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

URDF = Path(__file__).resolve().parents[2] / "urdf"


def test_committed_files_are_the_generators(generator: Any) -> None:
    made = {str(path): text for path, text in generator.files().items()}
    found = {
        path.relative_to(URDF).as_posix(): path.read_text(encoding="utf-8")
        for path in URDF.rglob("*")
        if path.is_file() and path.suffix in (".urdf", ".toml")
    }
    assert sorted(made) == sorted(found)
    stale = [path for path in made if made[path] != found[path]]
    assert not stale, f"run `python tools/make_robots.py`: {stale} differ"


def test_two_runs_write_the_same_bytes(generator: Any) -> None:
    assert generator.files() == generator.files()


@pytest.mark.parametrize("moments", [(1.0, 1.0, 2.1), (-1e-9, 1.0, 1.0)], ids=["triangle", "negative"])
def test_impossible_inertias_are_refused(generator: Any, moments: tuple[float, float, float]) -> None:
    from robots.parts import rigid

    with pytest.raises(ValueError, match="rigid body"):
        rigid(1.0, (0.0, 0.0, 0.0), moments)
    with pytest.raises(ValueError, match="rigid body"):
        rigid(0.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))


@pytest.mark.parametrize("value", [1 / 3, 0.1 + 0.2, 2.0, 1e-20, -0.0, 123456.789, 2**0.5 * 1e-7])
def test_cleaned_numbers_are_the_same(generator: Any, value: float) -> None:
    from robots.parts import clean

    assert abs(clean(value) - value) <= max(4e-16 * abs(value), 1e-16)
    assert repr(clean(value)) != "-0.0"


def test_angles_are_written_as_given(generator: Any) -> None:
    from robots.parts import at
    from robots.write import urdf

    from cutjoint.description import Joint, JointType, Link, RobotDescription

    rpy = (0.0, 0.5 * 3.141592653589793, 2.1)
    joint = Joint("joint", JointType.FLOATING, "base", "body", at((0.1, 0.0, 0.0), rpy))
    robot = RobotDescription(name="one", links=(Link("base"), Link("body")), joints=(joint,))
    assert f'rpy="{rpy[0]!r} {rpy[1]!r} {rpy[2]!r}"' in urdf(robot, ())
