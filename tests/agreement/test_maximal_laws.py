"""The maximal-coordinate oracle by its own laws, and against the closed forms beside it: can the judge be trusted?"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import Blueprint, random_mounting
from kit.built import at_home
from kit.mechanisms import MECHANISMS
from oracles.connections import turn
from oracles.fivebar import FiveBar
from oracles.fourbar import FourBar
from oracles.maximal import Maximal
from oracles.reactions import Reactions
from oracles.reading import rpy_rotation
from oracles.stewart import Motion, Stewart
from oracles.tree import URDF

Array = np.ndarray


def near(found: Any, wanted: Any, tolerance: float = 1e-10) -> None:
    size = max(float(np.abs(wanted).max()), 1.0)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance * size)


def values(oracle: Maximal, flat: Array) -> dict[str, Array]:
    return {name: flat[own] for name, own in oracle.velocity.items()}


def advanced(oracle: Maximal, coordinates: dict[str, Any], change: dict[str, Array]) -> dict[str, Any]:
    """Coordinates after a motion of all joints, to second order where they turn about changing axes."""
    moved = {}
    for joint in oracle.robot.joints:
        step, old = change[joint.name], coordinates.get(joint.name)
        if joint.kind == "fixed":
            continue
        if joint.kind == "spherical":
            moved[joint.name] = old @ _turned(step)
        elif joint.kind == "floating":
            moved[joint.name] = np.eye(4)
            moved[joint.name][:3, :3] = old[:3, :3] @ _turned(step[3:])
            # along axes that turn meanwhile: half of the turn is the mean direction
            moved[joint.name][:3, 3] = old[:3, 3] + old[:3, :3] @ _turned(0.5 * step[3:]) @ step[:3]
        elif joint.kind == "planar":
            half = old[2] + 0.5 * step[2]
            along = np.array([[np.cos(half), -np.sin(half)], [np.sin(half), np.cos(half)]]) @ step[:2]
            moved[joint.name] = np.r_[old[:2] + along, old[2] + step[2]]
        else:
            moved[joint.name] = old + (step if joint.kind == "universal" else float(step[0]))
    return moved


def _turned(step: Array) -> Array:
    angle = float(np.linalg.norm(step))
    return turn(step / angle, angle) if angle else np.eye(3)


MANY_JOINTS = """<robot name="tree"><link name="base"/>
{links}
{joints}
</robot>"""


def write_tree(folder: Path, seed: int) -> Path:
    """One joint of every type in a row, in the air; massive links that fixed joints carry among them."""
    rng = np.random.default_rng(seed)
    kinds = ["floating", "revolute", "fixed", "prismatic", "floating", "continuous", "planar", "floating", "fixed"]
    links, joints = [], []
    for index, kind in enumerate(kinds):
        points = rng.normal(size=(8, 3)) * 0.2
        inertia = sum((p @ p) * np.eye(3) - np.outer(p, p) for p in points) * 0.3
        moments = dict(zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), inertia[np.triu_indices(3)], strict=True))
        text = " ".join(f'{key}="{value!r}"' for key, value in ((k, float(v)) for k, v in moments.items()))
        origin = '<origin xyz="{} {} {}" rpy="{} {} {}"/>'
        links.append(
            f'<link name="l{index}"><inertial>{origin.format(*rng.normal(size=6) * 0.3)}'
            f'<mass value="{rng.uniform(0.5, 2)}"/><inertia {text}/></inertial></link>'
        )
        parent = f"l{index - 1}" if index else "base"
        joints.append(
            f'<joint name="j{index}" type="{kind}"><parent link="{parent}"/><child link="l{index}"/>'
            f'{origin.format(*rng.normal(size=6) * 0.5)}<axis xyz="{" ".join(map(str, rng.normal(size=3)))}"/></joint>'
        )
    (folder / "tree.urdf").write_text(MANY_JOINTS.format(links="\n".join(links), joints="\n".join(joints)))
    (folder / "loops.toml").write_text(
        'schema = 1\nurdf = "tree.urdf"\nactuators = ["j1", "j5"]\ngravity = [1.0, -2.0, 4.0]\n'
        '[joint.j4]\ntype = "spherical"\n'
        '[joint.j7]\ntype = "universal"\naxis = [0.0, 0.6, 0.8]\naxis2 = [1.0, 0.0, 0.0]\n'
        '[[coupling]]\nname = "gear"\njoint = "j5"\ndriver = "j1"\nratio = -1.7\noffset = 0.2\n'
    )
    return folder


def tree_state(rng: np.random.Generator) -> dict[str, Any]:
    floating = np.eye(4)
    floating[:3, :3], floating[:3, 3] = rpy_rotation(rng.normal(size=3)), rng.normal(size=3)
    first = float(rng.normal())
    return {
        "j0": floating,
        "j1": first,
        "j3": float(rng.normal()),
        "j4": rpy_rotation(rng.normal(size=3)),
        "j5": -1.7 * first + 0.2,
        "j6": rng.normal(size=3),
        "j7": rng.normal(size=2),
    }


@pytest.mark.parametrize("seed", range(4))
def test_every_joint_moves_as_its_velocities_say(seed: int, tmp_path: Path) -> None:
    """Twists of all bodies, joint velocities and constraints by central differences of the poses."""
    oracle, rng = Maximal(write_tree(tmp_path, seed)), np.random.default_rng(seed)
    at, rates, h = tree_state(rng), rng.normal(size=oracle.velocities), 1e-5
    state = oracle.at(at).moving(values(oracle, rates))
    before, after = (oracle.at(advanced(oracle, at, values(oracle, sign * h * rates))) for sign in (-1, 1))
    for link in oracle.column:
        v, w = state.twist(link)
        near((after.poses[link].position - before.poses[link].position) / (2 * h), v, 1e-8)
        turning = (after.poses[link].rotation - before.poses[link].rotation) / (2 * h)
        turning = turning @ state.placed.poses[link].rotation.T
        near(np.array([turning[2, 1], turning[0, 2], turning[1, 0]]), w, 1e-8)
    near(state.placed.speeds @ state.twists, rates, 1e-12)
    near(state.placed.tree_rows @ state.twists, np.zeros(len(state.placed.tree_rows)), 1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_drifts_by_differences(seed: int, tmp_path: Path) -> None:
    """Joint accelerations and the constraints' drift: how rows on relative twists change along a motion."""
    oracle, rng = Maximal(write_tree(tmp_path, seed)), np.random.default_rng(seed)
    at, rates, changes = tree_state(rng), *rng.normal(size=(2, oracle.velocities))
    state, h = oracle.at(at).moving(values(oracle, rates)), 1e-5

    def there(time: float) -> Any:
        step = time * rates + 0.5 * time**2 * changes
        return oracle.at(advanced(oracle, at, values(oracle, step))).moving(values(oracle, rates + time * changes))

    before, after = there(-h), there(h)
    twist_rates = (after.twists - before.twists) / (2 * h)
    near(twist_rates, state._tree_start + state.placed.tree @ changes, 2e-8)
    near(state.placed.speeds @ twist_rates + state.joint_drift, changes, 2e-8)
    rows = np.concatenate([state.placed.tree_rows, state.placed.loop_rows])
    by_hand = [(p.placed.tree_rows @ p.twists, p.placed.loop_rows @ p.twists) for p in (before, after)]
    by_hand = (np.r_[by_hand[1]] - np.r_[by_hand[0]]) / (2 * h)
    size = 1.0 + float(np.abs(twist_rates).max())
    np.testing.assert_allclose(rows @ twist_rates + state.constraint_drift, by_hand, rtol=0.0, atol=1e-8 * size)


@pytest.mark.parametrize("seed", range(6))
def test_energy_rate_is_power_and_gravity_turns_the_momentum(seed: int, tmp_path: Path) -> None:
    """A whole tree in the air with a gear: d(T + V)/dt = power, momentum changes by weight alone."""
    oracle, rng = Maximal(write_tree(tmp_path, seed)), np.random.default_rng(seed)
    placed, at = None, tree_state(rng)
    placed = oracle.at(at)
    rates = placed.joint_motions() @ rng.normal(size=placed.mobility)
    assert placed.mobility == oracle.velocities - 1
    near(rates[oracle.velocity["j5"]], -1.7 * rates[oracle.velocity["j1"]], 1e-12)
    state = placed.moving(values(oracle, rates))
    efforts = 4.0 * rng.normal(size=oracle.velocities)
    efforts[oracle.velocity["j0"]] = 0.0
    motion = state.driven(values(oracle, efforts))
    h = 2e-5

    def energy(time: float) -> tuple[float, Array, Array]:
        step = values(oracle, time * rates + 0.5 * time**2 * motion.flat)
        there = oracle.at(advanced(oracle, at, step)).moving(values(oracle, rates + time * motion.flat))
        return there.kinetic_energy + there.placed.potential_energy, *there.momentum()

    (e1, p1, l1), (e0, p0, l0) = energy(h), energy(-h)
    assert (e1 - e0) / (2 * h) == pytest.approx(float(efforts @ rates), rel=2e-7, abs=1e-6)
    links = [link for link in oracle.column if oracle.robot.bodies[link].mass]
    weights = [oracle.robot.bodies[link].mass * oracle.robot.gravity for link in links]
    near((p1 - p0) / (2 * h), sum(weights), 1e-7)
    arms = [placed.poses[link].position + placed.centre(link) for link in links]
    near((l1 - l0) / (2 * h), sum(np.cross(a, w) for a, w in zip(arms, weights, strict=True)), 1e-7)
    force, moment = Reactions(motion).of["j0"]
    near(np.r_[force, moment], np.zeros(6), 1e-10)
    assert max(motion.unmet) < 1e-11


def test_a_simulated_crank_keeps_its_books() -> None:
    """0.08 s of the shipped four-bar by Runge-Kutta 4: the loop stays closed and energy grows by the motor's work."""
    oracle, crank = Maximal(URDF / "fourbar", length=0.2), FourBar()
    start = {name: value[0] for name, value in crank.joints(2.0, 0.0, 0.0).items()}

    def rate(y: Array) -> Array:
        names = [joint.name for joint in oracle.robot.joints if joint.kind != "fixed"]
        q, v = dict(zip(names, y[:3], strict=True)), y[3:6]
        state = oracle.at(q).moving(dict(zip(names, v, strict=True)))
        return np.r_[v, state.driven({"crank": 0.5}).flat, 0.5 * v[names.index("crank")]]

    names = [joint.name for joint in oracle.robot.joints if joint.kind != "fixed"]
    y, dt = np.r_[[start[name] for name in names], np.zeros(4)], 2e-3
    first = oracle.at(dict(zip(names, y[:3], strict=True))).potential_energy
    for _ in range(40):
        k1 = rate(y)
        k2 = rate(y + 0.5 * dt * k1)
        k3 = rate(y + 0.5 * dt * k2)
        y = y + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(y + dt * k3))
    end = oracle.at(dict(zip(names, y[:3], strict=True))).moving(dict(zip(names, y[3:6], strict=True)))
    assert max(map(max, end.placed.gaps.values())) < 1e-8
    assert abs(y[names.index("crank")] - start["crank"]) > 0.02, "it moved"
    assert end.kinetic_energy + end.placed.potential_energy - first == pytest.approx(y[6], abs=1e-8)


def test_the_four_bar_in_closed_form() -> None:
    oracle, other, rng = Maximal(URDF / "fourbar", length=0.2), FourBar(), np.random.default_rng(1)
    for q in np.linspace(2.0, 8.2, 20):
        v, a, torque = rng.normal(size=3) * (5.0, 50.0, 2.0)
        joints = other.joints(q, v, a)
        placed = oracle.at({name: value[0] for name, value in joints.items()})
        assert placed.mobility == 1
        assert max(map(max, placed.gaps.values())) < 1e-14
        state = placed.with_actuators({"crank": v})
        for name, (_, rate, _) in joints.items():
            near(state.speeds[name], [rate], 1e-12)
        effort, motion = state.led({"crank": a})
        near([effort["crank"]], [other.inverse_dynamics(q, v, a)])
        for name, (_, _, change) in joints.items():
            near(motion.joints[name], [change], 1e-11)
        near(state.driven({"crank": torque}).joints["crank"], [other.forward_dynamics(q, v, torque)])
        assert placed.potential_energy == pytest.approx(other.potential_energy(q), abs=1e-12)


def test_the_five_bar_in_closed_form() -> None:
    oracle, other, rng = Maximal(URDF / "fivebar", length=0.2), FiveBar(), np.random.default_rng(2)
    home = np.array([2.031206776817089, 0.8572607736387785])
    names = oracle.robot.actuators
    for _ in range(20):
        q = home + rng.uniform(-0.25, 0.25, 2)
        v, a, torque = 5.0 * rng.normal(size=2), 50.0 * rng.normal(size=2), 3.0 * rng.normal(size=2)
        placed = oracle.at({name: value[0] for name, value in other.joints(q, v, a).items()})
        assert placed.mobility == 2
        state = placed.with_actuators(dict(zip(names, v, strict=True)))
        effort, _ = state.led(dict(zip(names, a, strict=True)))
        near([effort[name] for name in names], other.inverse_dynamics(q, v, a))
        motion = state.driven(dict(zip(names, torque, strict=True)))
        near(np.r_[tuple(motion.joints[name] for name in names)], other.forward_dynamics(q, v, torque))


def test_the_stewart_platform_leg_by_leg() -> None:
    oracle, other, rng = Maximal(URDF / "stewart", length=0.3), Stewart(), np.random.default_rng(3)
    for _ in range(8):
        rotation = rpy_rotation(rng.uniform(-0.2, 0.2, 3))
        position = np.array([0.0, 0.0, 0.48]) + rng.uniform(-0.05, 0.05, 3)
        given = Motion(position, rotation, *(scale * rng.normal(size=3) for scale in (0.5, 1.5, 4.0, 10.0)))
        legs = [other.leg(i, given) for i in range(6)]
        floating = np.eye(4)
        floating[:3, :3], floating[:3, 3] = rotation, position
        q: dict[str, Any] = {"platform": floating}
        for i, leg in enumerate(legs, start=1):
            q |= {f"leg{i}_swing": leg.swing[0], f"leg{i}_tilt": leg.tilt[0], f"leg{i}_slide": leg.slide[0]}
        placed = oracle.at(q)
        assert max(map(max, placed.gaps.values())) < 1e-14
        assert placed.mobility == 6
        state = placed.with_actuators({f"leg{i}_slide": leg.slide[1] for i, leg in enumerate(legs, start=1)})
        near(np.r_[state.twist("platform_link")], np.r_[given.velocity, given.spin])
        effort, motion = state.led({f"leg{i}_slide": leg.slide[2] for i, leg in enumerate(legs, start=1)})
        near([effort[f"leg{i}_slide"] for i in range(1, 7)], other.inverse_dynamics(given))
        back = state.driven(effort)
        near(back.accelerations, motion.accelerations)


def test_reactions_hold_what_they_carry() -> None:
    """At rest under gravity: the fixed base of every robot carries its moving weight, whatever the loops press."""
    for name in ("cpm", "omega3", "stewart", "redundant"):
        oracle = Maximal(URDF / name)
        at = {joint.name: _zero(joint.kind) for joint in oracle.robot.joints}
        at |= {key: value for key, value in _home(oracle, name).items() if np.ndim(value) == 0}
        state = oracle.at(at).moving({})
        motion = state.driven({})
        rates = state.placed.mass @ motion.accelerations
        weights = {link: oracle.robot.bodies[link].mass * oracle.robot.gravity for link in oracle.column}
        lost = sum(weights[link] - rates[start : start + 3] for link, start in oracle.column.items())
        grounded = [joint.name for joint in oracle.robot.joints if joint.parent == oracle.robot.root]
        carried = sum(Reactions(motion).of[joint][0] for joint in grounded)
        near(carried, -lost, 1e-9)


def _home(oracle: Maximal, name: str) -> dict[str, Any]:
    import tomllib

    home = tomllib.loads((URDF / name / "loops.toml").read_text(encoding="utf-8"))["home"]["default"]
    return home["actuated"] | home["passive"]


def _zero(kind: str) -> Any:
    several = {"floating": np.eye(4), "spherical": np.eye(3), "universal": np.zeros(2), "planar": np.zeros(3)}
    return several.get(kind, 0.0)


@pytest.mark.parametrize("name", ["spherical_4r", "scotch_yoke", "geared_fivebar", "upu_3", "bricard"])
def test_no_smaller_loop_forces_do_the_work(name: str, tmp_path: Path) -> None:
    """Of all forces of joints and loops that balance the bodies, by least squares in one, the smallest in the loops."""
    rng = np.random.default_rng(5)
    plan = MECHANISMS[name](rng).plan
    oracle = Maximal(plan.write(tmp_path, random_mounting(rng)), length=0.37)
    placed = oracle.at(at_home(plan, oracle))
    state = placed.moving(values(oracle, placed.joint_motions() @ rng.normal(size=placed.mobility)))
    motion = state.driven(values(oracle, rng.normal(size=oracle.velocities)))
    rows = np.concatenate([placed.tree_rows, placed.loop_rows]).T * placed.column_scale[:, None]
    some = np.linalg.lstsq(rows, placed.column_scale * motion.reaction, rcond=1e-10)[0]
    sizes, right = np.linalg.svd(rows)[1:]
    free = right[int(np.sum(sizes > 1e-10)) :].T[len(placed.tree_rows) :]
    loops = some[len(placed.tree_rows) :]
    least = loops - free @ np.linalg.lstsq(free, loops, rcond=1e-10)[0] if free.shape[1] else loops
    found = []
    for cut in oracle.robot.cuts:
        force, moment = motion.wrenches[cut.name]
        found += [*(oracle.length * force), *moment]
    squares = float(np.dot(found, found)) + sum(force**2 for force in motion.couplings.values())
    assert squares == pytest.approx(float(least @ least), rel=1e-10)
    assert max(motion.unmet) < 1e-11


def test_a_gear_by_hand(tmp_path: Path) -> None:
    """Two wheels in the void, right = k left: (I + k^2 J) a = tau + k sigma, and the teeth push with J k a - sigma."""
    rng, k, tau, sigma = np.random.default_rng(6), -1.5, 2.0, -0.7
    plan = Blueprint("gear", rng, gravity=np.zeros(3))
    for name in ("left", "right"):
        plan.joint(name, "continuous", "base", f"{name}_wheel", rng.normal(size=3), rng.normal(size=3))
    loose = Maximal(plan.write(tmp_path / "loose"))
    free = loose.at(at_home(plan, loose)).moving({}).driven({"left": 1.0, "right": 1.0}).joints
    first, second = (1.0 / float(free[name][0]) for name in ("left", "right"))
    plan.couple("teeth", "right", "left", k)
    oracle = Maximal(plan.write(tmp_path / "geared"), length=0.4)
    motion = oracle.at(at_home(plan, oracle)).moving({}).driven({"left": tau, "right": sigma})
    turned = (tau + k * sigma) / (first + k**2 * second)
    near(motion.flat, [turned, k * turned], 1e-12)
    assert motion.couplings["teeth"] == pytest.approx(second * k * turned - sigma, rel=1e-11)
