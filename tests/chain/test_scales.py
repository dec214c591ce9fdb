"""Neither the size of a robot nor its mass, its orientation, gravity or its place in the world decides anything.

Each robot is built again in another size and somewhere else.  What is computed there is made dimensionless and compared
with the robot as it is; where that is only rounding, it may be a hundred times the rounding of the robot merely turned.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.blueprint import Blueprint, random_rotation
from kit.loops import loop
from kit.mechanisms import MECHANISMS
from kit.rods import ankle
from kit.sized import UPRIGHT, Size, configuration, coordinate_units

from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, Home, RobotDescription, catalogue, load_description
from cutjoint.errors import CutjointError
from cutjoint.robots import load

EPS = 1e-15
"""What counts as the rounding of a number of size 1, where the robot that is merely turned shows less."""
FACTOR = 100.0


def drawn(plan: Blueprint, *actuators: str) -> RobotDescription:
    """A plan, read from its files."""
    plan.actuators = [*actuators] or plan.actuators
    with TemporaryDirectory() as folder:
        return load_description(plan.write(Path(folder)))


def with_slide_and_gear() -> RobotDescription:
    """A planar loop with a slide in its tree, a universal cut and a gear to a wheel."""
    rng = np.random.default_rng(6)
    plan, _ = loop("planar", "universal", "prismatic", rng)
    plan.joint("wheel", "continuous", "base", "wheel_link", 0.3 * rng.normal(size=3), rng.normal(size=3))
    driver = next(joint for joint in plan.joints if joint.kind == "continuous" and joint.name != "wheel")
    slide = next(joint for joint in plan.joints if joint.kind == "prismatic")
    plan.couple("gear", "wheel", driver.name, -2.0)
    plan.tool = (slide.child, 0.2 * rng.normal(size=3))
    return drawn(plan, driver.name)


def with_rack() -> RobotDescription:
    """A spatial loop closed by a prismatic cut, with a rack: a slide that a hinge drives."""
    rng = np.random.default_rng(23)
    plan, _ = loop("spatial", "prismatic", "none", rng)
    plan.joint("rack", "prismatic", "base", "rack_link", 0.3 * rng.normal(size=3), rng.normal(size=3), start=0.02)
    first = plan.joints[0]
    plan.couple("pinion", "rack", first.name, 0.07)
    plan.tool = (first.child, 0.2 * rng.normal(size=3))
    return drawn(plan, first.name)


OTHERS: dict[str, Callable[[], RobotDescription]] = {
    "slide, universal cut, gear": with_slide_and_gear,
    "prismatic cut, rack": with_rack,
    "ball-ball rods": lambda: drawn(ankle(np.random.default_rng(3))),
}
ROBOTS = [*catalogue.names(), *OTHERS]


@cache
def description(name: str) -> RobotDescription:
    return OTHERS[name]() if name in OTHERS else load_description(name)


@dataclass(frozen=True)
class Sample:
    """A state at size 1: configuration, velocity and efforts of all joints; speeds, their rates and a way of the
    actuators; a little error of all joints."""

    q: np.ndarray
    v: np.ndarray
    effort: np.ndarray
    speed: np.ndarray
    rate: np.ndarray
    step: np.ndarray
    nudge: np.ndarray


@cache
def plain(name: str) -> ClosedChain:
    """The robot as it is."""
    return ClosedChain(Size().of(description(name)))


@cache
def samples(name: str) -> list[Sample]:
    chain, rng, made = plain(name), np.random.default_rng(11), []
    units = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    for _ in range(2):
        free = tree_motions(chain, np.array(chain.home.q_full))
        start = chain.integrate(chain.home.q_full, free @ rng.uniform(-0.1, 0.1, free.shape[1]))
        at = chain.assemble(start, keep_actuators=False)
        speed = units * rng.normal(size=chain.n)
        free = tree_motions(chain, np.array(at.q_full))
        determined = chain.mobility().determined
        v = chain.full_velocity(at, speed) if determined else free @ rng.normal(size=free.shape[1])
        made.append(
            Sample(
                np.array(at.q_full),
                np.array(v),
                3.0 * rng.normal(size=chain.nv),
                speed,
                units * rng.normal(size=chain.n),
                0.05 * units * rng.uniform(-1.0, 1.0, chain.n),
                1e-4 * tree_units(chain) * rng.uniform(-1.0, 1.0, chain.nv),
            )
        )
    return made


def tree_units(chain: ClosedChain) -> np.ndarray:
    """The robot's length for the velocities that are lengths, 1 for angles, (nv,)."""
    return coordinate_units(chain, Size(length=chain.length))


def tree_motions(chain: ClosedChain, q: np.ndarray) -> np.ndarray:
    """Basis of the motions that the loops allow, (nv, k)."""
    rows = np.where(chain._k.closure.is_length, chain.length, 1.0)[:, None]
    matrix = chain.constraint_jacobian(q) / rows * tree_units(chain)
    if not len(matrix):
        return np.diag(tree_units(chain))
    _, values, right = np.linalg.svd(matrix)
    return tree_units(chain)[:, None] * right[int((values > 1e-8 * values[0]).sum()) :].T


def off(found: Any, wanted: Any, size: float | None = None) -> float:
    """Largest difference relative to the largest wanted number, or to `size`."""
    found, wanted = np.asarray(found, dtype=float), np.asarray(wanted, dtype=float)
    assert np.isfinite(found).all()
    assert found.shape == wanted.shape
    scale = float(np.abs(wanted).max(initial=0.0)) if size is None else size
    return float(np.abs(found - wanted).max(initial=0.0)) / (scale or 1.0)


def errors(name: str, size: Size) -> dict[str, float]:
    """Relative errors of all quantities at a size, the largest over the samples."""
    plainly, chain = plain(name), ClosedChain(size.of(description(name)))
    worst: dict[str, float] = {}
    for sample in samples(name):
        found = {**placed(plainly, chain, size, sample), **moved(plainly, chain, size, sample)}
        if plainly.mobility().determined:
            found |= actuated(plainly, chain, size, sample)
        worst = {key: max(worst.get(key, 0.0), value) for key, value in found.items()}
    return worst


def placed(one: ClosedChain, chain: ClosedChain, size: Size, s: Sample) -> dict[str, float]:
    """Places, energies and distances to singularities."""
    q = configuration(chain, size, s.q)
    at, right = chain.assemble(q), one.posture(s.q)
    far = float(np.linalg.norm(size.offset))
    reach = size.length * one._k.reach + far
    mine, own = chain.mobility(at), one.mobility(right)
    for key in (
        "velocities",
        "rows",
        "rank",
        "mobility",
        "dropped_rows",
        "determined",
        "free",
        "idle",
        "idle_mobility",
    ):
        assert getattr(mine, key) == getattr(own, key), key
    # rows along the world's axes are other rows for a robot that is turned
    assert len(mine.redundant_rows) == len(own.redundant_rows)
    if size.rotation is UPRIGHT:
        assert mine.redundant_rows == own.redundant_rows
    found = {"gap": at.gap[0] / (size.length * one.length) + at.gap[1]}
    for key in ("type1", "type2", "condition"):
        a, b = getattr(mine, key), getattr(own, key)
        assert np.isnan(a) == np.isnan(b), key
        if np.isfinite(b):
            found[key] = off(a, b)
    links, wanted = chain.link_placements(at), one.link_placements(s.q)
    found["links"] = max(pose_off(links[key], wanted[key], size, reach) for key in wanted if key != "ground")
    pairs = zip(chain.cut_placements(at), one.cut_placements(s.q), strict=True)
    found["cuts"] = max(
        (max(pose_off(a, c, size, reach), pose_off(b, d, size, reach)) for (_, a, b), (_, c, d) in pairs), default=0.0
    )
    found["centre"] = off(chain.centre_of_mass(at), size.place(one.centre_of_mass(s.q)), reach)
    mass = sum(inertia.mass for inertia in list(chain.model.inertias)[1:])
    weight = mass * np.array(chain.model.gravity.linear)
    energy = size.energy * one.potential_energy(right) - weight @ size.offset
    found["potential energy"] = off(chain.potential_energy(at), energy, float(np.linalg.norm(weight)) * reach)
    if chain.description.tool is not None:
        frame = chain.description.tool
        position = (links[frame.link] @ frame.placement)[:3, 3]
        before = one.description.tool
        assert before is not None
        right_place = size.place((wanted[before.link] @ before.placement)[:3, 3])
        found["tool"] = off(position, right_place, reach)
    return found


def pose_off(found: np.ndarray, wanted: np.ndarray, size: Size, reach: float) -> float:
    """A placement (4, 4) against that of the robot as it is."""
    turned = off(found[:3, :3], size.rotation @ wanted[:3, :3], 1.0)
    return max(turned, off(found[:3, 3], size.place(wanted[:3, 3]), reach))


def moved(one: ClosedChain, chain: ClosedChain, size: Size, s: Sample) -> dict[str, float]:
    """Dynamics in full coordinates, and projecting."""
    at, units = chain.assemble(configuration(chain, size, s.q)), coordinate_units(chain, size)
    v, effort = units * s.v / size.time, size.energy * s.effort / units
    motion = chain.full_forward_dynamics(at, v, effort)
    right = one.full_forward_dynamics(one.posture(s.q), s.v, s.effort)
    own = tree_units(one)
    acceleration = motion.acceleration * size.time**2 / units
    quick = chain.full_acceleration(at.q_full, v, effort) * size.time**2 / units
    free = tree_motions(one, s.q)
    forces = np.array(pin.rnea(one.model, one.model.createData(), s.q, s.v, acceleration))
    terms = np.abs(free.T) @ (np.abs(forces) + np.abs(s.effort))
    found = {
        "acceleration": off(acceleration / own, right.acceleration / own),
        "acceleration alone": off(quick / own, right.acceleration / own),
        "Newton's equation": float(np.abs(free.T @ (forces - s.effort)).max() / terms.max()),
    }
    loads = [one.length * np.linalg.norm(w.force) + np.linalg.norm(w.moment) for w in right.loop_forces.values()]
    for cut, wrench in right.loop_forces.items():
        here, unit = motion.loop_forces[cut], size.mass * size.gravity
        force = off(here.force / unit, size.rotation @ wrench.force, max(loads) / one.length)
        moment = off(here.moment / unit / size.length, size.rotation @ wrench.moment, max(loads))
        found["loop forces"] = max(found.get("loop forces", 0.0), force, moment)
    nudged = chain.integrate(at.q_full, coordinate_units(chain, size) * s.nudge)
    projected, rates = chain.project(nudged, v)
    ahead, rate = one.project(one.integrate(s.q, s.nudge), s.v)
    apart = pin.difference(chain.model, np.array(configuration(chain, size, ahead)), np.array(projected))
    found["projected"] = off(apart / units / own, np.zeros(chain.nv), 1.0)
    found["projected gap"] = chain.gap(projected)[0] / (size.length * one.length) + chain.gap(projected)[1]
    found["projected velocity"] = off(rates * size.time / units / own, rate / own)
    return found


def actuated(one: ClosedChain, chain: ClosedChain, size: Size, s: Sample) -> dict[str, float]:
    """Everything in actuated coordinates."""
    at, right = chain.assemble(configuration(chain, size, s.q)), one.posture(s.q)
    units = np.array([size.length if a.kind == "translation" else 1.0 for a in chain.actuators])
    own = np.array([one.length if a.kind == "translation" else 1.0 for a in one.actuators])
    force = size.energy / units
    v, a = units * s.speed / size.time, units * s.rate / size.time**2
    effort = chain.inverse_dynamics(at, v, a)
    terms, wanted = chain.terms(at, v), one.terms(right, s.speed)
    sizes = np.abs(own * (wanted.mass @ s.rate)) + np.abs(own * wanted.coriolis) + np.abs(own * wanted.gravity)
    load = float(sizes.max())
    mass = own[:, None] * wanted.mass * own
    found = {
        "round trip": off(chain.forward_dynamics(at, v, effort) / a, np.ones(chain.n)),
        "inverse": off(own * effort / force, own * one.inverse_dynamics(right, s.speed, s.rate), load),
        "mass": off(own[:, None] * terms.mass * own / (force * size.time**2 / units[:, None]).T, mass),
        "coriolis": off(own * terms.coriolis / force, own * wanted.coriolis, load),
        "gravity": off(own * terms.gravity / force, own * wanted.gravity, load),
    }
    moved_to = chain.close(units * (right.q + s.step), at)
    there = one.close(right.q + s.step, right)
    tree = coordinate_units(chain, size) * tree_units(one)
    idle = chain.mobility().idle_mobility > 0

    def apart(mine: Any, wanted: Any) -> float:
        return off(pin.difference(chain.model, configuration(chain, size, wanted.q_full), np.array(mine.q_full)) / tree,
                   np.zeros(chain.nv), 1.0)  # fmt: skip

    found["close"] = apart(moved_to, there)
    found["close gap"] = moved_to.gap[0] / (size.length * one.length) + moved_to.gap[1]
    if chain.description.tool is not None:
        tool, place = chain.tool(at, v), one.tool(right, s.speed)
        reach = size.length * one._k.reach + float(np.linalg.norm(size.offset))
        found["tool point"] = off(tool.position, size.place(place.position), reach)
        found["jacobian"] = off(size.rotation.T @ tool.jacobian / (size.length / units) * own, place.jacobian * own)
        found["tool drift"] = off(size.rotation.T @ tool.drift * size.time**2 / size.length, place.drift, one.length)
        target = chain.tool(moved_to).pose
        back = chain.tool(reached := chain.reach(target, at)).pose
        found["reach"] = off(back.position, target.position, reach)
        found["reach turn"] = off(back.rotation, target.rotation, reach / size.length)
        if not idle:
            found["reach back"] = apart(reached, there) * size.length / reach
    return found


@cache
def rounding(name: str) -> dict[str, float]:
    """The errors of the robot merely turned."""
    rng = np.random.default_rng(5)
    found = [errors(name, Size(rotation=random_rotation(rng))) for _ in range(2)]
    return {key: max(one[key] for one in found) for key in found[0]}


def check(name: str, size: Size) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = errors(name, size)
    usual = rounding(name)
    bad = {k: (v, usual[k]) for k, v in found.items() if not v <= FACTOR * max(usual[k], EPS)}
    assert not bad, bad


TURNED = random_rotation(np.random.default_rng(8))
FAR = 1e4 * np.array([0.6, -0.64, 0.48])
SIZES = {
    "tiny and light": Size(1e-4, 1e-6, rotation=TURNED),
    "tiny and heavy": Size(1e-4, 1e6),
    "huge and light": Size(1e4, 1e-6),
    "huge and heavy": Size(1e4, 1e6, rotation=TURNED),
    "on the moon": Size(gravity=0.165),
    "in a centrifuge": Size(gravity=50.0, rotation=TURNED),
    "far": Size(offset=FAR),
    "far and turned": Size(offset=-FAR, rotation=TURNED),
}


@pytest.mark.parametrize("which", SIZES)
@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_is_the_same_at_every_size_mass_and_place(name: str, which: str) -> None:
    check(name, SIZES[which])


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_is_the_same_in_every_orientation_and_size(name: str) -> None:
    """Twenty orientations, each at another size, mass, gravity and place."""
    rng = np.random.default_rng(9)
    for _ in range(20):
        length, mass, gravity = 10.0 ** rng.uniform(-4, 4), 10.0 ** rng.uniform(-6, 6), 10.0 ** rng.uniform(-2, 2)
        # no further off than 1e7 lengths: the place of a link in the world is rounded to the distance from there
        offset = min(1e4, 1e7 * length) * random_rotation(rng)[0] * rng.integers(2)
        check(name, Size(length, mass, gravity, random_rotation(rng), offset))


@pytest.mark.parametrize("name", ROBOTS)
def test_without_gravity_nothing_weighs(name: str) -> None:
    robot, at = Size(gravity=0.0).of(description(name)), None
    chain, sample = ClosedChain(robot), samples(name)[0]
    at = chain.posture(sample.q)
    assert chain.potential_energy(at) == 0.0
    still = np.zeros(chain.nv)
    assert not chain.full_forward_dynamics(at, still, still).acceleration.any()
    if chain.mobility().determined:
        terms, wanted = chain.terms(at, sample.speed), plain(name).terms(at, sample.speed)
        assert not terms.gravity.any()
        assert off(terms.mass, wanted.mass) < 1e-14
        assert (
            off(terms.coriolis, wanted.coriolis, max(np.abs(wanted.gravity).max(), np.abs(wanted.coriolis).max()))
            < 1e-14
        )


@pytest.mark.parametrize("distance", [1e2, 1e4, 1e6, 1e7, 1e8, 1e10])
@pytest.mark.parametrize("name", ["floating_fourbar", "hexapod"])
def test_a_floating_base_far_away_is_right_to_the_rounding_of_its_place(name: str, distance: float) -> None:
    """Its place is a coordinate, so a body there is rounded to 1e-16 of the distance; beyond what that leaves there is
    an error and never a wrong number."""
    plan = MECHANISMS[name](np.random.default_rng(2)).plan
    near = ClosedChain(drawn(plan))
    shift = distance * np.array([0.6, -0.64, 0.48])
    robot = near.description
    start = np.array(robot.homes[0].passive["flight"])
    start[:3] += robot.joint("flight").placement[:3, :3].T @ shift
    home = Home("far", robot.homes[0].actuated, {**robot.homes[0].passive, "flight": tuple(start.tolist())})

    def along(frame: Frame) -> Frame:
        place = np.array(frame.placement)
        place[:3, 3] += shift * (frame.link == "base")
        return Frame(frame.link, place)

    cuts = tuple(replace(cut, a=along(cut.a), b=along(cut.b)) for cut in robot.cuts)  # feet stand on the ground there
    allowed = 1e-13 + 50.0 * 2.2e-16 * distance / near.length
    try:
        far = ClosedChain(replace(robot, homes=(home,), cuts=cuts))
        at, report, wanted = far.home, far.mobility(), near.mobility()
        rng = np.random.default_rng(3)
        free = tree_motions(near, np.array(near.home.q_full))
        v, effort = free @ rng.normal(size=free.shape[1]), rng.normal(size=near.nv)
        # the turn of the base lives in its own axes, so the same numbers say the same motion
        motion = far.full_forward_dynamics(at, far.project(at.q_full, v)[1], effort)
    except CutjointError:
        if distance > 1e7:
            return
        raise
    assert (report.rank, report.mobility, report.determined) == (wanted.rank, wanted.mobility, wanted.determined)
    assert at.gap[0] < allowed * near.length
    right = near.full_forward_dynamics(near.home, v, effort)
    assert off(motion.acceleration, right.acceleration) < 10.0 * allowed
    assert off(far.centre_of_mass(at), near.centre_of_mass(near.home) + shift, near.length) < allowed


LOOPED = ("cassie", *catalogue.names())


@pytest.mark.parametrize("name", LOOPED)
def test_projecting_closes_the_loops_of_every_named_robot(name: str) -> None:
    """Also from where they are open by a part in a million of the robot: nothing stops just short of closed."""
    chain, rng = load(name), np.random.default_rng(4)
    for reach in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12):
        for _ in range(5):
            q = chain.integrate(chain.home.q_full, reach * tree_units(chain) * rng.uniform(-1.0, 1.0, chain.nv))
            closed, v = chain.project(q, rng.normal(size=chain.nv))
            gap = chain.gap(closed)
            assert max(gap[0] / chain._k.reach, gap[1]) < 1e-12
            chain.posture(closed)
            rates = chain._k.row_scale * (chain.constraint_jacobian(closed) @ v)
            # a row that is dependent but for 1e-10, as in the feet of cassie, is not met more exactly than that
            assert np.abs(rates).max(initial=0.0) < 1e-10 * np.abs(v / tree_units(chain)).max()


@pytest.mark.parametrize("name", ["fourbar", "fivebar"])
def test_a_tool_on_a_curve_or_in_a_plane_reaches_rounded_points_far_away(name: str) -> None:
    """In the world a point 10 km off is rounded by more than counts as closed, so it lies beside curve and plane."""
    rng = np.random.default_rng(12)
    for _ in range(10):
        size = Size(1e-2, rotation=random_rotation(rng), offset=1e4 * random_rotation(rng)[0])
        chain = ClosedChain(size.of(description(name)))
        there = chain.close(chain.home.q + 0.1 * rng.uniform(-1.0, 1.0, chain.n))
        target = chain.tool(there).position
        found = chain.reach(target)
        assert off(chain.tool(found).position, target, 1e4) < 1e-15
        assert max(found.gap) < 1e-12
        np.testing.assert_allclose(found.q, there.q, rtol=0.0, atol=1e-8)
