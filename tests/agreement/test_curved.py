"""Couplings of several drivers along curves, and distances: mobility, dynamics, reactions, compiled, simulated.

The second derivation is that of maximal coordinates (`oracles.maximal`), whose curves are numpy's and scipy's.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import built, built_with_physics
from kit.by_joint import by_joint, placed
from kit.curved import CURVED
from kit.lively import Strength, bushed
from kit.postures import moving, random_posture
from kit.quickly import few
from kit.verdict import Verdicts
from oracles.reactions import Reactions

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.description.curves import Polynomial
from cutjoint.description.cuts import CutType
from cutjoint.description.model import (
    Coupling,
    DriverCurve,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, ClosureError, CompileError, DynamicsError
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, run

ACCURACY = 1e-10
QUICK = ("summed_arm", "tabled_lift")
SCALES = (1e-3, 1.0, 1e3)


def drawn(name: str, seed: int, folder: Path, scale: float = 1.0) -> tuple[Any, ClosedChain, Any, np.random.Generator]:
    rng = np.random.default_rng([seed, *name.encode()])
    mechanism = CURVED[name](rng)
    return mechanism, *built(mechanism.plan, folder, random_mounting(rng), scale, scale), rng


def check(name: str, seed: int, folder: Path, scale: float, with_compiled: bool = False) -> None:
    mechanism, chain, oracle, rng = drawn(name, seed, folder, scale)
    machine = compiled(chain, cached=False) if with_compiled else None
    for at in (chain.home, random_posture(chain, oracle, rng, mobility=mechanism.mobility)):
        p = placed(chain, oracle, at.q_full)
        assert p.mobility == mechanism.mobility
        if judge.leverage(p) < judge.WELL_LED:
            continue  # where a curve turns back, its motor leads nothing
        v, effort = moving(chain, p, rng.normal(size=p.mobility)), rng.normal(size=chain.nv)
        judge.require(judge.everything(chain, oracle, at, v, effort, rng, machine), ACCURACY)


@pytest.mark.parametrize("name", few(CURVED, *QUICK))
def test_everything(name: str, tmp_path: Path) -> None:
    check(name, 0, tmp_path, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", CURVED)
def test_everything_in_many_shapes(name: str, tmp_path: Path) -> None:
    for seed in range(1, 13):
        check(name, seed, tmp_path / str(seed), SCALES[seed % 3])


@pytest.mark.slow
@pytest.mark.parametrize("name", CURVED)
def test_compiled(name: str, tmp_path: Path) -> None:
    for seed in range(3):
        check(name, seed, tmp_path / str(seed), SCALES[seed], with_compiled=True)


@pytest.mark.parametrize("name", few(CURVED, "summed_arm"))
def test_rows_and_drift_are_derivatives_of_what_is_open(name: str, tmp_path: Path) -> None:
    """Also where the loops are open; by central differences."""
    _, chain, _, rng = drawn(name, 20, tmp_path)
    k, h = chain._k, 1e-5

    def along(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        ahead, behind = (k.at(chain.integrate(q, s * h * v)).residual_of_all for s in (1.0, -1.0))
        return (ahead - behind) / (2.0 * h)

    for _ in range(3):
        q, v = chain.integrate(chain.home.q_full, 0.2 * rng.normal(size=chain.nv)), rng.normal(size=chain.nv)
        if not any(cut.type != "distance" for cut in chain.description.cuts):  # other rows are exact where closed
            np.testing.assert_allclose(k.at(q).jacobian @ v, along(q, v), rtol=0, atol=1e-7)
        at = chain.home.q_full
        v = chain.project(at, v)[1]
        bent, h2 = k.moving(at, v).drift, 1e-4
        rows = [k.at(chain.integrate(at, s * h2 * v)).jacobian @ v for s in (1.0, -1.0)]
        flat = [joint.type.single for joint in chain.description.joints if joint.type.moves]
        if all(flat):  # where velocities are rates of coordinates
            np.testing.assert_allclose(bent, (rows[0] - rows[1]) / (2.0 * h2), rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", few(CURVED, "summed_arm"))
def test_reactions_and_what_acts_by_itself(name: str, tmp_path: Path) -> None:
    """With dampers, friction, springs and rotors everywhere; every driver of a coupling feels its share."""
    rng = np.random.default_rng([30, *name.encode()])
    plan = CURVED[name](rng).plan
    chain, oracle = built_with_physics(plan, tmp_path, rng, random_mounting(rng))
    for at in (chain.home, random_posture(chain, oracle, rng, 0.2)):
        p = placed(chain, oracle, at.q_full)
        v, effort = moving(chain, p, rng.normal(size=p.mobility)), rng.normal(size=chain.nv)
        state = p.moving(by_joint(chain, v))
        judge.require(judge.everything(chain, oracle, at, v, effort, rng), ACCURACY)
        motion = state.driven(by_joint(chain, effort))
        a = chain.full_forward_dynamics(at, v, effort).acceleration
        found, wanted = chain.full_reactions(at, v, a, effort), Reactions(motion).of
        size = max(float(np.abs(force).max()) for force, _ in wanted.values())
        if found.redundancy:
            continue
        for one in found:
            force, moment = wanted[one.name]
            assert np.abs(np.array(one.force) - force).max() < 1e-8 * size
            assert np.abs(np.array(one.moment) - moment).max() < 1e-8 * size * chain.length


@pytest.mark.slow
@pytest.mark.parametrize("block", range(8))
def test_random_robots(block: int) -> None:
    """Trees of all types of joints, closed by cuts of all types, distances too, and by couplings of any curves."""
    verdicts, rng = Verdicts(), np.random.default_rng([40, block])
    for _ in range(25):
        verdicts.judge(rng, int(rng.integers(2, 9)), int(rng.integers(1, 4)), curved=True)
    counts = verdicts.counts
    assert counts["refused"] <= 0.02 * counts["answers"], verdicts.reasons
    assert min(counts["moves"], counts["structure"]) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CURVED if name != "rover"])
def test_a_fall_keeps_its_energy(name: str, tmp_path: Path) -> None:
    """Compiled, in full coordinates and, where the actuators tell the motion, in reduced ones: the same fall."""
    _, chain, _, rng = drawn(name, 3, tmp_path)
    if chain.description.tool is None:
        chain = chain.rebuilt(replace(chain.description, tool=Frame("plate")))
    duration, falls = 0.4 * float(np.sqrt(chain.length / 9.81)), []
    unit = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    push = 0.3 / duration * unit * rng.normal(size=chain.n)
    plants: list[Any] = [chain, ConstrainedPlant(chain), *([ReducedPlant(chain)] if chain.n else [])]
    for robot in plants:
        exact: dict[str, Any] = {} if robot is chain else {"integrator": Adaptive(1e-11, 1e-13)}
        result = run(robot, duration=duration, every=duration / 5, start_velocity=push, **exact)
        energy = result.kinetic + result.potential
        assert np.abs(energy - energy[0]).max() < 1e-8 * np.abs(result.kinetic).max()
        falls.append(np.array(result.tool))
    assert np.abs(falls[0] - falls[0][0]).max() > 1e-3 * chain.length
    for fall in falls[1:]:
        np.testing.assert_allclose(fall, falls[0], rtol=0, atol=1e-7 * chain.length)


# ---- a spring between two points ---------------------------------------------------------------------------------


def sprung(folder: Path, seed: int = 0) -> tuple[ClosedChain, np.random.Generator]:
    """A hanging plate with a spring to the base, of some length at rest."""
    _, chain, _, rng = drawn("hanging_plate", seed, folder)
    spring = bushed(chain, "spring", CutType.DISTANCE, Strength.of(chain), rng, 0.5)
    spring = replace(spring, bushing=replace(spring.bushing, damping=0.0))
    return ClosedChain(replace(chain.description, cuts=(*chain.description.cuts, spring), tool=Frame("plate"))), rng


def test_a_spring_pulls_along_itself_by_hooke(tmp_path: Path) -> None:
    chain, rng = sprung(tmp_path)
    cut = chain.description.cuts[-1]
    frames = chain.link_placements(chain.home)
    a, b = ((frames[one.link] @ one.placement)[:3, 3] for one in (cut.a, cut.b))
    stretch = float(np.linalg.norm(b - a)) - cut.length
    assert chain.spring_energy(chain.home) == pytest.approx(0.5 * cut.bushing.stiffness * stretch**2, rel=1e-12)
    v = chain.project(chain.home.q_full, rng.normal(size=chain.nv))[1]
    a_full = chain.full_forward_dynamics(chain.home, v, np.zeros(chain.nv)).acceleration
    force = chain.full_reactions(chain.home, v, a_full, np.zeros(chain.nv)).cuts["spring"].force
    pull = -cut.bushing.stiffness * stretch * (b - a) / np.linalg.norm(b - a)
    np.testing.assert_allclose(force, pull, rtol=0, atol=1e-10 * np.linalg.norm(pull))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_spring_keeps_the_energy(seed: int, tmp_path: Path) -> None:
    chain, _ = sprung(tmp_path, seed)
    duration = 0.5 * float(np.sqrt(chain.length / 9.81))
    result = run(chain, duration=duration, every=duration / 10)
    energy = result.kinetic + result.potential
    assert np.abs(energy - energy[0]).max() < 1e-8 * np.abs(result.kinetic).max()


def test_a_spring_whose_ends_meet_has_no_direction(tmp_path: Path) -> None:
    chain, _ = sprung(tmp_path)
    frames, cut = chain.link_placements(chain.home), chain.description.cuts[-1]
    there = frames[cut.b.link] @ cut.b.placement
    met = replace(cut, a=Frame(cut.a.link, np.linalg.inv(frames[cut.a.link]) @ there))
    robot = ClosedChain(replace(chain.description, cuts=(*chain.description.cuts[:-1], met)))
    with pytest.raises(DynamicsError, match=r"the ends of cut 'spring' meet, .* has no direction"):
        robot.full_forward_dynamics(robot.home, np.zeros(robot.nv), np.zeros(robot.nv))
    with pytest.raises(CompileError, match="cannot be compiled: near home the ends of cut 'spring' meet"):
        compiled(robot, cached=False).full_acceleration(robot.home.q_full, np.zeros(robot.nv), np.zeros(robot.nv))


# ---- motors at the other end, and at both ------------------------------------------------------------------------


@pytest.mark.parametrize("seed", few(range(3), 0))
def test_motors_at_both_ends_of_a_coupling_share_one_motion(seed: int, tmp_path: Path) -> None:
    """An effort on the joint that follows is one on its driver, times the slope of the curve."""
    rng = np.random.default_rng(seed)
    plan = CURVED["gripper"](rng).plan
    plan.actuators = ["left", "right"]
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    report = chain.mobility()
    assert (report.mobility, report.actuators, report.determined) == (1, 2, False)
    with pytest.raises(ActuationError, match="1 actuators more than the mobility"):
        chain.inverse_dynamics(chain.home, [0.0, 0.0], [0.0, 0.0])
    slope = -placed(chain, oracle, chain.home.q_full).shares["mirror"]["right"]
    v = chain.project(chain.home.q_full, rng.normal(size=2))[1]
    one, two = rng.normal(size=2)
    both = chain.full_forward_dynamics(chain.home, v, chain.full_effort([one, two])).acceleration
    alone = chain.full_forward_dynamics(chain.home, v, chain.full_effort([0.0, two + slope * one])).acceleration
    np.testing.assert_allclose(both, alone, rtol=0, atol=1e-11 * np.abs(both).max())
    shared = chain.full_inverse_dynamics(chain.home, v, both).effort
    assert slope * shared[0] + shared[1] == pytest.approx(slope * one + two, rel=1e-10)
    assert shared[0] == pytest.approx(slope * shared[1], rel=1e-9), "the least of all that do it"
    found = run(ConstrainedPlant(chain), lambda t: [one, two], duration=0.1, every=0.05)
    wanted = run(ConstrainedPlant(chain), lambda t: [0.0, two + slope * one], duration=0.1, every=0.05)
    if len(plan.couplings[0].curves["right"]) == 2 and isinstance(plan.couplings[0].curves["right"], tuple):
        np.testing.assert_allclose(found.q, wanted.q, rtol=0, atol=1e-8)
    assert max(chain.gap(found.q_full[-1])) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(
    ("curve", "at", "working"),
    [
        (Polynomial((0.0, 0.0, 1.0)), 0.5, {-0.5, 0.5}),
        (Polynomial((0.0, -1.0, 0.0, 1.0)), 0.2, {0.2, 0.884886, -1.084886}),
    ],
)
def test_a_curve_that_turns_back_has_several_modes(curve: Polynomial, at: float, working: set[float]) -> None:
    """The tool on the joint that follows; with the motor there it is the driver that may stand elsewhere."""
    body = Inertial(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3))
    joints = tuple(
        Joint(name, JointType.CONTINUOUS, "base", f"{name}_link", axis=np.array([0.0, 0.0, 1.0])) for name in "ab"
    )
    value = curve.at(at).value
    robot = RobotDescription(
        "cam",
        (Link("base"), Link("a_link", body), Link("b_link", body)),
        joints,
        couplings=(Coupling("cam", "b", (DriverCurve("a", curve),)),),
        actuators=("a",),
        tool=Frame("b_link", placement((0.1, 0.0, 0.0))),
        homes=(Home("default", {"a": at}, {"b": value}),),
    )
    found = [float(mode.q[0]) for mode in ClosedChain(robot).working_modes()]
    assert all(curve.at(one).value - value == pytest.approx(2.0 * np.pi * round((curve.at(one).value - value) / 6.28))
               for one in found)  # fmt: skip
    same = {round(one, 6) for one in found if abs(curve.at(one).value - value) < 1e-9}
    assert same == working
    led = replace(robot, actuators=("b",), homes=(Home("default", {"b": value}, {"a": at}),))
    modes = ClosedChain(replace(led, tool=Frame("a_link", placement((0.1, 0.0, 0.0))))).assembly_modes()
    assert {round(float(mode.q_full[0]), 6) for mode in modes} == working
    with pytest.raises(ClosureError, match="coupling 'cam' stays"):
        ClosedChain(led).close([value - 10.0 if len(curve.coefficients) == 3 else value - 0.5])


def test_a_rover_moves_its_carrier_by_the_mean(tmp_path: Path) -> None:
    _, chain, _, rng = drawn("rover", 0, tmp_path)
    assert chain.mobility().mobility == 2
    start = chain.home.q_full
    for turn in rng.normal(size=(4, 2)):
        q = chain.close(chain.home.q + turn).q_full
        index = chain.model.idx_qs[chain.model.getJointId("carrier")]
        assert q[index] - start[index] == pytest.approx(turn.mean(), abs=1e-12)
