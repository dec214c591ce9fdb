"""Single loops of every kind: planar, spherical or spatial, closed by any cut, with a gear, a slide or a universal.

The motions of a planar loop are the three of the plane, those of a spherical one the three turns about a point; a
spatial one has all six.  So many of them a cut takes away (ranks below); the loop gets one joint more, so it has one
freedom.  What is added to the plain hinges:

- `coupling`: a gear from the first joint of the loop to a wheel on the base, or to another joint of a loop that got one
  more;
- `prismatic`: one hinge becomes a slide.  In a spherical loop a slide belongs to none of its motions; it is put in
  beside the hinges, and the loop holds it;
- `universal`: one hinge becomes a universal joint.  In a planar loop its second axis cannot turn: the loop holds it; a
  spatial one has one hinge less instead, and in a spherical one both axes count.

No combination is left out: where a joint cannot move, the rows that hold it are judged all the same.
"""

from __future__ import annotations

import numpy as np
from kit.blueprint import Blueprint, random_rotation, unit

Array = np.ndarray
Rng = np.random.Generator

CUTS = ("fixed", "revolute", "prismatic", "universal", "spherical")
SPACES = ("planar", "spherical", "spatial")
EXTRAS = ("none", "coupling", "prismatic", "universal")

RANKS = {
    "planar": {"fixed": 3, "revolute": 2, "prismatic": 2, "universal": 2, "spherical": 2},
    # about one point: a slide there holds all turns; balls and universals sit in the point or (balls) beside it
    "spherical": {"fixed": 3, "revolute": 2, "prismatic": 3, "universal": 1, "spherical": 2},
    "spatial": {"fixed": 6, "revolute": 5, "prismatic": 5, "universal": 4, "spherical": 3},
}
"""How many of the loop's motions a cut takes away."""


def loop(space: str, cut: str, extra: str, rng: Rng) -> tuple[Blueprint, int]:
    """A loop, and how many freedoms it has: one, but for a universal joint and a hinge that close with a universal."""
    plan = Blueprint(f"{space}_{cut}_{extra}", rng)
    tilt, centre = random_rotation(rng), 0.2 * rng.normal(size=3)
    count = RANKS[space][cut] + 1
    freedoms = 1
    inside = extra == "coupling" and rng.integers(2) == 1
    kinds = ["continuous"] * (count + inside)
    if extra == "prismatic" and space == "spherical":
        kinds.insert(int(rng.integers(len(kinds) + 1)), "prismatic")
    elif extra == "prismatic":
        kinds[int(rng.integers(len(kinds)))] = "prismatic"
    elif extra == "universal":
        which = int(rng.integers(len(kinds)))
        kinds[which] = "universal"
        freedoms += space != "planar" and len(kinds) == 2
        if space != "planar" and len(kinds) > 2:
            del kinds[which - 1]
    split = int(rng.integers(len(kinds)))
    ends = {}
    for name, own, side in (("a", kinds[:split], -1.0), ("b", kinds[split:], 1.0)):
        link = "base"
        for index, kind in enumerate(own, start=1):
            at, axis, axis2 = _line(space, kind, tilt, centre, rng, (index + side * 0.3) / (len(own) + 1))
            plan.joint(f"{name}{index}", kind, link, f"{name}_link{index}", at, axis, axis2)
            link = f"{name}_link{index}"
        ends[name] = link
    at, axis, axis2 = _cut_line(space, cut, tilt, centre, rng)
    plan.cut("cut", cut, ends["a"], ends["b"], at, axis, axis2)
    if extra == "coupling":
        names = [joint.name for joint in plan.joints]
        if inside:
            first, second = rng.choice(len(names), 2, replace=False)
            plan.couple("gear", names[first], names[second], float(rng.choice([-2.0, -1.0, 0.5, 1.5])))
        else:
            plan.joint("wheel", "continuous", "base", "wheel_link", 0.3 * rng.normal(size=3), rng.normal(size=3))
            plan.couple("gear", "wheel", names[int(rng.integers(len(names)))], float(rng.choice([-2.0, -1.0, 0.5])))
    return plan, freedoms


def _line(space: str, kind: str, tilt: Array, centre: Array, rng: Rng, along: float) -> tuple[Array, Array, Array]:
    """Point and axes of a joint in the loop."""
    if space == "planar":
        at = tilt @ (np.array([along - 0.5, 0.0, 0.0]) + 0.3 * rng.normal(size=3))
        in_plane = tilt @ np.append(rng.normal(size=2), 0.0)
        first, second = (in_plane, tilt[:, 2]) if kind == "prismatic" else (tilt[:, 2], in_plane)
        # the hinge of a universal joint in the plane is either of its axes
        return (at, second, first) if kind == "universal" and rng.integers(2) else (at, first, second)
    axis, axis2 = unit(rng.normal(size=3)), rng.normal(size=3)
    if space == "spherical":
        reach = 0.0 if kind == "universal" else rng.uniform(0.1, 0.4)
        return centre + reach * axis, axis, axis2
    return 0.4 * rng.normal(size=3), axis, axis2


def _cut_line(space: str, cut: str, tilt: Array, centre: Array, rng: Rng) -> tuple[Array, Array, Array]:
    """Point and axes of the cut."""
    axis, axis2 = unit(rng.normal(size=3)), rng.normal(size=3)
    if space == "planar":
        at = tilt @ (0.4 * rng.normal(size=3))
        in_plane = tilt @ np.append(rng.normal(size=2), 0.0)
        return (at, in_plane, in_plane) if cut == "prismatic" else (at, tilt[:, 2], in_plane)
    if space == "spherical":
        reach = 0.0 if cut == "universal" else rng.uniform(0.1, 0.4)
        return centre + reach * axis, axis, axis2
    return 0.4 * rng.normal(size=3), axis, axis2
