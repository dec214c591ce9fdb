"""The robots that ship with cutjoint, sorted by what tests ask of them, without loading one while tests are collected.

`tests/chain/test_shipped.py` holds the lists to the robots.
"""

from __future__ import annotations

from cutjoint.description import catalogue

SHIPPED = catalogue.names()
OTHERS = ("redundant", "underactuated")
"""Those whose actuators do not determine the motion."""
DETERMINED = tuple(name for name in SHIPPED if name not in OTHERS)
VARIANTS = tuple((name, variant) for name in ("cpm", "cpm_rotary", "omega3") for variant in ("distributed", "lumped"))
"""Robots with further sets of inertias: (robot, variant)."""
