"""Every robot that has a published model against it: a thousand states, and mistakes made on purpose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import QUANTITIES, Comparison, SampledState, compare, hypothesis_cost, sample_states
from cutjoint.description import load_description
from cutjoint.description.model import Inertial, RobotDescription
from cutjoint.errors import ToleranceError
from cutjoint.robots import PUBLISHED, load, published

PAIRS = sorted(PUBLISHED)
WITH_HYPOTHESIS = [robot for robot in PAIRS if PUBLISHED[robot].physical is not None]


@cache
def states(robot: str, count: int) -> tuple[SampledState, ...]:
    return tuple(sample_states(published(robot), count, seed=1))


def against(robot: str, description: RobotDescription, count: int = 12) -> Comparison:
    """A changed chain against the published model."""
    return compare(ClosedChain(description), published(robot), states(robot, count))


def lumped(robot: str) -> RobotDescription:
    return load_description(robot, PUBLISHED[robot].variant)


@pytest.mark.slow
@pytest.mark.parametrize("robot", PAIRS)
def test_a_thousand_states_agree_to_1e_10(robot: str) -> None:
    reference = published(robot)
    found = compare(load(robot, PUBLISHED[robot].variant), reference, sample_states(reference, 1000, seed=0))
    assert found.samples == 1000
    assert found.refused == 0
    assert tuple(row.quantity for row in found.rows) == QUANTITIES
    assert {row.quantity: row.error for row in found.rows if not row.error <= 1e-10} == {}
    assert found.passes
    found.require()


@pytest.mark.parametrize("robot", PAIRS)
def test_what_both_models_say_about_themselves(robot: str) -> None:
    chain, paper = load(robot, PUBLISHED[robot].variant), published(robot)
    assert chain.n == paper.n
    assert [one.kind for one in chain.actuators] == [one.kind for one in paper.actuators]
    np.testing.assert_allclose(chain.home.q, paper.home.q, atol=1e-12)
    np.testing.assert_allclose(chain.tool(chain.home).position, paper.tool(paper.home).position, atol=1e-12)


@pytest.mark.parametrize("robot", WITH_HYPOTHESIS)
def test_the_physical_variant_differs_as_much_as_the_hypothesis_costs(robot: str) -> None:
    """Geometry and gravity cannot tell the two apart; inertia does."""
    found = against(robot, load_description(robot, PUBLISHED[robot].physical))
    off = {row.quantity for row in found.rows if not row.passes}
    assert {"mass matrix", "inverse dynamics", "forward dynamics"} <= off
    assert not off & {"actuated coordinates", "tool position", "Jacobian", "J_dot v", "gravity"}


@pytest.mark.parametrize("robot", PAIRS)
def test_payloads_agree_too(robot: str) -> None:
    chain, paper = load(robot, PUBLISHED[robot].variant).with_payload(0.8), published(robot).with_payload(0.8)
    compare(chain, paper, sample_states(paper, 20, seed=3)).require()


# ---- wrong on purpose ------------------------------------------------------------------------------------------------

GEOMETRY = {"actuated coordinates", "Jacobian"}
DYNAMICS = {"mass matrix", "gravity", "inverse dynamics", "forward dynamics"}


def heavier(description: RobotDescription, link: str) -> RobotDescription:
    """One mass, and with it its inertia, larger by one per cent."""
    old = description.link(link).inertial
    assert old is not None
    return description.with_inertial(link, Inertial(1.01 * old.mass, old.com, 1.01 * old.inertia))


def upside_down(description: RobotDescription) -> RobotDescription:
    return replace(description, gravity=readonly(-description.gravity))


def shifted(description: RobotDescription, joint: str, axis: int) -> RobotDescription:
    """The base of a limb moved by a millimetre."""
    place = np.array(description.joint(joint).placement)
    place[axis, 3] += 1e-3
    joints = tuple(replace(one, placement=readonly(place)) if one.name == joint else one for one in description.joints)
    return replace(description, joints=joints)


@pytest.mark.parametrize(
    ("robot", "link"),
    [("cpm", "limb1_proximal"), ("cpm", "limb3_slider"), ("omega3", "arm2_link"), ("omega3", "platform_link")],
)
def test_a_mass_changed_by_one_per_cent_is_noticed(robot: str, link: str) -> None:
    found = against(robot, heavier(lumped(robot), link))
    off = {row.quantity for row in found.rows if not row.passes}
    assert off >= {"mass matrix", "inverse dynamics", "forward dynamics"}
    assert not off & {"actuated coordinates", "tool position", "Jacobian", "J_dot v"}
    assert not found.passes
    with pytest.raises(ToleranceError, match="mass matrix") as caught:
        found.require()
    assert set(caught.value.worst) == off
    error, allowed = caught.value.worst["mass matrix"]
    assert 1e-5 < error < 0.02
    assert allowed == 1e-10


@pytest.mark.parametrize("robot", PAIRS)
def test_a_wrong_sign_of_gravity_is_noticed(robot: str) -> None:
    found = against(robot, upside_down(lumped(robot)))
    off = {row.quantity for row in found.rows if not row.passes}
    assert off == {"gravity", "inverse dynamics", "forward dynamics"}
    with pytest.raises(ToleranceError, match="gravity"):
        found.require()


@pytest.mark.parametrize(("robot", "joint", "axis"), [("cpm", "limb3_slide", 1), ("omega3", "arm1", 2)])
def test_a_base_moved_by_a_millimetre_is_noticed(robot: str, joint: str, axis: int) -> None:
    found = against(robot, shifted(lumped(robot), joint, axis))
    off = {row.quantity for row in found.rows if not row.passes}
    assert {"mass matrix", "inverse dynamics", "forward dynamics"} <= off
    assert "J_dot v" in off or robot == "cpm", "the CPM's Jacobian is constant"
    if robot == "omega3":
        assert {"actuated coordinates", "Jacobian"} <= off
    with pytest.raises(ToleranceError):
        found.require()


@pytest.mark.parametrize(
    "spoil",
    [
        lambda description: replace(description, actuators=description.actuators[::-1]),
        lambda description: replace(
            description, tool=replace(description.tool, placement=readonly(moved(description.tool.placement)))
        ),
    ],
    ids=["actuators in another order", "tool frame off by 0.1 mm"],
)
@pytest.mark.parametrize("robot", PAIRS)
def test_other_mistakes_are_noticed(robot: str, spoil: Callable[[RobotDescription], RobotDescription]) -> None:
    found = against(robot, spoil(lumped(robot)))
    assert not found.passes
    assert any(row.quantity == "actuated coordinates" and not row.passes for row in found.rows) or found.refused


def moved(placement: np.ndarray) -> np.ndarray:
    place = np.array(placement)
    place[:3, 3] += 1e-4
    return place


@pytest.mark.parametrize("robot", WITH_HYPOTHESIS)
def test_what_the_hypothesis_costs_along_the_papers_path(robot: str) -> None:
    row = PUBLISHED[robot]
    trajectory = row.trajectory()
    motions = [trajectory.at(float(t)) for t in np.linspace(0.0, trajectory.duration, 41)]
    path = [(one.position, one.velocity, one.acceleration) for one in motions]
    nothing = hypothesis_cost(published(robot), load(robot, row.variant), path)
    assert nothing.error.max() < 1e-10 * nothing.peak.max()
    cost = hypothesis_cost(published(robot), load(robot, row.physical), path)
    assert cost.units == (("N",) * 3 if robot == "cpm" else ("N m",) * 3)
    assert (cost.percent > 1e-3).all()
    assert (cost.percent < 20.0).all()
    assert (cost.percent_inertial > cost.percent).all()
    if robot == "cpm":  # the figures of the errata
        assert cost.error.max() == pytest.approx(0.109, abs=0.002)
