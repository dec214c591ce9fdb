"""The lists of shipped robots that tests are made from say what is true of the robots."""

from __future__ import annotations

from kit.shipped import DETERMINED, OTHERS, SHIPPED, VARIANTS

from cutjoint import load


def test_the_lists_of_shipped_robots_are_true() -> None:
    robots = {name: load(name) for name in SHIPPED}
    assert {name for name, robot in robots.items() if robot.mobility().determined} == set(DETERMINED)
    assert set(DETERMINED) | set(OTHERS) == set(SHIPPED)
    found = [(name, one.name) for name, robot in robots.items() for one in robot.description.variants]
    assert sorted(found) == sorted(VARIANTS)
