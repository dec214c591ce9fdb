"""The robots of `kit.led`, each drawn in a random shape: `LED`, name -> builder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from kit.blueprint import Blueprint, random_rotation, unit
from kit.led import Led, Standing, stand
from kit.mechanisms import on_circle
from kit.sized import Size
from oracles.closed_form import (
    Cranks,
    FiveBar,
    Legs,
    OutOfReachError,
    PanTilt,
    SerialWrist,
    SphericalLimbs,
    Tripod,
)

Array = np.ndarray
Rng = np.random.Generator

X, Y, Z = np.eye(3)
STILL = np.eye(3)


def around(rng: Rng, count: int, spread: float = 0.15) -> Array:
    """Angles about evenly around a circle, shape (count,)."""
    return 2.0 * np.pi * np.arange(count) / count + rng.uniform(-spread, spread, count)


def stewart(rng: Rng) -> Led:
    """Six universal-prismatic-spherical legs; the first carries the platform in the tree."""
    pairs = np.repeat(2.0 * np.pi * np.arange(3) / 3, 2)
    low, high = (pairs + np.tile([-1.0, 1.0], 3) * rng.uniform(near, far, 6) for near, far in ((0.1, 0.3), (0.7, 0.95)))
    centre = np.array([*rng.uniform(-0.03, 0.03, 2), rng.uniform(0.4, 0.5)])
    feet = np.array([on_circle(rng.uniform(0.35, 0.45), angle, rng.uniform(-0.02, 0.02)) for angle in low])
    tops = np.array([on_circle(rng.uniform(0.18, 0.24), angle, rng.uniform(-0.04, 0.0)) for angle in high])
    form = Legs(centre, ("x", "y", "z", "rx", "ry", "rz"), feet, tops)
    plan = Blueprint("stewart", rng)
    for k, (foot, top, length) in enumerate(zip(feet, tops + centre, form.joints(centre, STILL), strict=True), start=1):
        along, across = top - foot, np.cross(foot, Z)
        plan.joint(f"foot{k}", "universal", "base", f"low{k}", foot, across, np.cross(across, along))
        plan.joint(f"leg{k}", "prismatic", f"low{k}", f"high{k}", top, along, start=length)
        if k == 1:
            plan.joint("ball1", "spherical", "high1", "platform", top)
        else:
            plan.cut(f"ball{k}", "spherical", f"high{k}", "platform", top)
    plan.actuators, plan.tool = [f"leg{k}" for k in range(1, 7)], ("platform", centre)
    return Led(plan, form, ("x", "y", "z", "rx", "ry", "rz"), True, np.array([0.08] * 3 + [0.25] * 3))


def planar_3rrr(rng: Rng) -> Led:
    """A plate on three limbs of three parallel hinges, with any elbows."""
    angles, signs = around(rng, 3), rng.choice([-1.0, 1.0], 3)
    centre = np.array([*rng.uniform(-0.03, 0.03, 2), 0.0])
    feet = np.array([on_circle(rng.uniform(0.38, 0.42), angle) for angle in angles])
    tops = np.array([on_circle(rng.uniform(0.09, 0.13), angle + rng.uniform(0.2, 0.5)) for angle in angles])
    flat = np.tile(X, (3, 1)), np.tile(Y, (3, 1))
    radii, rods = rng.uniform(0.22, 0.27, 3), rng.uniform(0.22, 0.27, 3)
    form = Cranks(centre, ("x", "y", "rz"), feet, tops, *flat, radii, rods, signs)
    plan = Blueprint("planar_3rrr", rng)
    starts, bends = form.joints(centre, STILL), form.bends(centre, STILL)
    for k, top in enumerate(centre + tops):
        plan.joint(f"crank{k}", "continuous", "base", f"arm{k}", feet[k], Z, start=float(starts[k]))
        plan.joint(f"elbow{k}", "continuous", f"arm{k}", f"rod{k}", bends[k], Z)
        if k == 0:
            plan.joint("top0", "continuous", "rod0", "platform", top, Z)
        else:
            plan.cut(f"top{k}", "revolute", f"rod{k}", "platform", top, Z)
    plan.actuators, plan.tool = ["crank0", "crank1", "crank2"], ("platform", centre)
    return Led(plan, form, ("x", "y", "rz"), False, np.array([0.06, 0.06, 0.4]))


def fivebar(rng: Rng) -> Led:
    """Two cranks whose rods meet in the tool; the cut is there too."""
    feet = np.array([-rng.uniform(0.05, 0.1) * X, rng.uniform(0.05, 0.1) * X])
    centre = np.array([rng.uniform(-0.05, 0.05), rng.uniform(0.28, 0.36), 0.0])
    flat = np.tile(X, (2, 1)), np.tile(Y, (2, 1))
    lengths = rng.uniform(0.22, 0.28, (2, 2))
    form = FiveBar(centre, ("x", "y"), feet, np.zeros((2, 3)), *flat, *lengths, np.array([1.0, -1.0]))
    plan, (angles, bends) = Blueprint("fivebar", rng), (form.joints(centre, STILL), form.bends(centre, STILL))
    for k, name in enumerate("ab"):
        plan.joint(f"crank_{name}", "continuous", "base", f"arm_{name}", feet[k], Z, start=float(angles[k]))
        plan.joint(f"elbow_{name}", "continuous", f"arm_{name}", f"rod_{name}", bends[k], Z)
    plan.cut("tip", "revolute", "rod_a", "rod_b", centre, Z)
    plan.actuators, plan.tool = ["crank_a", "crank_b"], ("rod_a", centre)
    return Led(plan, form, ("x", "y"), False, np.array([0.08, 0.08]))


def delta(rng: Rng) -> Led:
    """Three arms with two ball-ball rods each, every limb with lengths of its own."""
    angles, centre = around(rng, 3), np.array([*rng.uniform(-0.03, 0.03, 2), -rng.uniform(0.33, 0.38)])
    out = np.array([on_circle(1.0, angle) for angle in angles])
    feet = rng.uniform(0.16, 0.2, (3, 1)) * out + rng.uniform(-0.02, 0.02, (3, 1)) * Z
    tops = rng.uniform(0.05, 0.07, (3, 1)) * out + rng.uniform(0.0, 0.02, (3, 1)) * Z
    radii, rods = rng.uniform(0.17, 0.2, 3), rng.uniform(0.37, 0.42, 3)
    form = Cranks(centre, ("x", "y", "z"), feet, tops, out, np.tile(-Z, (3, 1)), radii, rods, -np.ones(3))
    plan, (starts, bends) = Blueprint("delta", rng), (form.joints(centre, STILL), form.bends(centre, STILL))
    plan.joint("flight", "floating", "base", "platform", centre)
    for k in range(3):
        side = np.cross(Z, out[k])
        plan.joint(f"crank{k}", "continuous", "base", f"arm{k}", feet[k], side, start=float(starts[k]))
        for name, half in (("a", 0.035 * side), ("b", -0.035 * side)):
            plan.joint(f"elbow{k}{name}", "spherical", f"arm{k}", f"rod{k}{name}", bends[k] + half)
            plan.cut(f"wrist{k}{name}", "spherical", f"rod{k}{name}", "platform", centre + tops[k] + half)
    plan.actuators, plan.tool = ["crank0", "crank1", "crank2"], ("platform", centre)
    return Led(plan, form, ("x", "y", "z"), False, np.array([0.08] * 3))


def schoenflies(rng: Rng) -> Led:
    """4-RUU: cranks about upright axes, rods between universal joints; the plate turns about the upright alone."""
    angles, centre = around(rng, 4), np.array([*rng.uniform(-0.03, 0.03, 2), 0.0])
    feet = np.array([on_circle(rng.uniform(0.35, 0.45), angle) for angle in angles])
    feet += rng.choice([-1.0, 1.0]) * np.outer([0.3, -0.3, 0.25, -0.2], Z)
    tops = np.array([on_circle(rng.uniform(0.12, 0.18), angle + rng.uniform(0.5, 0.9)) for angle in angles])
    flat = np.tile(X, (4, 1)), np.tile(Y, (4, 1))
    radii, rods = rng.uniform(0.2, 0.25, 4), rng.uniform(0.4, 0.45, 4)
    form = Cranks(centre, ("x", "y", "z", "rz"), feet, tops, *flat, radii, rods, rng.choice([-1.0, 1.0], 4))
    plan, (starts, bends) = Blueprint("schoenflies", rng), (form.joints(centre, STILL), form.bends(centre, STILL))
    for k, top in enumerate(centre + tops):
        across = unit(np.cross(Z, top - bends[k]))
        plan.joint(f"crank{k}", "continuous", "base", f"arm{k}", feet[k], Z, start=float(starts[k]))
        plan.joint(f"elbow{k}", "universal", f"arm{k}", f"rod{k}", bends[k], Z, across)
        if k == 0:
            plan.joint("top0", "universal", "rod0", "platform", top, across, Z)
        else:
            plan.cut(f"top{k}", "universal", f"rod{k}", "platform", top, across, Z)
    plan.actuators, plan.tool = [f"crank{k}" for k in range(4)], ("platform", centre)
    return Led(plan, form, ("x", "y", "z", "rz"), False, np.array([0.06, 0.06, 0.06, 0.3]))


def tripod(rng: Rng) -> Led:
    """3-RPS: legs from tangential hinges to balls, the plate's corners not quite even, so that it turns as it tilts."""
    angles = around(rng, 3, 0.1)
    feet = np.array([on_circle(rng.uniform(0.32, 0.38), angle, rng.uniform(-0.02, 0.02)) for angle in angles])
    hinges = np.array([on_circle(1.0, angle + np.pi / 2) for angle in angles])
    centre = np.array([0.0, 0.0, rng.uniform(0.4, 0.5)])
    tops = np.array([on_circle(rng.uniform(0.18, 0.22), angle) for angle in angles])
    form = Tripod(centre, ("z", "rx", "ry"), feet, tops, hinges)
    plan, lengths = Blueprint("tripod", rng), form.joints(centre, STILL)
    for k, top in enumerate(centre + tops):
        plan.joint(f"hinge{k}", "continuous", "base", f"low{k}", feet[k], hinges[k])
        plan.joint(f"leg{k}", "prismatic", f"low{k}", f"high{k}", top, top - feet[k], start=float(lengths[k]))
        if k == 0:
            plan.joint("ball0", "spherical", "high0", "platform", top)
        else:
            plan.cut(f"ball{k}", "spherical", f"high{k}", "platform", top)
    plan.actuators, plan.tool = ["leg0", "leg1", "leg2"], ("platform", centre)
    return Led(plan, form, ("z", "rx", "ry"), True, np.array([0.1, 0.35, 0.35]))


def spherical_3rrr(rng: Rng) -> Led:
    """A plate that turns about a point, on three limbs whose nine axes meet there; the tool is that point."""
    tilt, signs = random_rotation(rng), rng.choice([-1.0, 1.0], 3)
    angles = around(rng, 3)
    first = np.array([unit(on_circle(1.0, angle, -rng.uniform(0.5, 0.8))) for angle in angles]) @ tilt.T
    last = np.array([unit(on_circle(1.0, angle + 1.0, rng.uniform(0.5, 0.8))) for angle in angles]) @ tilt.T
    u = np.array([unit(np.cross(axis, rng.normal(size=3))) for axis in first])
    form = SphericalLimbs(
        0.2 * rng.normal(size=3), ("rx", "ry", "rz"), first, last, u, np.cross(first, u),
        rng.uniform(1.3, 1.7, 3), rng.uniform(1.3, 1.7, 3), signs,
    )  # fmt: skip
    plan, starts = Blueprint("spherical_3rrr", rng), form.joints(form.centre, STILL)
    for k, axes in enumerate(zip(first, form.middles(), last, strict=True)):
        joints = [("continuous", form.centre + rng.uniform(0.15, 0.25) * axis, axis) for axis in axes]
        plan.joint(f"crank{k}", "continuous", "base", f"arm{k}", joints[0][1], axes[0], start=float(starts[k]))
        plan.joint(f"elbow{k}", "continuous", f"arm{k}", f"rod{k}", joints[1][1], axes[1])
        if k == 0:
            plan.joint("top0", "continuous", "rod0", "platform", joints[2][1], axes[2])
        else:
            plan.cut(f"top{k}", "revolute", f"rod{k}", "platform", joints[2][1], axes[2])
    plan.actuators, plan.tool = ["crank0", "crank1", "crank2"], ("platform", form.centre)
    return Led(plan, form, ("rx", "ry", "rz"), False, np.array([0.3] * 3))


def serial_wrist(rng: Rng) -> Led:
    """Three hinges in a row whose axes meet in the tool point: an open chain."""
    axes, start = random_rotation(rng), rng.uniform(-0.4, 0.4, 3)
    form = SerialWrist(0.2 * rng.normal(size=3), ("rx", "ry", "rz"), axes, start)
    plan, parent = Blueprint("serial_wrist", rng), "base"
    places = (np.zeros(3), start * X, start * (X + Y))
    for k, (name, before) in enumerate(zip(("yaw", "pitch", "roll"), places, strict=True)):
        axis = form.turned(before) @ axes[:, 2 - k]
        at = form.centre + rng.uniform(0.05, 0.1) * axis
        plan.joint(name, "continuous", parent, f"{name}_link", at, axis, start=float(start[k]))
        parent = f"{name}_link"
    plan.actuators, plan.tool = ["yaw", "pitch", "roll"], (parent, form.centre)
    return Led(plan, form, ("rx", "ry", "rz"), False, np.array([0.5] * 3))


def pan_tilt(rng: Rng) -> Led:
    """Two crossing hinges and an arm: the tool goes all over a sphere."""
    arm, start, middle = rng.uniform(0.25, 0.5), rng.uniform(-0.5, 0.5, 2), 0.1 * rng.normal(size=3)
    point, turned = PanTilt(np.zeros(3), ("pan", "tilt"), arm, start).at(start)
    form = PanTilt(middle + point, ("pan", "tilt"), arm, start)
    plan = Blueprint("pan_tilt", rng)
    plan.joint("pan", "continuous", "base", "fork", middle, Z, start=float(start[0]))
    plan.joint("tilt", "continuous", "fork", "head", middle, -turned[:, 1], start=float(start[1]))
    plan.actuators, plan.tool = ["pan", "tilt"], ("head", form.centre)
    return Led(plan, form, ("x", "y", "z"), False, np.array([0.6, 0.6]))


LED: dict[str, Callable[[Rng], Led]] = {
    builder.__name__: builder
    for builder in (
        stewart, planar_3rrr, fivebar, delta, schoenflies, tripod, spherical_3rrr, serial_wrist, pan_tilt,
    )
}  # fmt: skip


def drawn(name: str, seed: int) -> Led:
    """One of `LED` in a random shape that is regular around home."""
    for attempt in range(500):
        rng = np.random.default_rng([seed, attempt, *name.encode()])
        try:
            led = LED[name](rng)
        except OutOfReachError:
            continue
        trials = (led.spread * rng.uniform(-1.0, 1.0, len(led.spread)) for _ in range(10))
        if led.is_regular(0.0 * led.spread) and sum(map(led.is_regular, trials)) >= 6:
            return led
    raise AssertionError(f"no regular {name}")


def somewhere(name: str, seed: int, folder: Path, rng: Rng) -> Standing:
    """A random shape on the ground: in the world's axes where the seed is even, else anywhere, of any size."""
    size = Size()
    if seed % 2:
        length = 10.0 ** rng.uniform(-3.0, 3.0)
        size = Size(length=length, rotation=random_rotation(rng), offset=length * rng.normal(size=3))
    return stand(drawn(name, seed), folder / str(seed), size)
