"""Workspaces: points that are masked by the million, and whole workspaces of published models and of chains."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.rounds import Contender, duration, measure
from benchmarks.section import SMALL, Section, Size
from cutjoint.arrays import Array
from cutjoint.compile import compiled
from cutjoint.errors import SingularError, UnreachableError
from cutjoint.mechanism import Mechanism
from cutjoint.robots import load, published
from cutjoint.workspace import workspace

VOLUMES = {"omega3": 8.83e-3, "cpm": 1.681}
"""Of the assembly mode of home, from closed forms [m3] (tests/workspace/test_map.py)."""
AROUND = {"omega3": 0.35, "cpm": 1.0}
"""How far points are spread [m]."""


def one_by_one(model: Mechanism, points: Array) -> int:
    """How many points are reached, each asked by itself."""
    count = 0
    for point in points:
        try:
            model.reach(point)
        except (UnreachableError, SingularError):
            continue
        count += 1
    return count


def workspaces(size: Size) -> Section:
    """Points a second, and workspaces with as many cells as a rule."""
    section = Section(
        "Workspaces, CPU time",
        ("robot", "a point, batch", "a point, one by one", "workspace, published", "off", "workspace, chain", "off"),
    )
    cells = 8 if size is SMALL else None
    for name, volume in VOLUMES.items():
        model, chain = compiled(published(name)), compiled(load(name))
        points = np.random.default_rng(0).uniform(-AROUND[name], AROUND[name], (10 * size.inverse, 3))
        few = points[: size.calls]
        found = {one: workspace(one, cells=cells, limits="ignore") for one in (model, chain)}
        times = measure(
            {
                "batch": Contender(partial(model.batch.reached, points), len(points)),
                "single": Contender(partial(one_by_one, model, few), len(few)),
                "published": Contender(partial(workspace, model, cells=cells)),
                "chain": Contender(partial(workspace, chain, cells=cells, limits="ignore")),
            },
            min(size.rounds, 3),
        )
        off = [one.extent / volume - 1.0 for one in found.values()]
        section.rows.append(
            (
                name,
                duration(times["batch"].median),
                duration(times["single"].median),
                duration(times["published"].median),
                f"{100.0 * off[0]:+.2f} %",
                duration(times["chain"].median),
                f"{100.0 * off[1]:+.2f} %",
            )
        )
        section.ratios[f"{name}, points in batches, quicker than one by one"] = times["batch"].ratio(times["single"])
        section.ratios[f"{name}, published model, quicker than chain"] = times["published"].ratio(times["chain"])
        # where one asks alone what is reached is told by an error; both must agree
        section.differences[f"{name}, points reached"] = abs(
            float(model.batch.reached(few)[1].sum()) - one_by_one(model, few)
        )
    return section
