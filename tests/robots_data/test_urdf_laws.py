"""What must hold for every robot under urdf/: it closes at home, has the mobility it claims, and real bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import chain
from typing import Any

import numpy as np
import pytest

# robot: velocities, constraint rows, rank, mobility, rank of the passive columns
EXPECTED = {
    "cpm": (12, 12, 9, 3, 9),
    "cpm_rotary": (12, 12, 9, 3, 9),
    "omega3": (18, 18, 15, 3, 15),
    "fourbar": (3, 5, 2, 1, 2),
    "fivebar": (4, 5, 2, 2, 2),
    "stewart": (24, 18, 18, 6, 18),
    "redundant": (6, 10, 4, 2, 3),
    "underactuated": (4, 5, 2, 2, 2),
}
ROBOTS = sorted(EXPECTED)


def rank(matrix: np.ndarray) -> int:
    """Singular values above 1e-8 of the largest; none may lie between that and 1e-4, a near-singularity."""
    values = np.linalg.svd(matrix, compute_uv=False)
    kept = values > 1e-8 * values[0]
    assert values[kept].min() > 1e-4 * values[0], values
    return int(kept.sum())


def test_every_folder_is_covered(generator: Any) -> None:
    assert sorted({path.parts[0] for path in generator.files()}) == ROBOTS


@pytest.mark.parametrize("name", ROBOTS)
def test_home_is_nearly_closed_and_regular(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    nv, rows, full, mobility, passive = EXPECTED[name]
    rough = robot.home()
    assert np.abs(robot.gap(rough)[0]).max() < 1e-3
    q = robot.close(rough)
    jacobian = robot.gap(q)[1]
    assert (robot.model.nv, jacobian.shape[0]) == (nv, rows)
    assert rank(jacobian) == full == nv - mobility
    assert rank(jacobian[:, robot.passive]) == passive
    assert robot.model.check(robot.data)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_of_the_cuts_against_finite_differences(name: str, tree: Callable[..., Any]) -> None:
    import pinocchio as pin

    robot = tree(name)
    q = robot.close(robot.home())
    jacobian = robot.gap(q)[1]
    h = 1e-6
    for k, e in enumerate(np.eye(robot.model.nv)):
        ahead, behind = (robot.gap(pin.integrate(robot.model, q, s * h * e))[0] for s in (1, -1))
        assert np.abs((ahead - behind) / (2 * h) - jacobian[:, k]).max() < 1e-8


@pytest.mark.parametrize("name", ROBOTS)
def test_mobility_stays_around_home(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    home = robot.close(robot.home())
    rng = np.random.default_rng(5)
    reach = np.where([unit == "prismatic" for unit in _types(robot)], 0.02, 0.15)
    for _ in range(10):
        n = len(robot.actuated)
        step = reach * rng.uniform(-1, 1, n) if EXPECTED[name][3] >= n else np.zeros(n)
        q = robot.moved(home, step)
        assert rank(robot.gap(q)[1]) == EXPECTED[name][2]


def _types(robot: Any) -> list[str]:
    types = {joint.get("name"): joint.get("type") for joint in robot.xml.iter("joint")}
    return [types[name] for name in robot.loops["actuators"]]


@pytest.mark.parametrize("name", ROBOTS)
def test_mass_matrix_is_positive_definite_in_every_variant(name: str, tree: Callable[..., Any]) -> None:
    for variant in (None, *tree(name).loops.get("variant", {})):
        robot = tree(name, variant)
        values = np.linalg.eigvalsh(robot.mass(robot.close(robot.home())))
        assert values[0] > 1e-6 * values[-1]


@pytest.mark.parametrize("name", ROBOTS)
def test_bodies_can_exist(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    found = []
    for inertial in robot.xml.iter("inertial"):
        moments = inertial.find("inertia")
        found.append(
            (float(inertial.find("mass").get("value")), *(float(moments.get(k)) for k in ("ixx", "iyy", "izz")))
        )
    for variant in robot.loops.get("variant", {}).values():
        found += [(body["mass"], *body["inertia"][:3]) for body in variant.get("inertial", {}).values()]
    for mass, *moments in found:
        assert mass > 0
        assert min(moments) >= 0
        assert sum(moments) >= 2 * max(moments) * (1 - 1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_names_are_unique_and_known(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    links = [link.get("name") for link in robot.xml.findall("link")]
    joints = [joint.get("name") for joint in robot.xml.findall("joint")]
    assert len(set(links + joints)) == len(links + joints)
    assert robot.xml.get("name") == robot.loops["name"] == name
    assert links[0] == "base"
    assert robot.loops["tool"]["frame"] in links
    home = robot.loops["home"]["default"]
    assert sorted(home["actuated"]) == sorted(robot.loops["actuators"])
    moving = [joint.get("name") for joint in robot.xml.findall("joint") if joint.get("type") != "fixed"]
    assert sorted(chain(home["actuated"], home["passive"])) == sorted(moving)


@pytest.mark.parametrize("name", ROBOTS)
def test_joints_have_limits_that_hold_home(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    home = robot.loops["home"]["default"]
    values = home["actuated"] | home["passive"]
    for joint in robot.xml.findall("joint"):
        if joint.get("type") not in ("revolute", "prismatic"):
            continue
        limit, axis = joint.find("limit"), [float(a) for a in joint.find("axis").get("xyz").split()]
        assert math.isclose(math.hypot(*axis), 1.0)
        assert float(limit.get("lower")) < values[joint.get("name")] < float(limit.get("upper"))
        actuated = joint.get("name") in robot.loops["actuators"]
        assert (float(limit.get("effort")) > 0) == actuated


@pytest.mark.parametrize("name", ROBOTS)
def test_every_moving_body_can_be_seen_in_a_known_colour(name: str, tree: Callable[..., Any]) -> None:
    robot = tree(name)
    colours = {material.get("name") for material in robot.xml.findall("material")}
    for link in robot.xml.findall("link"):
        if link.get("name") != robot.loops["tool"]["frame"]:
            assert link.findall("visual")
    assert {visual.find("material").get("name") for visual in robot.xml.iter("visual")} == colours
