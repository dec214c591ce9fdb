"""Placements and axes mean what others take them to mean: Pinocchio and yourdfpy put every link at the same place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

from cutjoint.description import JointType, RobotDescription, load_description
from cutjoint.description.catalogue import resolve
from cutjoint.description.transforms import (
    frame_along,
    inverse,
    placement,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
)

ROBOTS = ("cpm", "omega3", "ur5", "panda")


def urdf_of(name: str) -> Path:
    path = resolve(name)
    return path if path.suffix == ".urdf" else path.parent / "robot.urdf"


def random_values(robot: RobotDescription, generator: np.random.Generator) -> dict[str, float]:
    driven = {coupling.joint: coupling for coupling in robot.couplings}
    one = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)
    values = {joint.name: generator.uniform(-2, 2) for joint in robot.joints if joint.type in one}
    for name, coupling in driven.items():
        values[name] = coupling.gear[1] * values[coupling.gear[0]] + coupling.offset
    return values


def configuration(model: pin.Model, values: dict[str, float]) -> np.ndarray:
    q = pin.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        entry = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        q[joint.idx_q : joint.idx_q + joint.nq] = entry
    return q


@pytest.mark.parametrize("name", ROBOTS)
def test_every_link_is_where_pinocchio_has_it(name: str, forward) -> None:
    robot = load_description(urdf_of(name))
    model = pin.buildModelFromUrdf(str(urdf_of(name)))
    data = model.createData()
    generator = np.random.default_rng(0)
    for _ in range(20):
        values = random_values(robot, generator)
        pin.framesForwardKinematics(model, data, configuration(model, values))
        world = forward(robot, values)
        for link in robot.links:
            frame = model.getFrameId(link.name, pin.FrameType.BODY)
            np.testing.assert_allclose(world[link.name], data.oMf[frame].homogeneous, atol=1e-12, err_msg=link.name)


@pytest.mark.parametrize("name", ROBOTS)
def test_every_link_is_where_yourdfpy_has_it(name: str, forward) -> None:
    robot = load_description(urdf_of(name))
    other = yourdfpy.URDF.load(str(urdf_of(name)), load_meshes=False, build_scene_graph=True)
    generator = np.random.default_rng(1)
    for _ in range(5):
        values = random_values(robot, generator)
        other.update_cfg({joint: values[joint] for joint in other.actuated_joint_names if joint in values})
        world = forward(robot, values)
        for link in robot.links:
            found = other.get_transform(link.name, robot.root)
            np.testing.assert_allclose(world[link.name], found, atol=1e-12, err_msg=link.name)


@pytest.mark.parametrize("name", ROBOTS)
def test_inertias_are_pinocchios(name: str, forward) -> None:
    robot = load_description(urdf_of(name))
    model = pin.buildModelFromUrdf(str(urdf_of(name)), pin.JointModelFreeFlyer())
    data = model.createData()
    total = sum(link.inertial.mass for link in robot.links if link.inertial)
    assert total == pytest.approx(pin.computeTotalMass(model), rel=1e-13)
    values = random_values(robot, np.random.default_rng(2))
    q = configuration(model, values)
    pin.ccrba(model, data, q, np.zeros(model.nv))
    world = forward(robot, values)
    com = np.zeros(3)
    for link in robot.links:
        if link.inertial:
            com += link.inertial.mass / total * (world[link.name] @ [*link.inertial.com, 1.0])[:3]
    inertia = np.zeros((3, 3))
    for link in robot.links:
        if link.inertial:
            rotation, arm = world[link.name][:3, :3], (world[link.name] @ [*link.inertial.com, 1.0])[:3] - com
            inertia += rotation @ link.inertial.inertia @ rotation.T
            inertia += link.inertial.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(com, pin.centerOfMass(model, data, q), atol=1e-12)
    np.testing.assert_allclose(inertia, data.Ig.inertia, atol=1e-11)


def test_roll_pitch_yaw_is_pinocchios_to_rounding() -> None:
    generator = np.random.default_rng(3)
    for _ in range(500):
        rpy = generator.uniform(-4, 4, 3)
        np.testing.assert_allclose(rotation_from_rpy(rpy), pin.rpy.rpyToMatrix(rpy), atol=1e-15, rtol=0)


def test_rotations_come_back() -> None:
    generator = np.random.default_rng(4)
    near = [np.pi / 2 - 10.0**-power for power in range(1, 16)]
    pitches = [*generator.uniform(-1.5, 1.5, 200), *near, *(-angle for angle in near), np.pi / 2, -np.pi / 2]
    for pitch in pitches:
        rotation = rotation_from_rpy((generator.uniform(-3, 3), pitch, generator.uniform(-3, 3)))
        np.testing.assert_allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, atol=4e-15, rtol=0)
        quaternion = quaternion_from_rotation(rotation)
        np.testing.assert_allclose(rotation_from_quaternion(quaternion), rotation, atol=2e-15, rtol=0)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_come_back_as_quaternions(axis: int) -> None:
    quaternion = np.zeros(4)
    quaternion[axis + 1] = 1.0
    np.testing.assert_array_equal(quaternion_from_rotation(rotation_from_quaternion(quaternion)), quaternion)


def test_placements_invert() -> None:
    matrix = placement((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    np.testing.assert_allclose(matrix @ inverse(matrix), np.eye(4), atol=1e-15)
    assert not matrix.flags.writeable
    np.testing.assert_array_equal(rotation_from_quaternion((2.0, 0.0, 0.0, 0.0)), np.eye(3))


def test_a_frame_along_an_axis_is_a_rotation_with_that_z() -> None:
    generator = np.random.default_rng(5)
    for axis in [*generator.normal(size=(50, 3)), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])]:
        unit = axis / np.linalg.norm(axis)
        rotation = frame_along(axis)
        np.testing.assert_allclose(rotation[:, 2], unit, atol=1e-15)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(rotation) > 0
