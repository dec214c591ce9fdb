"""Engineering answers against each other: what two of them tell of one robot is the same number."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.led_robots import LED, somewhere

import cutjoint
from cutjoint.accuracy import accuracy, backlash
from cutjoint.chain import ClosedChain
from cutjoint.control import law
from cutjoint.mechanism import Posture
from cutjoint.motion import Reference
from cutjoint.motion.catalogue import trajectory
from cutjoint.simulation import ReducedPlant, run
from cutjoint.sizing import size
from cutjoint.stiffness import Springs, stiffness
from cutjoint.synthesis import QUANTITIES, Subject
from cutjoint.tuning import PolePlacement, tune
from cutjoint.workspace import workspace

HARD = 1e12
"""Stiffness of actuators beside which weights count for nothing; compliance is linear in its reciprocal."""
QUICK = ("planar_3rrr", "fivebar", "serial_wrist", "pan_tilt")
SHIPPED = ("fivebar", "omega3", "cpm", "stewart")


def coordinates(robot: ClosedChain, at: Posture) -> np.ndarray:
    return np.array([at[one.name] for one in robot.actuators])


def nearby(robot: ClosedChain, rng: np.random.Generator) -> Posture:
    """A posture not far from home."""
    units = np.array([robot.length if one.kind == "translation" else 1.0 for one in robot.actuators])
    return robot.close(coordinates(robot, robot.home) + 0.02 * units * rng.uniform(-1.0, 1.0, robot.n), near=robot.home)


def softest(robot: ClosedChain, at: Posture) -> float:
    """Least stiffness of the tool point with 1 N/m or 1 N m/rad at every actuator."""
    weightless = ClosedChain(replace(robot.description, gravity=np.zeros(3)))
    return (
        stiffness(weightless, Springs({"*": HARD}), weightless.close(coordinates(robot, at))).translation.softest / HARD
    )


# ---- one robot in many postures --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_maps_of_a_workspace_are_the_other_answers(name: str) -> None:
    robot = cutjoint.load(name)
    found = workspace(robot, cells=4, maps=["stiffness", "isotropy", "condition", "effort"])
    reached = np.argwhere(found.inside)
    for cell in reached[np.random.default_rng(0).integers(0, len(reached), 3)]:
        at = robot.close(found.q[tuple(cell)])
        told = {one: float(found.maps[one].values[tuple(cell)]) for one in found.maps}
        assert np.isclose(told["isotropy"], 1.0 / robot.mobility(at).condition, rtol=1e-6)
        assert np.isclose(told["condition"] * told["isotropy"], 1.0)
        assert np.isclose(told["stiffness"], softest(robot, at), rtol=1e-5)
        # by virtual work the effort against a push is how the tool moves with the actuator: also what its play does
        play = backlash(robot, {"*": 1e-5}, at)
        assert np.isclose(told["effort"], np.linalg.norm(play.parts[:3], axis=0).max() / 1e-5, rtol=1e-6)


@pytest.mark.parametrize("name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in LED])
def test_play_tolerances_and_springs_of_actuators_are_one_jacobian(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng([7, *name.encode()])
    robot = ClosedChain(somewhere(name, 1, tmp_path, rng).description)
    at = nearby(robot, rng)
    jacobian = robot.tool(at).frame_jacobian
    units = np.array([robot.length if one.kind == "translation" else 1.0 for one in robot.actuators])
    size_of_rows = np.array([robot.length] * 3 + [1.0] * 3)
    halves = 1e-4 * units * rng.uniform(0.5, 1.5, robot.n)
    loose = backlash(robot, {one.name: half for one, half in zip(robot.actuators, halves, strict=True)}, at)
    box = np.abs(jacobian) @ halves
    assert np.allclose(loose.box / size_of_rows, box / size_of_rows, atol=1e-11)
    off = accuracy(
        robot, {f"actuators.{one.name}": half for one, half in zip(robot.actuators, halves, strict=True)}, at, samples=0
    )
    assert np.allclose(off.worst / size_of_rows, box / size_of_rows, atol=1e-11)
    # a spring k at every actuator: compliance J k^-1 J'
    k = HARD / units**2
    springs = Springs({one.name: each for one, each in zip(robot.actuators, k, strict=True)})
    weightless = ClosedChain(replace(robot.description, gravity=np.zeros(3)))
    soft = stiffness(weightless, springs, weightless.close(coordinates(robot, at))).compliance * HARD
    wanted = (jacobian * units**2) @ jacobian.T
    scale = np.outer(size_of_rows, size_of_rows)
    assert np.allclose(soft / scale, wanted / scale, atol=1e-7)


# ---- along motions -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fivebar", "cpm"])
def test_what_a_design_is_judged_by_is_what_the_answers_tell(name: str) -> None:
    robot = cutjoint.load(name)
    motion = trajectory("about-home", robot)
    subject = Subject(robot, {"about-home": motion})
    along = {"trajectory": "about-home"}
    sized = size(robot, Reference(motion, robot)).cycles[0].duties
    assert np.isclose(QUANTITIES["rms-effort"].judge(subject, along), max(one.rms_effort for one in sized), rtol=0.05)
    largest = QUANTITIES["effort"].judge(subject, along)
    peak = max(abs(one.effort.value) for one in sized)
    assert 0.95 * peak < largest <= peak * (1.0 + 1e-9)
    reference = Reference(motion, robot)
    isotropy = QUANTITIES["isotropy"].judge(subject, along)
    assert isotropy <= 1.0 / robot.mobility(reference.at(0.0).posture).condition + 1e-12
    assert np.isclose(
        QUANTITIES["mass"].judge(subject, {}),
        sum(
            one.inertial.mass for one in robot.description.links if one.inertial and one.name != robot.description.root
        ),
    )


@pytest.mark.slow
def test_what_tuning_tells_of_its_gains_is_what_a_run_with_them_does() -> None:
    robot = cutjoint.load("fivebar")
    way = Reference(trajectory("about-home", robot), robot)
    found = tune(robot, "pd-gravity", way, by=PolePlacement(bandwidth=30.0, damping=0.8))
    for row in (found.found, found.rows[-1]):
        alone = run(ReducedPlant(robot), law("pd-gravity", robot, dict(row.gains)), way)
        error = np.abs(alone.tool - alone.desired_tool).max()
        assert np.isclose(row.largest, error, rtol=0.02)
        assert np.allclose(row.peak, np.abs(alone.effort).max(axis=0), rtol=0.01)
        assert np.isclose(row.rms, np.sqrt(np.mean((alone.q - alone.desired_q) ** 2)), rtol=0.05)
