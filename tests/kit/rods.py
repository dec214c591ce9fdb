"""Robots with idle freedoms: rods between two balls and legs between two balls, which spin about themselves.

Rods are round unless asked otherwise: their masses lie on their axes, with two equal moments across.
"""

from __future__ import annotations

import numpy as np
from kit.blueprint import Blueprint, Inertia, random_rotation, unit
from kit.mechanisms import on_circle
from kit.writing import rpy_of

Array = np.ndarray
Rng = np.random.Generator

X, Y, Z = np.eye(3)


def rod_body(plan: Blueprint, link: str, start: Array, end: Array, mass: float, out_of_round: float = 0.0) -> None:
    """The inertia of a rod on the line from `start` to `end`.

    Args:
        out_of_round: relative difference of the two moments across; the middle lies beside the line by a tenth of it.
    """
    pose, length, along = plan.poses[link], float(np.linalg.norm(end - start)), unit(end - start)
    frame = np.column_stack([along, *np.linalg.svd(along[None, :])[2][1:]])
    if np.linalg.det(frame) < 0.0:
        frame[:, 2] *= -1.0
    across = mass * length**2 / 12.0
    moments = np.array([0.02 * across, across, across * (1.0 + out_of_round)])
    if out_of_round:
        moments[0] = 0.5 * across  # three moments that a body can have
    middle = start + plan.rng.uniform(0.4, 0.6) * (end - start) + 0.1 * out_of_round * length * frame[:, 1]
    middle = pose.rotation.T @ (middle - pose.position)
    plan.inertias[link] = Inertia(mass, middle, rpy_of(pose.rotation.T @ frame), moments)


def delta(rng: Rng, side: str = "arms", out_of_round: float = 0.0) -> Blueprint:
    """Three motors, three arms, six rods with balls at both ends: mobility 9, of which 6 idle.

    In the tree the rods hang at one `side`: on the "arms", on the "platform", or one of them carries the platform:
    "through".
    """
    plan = Blueprint(f"delta_{side}", rng)
    height = rng.uniform(0.35, 0.45)
    carried = side == "through"
    if not carried:
        plan.joint("flight", "floating", "base", "platform", [0.0, 0.0, -height])
    for k in range(3):
        angle = 2.0 * k * np.pi / 3
        along, axis = on_circle(1.0, angle), on_circle(1.0, angle + np.pi / 2)
        bend = rng.uniform(0.0, 0.4)
        pivot = 0.12 * along
        elbow = pivot + rng.uniform(0.14, 0.18) * (np.cos(bend) * along - np.sin(bend) * Z)
        ball = 0.05 * along - height * Z
        plan.joint(f"motor{k + 1}", "continuous", "base", f"arm{k + 1}", pivot, axis)
        for name, sign in (("left", 1.0), ("right", -1.0)):
            top, low = elbow + 0.04 * sign * axis, ball + 0.04 * sign * axis
            rod = f"{name}{k + 1}"
            if carried:
                plan.joint(f"{rod}_top", "spherical", f"arm{k + 1}", rod, top)
                plan.joint("platform_ball", "spherical", rod, "platform", low)
                carried = False
            elif side == "platform":
                plan.joint(f"{rod}_low", "spherical", "platform", rod, low)
                plan.cut(f"{rod}_top", "spherical", f"arm{k + 1}", rod, top)
            else:
                plan.joint(f"{rod}_top", "spherical", f"arm{k + 1}", rod, top)
                plan.cut(f"{rod}_low", "spherical", rod, "platform", low)
            rod_body(plan, rod, top, low, 0.1, out_of_round)
    plan.actuators = ["motor1", "motor2", "motor3"]
    plan.tool = ("platform", np.array([0.0, 0.0, -height]))
    return plan


def ankle(rng: Rng, out_of_round: float = 0.0, tool: bool = True) -> Blueprint:
    """A foot on a universal joint that two motors tilt through cranks and rods: mobility 4, of which 2 idle."""
    plan = Blueprint("ankle", rng)
    plan.joint("ankle", "universal", "base", "foot", [0.0, 0.0, 0.0], Y, X)
    for k, side in enumerate((1.0, -1.0), start=1):
        pivot = np.array([-0.02, 0.05 * side, 0.25])
        crank = pivot + np.array([-0.05, 0.0, rng.uniform(-0.01, 0.01)])
        heel = np.array([-0.06, 0.04 * side, rng.uniform(0.0, 0.02)])
        plan.joint(f"motor{k}", "continuous", "base", f"crank{k}", pivot, Y)
        plan.joint(f"rod{k}_top", "spherical", f"crank{k}", f"rod{k}", crank)
        plan.cut(f"rod{k}_low", "spherical", f"rod{k}", "foot", heel)
        rod_body(plan, f"rod{k}", crank, heel, 0.1, out_of_round)
    plan.actuators = ["motor1", "motor2"]
    plan.tool = ("foot", np.array([0.1, 0.0, -0.03])) if tool else None
    return plan


def sps_6(rng: Rng, out_of_round: float = 0.0, tool: bool = True) -> Blueprint:
    """A platform on six legs between balls, each of two tubes on a slide: mobility 12, of which 6 idle."""
    plan = Blueprint("sps_6", rng)
    plan.joint("flight", "floating", "base", "platform", [0.0, 0.0, 0.45])
    for k in range(6):
        pair, side = divmod(k, 2)
        middle, sign = 2.0 * pair * np.pi / 3, 2 * side - 1
        foot = on_circle(0.4, middle + sign * 0.25, rng.uniform(-0.02, 0.02))
        top = on_circle(0.2, middle + sign * 0.85, 0.45 + rng.uniform(-0.03, 0.03))
        name, between = f"leg{k + 1}", 0.55 * foot + 0.45 * top
        plan.joint(f"{name}_foot", "spherical", "base", f"{name}_low", foot)
        plan.joint(f"{name}_slide", "prismatic", f"{name}_low", f"{name}_high", between, top - foot, start=0.0)
        plan.cut(f"{name}_top", "spherical", f"{name}_high", "platform", top)
        rod_body(plan, f"{name}_low", foot, between, 0.2, out_of_round)
        rod_body(plan, f"{name}_high", between, top, 0.1, out_of_round)
    plan.actuators = [f"leg{k + 1}_slide" for k in range(6)]
    plan.tool = ("platform", np.array([0.0, 0.0, 0.45])) if tool else None
    return plan


def legs_3(rng: Rng, out_of_round: float = 0.0) -> Blueprint:
    """A platform on a slide, held level by three SPS legs of which one drives: one freedom and three idle spins."""
    plan, tilt = Blueprint("legs_3", rng), random_rotation(rng)
    plan.joint("lift", "prismatic", "base", "platform", tilt @ (0.4 * Z), tilt @ Z, start=0.0)
    for k in range(3):
        foot, top = tilt @ on_circle(0.4, 2.0 * k * np.pi / 3), tilt @ on_circle(0.2, 2.0 * k * np.pi / 3, 0.4)
        name, between = f"leg{k + 1}", 0.55 * foot + 0.45 * top
        plan.joint(f"{name}_foot", "spherical", "base", f"{name}_low", foot)
        plan.joint(f"{name}_slide", "prismatic", f"{name}_low", f"{name}_high", between, top - foot, start=0.0)
        plan.cut(f"{name}_top", "spherical", f"{name}_high", "platform", top)
        rod_body(plan, f"{name}_low", foot, between, 0.2, out_of_round)
        rod_body(plan, f"{name}_high", between, top, 0.1, out_of_round)
    plan.actuators = ["leg1_slide"]
    plan.tool = ("platform", tilt @ (0.45 * Z))
    return plan
