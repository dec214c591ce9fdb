"""Mechanisms of the textbooks whose mobility is known, each in a random shape, drawn closed.

Each builder takes a random generator and gives a `Mechanism`.  What is random: lengths and angles as far as the
mechanism allows, frames of links, inertias, coordinates at home.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from kit import ball_rods
from kit.blueprint import Blueprint, random_rotation, turn, unit

Array = np.ndarray
Rng = np.random.Generator

X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Mechanism:
    """A plan, its mobility where it is regular, and at home where that is another one."""

    plan: Blueprint
    mobility: int
    at_home: int | None = None


def on_circle(radius: float, angle: float, height: float = 0.0) -> Array:
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def limb(plan: Blueprint, name: str, start: str, joints: list[tuple[str, Array, Array]]) -> str:
    """Joints (kind, point, axis) one after another from link `start`; returns the last link."""
    for index, (kind, at, axis) in enumerate(joints, start=1):
        plan.joint(f"{name}{index}", kind, start, f"{name}_link{index}", at, axis, axis2=axis)
        start = f"{name}_link{index}"
    return start


def loop_of_lines(name: str, rng: Rng, points: Array, axes: Array) -> Blueprint:
    """A ring of revolute joints on given lines; the base lies between the last and the first."""
    plan = Blueprint(name, rng)
    count = len(points)
    split = int(rng.integers(1, count - 1)) + 1
    left = limb(plan, "a", "base", [("continuous", points[k], axes[k]) for k in range(split - 1)])
    right = limb(plan, "b", "base", [("continuous", points[k], axes[k]) for k in range(count - 1, split - 1, -1)])
    plan.cut("closing", "revolute", left, right, points[split - 1], axes[split - 1])
    plan.actuators = ["b1"]
    return plan


def bennett(rng: Rng) -> Mechanism:
    """Four hinges, a / sin(alpha) = b / sin(beta), opposite links equal (Bennett 1903)."""
    alpha, beta = rng.uniform(0.4, 0.9), rng.uniform(1.1, 1.6)
    a = rng.uniform(0.2, 0.4)
    b = a * np.sin(beta) / np.sin(alpha)
    first = rng.uniform(0.6, 1.5)
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    second = 2.0 * np.arctan2(ratio, np.tan(0.5 * first))
    place, points, axes = np.eye(4), [], []
    for theta, length, twist in [(first, a, alpha), (second, b, beta), (-first, a, alpha), (-second, b, beta)]:
        points.append(place[:3, 3].copy())
        axes.append(place[:3, 2].copy())
        step = np.eye(4)
        step[:3, :3] = turn(Z, theta) @ turn(X, twist)
        step[:3, 3] = turn(Z, theta) @ (length * X)
        place = place @ step
    assert np.abs(place - np.eye(4)).max() < 1e-12, "Bennett's loop is open"
    return Mechanism(loop_of_lines("bennett", rng, np.array(points), np.array(axes)), 1)


def bricard(rng: Rng) -> Mechanism:
    """Six hinges, three anywhere and their images in a half turn: the line-symmetric one (Bricard 1897)."""
    points, axes = 0.4 * rng.normal(size=(3, 3)), np.array([unit(rng.normal(size=3)) for _ in range(3)])
    half = np.diag([-1.0, -1.0, 1.0])
    return Mechanism(loop_of_lines("bricard", rng, np.r_[points, points @ half], np.r_[axes, axes @ half]), 1)


def sarrus(rng: Rng) -> Mechanism:
    """Two limbs of three parallel hinges each guide a plate along a straight line (Sarrus 1853)."""
    plan, height = Blueprint("sarrus", rng), rng.uniform(0.3, 0.5)
    ends = []
    for name, angle in (("a", 0.0), ("b", rng.uniform(1.0, 2.0))):
        axis, r = on_circle(1.0, angle + np.pi / 2), rng.uniform(0.2, 0.3)
        elbow = on_circle(r + rng.uniform(0.1, 0.2), angle, rng.uniform(0.4, 0.6) * height)
        points = [on_circle(r, angle), elbow, on_circle(r, angle, height)]
        ends.append((name, axis, points))
    name, axis, points = ends[0]
    limb(plan, name, "base", [("continuous", point, axis) for point in points])
    name, axis, points = ends[1]
    limb(plan, name, "base", [("continuous", point, axis) for point in points[:2]])
    plan.cut("plate", "revolute", "b_link2", "a_link3", points[2], axis)
    plan.actuators = ["a1"]
    plan.tool = ("a_link3", np.array([0.0, 0.0, height]))
    return Mechanism(plan, 1)


def peaucellier(rng: Rng) -> Mechanism:
    """Eight bars draw a straight line (Peaucellier 1864): arms O-A and O-B, rhombus A-C-B-P, crank Q-C with QC = OQ."""
    plan = Blueprint("peaucellier", rng)
    arm, side, ground, angle = rng.uniform(0.4, 0.45), rng.uniform(0.2, 0.25), rng.uniform(0.14, 0.18), 0.5
    o, q = np.zeros(3), ground * X
    c = q + on_circle(ground, angle)
    along = unit(c - o)
    # both A and B are `arm` from O and `side` from C
    distance = np.linalg.norm(c - o)
    foot = (distance**2 + arm**2 - side**2) / (2.0 * distance)
    rise = np.sqrt(arm**2 - foot**2) * np.cross(Z, along)
    a, b = foot * along + rise, foot * along - rise
    p = a + b - c
    for name, parent, child, at in (
        ("crank", "base", "QC", q), ("arm_a", "base", "OA", o), ("arm_b", "base", "OB", o),
        ("c_a", "QC", "CA", c), ("c_b", "QC", "CB", c), ("a_p", "OA", "AP", a), ("b_p", "OB", "BP", b),
    ):  # fmt: skip
        plan.joint(name, "continuous", parent, child, at, Z)
    plan.cut("at_a", "revolute", "CA", "OA", a, Z)
    plan.cut("at_b", "revolute", "CB", "OB", b, Z)
    plan.cut("at_p", "revolute", "AP", "BP", p, Z)
    plan.actuators, plan.tool = ["crank"], ("AP", p)
    return Mechanism(plan, 1)


def spherical_4r(rng: Rng) -> Mechanism:
    """Four hinges whose axes meet in one point."""
    axes = np.array([on_circle(1.0, k * np.pi / 2 + rng.uniform(-0.3, 0.3), rng.uniform(0.5, 1.5)) for k in range(4)])
    axes = np.array([unit(axis) for axis in axes]) @ random_rotation(rng).T
    reach = rng.uniform(0.2, 0.5, size=(4, 1))
    return Mechanism(loop_of_lines("spherical_4r", rng, reach * axes, axes), 1)


def planar_3rrr(rng: Rng) -> Mechanism:
    """A plate on three limbs of three parallel hinges."""
    plan = Blueprint("planar_3rrr", rng)
    tilt = random_rotation(rng)
    axis, centre = tilt @ Z, rng.uniform(-0.05, 0.05, 3) * (1, 1, 0)
    for k in range(3):
        angle = 2.0 * k * np.pi / 3 + rng.uniform(-0.2, 0.2)
        foot, top = on_circle(0.5, angle), centre + on_circle(0.15, angle + 0.4)
        elbow = 0.5 * (foot + top) + 0.15 * np.cross(Z, unit(top - foot)) * rng.choice([-1.0, 1.0])
        points = [tilt @ point for point in (foot, elbow, top)]
        if k == 0:
            limb(plan, "a", "base", [("continuous", point, axis) for point in points])
        else:
            name = "abc"[k]
            end = limb(plan, name, "base", [("continuous", point, axis) for point in points[:2]])
            plan.cut(f"plate_{name}", "revolute", end, "a_link3", points[2], axis)
    plan.actuators, plan.tool = ["a1", "b1", "c1"], ("a_link3", tilt @ centre)
    return Mechanism(plan, 3)


def spherical_3rrr(rng: Rng) -> Mechanism:
    """A plate that turns about a point on three limbs whose nine axes all meet there (Gosselin's agile eye)."""
    plan, tilt = Blueprint("spherical_3rrr", rng), random_rotation(rng)
    for k in range(3):
        angle = 2.0 * k * np.pi / 3
        axes = [on_circle(1.0, angle, 0.2), on_circle(0.9, angle + 0.9, 0.9), on_circle(1.0, angle + 0.2, 1.8)]
        axes = [tilt @ unit(axis + 0.1 * rng.normal(size=3)) for axis in axes]
        joints = [("continuous", rng.uniform(0.2, 0.4) * axis, axis) for axis in axes]
        name = "abc"[k]
        end = limb(plan, name, "base", joints if k == 0 else joints[:2])
        if k:
            plan.cut(f"plate_{name}", "revolute", end, "a_link3", joints[2][1], axes[2])
    plan.actuators = ["a1", "b1", "c1"]
    return Mechanism(plan, 3)


def prs_3(rng: Rng) -> Mechanism:
    """A plate on three slides, tangential hinges and balls: heave and two tilts, with parasitic motions."""
    plan = Blueprint("prs_3", rng)
    for k in range(3):
        angle = 2.0 * k * np.pi / 3 + rng.uniform(-0.1, 0.1)
        hinge = on_circle(0.4, angle, rng.uniform(0.0, 0.1))
        ball = on_circle(0.2, angle, 0.4 + rng.uniform(-0.03, 0.03))
        name = "abc"[k]
        end = limb(plan, name, "base", [("prismatic", hinge, Z), ("continuous", hinge, np.cross(Z, ball))])
        if k == 0:
            plan.joint("a_ball", "spherical", end, "plate", ball)
        else:
            plan.cut(f"{name}_ball", "spherical", end, "plate", ball)
    plan.actuators, plan.tool = ["a1", "b1", "c1"], ("plate", np.array([0.0, 0.0, 0.4]))
    return Mechanism(plan, 3)


def upu_3(rng: Rng, equal: bool = False) -> Mechanism:
    """A plate that only translates on three universal-prismatic-universal legs (Tsai 1996).

    With equal plates the legs are parallel at home, so all three hold the same turn alone: five freedoms there.
    """
    plan = Blueprint("upu_3_equal" if equal else "upu_3", rng)
    low = rng.uniform(0.3, 0.4)
    high, shift = (low, np.zeros(3)) if equal else (0.5 * low, rng.uniform(-0.05, 0.05, 3))
    for k in range(3):
        angle = 2.0 * k * np.pi / 3 + (0.0 if equal else rng.uniform(-0.1, 0.1))
        foot, top = on_circle(low, angle), on_circle(high, angle, 0.5) + shift
        first, along = on_circle(1.0, angle + np.pi / 2), unit(top - foot)
        second = unit(np.cross(along, first))
        name = "abc"[k]
        plan.joint(f"{name}_foot", "universal", "base", f"{name}_low", foot, first, second)
        plan.joint(f"{name}_slide", "prismatic", f"{name}_low", f"{name}_high", foot + 0.4 * (top - foot), along)
        if k == 0:
            plan.joint("a_top", "universal", "a_high", "plate", top, second, first)
        else:
            plan.cut(f"{name}_top", "universal", f"{name}_high", "plate", top, second, first)
    plan.actuators = ["a_slide", "b_slide", "c_slide"]
    plan.tool = ("plate", shift + 0.5 * Z)
    return Mechanism(plan, 3, 5 if equal else None)


def upu_3_equal(rng: Rng) -> Mechanism:
    """The same with equal plates, whose home is singular."""
    return upu_3(rng, equal=True)


def ups_6(rng: Rng) -> Mechanism:
    """A platform on six universal-prismatic-spherical legs (Gough, Stewart); one of them carries it in the tree."""
    plan = Blueprint("ups_6", rng)
    for k in range(6):
        pair, side = divmod(k, 2)
        middle, sign = 2.0 * pair * np.pi / 3, 2 * side - 1
        foot = on_circle(0.4, middle + sign * 0.25, rng.uniform(-0.02, 0.02))
        top = on_circle(0.2, middle + sign * 0.85, 0.45 + rng.uniform(-0.03, 0.03))
        name = f"leg{k + 1}"
        plan.joint(f"{name}_foot", "universal", "base", f"{name}_low", foot, np.cross(foot, Z), rng.normal(size=3))
        plan.joint(f"{name}_slide", "prismatic", f"{name}_low", f"{name}_high", 0.6 * foot + 0.4 * top, top - foot)
        if k == 0:
            plan.joint(f"{name}_ball", "spherical", f"{name}_high", "platform", top)
        else:
            plan.cut(f"{name}_ball", "spherical", f"{name}_high", "platform", top)
    plan.actuators = [f"leg{k + 1}_slide" for k in range(6)]
    plan.tool = ("platform", np.array([0.0, 0.0, 0.45]))
    return Mechanism(plan, 6)


def scotch_yoke(rng: Rng) -> Mechanism:
    """A pin's block slides across a yoke that slides along the base; the block's slide is the cut."""
    plan, tilt = Blueprint("scotch_yoke", rng), random_rotation(rng)
    pin = on_circle(rng.uniform(0.1, 0.2), rng.uniform(0.5, 1.2))
    plan.joint("crank", "continuous", "base", "disc", np.zeros(3), tilt @ Z)
    plan.joint("pin", "continuous", "disc", "block", tilt @ pin, tilt @ Z)
    plan.joint("slide", "prismatic", "base", "yoke", tilt @ (pin * X), tilt @ X)
    plan.cut("slot", "prismatic", "block", "yoke", tilt @ pin, tilt @ (Y + 0.3 * rng.normal() * X))
    plan.actuators = ["crank"]
    return Mechanism(plan, 1)


def geared_fivebar(rng: Rng) -> Mechanism:
    """A planar five-bar whose cranks a gear couples: one freedom instead of two."""
    plan, tilt = Blueprint("geared_fivebar", rng), random_rotation(rng)
    points = [np.zeros(3), on_circle(0.25, 1.9), np.array([0.15, 0.55, 0.0]), np.array([0.4, 0.2, 0.0]), 0.35 * X]
    points = [tilt @ (point + 0.02 * rng.normal(size=3) * (1, 1, 0)) for point in points]
    axis = tilt @ Z
    limb(plan, "a", "base", [("continuous", points[0], axis), ("continuous", points[1], axis)])
    limb(plan, "b", "base", [("continuous", points[4], axis), ("continuous", points[3], axis)])
    plan.cut("tip", "revolute", "a_link2", "b_link2", points[2], axis)
    plan.couple("gear", "b1", "a1", float(rng.choice([-1.0, -2.0, 0.5])))
    plan.actuators, plan.tool = ["a1"], ("a_link2", points[2])
    return Mechanism(plan, 1)


def parallelogram(rng: Rng, flat: bool = False) -> Mechanism:
    """Equal and parallel cranks.  Flat, all four hinges on one line, it can fold either way: two freedoms there."""
    plan, tilt = Blueprint("parallelogram_flat" if flat else "parallelogram", rng), random_rotation(rng)
    long, angle = rng.uniform(0.4, 0.6), 0.0 if flat else rng.uniform(0.7, 1.3)
    crank, axis = tilt @ on_circle(rng.uniform(0.15, 0.3), angle), tilt @ Z
    base = tilt @ (long * X)
    limb(plan, "a", "base", [("continuous", np.zeros(3), axis), ("continuous", crank, axis)])
    limb(plan, "b", "base", [("continuous", base, axis)])
    plan.cut("pin", "revolute", "a_link2", "b_link1", base + crank, axis)
    plan.actuators, plan.tool = ["a1"], ("a_link2", 0.5 * base + crank)
    return Mechanism(plan, 1, 2 if flat else None)


def parallelogram_flat(rng: Rng) -> Mechanism:
    """The same with a home where branches meet."""
    return parallelogram(rng, flat=True)


def floating_fourbar(rng: Rng) -> Mechanism:
    """A four-bar whose ground link flies: six freedoms and its own."""
    plan, tilt = Blueprint("floating_fourbar", rng), random_rotation(rng)
    points = [np.zeros(3), on_circle(0.15, 1.2), np.array([0.35, 0.35, 0.0]), 0.4 * X]
    points = [tilt @ (point + 0.02 * rng.normal(size=3) * (1, 1, 0)) for point in points]
    plan.joint("flight", "floating", "base", "ground", 0.3 * rng.normal(size=3))
    limb(plan, "a", "ground", [("continuous", points[0], tilt @ Z), ("continuous", points[1], tilt @ Z)])
    limb(plan, "b", "ground", [("continuous", points[3], tilt @ Z)])
    plan.cut("pin", "revolute", "a_link2", "b_link1", points[2], tilt @ Z)
    plan.actuators = ["a1"]
    return Mechanism(plan, 7)


def hexapod(rng: Rng) -> Mechanism:
    """A trunk in the air on six legs of three hinges, feet held by balls: 6 + 18 velocities less 18 rows, six left."""
    plan = Blueprint("hexapod", rng)
    plan.joint("flight", "floating", "base", "trunk", np.array([0.0, 0.0, 0.3]))
    for k in range(6):
        angle = k * np.pi / 3 + rng.uniform(-0.1, 0.1)
        side = on_circle(1.0, angle + np.pi / 2)
        joints = [
            ("continuous", on_circle(0.15, angle, 0.3), Z),
            ("continuous", on_circle(0.2, angle, 0.3), side),
            ("continuous", on_circle(0.35, angle, 0.4 + rng.uniform(-0.02, 0.02)), side),
        ]
        end = limb(plan, f"leg{k + 1}_", "trunk", joints)
        plan.cut(f"foot{k + 1}", "spherical", end, "base", on_circle(0.45, angle, 0.0))
    plan.actuators = [f"leg{k + 1}_{joint}" for k in range(6) for joint in (1, 2, 3)]
    return Mechanism(plan, 6)


def ball_rod_delta(rng: Rng) -> Mechanism:
    """A Delta on six ball-ball rods: three freedoms of the motors and six spins that no motor needs."""
    return Mechanism(ball_rods.Delta(rod=rng.uniform(0.35, 0.45)).plan(rng.uniform(0.2, 0.6), rng), 9)


def ball_rod_ankle(rng: Rng) -> Mechanism:
    """Two motors turn a foot over two ball-ball rods."""
    return Mechanism(ball_rods.ankle(rng), 4)


def ball_rod_slider_crank(rng: Rng) -> Mechanism:
    """A crank drives a slide over a ball-ball rod."""
    return Mechanism(ball_rods.slider_crank(rng), 2)


MECHANISMS: dict[str, Callable[[Rng], Mechanism]] = {
    builder.__name__: builder
    for builder in (
        bennett, bricard, sarrus, peaucellier, spherical_4r, planar_3rrr, spherical_3rrr, prs_3, upu_3, upu_3_equal,
        ups_6, scotch_yoke, geared_fivebar, parallelogram, parallelogram_flat, floating_fourbar, hexapod,
        ball_rod_delta, ball_rod_ankle, ball_rod_slider_crank,
    )
}  # fmt: skip
