"""The oracles of tests/oracles against pinocchio's tree, and against finite differences of themselves."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin
import pytest


def placed(robot: Any, joints: dict[str, tuple[float, float, float]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Full coordinates, velocities and accelerations from those of the joints."""
    q, v, a = robot.home(), np.zeros(robot.model.nv), np.zeros(robot.model.nv)
    for name, (coordinate, rate, change) in joints.items():
        joint = robot._joint(name)
        q[joint.idx_q], v[joint.idx_v], a[joint.idx_v] = coordinate, rate, change
    return q, v, a


def reduced(robot: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Effort of the actuators by virtual work."""
    return robot.tangent(q).T @ pin.rnea(robot.model, robot.data, q, v, a)


def tool(robot: Any, q: np.ndarray) -> np.ndarray:
    """Tool point of the tree."""
    pin.framesForwardKinematics(robot.model, robot.data, q)
    return robot.data.oMf[robot.model.getFrameId("tool", pin.BODY)].translation


def closed(robot: Any, q: np.ndarray, v: np.ndarray) -> None:
    """The posture is closed and the velocity keeps it closed."""
    gap, jacobian = robot.gap(q)
    assert np.abs(gap).max() < 1e-13
    assert np.abs(jacobian @ v).max() < 1e-11


def test_fourbar_agrees_with_the_tree(tree: Callable[..., Any], oracles: Callable[[str], ModuleType]) -> None:
    robot, oracle = tree("fourbar"), oracles("fourbar").FourBar()
    rng = np.random.default_rng(1)
    for angle in np.linspace(0.0, 6.2, 40):
        speed, change = rng.normal(size=2) * (5.0, 50.0)
        q, v, a = placed(robot, oracle.joints(angle, speed, change))
        closed(robot, q, v)
        torque = oracle.inverse_dynamics(angle, speed, change)
        assert reduced(robot, q, v, a)[0] == pytest.approx(torque, rel=1e-11, abs=1e-12)
        assert oracle.forward_dynamics(angle, speed, torque) == pytest.approx(change, rel=1e-12)
        assert tool(robot, q) == pytest.approx(oracle.tool(angle), abs=1e-13)
        assert pin.computePotentialEnergy(robot.model, robot.data, q) == pytest.approx(oracle.potential_energy(angle))


def test_fivebar_agrees_with_the_tree(tree: Callable[..., Any], oracles: Callable[[str], ModuleType]) -> None:
    robot, oracle = tree("fivebar"), oracles("fivebar").FiveBar()
    rng = np.random.default_rng(2)
    home = robot.close(robot.home())[[robot._joint(name).idx_q for name in robot.loops["actuators"]]]
    for _ in range(40):
        angles, speeds, changes = (
            home + rng.uniform(-0.25, 0.25, 2),
            5.0 * rng.normal(size=2),
            50.0 * rng.normal(size=2),
        )
        q, v, a = placed(robot, oracle.joints(angles, speeds, changes))
        closed(robot, q, v)
        torque = oracle.inverse_dynamics(angles, speeds, changes)
        assert reduced(robot, q, v, a) == pytest.approx(torque, rel=1e-11, abs=1e-11)
        assert oracle.forward_dynamics(angles, speeds, torque) == pytest.approx(changes, rel=1e-10)
        assert tool(robot, q) == pytest.approx(oracle.tool(angles), abs=1e-13)
        assert pin.computePotentialEnergy(robot.model, robot.data, q) == pytest.approx(oracle.potential_energy(angles))


def stewart_motion(module: ModuleType, rng: np.random.Generator) -> Any:
    """A platform motion within the legs' strokes."""
    rotation = pin.exp3(rng.uniform(-0.2, 0.2, 3))
    position = np.array([0.0, 0.0, 0.48]) + rng.uniform(-0.05, 0.05, 3)
    return module.Motion(position, rotation, *(scale * rng.normal(size=3) for scale in (0.5, 1.5, 4.0, 10.0)))


def test_stewart_agrees_with_the_tree(tree: Callable[..., Any], oracles: Callable[[str], ModuleType]) -> None:
    module = oracles("stewart")
    robot, oracle = tree("stewart"), module.Stewart()
    rng = np.random.default_rng(3)
    for _ in range(30):
        motion = stewart_motion(module, rng)
        joints = {}
        for i in range(6):
            leg = oracle.leg(i, motion)
            for part in ("swing", "tilt", "slide"):
                joints[f"leg{i + 1}_{part}"] = getattr(leg, part)
        q, v, a = placed(robot, joints)
        platform, back = robot._joint("platform"), motion.rotation.T
        q[platform.idx_q : platform.idx_q + 7] = pin.SE3ToXYZQUAT(pin.SE3(motion.rotation, motion.position))
        v[platform.idx_v : platform.idx_v + 6] = np.r_[back @ motion.velocity, back @ motion.spin]
        linear = motion.acceleration - np.cross(motion.spin, motion.velocity)
        a[platform.idx_v : platform.idx_v + 6] = np.r_[back @ linear, back @ motion.spin_rate]
        closed(robot, q, v)
        assert reduced(robot, q, v, a) == pytest.approx(oracle.inverse_dynamics(motion), rel=1e-10, abs=1e-9)


def test_accelerations_are_derivatives(oracles: Callable[[str], ModuleType]) -> None:
    """Rates and accelerations of all joints against central differences along a motion."""
    four, five = oracles("fourbar").FourBar(), oracles("fivebar").FiveBar()
    h = 1e-5

    def differences(motion: Callable[[float], dict[str, tuple[float, float, float]]]) -> None:
        before, now, after = motion(-h), motion(0.0), motion(h)
        for name, (_, rate, change) in now.items():
            assert (after[name][0] - before[name][0]) / (2 * h) == pytest.approx(rate, rel=1e-6, abs=1e-7)
            assert (after[name][1] - before[name][1]) / (2 * h) == pytest.approx(change, rel=1e-6, abs=1e-6)

    differences(lambda t: four.joints(2.0 + 1.3 * t - 0.4 * t * t, 1.3 - 0.8 * t, -0.8))
    start, speed, change = np.array([2.0, 0.9]), np.array([1.3, -0.7]), np.array([-0.8, 2.0])
    differences(lambda t: five.joints(start + speed * t + 0.5 * change * t * t, speed + change * t, change))


def test_stewart_legs_are_derivatives(oracles: Callable[[str], ModuleType]) -> None:
    module = oracles("stewart")
    oracle, h = module.Stewart(), 1e-5
    start = stewart_motion(module, np.random.default_rng(4))

    def at(t: float) -> Any:
        # angular velocity spin + t spin_rate, up to the second order in t
        turn = start.spin * t + 0.5 * start.spin_rate * t * t
        position = start.position + start.velocity * t + 0.5 * start.acceleration * t * t
        spin, velocity = start.spin + start.spin_rate * t, start.velocity + start.acceleration * t
        rotation = pin.exp3(turn) @ start.rotation
        return module.Motion(position, rotation, velocity, spin, start.acceleration, start.spin_rate)

    for i in range(6):
        before, now, after = (oracle.leg(i, at(t)) for t in (-h, 0.0, h))
        for part in ("swing", "tilt", "slide"):
            low, (_, rate, change), high = (getattr(leg, part) for leg in (before, now, after))
            assert (high[0] - low[0]) / (2 * h) == pytest.approx(rate, rel=1e-6, abs=1e-7)
            assert (high[1] - low[1]) / (2 * h) == pytest.approx(change, rel=1e-6, abs=1e-6)
