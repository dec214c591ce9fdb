"""Mechanisms with couplings of several drivers along curves, and with rods that are distances alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from kit.blueprint import Blueprint, Curve, random_rotation, unit
from kit.mechanisms import Mechanism, limb, on_circle

Rng = np.random.Generator

X, Y, Z = np.eye(3)


def random_curve(rng: Rng, x: float, slope: float, reach: float = 0.8) -> Curve:
    """A polynomial or a table whose slope at x is about `slope`, and which bends well within `reach` around it."""
    if rng.integers(2):
        degree = int(rng.integers(2, 7))
        local = np.polynomial.Polynomial([0.0, slope, *(0.4 * slope * rng.normal(size=degree - 1) / reach)])
        moved = local(np.polynomial.Polynomial([-x, 1.0]))
        return tuple(float(c) for c in moved.coef)
    count = int(rng.integers(3, 7))
    steps = np.cumsum(rng.uniform(0.5, 1.5, count))
    at = x + 1.6 * reach * ((steps - steps[0]) / (steps[-1] - steps[0]) - rng.uniform(0.3, 0.7))
    values = slope * (at - x) + 0.15 * slope * reach * rng.normal(size=count)
    return [(float(a), float(b)) for a, b in zip(at, values, strict=True)]


def start_of(plan: Blueprint, joint: str) -> float:
    return float(next(one.start for one in plan.joints if one.name == joint))


def cam_fivebar(rng: Rng) -> Mechanism:
    """A planar five-bar whose second crank follows a curve of the first one: one freedom."""
    plan, tilt = Blueprint("cam_fivebar", rng), random_rotation(rng)
    points = [np.zeros(3), on_circle(0.25, 1.9), np.array([0.15, 0.55, 0.0]), np.array([0.4, 0.2, 0.0]), 0.35 * X]
    points = [tilt @ (point + 0.02 * rng.normal(size=3) * (1, 1, 0)) for point in points]
    axis = tilt @ Z
    limb(plan, "a", "base", [("continuous", points[0], axis), ("continuous", points[1], axis)])
    limb(plan, "b", "base", [("continuous", points[4], axis), ("continuous", points[3], axis)])
    plan.cut("tip", "revolute", "a_link2", "b_link2", points[2], axis)
    plan.curved("cam", "b1", {"a1": random_curve(rng, start_of(plan, "a1"), float(rng.choice([-1.0, 0.5])))})
    plan.actuators, plan.tool = ["a1"], ("a_link2", points[2])
    return Mechanism(plan, 1)


def rover(rng: Rng) -> Mechanism:
    """A carrier whose angle is the mean of two rockers', as a differential has it; all on parallel axes."""
    plan, axis = Blueprint("rover", rng), unit(rng.normal(size=3))
    for name in ("left", "right", "carrier"):
        plan.joint(name, "continuous", "base", f"{name}_link", 0.3 * rng.normal(size=3), axis)
    plan.curved("differential", "carrier", {"left": (0.0, 0.5), "right": (0.0, 0.5)})
    plan.actuators, plan.tool = ["left", "right"], ("carrier_link", 0.3 * rng.normal(size=3))
    return Mechanism(plan, 2)


def summed_arm(rng: Rng) -> Mechanism:
    """A serial arm of six joints, hinges and slides: one is held, one follows curves of three others, one of that."""
    plan = Blueprint("summed_arm", rng)
    kinds = ["continuous", "prismatic", "continuous", "continuous", "prismatic", "continuous"]
    rng.shuffle(kinds)
    points = [(kind, 0.3 * rng.normal(size=3), rng.normal(size=3)) for kind in kinds]
    end = limb(plan, "j", "base", points)
    curves = {f"j{k}": random_curve(rng, start_of(plan, f"j{k}"), rng.uniform(0.2, 0.9)) for k in (1, 2, 4)}
    plan.curved("sum", "j5", curves)
    plan.curved("next", "j6", {"j5": random_curve(rng, start_of(plan, "j5"), -0.6), "j1": (0.0, 0.4)})
    plan.curved("held", "j3", {})
    plan.actuators, plan.tool = ["j1", "j2", "j4"], (end, 0.3 * rng.normal(size=3))
    return Mechanism(plan, 3)


def tabled_lift(rng: Rng) -> Mechanism:
    """Two slides carry the ends of a beam by ball and distance; a screw drives both along curves of its own."""
    plan, tilt = Blueprint("tabled_lift", rng), random_rotation(rng)
    feet = [tilt @ np.array([x, 0.02 * rng.normal(), 0.0]) for x in (-0.3, 0.3)]
    plan.joint("screw", "continuous", "base", "shaft", tilt @ np.array([0.0, 0.3, 0.0]), tilt @ Z)
    for name, foot in zip("ab", feet, strict=True):
        plan.joint(f"{name}_slide", "prismatic", "base", f"{name}_block", foot, tilt @ Z)
        plan.curved(f"{name}_nut", f"{name}_slide", {"screw": random_curve(rng, start_of(plan, "screw"), 0.08)})
    top = tilt @ np.array([0.0, 0.0, 0.35])
    plan.joint("hinge", "continuous", "a_block", "beam", feet[0], tilt @ Y)
    plan.rod("rod", "beam", "b_block", top, feet[1])
    plan.actuators, plan.tool = ["screw"], ("beam", top)
    return Mechanism(plan, 1)


def rssr(rng: Rng) -> Mechanism:
    """The spatial four-bar whose coupler is a rod with a ball at either end: a distance between crank and rocker."""
    plan, tilt = Blueprint("rssr", rng), random_rotation(rng)
    crank, rocker = np.array([0.0, 0.12, 0.05]), np.array([0.4, 0.1, 0.25])
    crank, rocker = (point + 0.02 * rng.normal(size=3) for point in (crank, rocker))
    plan.joint("crank", "continuous", "base", "disc", np.zeros(3), tilt @ unit(X + 0.3 * rng.normal(size=3)))
    plan.joint("rocker", "continuous", "base", "arm", tilt @ (0.4 * X), tilt @ unit(Y + 0.3 * rng.normal(size=3)))
    plan.rod("coupler", "disc", "arm", tilt @ crank, tilt @ rocker)
    plan.actuators, plan.tool = ["crank"], ("arm", tilt @ rocker)
    return Mechanism(plan, 1)


def rod_delta(rng: Rng) -> Mechanism:
    """Three arms carry a platform on six rods without mass: a Delta of distances."""
    plan, height = Blueprint("rod_delta", rng), rng.uniform(0.35, 0.45)
    plan.joint("flight", "floating", "base", "platform", [0.0, 0.0, -height])
    for k in range(3):
        along, axis = on_circle(1.0, 2.0 * k * np.pi / 3), on_circle(1.0, 2.0 * k * np.pi / 3 + np.pi / 2)
        pivot, bend = 0.12 * along, rng.uniform(0.0, 0.4)
        elbow = pivot + rng.uniform(0.14, 0.18) * (np.cos(bend) * along - np.sin(bend) * Z)
        plan.joint(f"motor{k}", "continuous", "base", f"arm{k}", pivot, axis)
        for name, sign in (("left", 0.04), ("right", -0.04)):
            ball = 0.05 * along - height * Z + sign * axis
            plan.rod(f"{name}{k}", f"arm{k}", "platform", elbow + sign * axis, ball)
    plan.actuators, plan.tool = [f"motor{k}" for k in range(3)], ("platform", [0.0, 0.0, -height])
    return Mechanism(plan, 3)


def hanging_plate(rng: Rng) -> Mechanism:
    """A plate on three strings that are always taut: nothing drives it, three freedoms."""
    plan = Blueprint("hanging_plate", rng)
    plan.joint("flight", "floating", "base", "plate", 0.05 * rng.normal(size=3) - 0.4 * Z)
    for k in range(3):
        angle = 2.0 * k * np.pi / 3 + rng.uniform(-0.2, 0.2)
        low = on_circle(0.15, angle, -0.4) + 0.03 * rng.normal(size=3)
        plan.rod(f"string{k}", "base", "plate", on_circle(rng.uniform(0.2, 0.3), angle), low)
    return Mechanism(plan, 3)


def gripper(rng: Rng) -> Mechanism:
    """Two fingers, one of which mirrors the other; the motor sits on the follower, whose coupling says otherwise."""
    plan = Blueprint("gripper", rng)
    plan.joint("left", "prismatic", "base", "left_finger", 0.1 * rng.normal(size=3), X)
    plan.joint("right", "prismatic", "base", "right_finger", 0.1 * rng.normal(size=3), -X)
    plan.curved("mirror", "left", {"right": random_curve(rng, start_of(plan, "right"), 1.0, 0.3)})
    plan.actuators, plan.tool = ["left"], ("right_finger", np.zeros(3))
    return Mechanism(plan, 1)


def follower_fivebar(rng: Rng) -> Mechanism:
    """The five-bar with a cam, its motor on the crank that follows."""
    mechanism = cam_fivebar(rng)
    mechanism.plan.name, mechanism.plan.actuators = "follower_fivebar", ["b1"]
    return mechanism


CURVED: dict[str, Callable[[Rng], Mechanism]] = {
    builder.__name__: builder
    for builder in (
        cam_fivebar, rover, summed_arm, tabled_lift, rssr, rod_delta, hanging_plate, gripper, follower_fivebar,
    )
}  # fmt: skip
