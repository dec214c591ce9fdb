"""Robots on rods with a ball at either end, which may spin about themselves: freedoms that no motor moves or needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from kit.blueprint import Blueprint, Inertia, turn

Array = np.ndarray
Rng = np.random.Generator

X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Delta:
    """A Delta whose arms all stand at one angle below the horizontal; lengths [m], masses [kg], rods uniform."""

    base: float = 0.21
    platform: float = 0.06
    arm: float = 0.18
    rod: float = 0.39
    half_width: float = 0.035
    arm_mass: float = 0.31
    arm_inertia: float = 0.0009
    rod_mass: float = 0.045
    platform_mass: float = 0.22
    weight: float = 9.81

    def heights(self, angle: float) -> tuple[float, float]:
        """Of the elbows and of the platform."""
        elbow = -self.arm * np.sin(angle)
        reach = self.base + self.arm * np.cos(angle) - self.platform
        return elbow, elbow - np.sqrt(self.rod**2 - reach**2)

    def potential(self, angle: float) -> float:
        """Energy of gravity [J]."""
        elbow, platform = self.heights(angle)
        arms, rods = 1.5 * self.arm_mass * elbow, 3.0 * self.rod_mass * (elbow + platform)
        return self.weight * (arms + rods + self.platform_mass * platform)

    def slopes(self, angle: float) -> tuple[float, float]:
        """Derivatives of both heights by the angle."""
        elbow, platform = self.heights(angle)
        reach = self.base + self.arm * np.cos(angle) - self.platform
        down = -self.arm * np.cos(angle)
        return down, down + reach * self.arm * np.sin(angle) / (platform - elbow)

    def mass(self, angle: float) -> float:
        """m of the kinetic energy m angle'^2 / 2 [kg m2] where the rods do not spin: (u^2 + u w + w^2) m / 6 each."""
        platform = self.slopes(angle)[1]
        end, other = self.arm * np.array([-np.sin(angle), -np.cos(angle)]), np.array([0.0, platform])
        rods = 6.0 * self.rod_mass / 3.0 * (end @ end + end @ other + other @ other)
        return 3.0 * self.arm_inertia + 0.75 * self.arm_mass * self.arm**2 + rods + self.platform_mass * platform**2

    def torque_at_rest(self, angle: float) -> float:
        """Of each motor, to hold the robot still [N m]."""
        elbow, platform = self.slopes(angle)
        rate = 1.5 * self.arm_mass * elbow + 3.0 * self.rod_mass * (elbow + platform) + self.platform_mass * platform
        return self.weight * rate / 3.0

    def plan(self, angle: float, rng: Rng) -> Blueprint:
        """Drawn with the arms at an angle."""
        plan = Blueprint("ball_rod_delta", rng)
        elbow, platform = self.heights(angle)
        plan.joint("flight", "floating", "base", "platform", platform * Z)
        plan.inertias["platform"] = Inertia(self.platform_mass, np.zeros(3), np.zeros(3), np.full(3, 3e-4))
        for k in range(3):
            about = turn(Z, 2.0 * k * np.pi / 3.0)
            out, side = about @ X, about @ Y
            motor, joint = self.base * out, (self.base + self.arm * np.cos(angle)) * out + elbow * Z
            plan.joint(f"motor{k}", "continuous", "base", f"arm{k}", motor, side, start=angle)
            uniform_rod(plan, f"arm{k}", joint - motor, self.arm_mass, np.array([1e-4, *[self.arm_inertia] * 2]))
            for sign, name in ((1.0, "a"), (-1.0, "b")):
                at = joint + sign * self.half_width * side
                to = (self.platform * out + platform * Z) + sign * self.half_width * side
                plan.joint(f"elbow{k}{name}", "spherical", f"arm{k}", f"rod{k}{name}", at)
                across = self.rod_mass * self.rod**2 / 12.0
                uniform_rod(plan, f"rod{k}{name}", to - at, self.rod_mass, np.array([1e-6, across, across]))
                plan.cut(f"wrist{k}{name}", "spherical", f"rod{k}{name}", "platform", to)
        plan.actuators, plan.tool = [f"motor{k}" for k in range(3)], ("platform", platform * Z)
        return plan


def uniform_rod(plan: Blueprint, link: str, span: Array, mass: float, moments: Array) -> None:
    """Give a link the inertia of a rod along `span` from its origin: moments about the rod and twice across."""
    along = span / np.linalg.norm(span)
    local = plan.poses[link].rotation.T @ along
    yaw, pitch = np.arctan2(local[1], local[0]), -np.arcsin(np.clip(local[2], -1.0, 1.0))
    plan.inertias[link] = Inertia(mass, 0.5 * np.linalg.norm(span) * local, np.array([0.0, pitch, yaw]), moments)


def ankle(rng: Rng, even: bool = False) -> Blueprint:
    """A foot on two crossing hinges, led by two motors over ball-ball rods: four freedoms, two of them idle.

    Rods that are `even` are the same all around, so that their spin moves no weight.
    """
    plan, height = Blueprint("ball_rod_ankle", rng), rng.uniform(0.2, 0.3)
    plan.joint("pitch", "continuous", "base", "cross", np.zeros(3), Y)
    plan.joint("roll", "continuous", "cross", "foot", np.zeros(3), X)
    for name, sign in (("left", 1.0), ("right", -1.0)):
        motor = np.array([0.0, sign * rng.uniform(0.03, 0.05), height])
        crank = motor + np.array([-rng.uniform(0.03, 0.05), 0.0, 0.01 * rng.normal()])
        plan.joint(f"motor_{name}", "continuous", "base", f"crank_{name}", motor, Y)
        plan.joint(f"ball_{name}", "spherical", f"crank_{name}", f"rod_{name}", crank)
        heel = np.array([-0.04, sign * rng.uniform(0.03, 0.05), 0.0])
        plan.cut(f"heel_{name}", "spherical", f"rod_{name}", "foot", heel)
        if even:
            uniform_rod(plan, f"rod_{name}", heel - crank, 0.3, np.array([1e-5, 2e-3, 2e-3]))
    plan.actuators, plan.tool = ["motor_left", "motor_right"], ("foot", [0.1, 0.0, -0.05])
    return plan


def slider_crank(rng: Rng) -> Blueprint:
    """A spatial slider-crank whose rod has two balls: one freedom of the motor and the rod's own."""
    plan, pin = Blueprint("ball_rod_slider_crank", rng), np.array([0.0, 0.1, 0.05])
    plan.joint("crank", "continuous", "base", "disc", np.zeros(3), X)
    plan.joint("ball", "spherical", "disc", "rod", pin)
    plan.joint("slide", "prismatic", "base", "block", [0.35, 0.0, rng.uniform(-0.05, 0.05)], X)
    plan.cut("end", "spherical", "rod", "block", plan.poses["block"].position)
    plan.actuators, plan.tool = ["crank"], ("block", plan.poses["block"].position)
    return plan
