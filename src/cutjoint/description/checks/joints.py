"""Joints by themselves: axes, limits, damping, placements."""

from __future__ import annotations

import math

import numpy as np

from cutjoint.description.findings import Findings
from cutjoint.description.model import Joint, RobotDescription

_LOOSE = 1e-6


def check_joints(robot: RobotDescription, findings: Findings) -> None:
    """Note wrong axes, limits and damping of every joint."""
    for joint in robot.joints:
        _placement(joint, findings)
        _axes(joint, findings)
        _limits(joint, findings)
        for what, value in (("damping", joint.damping), ("friction", joint.friction)):
            if not value >= 0.0 or math.isinf(value):
                findings.error(f"{what} of joint '{joint.name}' is {value:g}", "a number >= 0", "", joint.place)


def _placement(joint: Joint, findings: Findings) -> None:
    rotation = joint.placement[:3, :3]
    if not np.isfinite(joint.placement).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > _LOOSE:
        findings.error(f"placement of joint '{joint.name}' is not a rigid motion", "a rotation and a position",
                       "", joint.place)  # fmt: skip


def _axes(joint: Joint, findings: Findings) -> None:
    axes = (("axis", joint.axis), ("second axis", joint.axis2))[: joint.type.axes]
    for what, axis in axes:
        if not abs(float(np.linalg.norm(axis)) - 1.0) < _LOOSE:
            found = f"{what} of joint '{joint.name}' is {axis.tolist()}"
            findings.error(found, "a unit vector", "", joint.place)
    if joint.type.axes == 2 and abs(float(joint.axis @ joint.axis2)) > _LOOSE:
        found = f"the axes of {joint.type.value} joint '{joint.name}' are not perpendicular"
        findings.error(found, "two perpendicular axes", "use two revolute joints", joint.place)


def _limits(joint: Joint, findings: Findings) -> None:
    limits = joint.limits
    values = (limits.lower, limits.upper, limits.velocity, limits.effort)
    if any(value is not None and not math.isfinite(value) for value in values):
        findings.error(f"limits of joint '{joint.name}' are not finite: {values}", "numbers", "", joint.place)
        return
    if limits.lower is not None and limits.upper is not None:
        shown = f"{limits.lower:g} to {limits.upper:g}"
        if limits.lower > limits.upper:
            found = f"limits of joint '{joint.name}' are upside down: {shown}"
            findings.error(found, "lower <= upper", "swap them", joint.place)
        elif limits.lower == limits.upper:
            found = f"joint '{joint.name}' cannot move: limits {shown}"
            findings.warn(found, "a range, no limits, or a fixed joint", "", joint.place)
    for what, value in (("velocity", limits.velocity), ("effort", limits.effort)):
        if value is not None and value < 0.0:
            findings.error(f"{what} limit of joint '{joint.name}' is {value:g}", "a number >= 0", "", joint.place)
