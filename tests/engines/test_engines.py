"""Other engines agree with the closed chain, and notice a robot that is not the one they were given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.built import built
from kit.mechanisms import MECHANISMS

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import Comparison, SampledState, sample_states
from cutjoint.description import CutJoint, CutType, Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.engines import compare
from cutjoint.engines import mujoco as engine
from cutjoint.engines.compare import compare_with_mujoco
from cutjoint.engines.yourdfpy import compare_with_yourdfpy
from cutjoint.errors import InputError
from cutjoint.robots import PUBLISHED

pytest.importorskip("mujoco", reason="MuJoCo is an optional extra")


@pytest.fixture(scope="module", params=list(PUBLISHED))
def published(request: pytest.FixtureRequest) -> tuple[ClosedChain, Sequence[SampledState]]:
    name = request.param
    chain = cutjoint.load(name, PUBLISHED[name].variant)
    return chain, list(sample_states(cutjoint.published(name), 60, 3))


def test_mujoco_agrees(published: tuple[ClosedChain, Sequence[SampledState]]) -> None:
    comparison = compare_with_mujoco(*published)
    assert comparison.samples == 60
    comparison.require()


def test_yourdfpy_puts_every_link_where_pinocchio_has_it(published: tuple[ClosedChain, Sequence[SampledState]]) -> None:
    compare_with_yourdfpy(*published).require()


@pytest.mark.parametrize("name", ["fourbar", "fivebar", pytest.param("stewart", marks=pytest.mark.slow)])
def test_robots_without_a_paper(name: str) -> None:
    chain = cutjoint.load(name)
    states = list(sample_states(chain, 5, 0))
    compare_with_mujoco(chain, states).require()
    compare_with_yourdfpy(chain, states).require()


@pytest.mark.parametrize("root", ["world", "floor"])
def test_a_body_that_floats_from_anywhere(root: str, tmp_path: Path) -> None:
    """MuJoCo counts the place of a free body in the world, wherever its joint stands; of slides from there."""
    rng = np.random.default_rng(5)
    robot = built(MECHANISMS["floating_fourbar"](rng).plan, tmp_path)[0].description
    tilt = placement(rng.normal(size=3), rng.uniform(-2.0, 2.0, 3))
    joints = [replace(one, parent=root) if one.parent == robot.root else one for one in robot.joints]
    joints = [replace(one, parent=root, placement=tilt) if one.name == "flight" else one for one in joints]
    links = [replace(one, name=root, inertial=None) if one.name == robot.root else one for one in robot.links]
    chain = ClosedChain(replace(robot, joints=tuple(joints), links=tuple(links)))
    theirs, data, energies = engine.MujocoRobot(chain), chain.model.createData(), []
    for _ in range(2):
        q, v = chain.integrate(chain.home.q_full, rng.normal(size=chain.nv)), rng.normal(size=chain.nv)
        opinion = theirs.opinion(q, v, np.zeros(chain.nv))
        bias = np.array(pin.nonLinearEffects(chain.model, data, q, v))
        np.testing.assert_allclose(opinion.bias, bias, rtol=0.0, atol=1e-9 * np.abs(bias).max())
        energies.append([opinion.potential, pin.computePotentialEnergy(chain.model, data, q)])
    (ours, other), size = np.diff(energies, axis=0)[0], np.abs(energies).max()
    assert ours == pytest.approx(other, abs=1e-9 * size)


SOLVER = "MuJoCo's solver against Pinocchio"
LEAK = "what MuJoCo's solver lets through"


def compared(chain: ClosedChain, given: RobotDescription, monkeypatch: pytest.MonkeyPatch) -> Comparison:
    """The comparison where MuJoCo is given another robot than the chain."""
    natural = engine.natural
    monkeypatch.setattr(engine, "natural", lambda _, scale: natural(given, scale))
    source = cutjoint.published(chain.description.name) if chain.description.name in PUBLISHED else chain
    return compare_with_mujoco(chain, list(sample_states(source, 5, 0)))


def failed(comparison: Comparison) -> set[str]:
    return {row.quantity for row in comparison.rows if not row.passes}


@pytest.mark.parametrize("factor", [0.99, 1.001, 1.01])
def test_mujoco_notices_another_mass(factor: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo is given a robot with one rod of another mass: masses and dynamics are off, directions are not."""
    chain = cutjoint.load("cpm", "lumped")
    old = chain.description.link("limb2_distal").inertial
    assert old is not None
    heavier = chain.description.with_inertial("limb2_distal", replace(old, mass=factor * old.mass))
    off = failed(compared(chain, heavier, monkeypatch))
    assert {"mass matrix of the tree", "bias of the tree", "forward dynamics, hard constraints", SOLVER} <= off
    assert "directions of the constraints" not in off


@pytest.mark.parametrize("name", ["cpm", "omega3"])
@pytest.mark.parametrize("wrong", ["place", "missing"])
def test_mujoco_notices_another_cut(name: str, wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cut joint a tenth of a millimetre off, or one that is not there: the tree is right, the solver is not."""
    chain = cutjoint.load(name, PUBLISHED[name].variant if name in PUBLISHED else None)
    cut = chain.description.cuts[-1]
    beside = np.array(cut.b.placement)
    beside[:3, 3] += 1e-4
    other = replace(cut, b=replace(cut.b, placement=beside)) if wrong == "place" else None
    cuts = (*chain.description.cuts[:-1], *([] if other is None else [other]))
    comparison = compared(chain, replace(chain.description, cuts=cuts), monkeypatch)
    assert {"place": SOLVER, "missing": LEAK}[wrong] in failed(comparison)
    assert not failed(comparison) & {"mass matrix of the tree", "bias of the tree"}


@pytest.mark.parametrize("impedance", [0.9, 0.99, 0.9998])
def test_a_solver_softer_than_asked_for_is_noticed(impedance: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its softness explains what it gives, and is no excuse: the bound does not come from the solver."""
    chain = cutjoint.load("cpm", "lumped")
    made = engine.MujocoRobot

    def softer(chain: ClosedChain) -> engine.MujocoRobot:
        robot = made(chain)
        robot._model.eq_solimp[:, :2] = impedance
        return robot

    monkeypatch.setattr(compare, "MujocoRobot", softer)
    comparison = compare_with_mujoco(chain, list(sample_states(cutjoint.published("cpm"), 5, 0)))
    assert failed(comparison) - {LEAK} == {SOLVER}
    assert (LEAK in failed(comparison)) == (impedance < 0.999)


def test_no_tolerance_comes_from_what_is_compared() -> None:
    for name in PUBLISHED:
        chain = cutjoint.load(name)
        comparison = compare_with_mujoco(chain, list(sample_states(cutjoint.published(name), 2, 0)))
        assert {row.quantity: row.tolerance for row in comparison.rows} == compare.TOLERANCE


def placed(frame: Frame, s: float) -> Frame:
    return replace(frame, placement=moved(frame.placement, s))


def moved(placement: np.ndarray, s: float) -> np.ndarray:
    return np.block([[placement[:3, :3], s * placement[:3, 3:]], [placement[3:, :]]])


def scaled(robot: RobotDescription, s: float, m: float) -> RobotDescription:
    """The five-bar or the Omega-3 with lengths times s and masses times m."""
    links = []
    for link in robot.links:
        old = link.inertial
        new = None if old is None else Inertial(m * old.mass, s * old.com, m * s * s * old.inertia)
        links.append(replace(link, inertial=new))
    floating = {joint.name for joint in robot.joints if joint.type is JointType.FLOATING}

    def start(name: str, value: Any) -> Any:
        return (*(s * x for x in value[:3]), *value[3:]) if name in floating else value

    homes = tuple(replace(home, passive={k: start(k, v) for k, v in home.passive.items()}) for home in robot.homes)
    return replace(
        robot,
        links=tuple(links),
        joints=tuple(replace(joint, placement=moved(joint.placement, s)) for joint in robot.joints),
        cuts=tuple(replace(cut, a=placed(cut.a, s), b=placed(cut.b, s)) for cut in robot.cuts),
        tool=None if robot.tool is None else placed(robot.tool, s),
        homes=homes,
        variants=(),
    )


@pytest.mark.parametrize(("s", "m"), [(1e-4, 1.0), (1e4, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e-4, 1e-6), (1e4, 1e6)])
@pytest.mark.parametrize("name", ["fivebar", "omega3"])
def test_engines_agree_at_every_size_and_mass(name: str, s: float, m: float) -> None:
    """Errors are those of the robot as it is, within a factor of 100 above rounding."""
    base = cutjoint.load(name, PUBLISHED[name].variant if name in PUBLISHED else None).description
    random = np.random.default_rng(1)
    draws = [random.normal(size=(2, len(base.actuators))) for _ in range(3)]

    def comparisons(chain: ClosedChain, s: float, m: float) -> list[Comparison]:
        home = chain.home
        position = chain.tool(home).position
        size = m * 9.81 * chain.length
        states = [SampledState(home, position, v / np.sqrt(s), v / s, size * effort) for v, effort in draws]
        return [compare_with_mujoco(chain, states), compare_with_yourdfpy(chain, states)]

    plain = comparisons(ClosedChain(scaled(base, 1.0, 1.0)), 1.0, 1.0)
    for found, wanted in zip(comparisons(ClosedChain(scaled(base, s, m)), s, m), plain, strict=True):
        found.require()
        for one, other in zip(found.rows, wanted.rows, strict=True):
            assert one.error <= 100.0 * max(other.error, 1e-12)


def test_mujoco_says_which_joint_it_has_no_word_for() -> None:
    from cutjoint.engines.mujoco import MujocoRobot

    description = cutjoint.load("fourbar").description
    joint = next(joint for joint in description.joints if joint.name == "crank")
    universal = replace(joint, type=type(joint.type).UNIVERSAL, axis=np.array([0.0, 1.0, 0.0]))
    joints = tuple(universal if one.name == "crank" else one for one in description.joints)
    chain = ClosedChain(replace(description, joints=joints, actuators=(), cuts=(), homes=()))
    with pytest.raises(InputError, match="crank"):
        MujocoRobot(chain)


def test_mujoco_says_that_a_carrier_is_not_mapped() -> None:
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    body, turn = Inertial(1.0, inertia=np.eye(3)), JointType.CONTINUOUS
    robot = RobotDescription(
        name="cross",
        links=(Link("base"), Link("a", body), Link("b", body)),
        joints=(
            Joint("x", turn, "base", "a", axis=x),
            Joint("y", turn, "a", "b", axis=y),
        ),
        cuts=(CutJoint("twice", CutType.UNIVERSAL, Frame("base"), Frame("b")),),
        actuators=("x", "y"),
    )
    with pytest.raises(InputError, match="carrier"):
        compare_with_mujoco(ClosedChain(robot), [])
