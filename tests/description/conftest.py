"""A small valid robot on disk, and the means to spoil it: a planar four-bar, cut at its coupler."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import JointType, RobotDescription

URDF = """<?xml version="1.0"?>
<robot name="fourbar">
  <material name="steel">
    <color rgba="0.5 0.5 0.6 1"/>
  </material>
  <link name="ground"/>
  <link name="crank">
    <inertial>
      <origin xyz="0.1 0 0"/>
      <mass value="0.4"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0.0013" iyz="0" izz="0.0013"/>
    </inertial>
    <visual>
      <origin xyz="0.1 0 0"/>
      <geometry>
        <box size="0.2 0.02 0.02"/>
      </geometry>
      <material name="steel"/>
    </visual>
  </link>
  <link name="coupler">
    <inertial>
      <origin xyz="0.2 0 0" rpy="0 0 0.1"/>
      <mass value="0.8"/>
      <inertia ixx="0.001" ixy="0.0001" ixz="0" iyy="0.0107" iyz="0" izz="0.0107"/>
    </inertial>
    <collision>
      <geometry>
        <cylinder radius="0.01" length="0.4"/>
      </geometry>
    </collision>
  </link>
  <link name="rocker">
    <inertial>
      <origin xyz="0.15 0 0"/>
      <mass value="0.6"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.0045" iyz="0" izz="0.0045"/>
    </inertial>
  </link>
  <joint name="crank_turn" type="revolute">
    <parent link="ground"/>
    <child link="crank"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="10" velocity="20"/>
  </joint>
  <joint name="coupler_turn" type="continuous">
    <parent link="crank"/>
    <child link="coupler"/>
    <origin xyz="0.2 0 0" rpy="0 0 0.5"/>
    <axis xyz="0 0 1"/>
    <dynamics damping="0.01" friction="0.02"/>
  </joint>
  <joint name="rocker_turn" type="continuous">
    <parent link="ground"/>
    <child link="rocker"/>
    <origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/>
  </joint>
</robot>
"""

LOOPS = """schema = 1
name = "fourbar"
title = "Planar four-bar"
urdf = "robot.urdf"
source = "for the tests"
gravity = [0.0, -9.81, 0.0]
actuators = ["crank_turn"]

[tool]
frame = { link = "coupler", xyz = [0.2, 0.1, 0.0] }

[[cut]]
name = "tip"
type = "revolute"
frames = [
  { link = "coupler", xyz = [0.4, 0.0, 0.0] },
  { link = "rocker", xyz = [0.3, 0.0, 0.0] },
]

[home.default]
about = "open branch"
actuated = { crank_turn = 1.0 }
passive = { coupler_turn = -0.5, rocker_turn = 1.2 }

[variant.uniform]
about = "as the tree"

[variant.lumped]
about = "the crank's mass at its ends"
[variant.lumped.inertial.crank]
mass = 0.4
com = [0.1, 0.0, 0.0]
inertia = [0.0, 0.004, 0.004, 0.0, 0.0, 0.0]
"""


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula, (4, 4)."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def _forward(robot: RobotDescription, values: dict[str, float]) -> dict[str, np.ndarray]:
    """World placement of every link of the open tree, plain products of transforms."""
    world = {robot.root: np.eye(4)}
    below: dict[str, list] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint)
    stack = [robot.root]
    while stack:
        parent = stack.pop()
        for joint in below.get(parent, []):
            value = values.get(joint.name, 0.0)
            motion = np.eye(4)
            if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
                motion = turn(joint.axis, value)
            elif joint.type is JointType.PRISMATIC:
                motion[:3, 3] = value * joint.axis
            elif joint.type is JointType.UNIVERSAL and value:
                motion = turn(joint.axis, value[0]) @ turn(joint.axis2, value[1])
            world[joint.child] = world[parent] @ joint.placement @ motion
            stack.append(joint.child)
    return world


Edits = Sequence[tuple[str, str]]
Write = Callable[..., Path]


def spoil(text: str, edits: Edits) -> str:
    """`text` with the first occurrence of each old part replaced; an old part that is missing fails the test."""
    for old, new in edits:
        assert old in text, f"the test's own text lacks {old!r}"
        text = text.replace(old, new, 1)
    return text


@pytest.fixture
def fourbar(tmp_path: Path) -> Write:
    """fourbar(urdf=edits, loops=edits) writes the robot with edits (old, new) and gives the path of its loops.toml."""

    def write(urdf: Edits = (), loops: Edits = ()) -> Path:
        folder = tmp_path / "fourbar"
        folder.mkdir(exist_ok=True)
        (folder / "robot.urdf").write_text(spoil(URDF, urdf), encoding="utf-8")
        (folder / "loops.toml").write_text(spoil(LOOPS, loops), encoding="utf-8")
        return folder / "loops.toml"

    return write


@pytest.fixture
def forward():
    """forward(robot, values) -> world placement (4, 4) of every link of the open tree."""
    return _forward
