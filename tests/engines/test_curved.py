"""Couplings of several drivers and along curves, and distances, as MJCF: the same robot again, and in MuJoCo too."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.built import built
from kit.curved import CURVED
from kit.described import differences
from kit.quickly import few

from cutjoint import tolerances
from cutjoint.chain import ClosedChain
from cutjoint.description import Coupling, RobotDescription, load_description
from cutjoint.description.curves import Polynomial, Table
from cutjoint.description.formats import write
from cutjoint.description.model import DriverCurve
from cutjoint.engines.mujoco import MujocoRobot
from cutjoint.errors import InputError

pytest.importorskip("mujoco", reason="MuJoCo is an optional extra")

DEGREE = 4


def said(coupling: Coupling) -> bool:
    """Whether MJCF has a word for it."""
    degrees = [
        max((k for k, value in enumerate(one.curve.coefficients) if value), default=0)
        if isinstance(one.curve, Polynomial)
        else np.inf
        for one in coupling.drives
    ]
    return max(degrees, default=0) <= DEGREE and sum(degree > 1 for degree in degrees) <= 1


def sayable(robot: RobotDescription) -> RobotDescription:
    """The robot with curves that MJCF can say: all of a coupling but one straight, near where the robot stands."""
    standing = {**robot.homes[0].actuated, **robot.homes[0].passive}

    def drive(one: DriverCurve, straight: bool) -> DriverCurve:
        x = float(standing.get(one.driver, 0.0))  # type: ignore[arg-type]
        value, slope, bend = one.curve.at(x)
        slope = slope if abs(slope) > 0.2 else 0.5  # flat, it would lead nowhere
        local = np.polynomial.Polynomial(
            [value, slope, *((0.0,) if straight else (0.5 * bend, 0.3 * slope, -0.2 * slope))]
        )
        moved = local(np.polynomial.Polynomial([-x, 1.0]))
        return replace(one, curve=Polynomial(tuple(float(c) for c in moved.coef)))

    couplings = tuple(
        replace(one, drives=tuple(drive(own, k > 0) for k, own in enumerate(one.drives))) for one in robot.couplings
    )
    return replace(robot, couplings=couplings)


@pytest.mark.parametrize("seed", few(range(12), 0))
@pytest.mark.parametrize("name", few(list(CURVED), "rover", "rssr", "summed_arm"))
def test_what_mjcf_can_say_is_the_same_robot_in_mujoco(name: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng([seed, len(name)])
    chain = built(CURVED[name](rng).plan, tmp_path)[0]
    robot = sayable(chain.description)
    assert all(map(said, robot.couplings))
    again = load_description(write(robot, tmp_path / "robot.xml", to="mjcf")[0])
    assert differences(robot, again) == []
    moved = ClosedChain(again)
    if not moved.mobility().determined:
        return
    judge = MujocoRobot(moved)
    for _ in range(3):
        at = moved.close(moved.home.q + 0.02 * rng.uniform(-1.0, 1.0, moved.n))
        v, effort = rng.normal(size=moved.n), rng.normal(size=moved.n)
        speed, push = moved.full_velocity(at, v), moved.full_effort(effort)
        found = moved.full_forward_dynamics(at, speed, push).acceleration / judge.units
        opinion, tangent = judge.opinion(at.q_full, speed, push), moved.tangent(at)
        assert np.abs(opinion.jacobian @ tangent).max() < 1e-9 * np.abs(tangent / judge.units[:, None]).max()
        assert np.abs(opinion.hard / judge.units - found).max() < tolerances.ENGINE_HARD.value * np.abs(found).max()


@pytest.mark.parametrize("form", ["mjcf", "urdf", "loops"])
@pytest.mark.parametrize("seed", few(range(12), 0))
@pytest.mark.parametrize("name", few(list(CURVED), "summed_arm"))
def test_every_curve_comes_back_or_is_refused(name: str, seed: int, form: str, tmp_path: Path) -> None:
    robot = built(CURVED[name](np.random.default_rng([seed, len(name)])).plan, tmp_path)[0].description
    target = tmp_path / "again" / {"mjcf": "robot.xml", "urdf": "robot.urdf", "loops": "loops.toml"}[form]
    if form == "mjcf" and not all(map(said, robot.couplings)):
        with pytest.raises(InputError, match=r"MJCF cannot say coupling '.*': .*; write loops\.toml \(--to loops\)"):
            write(robot, target, to=form)
        assert not target.exists()
        return
    assert differences(robot, load_description(write(robot, target, to=form)[0])) == []


@pytest.mark.parametrize(
    ("curves", "why"),
    [
        ((Table(((0.0, 0.0), (1.0, 2.0))),), "a table of points"),
        ((Polynomial((0.0, 1.0, 0.0, 0.0, 0.0, 0.1)),), "degree 5, more than 4"),
        ((Polynomial((0.0, 1.0, 0.1)), Polynomial((0.0, 1.0, 0.1))), "follows 2 joints along curves"),
    ],
)
def test_what_mjcf_cannot_say_is_refused(curves: tuple[Polynomial | Table, ...], why: str, tmp_path: Path) -> None:
    robot = built(CURVED["rover"](np.random.default_rng(0)).plan, tmp_path)[0].description
    drives = tuple(DriverCurve(driver, curve) for driver, curve in zip(("left", "right"), curves, strict=False))
    other = replace(robot, couplings=(replace(robot.couplings[0], drives=drives),))
    with pytest.raises(InputError, match=why):
        write(other, tmp_path / "robot.xml", to="mjcf")
