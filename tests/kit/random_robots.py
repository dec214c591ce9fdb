"""Random robots that close at home: trees of all types of joints, cuts of all types and gears between their bodies.

Most random cuts leave nothing that moves, so that structures are common; joints on parallel axes, through one point or
on a coarse grid, as machines have them, give the rest their freedoms and the rows their redundancy.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from kit.blueprint import Blueprint, random_rotation, unit
from kit.built import choose_actuators

Array = np.ndarray
Rng = np.random.Generator

KINDS = {
    "continuous": 0.35,
    "revolute": 0.15,
    "prismatic": 0.18,
    "universal": 0.08,
    "spherical": 0.1,
    "planar": 0.05,
    "floating": 0.05,
    "fixed": 0.04,
}
CUTS = {"revolute": 0.3, "spherical": 0.35, "universal": 0.15, "prismatic": 0.1, "fixed": 0.1}
STYLES = ("anywhere", "plane", "point", "grid")


def pick(rng: Rng, weights: dict[str, float]) -> str:
    """One of the keys, by its weight."""
    sizes = np.array(list(weights.values()))
    return str(rng.choice(list(weights), p=sizes / sizes.sum()))


class Places:
    """Points and axes of one style, in a frame of their own."""

    def __init__(self, style: str, rng: Rng) -> None:
        self.style, self.rng = style, rng
        self.tilt, self.centre = random_rotation(rng), 0.3 * rng.normal(size=3)

    def line(self, slides: bool) -> tuple[Array, Array, Array]:
        """A point, an axis and a second one, for a joint that turns about the first or slides along it."""
        rng = self.rng
        point, axis, axis2 = 0.35 * rng.normal(size=3), unit(rng.normal(size=3)), rng.normal(size=3)
        if self.style == "plane":
            flat = self.tilt @ np.append(rng.normal(size=2), 0.0)
            return (point, flat, self.tilt[:, 2]) if slides else (point, self.tilt[:, 2], flat)
        if self.style == "point":
            return self.centre + (0.0 if rng.integers(4) == 0 else rng.uniform(-0.4, 0.4)) * axis, axis, axis2
        if self.style == "grid":
            first, second = rng.choice(3, 2, replace=False)
            return self.tilt @ (0.2 * rng.integers(-2, 3, 3)), self.tilt[:, first], self.tilt[:, second]
        return point, axis, axis2


def random_robot(rng: Rng, joints: int, closures: int, folder: Path) -> Blueprint:
    """A robot with this many joints and cuts or couplings; `folder` is where its actuators are tried."""
    style = str(rng.choice(STYLES))
    plan, places = Blueprint(f"{style}_{joints}_{closures}", rng), Places(style, rng)
    bare = 0.25 if rng.integers(4) == 0 else 0.0
    links = ["base"]
    for index in range(1, joints + 1):
        kind = pick(rng, KINDS)
        parent = links[-1] if rng.integers(3) else str(rng.choice(links))
        at, axis, axis2 = places.line(kind == "prismatic")
        plan.joint(f"j{index}", kind, parent, f"l{index}", at, axis, axis2, massless=rng.uniform() < bare)
        links.append(f"l{index}")
    for index in range(1, closures + 1):
        if not (rng.integers(4) == 0 and _gear(plan, f"g{index}", rng)):
            _cut(plan, f"c{index}", places, rng)
    if rng.integers(2):
        choose_actuators(plan, folder)
    else:
        plan.actuators = [name for name in plan.scalars if rng.integers(2)]
    return plan


def _gear(plan: Blueprint, name: str, rng: Rng) -> bool:
    """A gear between two joints of one coordinate, if there are two left that make no ring of gears."""
    free = plan.scalars
    drivers = {driver for one in plan.couplings for driver in one.curves}
    driven = [joint for joint in free if joint not in drivers]
    if len(free) < 2 or not driven:
        return False
    joint = str(rng.choice(driven))
    driver = str(rng.choice([one for one in free if one != joint]))
    plan.couple(name, joint, driver, float(rng.choice([-2.0, -1.0, 0.5, 1.0, 3.0])))
    return True


def _cut(plan: Blueprint, name: str, places: Places, rng: Rng) -> None:
    """A cut between two bodies that no fixed joints hold together."""
    body = {"base": "base"}
    for joint in plan.joints:
        body[joint.child] = body[joint.parent] if joint.kind == "fixed" else joint.child
    pairs = [(a, b) for a in body for b in body if body[a] != body[b]]
    if not pairs:
        return
    a, b = pairs[int(rng.integers(len(pairs)))]
    kind = pick(rng, CUTS)
    at, axis, axis2 = places.line(kind == "prismatic")
    plan.cut(name, kind, a, b, at, axis, axis2)
