"""Random loops of every kind, every cut, at random mountings: compiled dynamics against variational principles.

A planar loop that stands askew has redundant rows that are nothing but rounding, and so has a ball at the centre of a
spherical limb.  What is rounding is decided once, in the robot's own size, and never by a row's own.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement

LOOPS = ("planar", "spherical", "spatial")
CUTS = ("fixed", "revolute", "prismatic", "universal", "spherical")
EXTRAS = ("none", "coupling", "prismatic", "universal")
JOINTS = {
    "planar": {"fixed": 4, "revolute": 3, "prismatic": 3, "universal": 3, "spherical": 3},
    "spherical": {"fixed": 4, "revolute": 3, "prismatic": 4, "universal": 2, "spherical": 1},
    "spatial": {"fixed": 7, "revolute": 6, "prismatic": 6, "universal": 5, "spherical": 4},
}
"""Joints of a limb that can move once when its end is joined to the base: one more than the rank of the cut's rows."""


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """(4, 4)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    made = np.eye(4)
    made[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return made


def direction(rng: np.random.Generator) -> np.ndarray:
    axis = rng.normal(size=3)
    return np.asarray(axis / np.linalg.norm(axis))


def some_body(rng: np.random.Generator) -> Inertial:
    points = 0.1 * rng.normal(size=(6, 3))
    mass = rng.uniform(0.3, 2.0)
    inertia = sum((p @ p) * np.eye(3) - np.outer(p, p) for p in points) * mass / 6
    return Inertial(mass, 0.1 * rng.normal(size=3), inertia)


class Builder:
    """A robot of limbs that are joined at home, standing at `mount`."""

    def __init__(self, rng: np.random.Generator, mount: np.ndarray) -> None:
        self.rng, self.mount = rng, mount
        self.links, self.joints = [Link("base")], []
        self.home: dict[str, float] = {}
        self.cuts: list[CutJoint] = []

    def limb(self, name: str, count: int, kind: str) -> tuple[str, np.ndarray]:
        """Name and placement, at home and before the mounting, of the last link of a limb of revolute joints."""
        rng, carrier, here = self.rng, "base", np.eye(4)
        for k in range(count):
            axis = np.array([0.0, 0.0, 1.0]) if kind == "planar" else direction(rng)
            if kind == "planar":
                step = placement((*rng.uniform(0.2, 0.5, 2) * rng.choice([-1, 1], 2), 0.0), (0.0, 0.0, 0.0))
            elif kind == "spherical":
                step = np.eye(4)
            else:
                step = placement(tuple(rng.uniform(-0.4, 0.4, 3)), tuple(rng.uniform(-1, 1, 3)))
            link, angle = f"{name}{k}", float(rng.uniform(-1.0, 1.0))
            stands = self.mount @ step if carrier == "base" else step
            self.links.append(Link(link, some_body(rng)))
            self.joints.append(Joint(link, JointType.CONTINUOUS, carrier, link, stands, axis=axis))
            self.home[link] = angle
            here = here @ step @ turn(axis, angle)
            carrier = link
        return carrier, here

    def join(self, name: str, cut: str, ends: tuple[tuple[str, np.ndarray], tuple[str, np.ndarray]], kind: str) -> None:
        """Cut joint between two links where they are."""
        (link_a, at_a), (link_b, at_b) = ends
        axes = np.eye(4)
        if kind == "planar":
            # the hinge turns in the plane, the slide lies in it, one axis of the cross stands on it
            across = {"prismatic": turn(np.array([1.0, 0.0, 0.0]), 0.5 * np.pi)}
            across["universal"] = turn(np.array([0.0, 1.0, 0.0]), -0.5 * np.pi)
            axes = across.get(cut, axes)
        else:
            axes = turn(direction(self.rng), float(self.rng.uniform(0.3, 2.0)))
        tip = {"planar": (0.3, 0.1, 0.0), "spherical": (0.0, 0.0, 0.0), "spatial": (0.3, -0.2, 0.1)}[kind]
        where = at_b @ placement(tip, (0.0, 0.0, 0.0)) @ axes
        frames = [
            Frame(link, (self.mount if link == "base" else np.eye(4)) @ np.linalg.inv(at) @ where)
            for link, at in ((link_a, at_a), (link_b, at_b))
        ]
        self.cuts.append(CutJoint(name, CutType(cut), *frames))


def robot(loop: str, cut: str, extra: str, seed: int, rpy: tuple[float, ...]) -> RobotDescription:
    """A limb whose end is joined to the base, with one motor and something else that hangs on that; gravity turns with
    the mounting."""
    mount = placement((0.1, -0.2, 0.3), rpy)
    made = Builder(np.random.default_rng(seed), mount)
    base = ("base", np.eye(4))
    made.join("loop", cut, (base, made.limb("limb", JOINTS[loop][cut], loop)), loop)
    first = made.joints[0]
    crank = ("limb0", np.linalg.inv(mount) @ first.placement @ turn(first.axis, made.home["limb0"]))
    couplings: tuple[Coupling, ...] = ()
    if extra == "coupling":
        made.limb("gear", 1, "planar")
        made.home["gear0"] = -2.0 * made.home["limb0"] + 0.3
        couplings = (Coupling.geared("gears", "gear0", "limb0", -2.0, 0.3),)
    elif extra != "none":
        made.join("more", extra, (crank, made.limb("arm", JOINTS["spatial"][extra] - 1, "spatial")), "spatial")
    passive = {name: angle for name, angle in made.home.items() if name != "limb0"}
    return RobotDescription(
        name=f"{loop} loop, {cut} cut, {extra}",
        links=tuple(made.links),
        joints=tuple(made.joints),
        cuts=tuple(made.cuts),
        couplings=couplings,
        actuators=("limb0",),
        gravity=mount[:3, :3] @ np.array([1.0, -2.0, -9.0]),
        homes=(Home("default", {"limb0": made.home["limb0"]}, passive),),
    )


def mounting(seed: int) -> tuple[float, ...]:
    return tuple(np.random.default_rng(1000 + seed).uniform(-np.pi, np.pi, 3))


def check(kit: Any, loop: str, cut: str, extra: str, seed: int, rpy: tuple[float, ...]) -> np.ndarray:
    """Compiled dynamics of a robot are those of the principles; returns what falls out at a state."""
    chain = ClosedChain(robot(loop, cut, extra, seed, rpy))
    machine, numbers, rng = compiled(chain, cached=False), kit.numbers(chain), np.random.default_rng(seed)
    assert machine.source.determined
    what = (loop, cut, extra, seed, rpy)
    for q in (chain.home.q_full, machine.source.cloud[1]):
        here = chain.posture(q)
        v, a = 2.0 * rng.normal(size=1), 10.0 * rng.normal(size=1)
        tangent = numbers.tangent(q)
        effort = numbers.effort(q, v, a)
        v_full = tangent @ v
        projected = tangent.T @ numbers.forces(q, v_full, numbers.accelerations(q, v_full, effort))
        size = np.abs(tangent.T @ numbers.mass(q) @ tangent * a).max() + np.abs(effort).max()
        assert np.abs(projected - effort).max() < 1e-9 * size, what
        assert machine.kernel("inverse")(q, v, a, np.zeros(0))[-1] <= STRAIN_LIMIT, what
        assert np.abs(machine.inverse_dynamics(here, v, a) - effort).max() < 1e-9 * size, what
        # an acceleration is as exact as the forces are that make it
        missed = machine.forward_dynamics(here, v, effort) - a
        assert np.abs(tangent.T @ numbers.mass(q) @ tangent * missed).max() < 1e-9 * size, what
        assert np.abs(machine.tangent(here) - tangent).max() < 1e-9 * np.abs(tangent).max(), what
    return np.asarray(machine.forward_dynamics(chain.home, np.ones(1), np.zeros(1)))


SOME = [
    ("planar", "revolute", "coupling", 0),
    ("planar", "universal", "none", 1),
    ("planar", "fixed", "none", 2),
    ("spherical", "spherical", "coupling", 3),
    ("spherical", "prismatic", "none", 4),
    ("spatial", "spherical", "coupling", 5),
]


@pytest.mark.parametrize(("loop", "cut", "extra", "seed"), SOME)
def test_a_mounting_changes_nothing(kit: Any, loop: str, cut: str, extra: str, seed: int) -> None:
    straight = check(kit, loop, cut, extra, seed, (0.0, 0.0, 0.0))
    askew = check(kit, loop, cut, extra, seed, mounting(seed))
    np.testing.assert_allclose(askew, straight, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("loop", "cut", "extra"), list(product(LOOPS, CUTS, EXTRAS)))
def test_every_loop_cut_and_company_at_random_mountings(kit: Any, loop: str, cut: str, extra: str) -> None:
    found = [check(kit, loop, cut, extra, 7, mounting(k)) for k in range(4)]
    np.testing.assert_allclose(np.array(found), np.tile(found[0], (4, 1)), rtol=1e-9)


def test_many_motors_share_the_work_of_one(kit: Any) -> None:
    """Two motors on a spatial loop that moves twice: nothing above rests on there being one."""
    description = robot("spatial", "spherical", "none", 11, mounting(11))
    more = Builder(np.random.default_rng(12), placement((0.1, -0.2, 0.3), mounting(11)))
    name, _ = more.limb("free", 1, "spatial")
    both = replace(
        description,
        links=(*description.links, *more.links[1:]),
        joints=(*description.joints, *more.joints),
        actuators=("limb0", name),
        homes=(replace(description.homes[0], actuated={**description.homes[0].actuated, **more.home}),),
    )
    chain = ClosedChain(both)
    machine, numbers = compiled(chain, cached=False), kit.numbers(chain)
    v, a = np.array([1.0, -2.0]), np.array([3.0, 4.0])
    effort = numbers.effort(chain.home.q_full, v, a)
    np.testing.assert_allclose(machine.inverse_dynamics(chain.home, v, a), effort, rtol=1e-9)
    np.testing.assert_allclose(machine.forward_dynamics(chain.home, v, effort), a, rtol=1e-9)


def test_a_ball_at_the_centre_of_a_limb_takes_no_freedom(kit: Any) -> None:
    """All rows of its cut are rounding, and the largest of them is no measure of the others."""
    mount = placement((0.1, -0.2, 0.3), mounting(5))
    made = Builder(np.random.default_rng(5), mount)
    made.join("centre", "spherical", (("base", np.eye(4)), made.limb("limb", 3, "spherical")), "spherical")
    names = tuple(made.home)
    description = RobotDescription(
        name="ball at the centre",
        links=tuple(made.links),
        joints=tuple(made.joints),
        cuts=tuple(made.cuts),
        actuators=names,
        homes=(Home("default", made.home),),
    )
    chain = ClosedChain(description)
    machine, numbers = compiled(chain, cached=False), kit.numbers(chain)
    assert machine.source.idle == 0
    assert len(machine.source.plan.redundant) == 3
    v, a, q = np.array([1.0, -2.0, 0.5]), np.array([3.0, 4.0, -1.0]), chain.home.q_full
    effort = numbers.forces(q, v, a)
    np.testing.assert_allclose(machine.inverse_dynamics(chain.home, v, a), effort, rtol=1e-12)
    np.testing.assert_allclose(machine.forward_dynamics(chain.home, v, effort), a, rtol=1e-12)
    np.testing.assert_allclose(machine.full_acceleration(q, v, effort), a, rtol=1e-12)
