"""The CPM and the Omega-3 hold the papers' tables, and in the lumped variant exactly the papers' energies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.papers import cpm, omega3

CPM, OMEGA3 = cpm.Parameters(), omega3.Parameters()


def masses(robot: Any) -> dict[str, float]:
    """Mass of every link that has one."""
    links = robot.xml.findall("link")
    return {
        link.get("name"): float(link.find("inertial/mass").get("value"))
        for link in links
        if link.find("inertial") is not None
    }


def origin(robot: Any, joint: str) -> np.ndarray:
    """Placement of a joint in its parent link."""
    return np.array([float(x) for x in robot.xml.find(f"joint[@name='{joint}']/origin").get("xyz").split()])


def test_cpm_tables(tree: Callable[..., Any]) -> None:
    robot = tree("cpm")
    found = masses(robot)
    for i in (1, 2, 3):
        limb = f"limb{i}"
        assert found[f"{limb}_proximal"] == CPM.m1 == 1.892994
        assert found[f"{limb}_distal"] == CPM.m2 == 0.695528
        assert found[f"{limb}_slider"] == CPM.m3 == 0.2
        assert np.linalg.norm(origin(robot, f"{limb}_elbow")) == pytest.approx(CPM.L1, abs=1e-15)
        assert np.linalg.norm(origin(robot, f"{limb}_wrist")) == pytest.approx(CPM.L2, abs=1e-15)
    assert (CPM.L1, CPM.L2, CPM.L, CPM.D) == (0.5, 0.373, 0.105, 0.9144)
    assert sum(found[f"limb{i}_platform"] for i in (1, 2, 3)) == pytest.approx(CPM.m4, abs=1e-15)
    assert sum(found.values()) == pytest.approx(3 * (CPM.m1 + CPM.m2 + CPM.m3) + CPM.m4, abs=1e-14)
    assert origin(robot, "limb3_slide").tolist() == [0.0, CPM.D, 0.0]
    assert robot.loops["gravity"] == [0.0, 0.0, CPM.g]
    for frames in (cut["frames"] for cut in robot.loops["cut"]):
        assert [np.linalg.norm(frame["xyz"]) for frame in frames] == [CPM.L, CPM.L]


def test_omega3_tables(tree: Callable[..., Any]) -> None:
    robot = tree("omega3")
    found = masses(robot)
    for i in (1, 2, 3):
        assert found[f"arm{i}_link"] == OMEGA3.m_SC == 0.1
        assert found[f"rod{i}a_link"] + found[f"rod{i}b_link"] == pytest.approx(OMEGA3.m_R, abs=1e-16)
        assert np.linalg.norm(origin(robot, f"arm{i}")) == pytest.approx(OMEGA3.R_A, abs=1e-15)
        assert origin(robot, f"bar{i}").tolist() == [0.0, 0.0, OMEGA3.L_A]
        assert origin(robot, f"rod{i}a")[1] - origin(robot, f"rod{i}b")[1] == pytest.approx(OMEGA3.rod_spacing)
        arm = robot.xml.find(f"link[@name='arm{i}_link']/inertial")
        com = [float(x) for x in arm.find("origin").get("xyz").split()]
        assert com == pytest.approx([0.0, 0.0, OMEGA3.arm_com], abs=1e-16)
        assert float(arm.find("inertia").get("iyy")) == pytest.approx(OMEGA3.arm_inertia, rel=1e-14)
    assert (OMEGA3.L_A, OMEGA3.L_B, OMEGA3.R_A, OMEGA3.R_B) == (0.07, 0.146, 0.075, 0.03525)
    assert found["platform_link"] == OMEGA3.m_P == 0.11
    assert found["payload"] == OMEGA3.m_payload == 0.07
    total = 3 * (OMEGA3.m_SC + OMEGA3.m_R) + OMEGA3.m_P + OMEGA3.m_payload
    assert sum(found.values()) == pytest.approx(total, abs=1e-15)
    assert robot.loops["gravity"] == [0.0, 0.0, -OMEGA3.g]
    for cut in robot.loops["cut"]:
        platform, rod = cut["frames"]
        assert rod["xyz"] == [0.0, 0.0, OMEGA3.L_B]
        assert math.hypot(*platform["xyz"]) == pytest.approx(math.hypot(OMEGA3.R_B, OMEGA3.rod_spacing / 2), abs=1e-15)


def energies(robot: Any, q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
    """Kinetic and potential energy of the whole tree."""
    kinetic = pin.computeKineticEnergy(robot.model, robot.data, q, v)
    return kinetic, pin.computePotentialEnergy(robot.model, robot.data, q)


def states(robot: Any, reach: float, count: int = 20) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Closed postures, full velocities and actuated velocities around home."""
    rng = np.random.default_rng(11)
    home = robot.close(robot.home())
    found = []
    for _ in range(count):
        q = robot.moved(home, rng.uniform(-reach, reach, 3))
        u = rng.normal(size=3)
        found.append((q, robot.tangent(q) @ u, u))
    return found


def test_cpm_lumped_has_the_energies_of_equations_18_and_19(tree: Callable[..., Any]) -> None:
    """Kinetic and potential energy, without any constant left over; the uniform rods differ."""
    robot, uniform = tree("cpm", "lumped"), tree("cpm", "distributed")
    p = CPM
    differences = []
    for q, v, u in states(robot, 0.1):
        shoulders = [robot._joint(f"limb{i}_shoulder") for i in (1, 2, 3)]
        theta = [q[joint.idx_q] for joint in shoulders]
        rates = [v[joint.idx_v] for joint in shoulders]
        moving = p.m1 + 2 * p.m2 + p.m3 + p.m4
        kinetic = 0.5 * moving * u @ u + (p.m1 / 6 + p.m2 / 4) * p.L1**2 * np.dot(rates, rates)
        height = q[robot._joint("limb3_slide").idx_q]
        rods = (p.m1 + p.m2) / 2 * p.L1 * (math.sin(theta[0]) + math.cos(theta[1]))
        potential = -p.g * (rods + moving * height)
        found = energies(robot, q, v)
        assert found[0] == pytest.approx(kinetic, rel=1e-12)
        assert found[1] == pytest.approx(potential, rel=1e-12)
        differences.append(abs(energies(uniform, q, v)[0] / kinetic - 1))
    assert max(differences) > 1e-3


def test_cpm_shoulder_angles_are_the_papers(tree: Callable[..., Any]) -> None:
    """Equations (1) to (9): the wrist undoes shoulder and elbow, and theta_i2 closes each limb."""
    robot, p = tree("cpm"), CPM
    for q, _, _ in states(robot, 0.1, 5):
        x, y, z = (q[robot._joint(f"limb{i}_slide").idx_q] for i in (1, 2, 3))
        first = [q[robot._joint(f"limb{i}_shoulder").idx_q] for i in (1, 2, 3)]
        second = [t + q[robot._joint(f"limb{i}_elbow").idx_q] for i, t in enumerate(first, 1)]
        c = [p.L1 * math.cos(a) + p.L2 * math.cos(b) for a, b in zip(first, second, strict=True)]
        s = [p.L1 * math.sin(a) + p.L2 * math.sin(b) for a, b in zip(first, second, strict=True)]
        assert [c[0] + p.L, s[0], c[1], s[1] + p.L] == pytest.approx([y, z, z, x], abs=1e-12)
        assert [c[2], p.D - p.L - s[2]] == pytest.approx([x, y], abs=1e-12)
        pin.framesForwardKinematics(robot.model, robot.data, q)
        tool = robot.data.oMf[robot.model.getFrameId("tool", pin.BODY)]
        assert tool.translation == pytest.approx([x, y, z], abs=1e-12)
        assert tool.rotation == pytest.approx(np.eye(3), abs=1e-12)


def test_omega3_lumped_has_the_papers_two_kinds_of_bodies(tree: Callable[..., Any]) -> None:
    """Energy of m_E at the platform and of an arm with half a pair of rods at the elbow; the uniform rods differ."""
    robot, uniform = tree("omega3", "lumped"), tree("omega3", "distributed")
    p = OMEGA3
    carried = p.m_payload + p.m_P + 1.5 * p.m_R
    inertia = p.arm_inertia + p.m_SC * p.arm_com**2 + 0.5 * p.m_R * p.L_A**2
    lever = p.m_SC * p.arm_com + 0.5 * p.m_R * p.L_A
    offset, differences = [], []
    for q, v, u in states(robot, 0.3):
        platform = robot._joint("platform")
        kinetic = 0.5 * carried * np.sum(v[platform.idx_v : platform.idx_v + 3] ** 2) + 0.5 * inertia * u @ u
        theta = [q[robot._joint(f"arm{i}").idx_q] for i in (1, 2, 3)]
        up = sum(math.cos(2 * math.pi * i / 3) * math.cos(t) for i, t in enumerate(theta))
        potential = p.g * (carried * q[platform.idx_q + 2] + lever * up)
        found = energies(robot, q, v)
        assert found[0] == pytest.approx(kinetic, rel=1e-12)
        offset.append(found[1] - potential)
        differences.append(abs(energies(uniform, q, v)[0] / kinetic - 1))
        assert q[platform.idx_q + 3 : platform.idx_q + 6] == pytest.approx([0, 0, 0], abs=1e-12)
    assert offset == pytest.approx([0.0] * len(offset), abs=1e-13)
    assert max(differences) > 1e-3


def test_omega3_closes_the_papers_loop(tree: Callable[..., Any]) -> None:
    """Equation (16): from the elbow, moved in by R_B, to the platform's centre it is L_B."""
    robot, p = tree("omega3"), OMEGA3
    for q, _, _ in states(robot, 0.3, 5):
        centre = q[robot._joint("platform").idx_q :][:3]
        for i in (1, 2, 3):
            phi, theta = 2 * math.pi * (i - 1) / 3, q[robot._joint(f"arm{i}").idx_q]
            turn = pin.rpy.rpyToMatrix(phi, 0.0, 0.0)
            out = np.array([p.L_A * math.sin(theta), 0.0, p.R_A - p.R_B + p.L_A * math.cos(theta)])
            assert np.linalg.norm(centre - turn @ out) == pytest.approx(p.L_B, abs=1e-12)
