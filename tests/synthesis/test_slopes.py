"""Exact derivatives of what is wanted, against differences of robots that are built anew."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import with_values
from cutjoint.robots import load
from cutjoint.synthesis import DesignProblem, Variable, Want, judged, problem_of, synthesise
from cutjoint.synthesis.following import FollowedNumbers
from cutjoint.synthesis.slopes import EXACT, ExactSlopes, slopes_of
from cutjoint.synthesis.variables import chosen

CRANKS = Variable("cranks", "stretch", ("left_proximal", "right_proximal"), 0.8, 1.2, "x")
RODS = Variable("rods", "stretch", ("left_distal", "right_distal"), 0.8, 1.2, "x")
WEIGHT = Variable("weight", "path", ("links.left_distal.mass",), 0.1, 0.5)
ROLL = Variable("roll", "mount", ("roll",), -1.0, 1.0)
LIMBS = tuple(f"rod{limb}{side}_link" for limb in (1, 2, 3) for side in "ab")
FAMILIES = {
    "fivebar": ([CRANKS, RODS, WEIGHT, ROLL], "about-home"),
    "fivebar led by its joints": ([CRANKS, WEIGHT], "hold"),
    "omega3": (
        [
            Variable("rods", "stretch", LIMBS, 0.9, 1.2, "z"),
            Variable("arms", "stretch", ("arm1_link", "arm2_link", "arm3_link"), 0.9, 1.2, "z"),
        ],
        "paper",
    ),
    "cpm": (
        [
            Variable("platform", "path", ("links.limb3_platform.mass",), 0.1, 5.0),
            Variable("pitch", "mount", ("pitch",), -1.0, 1.0),
        ],
        "paper",
    ),
    "stewart": (
        [
            Variable("platform", "path", ("links.platform_link.mass",), 0.1, 5.0),
            Variable("roll", "mount", ("roll",), -0.5, 0.5),
        ],
        "about-home",
    ),
}


def asked(name: str) -> DesignProblem:
    variables, spec = FAMILIES[name]
    wants = [Want(one, {} if one == "mass" else {"trajectory": spec}, at_most=1e6) for one in EXACT]
    return problem_of(load(name.partition(" ")[0]), variables, wants)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_they_are_differences_of_designs(name: str) -> None:
    problem = asked(name)
    low, high = (np.array([getattr(one, end) for one in problem.variables]) for end in ("low", "high"))
    at = low + np.random.default_rng(len(name)).uniform(0.2, 0.8, len(low)) * (high - low)
    design = judged(problem, at)
    assert not design.why
    found = ExactSlopes(problem).of(design)
    for k, step in enumerate(3e-4 * (high - low)):
        way = step * np.eye(len(low))[k]
        ends = {s: judged(problem, at + s * way).found for s in (-2, -1, 1, 2)}
        for want in problem.wants:
            one = {s: end[want.name] for s, end in ends.items()}
            slope = (8.0 * (one[1] - one[-1]) - (one[2] - one[-2])) / (12.0 * step)
            size = abs(design.found[want.name]) / (high - low)[k] + abs(slope)
            assert abs(found[want.name][k] - slope) <= 1e-6 * size, (want.name, problem.variables[k].name)


@pytest.mark.slow
def test_a_descent_with_them_needs_fewer_designs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)
    wants = [Want("rms-effort", {}, "least"), Want("mass", {}, at_least=1.2)]
    problem = problem_of(load("fivebar"), [CRANKS, RODS, WEIGHT], wants)
    exact = synthesise(problem, designs=40)
    assert "exact" in exact.told[0]
    found = exact.designs[exact.best].found
    assert np.isclose(found["mass"], 1.2, atol=1e-6)  # as light as it may be
    beside = synthesise(
        problem_of(load("fivebar"), [CRANKS, RODS, WEIGHT], [*wants, Want("isotropy", {}, at_least=0.0)]), 40
    )
    assert "differences" in beside.told[0]
    assert "isotropy" in beside.told[0]
    assert len(exact.designs) < len(beside.designs)
    assert found["rms-effort"] < beside.designs[beside.best].found["rms-effort"] * (1.0 + 1e-6)


def test_numbers_follow_variables() -> None:
    robot, rng = load("fivebar").description, np.random.default_rng(5)
    other = Variable("thin", "stretch", ("left_distal", "left_proximal"), 0.7, 1.4, "z")
    variables = (CRANKS, RODS, WEIGHT, ROLL, other)
    followed = FollowedNumbers(robot, variables)
    low, high = (np.array([getattr(one, end) for one in variables]) for end in ("low", "high"))
    at = low + rng.uniform(0.1, 0.9, len(low)) * (high - low)
    # what is told is all that changes: set one by one, they are the robot with the values
    values = {str(path): x for one, x in zip(followed.groups, followed.at(at), strict=True) for path in one.paths}
    here, there = with_values(robot, values), chosen(robot, variables, at)
    for one, two in zip(here.links, there.links, strict=True):
        if one.inertial is not None and two.inertial is not None:
            assert np.allclose(one.inertial.inertia, two.inertial.inertia, rtol=1e-12, atol=1e-18)
    slopes, by_mass = followed.slopes(at)
    for k, step in enumerate(1e-3 * (high - low)):
        way = step * np.eye(len(low))[k]
        ends = [followed.at(at + s * way) for s in (-2, -1, 1, 2)]
        slope = (8.0 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12.0 * step)
        assert np.allclose(slopes[:, k], slope, rtol=1e-8, atol=1e-9 * (1.0 + np.abs(slopes).max()))
    assert np.isclose(by_mass[2], (there.link("left_distal").inertial or pytest.fail("no mass")).mass / at[2])


def test_without_them_the_reason_is_told() -> None:
    five = load("fivebar")
    exact, told = slopes_of(problem_of(five, [CRANKS], [Want("isotropy", {}, "most")]))
    assert exact is None
    assert "isotropy" in told
    still = ClosedChain(replace(five.description, gravity=np.zeros(3)))
    problem = problem_of(still, [WEIGHT], [Want("mass", {}, "least")])
    exact, told = slopes_of(problem)
    assert exact is not None
    assert np.allclose(exact.of(judged(problem, [0.3]))["mass"], [1.0])
