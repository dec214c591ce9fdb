"""A `kit.blueprint.Blueprint` as the text of robot.urdf and loops.toml, with every digit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from oracles.reading import COORDINATES, rpy_rotation

if TYPE_CHECKING:
    from kit.blueprint import Blueprint

Array = np.ndarray

LENGTHS = {"prismatic": 1, "planar": 2, "floating": 3}
"""How many of a joint's coordinates, the first ones, are lengths."""


@dataclass(frozen=True)
class Mounting:
    """Where the base stands: roll, pitch, yaw and position; whether gravity is turned along with it."""

    rpy: Array = field(default_factory=lambda: np.zeros(3))
    xyz: Array = field(default_factory=lambda: np.zeros(3))
    gravity_turns: bool = False

    def gravity(self, own: Array) -> Array:
        """Gravity in the world, of that in the base's axes if it turns along."""
        return rpy_rotation(self.rpy) @ own if self.gravity_turns else own


def rpy_of(rotation: Array) -> Array:
    """Roll, pitch, yaw of a rotation (3, 3), right to rounding also near a pitch of a quarter turn."""
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    s, c = np.sin(yaw), np.cos(yaw)
    pitch = np.arctan2(-rotation[2, 0], c * rotation[0, 0] + s * rotation[1, 0])
    roll = np.arctan2(s * rotation[0, 2] - c * rotation[1, 2], c * rotation[1, 1] - s * rotation[0, 1])
    return np.array([roll, pitch, yaw])


def _text(values: Any) -> str:
    return " ".join(repr(float(value)) for value in np.atleast_1d(values))


def _list(values: Any) -> str:
    return "[" + ", ".join(repr(float(value)) for value in np.atleast_1d(values)) + "]"


def _curve(curve: Any, unit_x: float, unit_y: float) -> str:
    """A curve of a coupling in other units."""
    if isinstance(curve, list):
        return f"table = [{', '.join(_list([unit_x * x, unit_y * y]) for x, y in curve)}]"
    return f"polynomial = {_list([unit_y * c / unit_x**k for k, c in enumerate(curve)])}"


def urdf_text(plan: Blueprint, mounting: Mounting, scale: float, density: float) -> str:
    """The tree, with a link `world` that carries `base` where the mounting says."""
    lines = [
        f'<robot name="{plan.name}">',
        '<link name="world"/>',
        '<joint name="mount" type="fixed"><parent link="world"/><child link="base"/>'
        f'<origin xyz="{_text(mounting.xyz)}" rpy="{_text(mounting.rpy)}"/></joint>',
    ]
    for link, body in plan.inertias.items():
        if body is None:
            lines.append(f'<link name="{link}"/>')
            continue
        moments = body.moments * density * scale**2
        named = " ".join(f'{key}="{float(value)!r}"' for key, value in zip(("ixx", "iyy", "izz"), moments, strict=True))
        lines.append(
            f'<link name="{link}"><inertial><origin xyz="{_text(scale * body.position)}" rpy="{_text(body.rpy)}"/>'
            f'<mass value="{density * body.mass!r}"/><inertia {named} ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    for joint in plan.joints:
        # spherical and universal joints are what loops.toml makes of a joint that URDF knows
        kind = "floating" if joint.kind in ("spherical", "universal") else joint.kind
        axis = "" if joint.axis is None or kind == "floating" else f'<axis xyz="{_text(joint.axis)}"/>'
        limited = kind in ("prismatic", "revolute")
        limit = '<limit lower="-100" upper="100" effort="1e6" velocity="1e6"/>' if limited else ""
        lines.append(
            f'<joint name="{joint.name}" type="{kind}"><parent link="{joint.parent}"/><child link="{joint.child}"/>'
            f'<origin xyz="{_text(scale * joint.position)}" rpy="{_text(rpy_of(joint.rotation))}"/>'
            f"{axis}{limit}</joint>"
        )
    return "\n".join([*lines, "</robot>", ""])


def loops_text(plan: Blueprint, mounting: Mounting, scale: float) -> str:
    """Cuts, couplings, actuators, types of joints and home."""
    names = ", ".join(f'"{name}"' for name in plan.actuators)
    lines = [
        "schema = 1",
        f'name = "{plan.name}"',
        'urdf = "robot.urdf"',
        f"actuators = [{names}]",
        f"gravity = {_list(mounting.gravity(plan.gravity))}",
    ]
    if plan.tool is not None:
        link, point = plan.tool
        pose = plan.poses[link]
        own = _list(scale * (pose.rotation.T @ (np.array(point, dtype=float) - pose.position)))
        lines += ["[tool]", f'frame = {{ link = "{link}", xyz = {own} }}']
    for joint in plan.joints:
        if joint.kind in ("spherical", "universal"):
            lines += [f"[joint.{joint.name}]", f'type = "{joint.kind}"']
        if joint.kind == "universal":
            lines += [f"axis = {_list(joint.axis)}", f"axis2 = {_list(joint.axis2)}"]
    for cut in plan.cuts:
        frames = ", ".join(
            f'{{ link = "{link}", xyz = {_list(scale * position)}, rpy = {_list(rpy_of(rotation))} }}'
            for link, rotation, position in (cut.a, cut.b)
        )
        lines += ["[[cut]]", f'name = "{cut.name}"', f'type = "{cut.kind}"', f"frames = [{frames}]"]
        if cut.kind == "distance":
            lines.append(f"length = {scale * cut.length!r}")
    kinds = {joint.name: joint.kind for joint in plan.joints}
    units = {joint.name: scale if joint.kind == "prismatic" else 1.0 for joint in plan.joints}
    for one in plan.couplings:
        own = units[one.joint]
        lines += ["[[coupling]]", f'name = "{one.name}"', f'joint = "{one.joint}"', f"offset = {own * one.offset!r}"]
        drives = [
            f'{{ driver = "{driver}", {_curve(curve, units[driver], own)} }}' for driver, curve in one.curves.items()
        ]
        if drives:
            lines.append(f"drives = [{', '.join(drives)}]")
    lines.append("[home.default]")
    for table, chosen in (("actuated", True), ("passive", False)):
        lines.append(f"[home.default.{table}]")
        for joint in plan.joints:
            if COORDINATES[joint.kind] and (joint.name in plan.actuators) is chosen:
                value = np.atleast_1d(np.array(joint.start, dtype=float))
                value[: LENGTHS.get(joint.kind, 0)] *= scale
                lines.append(f"{joint.name} = {_list(value) if len(value) > 1 else repr(float(value[0]))}")
    return "\n".join([*lines, ""])
