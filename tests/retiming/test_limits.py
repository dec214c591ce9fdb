"""Limits of a motion: where they are from, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import cutjoint
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.retiming import limits_of


def test_limits_are_those_of_the_description_where_nothing_is_given() -> None:
    robot = cutjoint.load("cpm")
    limits = limits_of(robot)
    assert limits.effort.tolist() == [120.0] * 3
    assert limits.speed.tolist() == [5.0] * 3
    assert np.isinf([limits.acceleration, limits.jerk, limits.power]).all()
    assert "effort of limb1_slide: 120 N, from the description" in limits.told
    some = limits_of(robot, effort={"limb2_slide": 60}, speed=[1, 2, np.inf])
    assert some.effort.tolist() == [120.0, 60.0, 120.0]
    assert some.speed.tolist() == [1.0, 2.0, np.inf]
    assert some.unit("effort", 0) == "N"
    assert some.named("effort", 1) == "effort of limb2_slide"


def test_a_model_without_a_description_needs_a_limit_of_acceleration() -> None:
    paper = cutjoint.published("cpm")
    with pytest.raises(InputError, match="nothing limits the acceleration"):
        limits_of(paper, speed=1.0)
    assert limits_of(paper, acceleration=2.0).acceleration.tolist() == [2.0] * 3


@pytest.mark.parametrize("wrong", [0, -1.0, np.nan, "x", [1, 2], [[1.0]], [1, 2, -3], [1, 2, np.nan], True])
def test_what_is_no_limit_is_refused(wrong: object) -> None:
    robot = cutjoint.load("cpm")
    with pytest.raises(InputError):
        limits_of(robot, effort=wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError):
        limits_of(robot, effort={"limb1_slide": wrong})  # type: ignore[dict-item]


def test_an_unknown_name_is_told_with_what_is_near() -> None:
    with pytest.raises(UnknownNameError, match="limb1_slide"):
        limits_of(cutjoint.load("cpm"), effort={"limb1_slid": 3.0})
