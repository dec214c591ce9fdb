"""Numbers of the description as arguments of compiled functions, against chains that are built anew with them."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.blueprint import random_mounting
from kit.held_up import held_up
from kit.mechanisms import MECHANISMS
from kit.quickly import few
from kit.shipped import DETERMINED

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled, simulate_many
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.control import PD
from cutjoint.description import load_description, paths, with_values
from cutjoint.description.model import RobotDescription
from cutjoint.errors import CompileError, CutjointError, InputError, UnknownNameError
from cutjoint.mechanism.rotations import vector_of
from cutjoint.motion import JointSine, Reference
from cutjoint.simulation import ReducedPlant, RungeKutta4
from cutjoint.simulation import run as simulate

JOINTS = ("revolute", "continuous", "prismatic", "universal", "spherical", "planar", "floating")
CUTS = ("fixed", "spherical", "revolute", "universal", "prismatic", "distance")
RODS = tuple(f"cuts.ball{k}a.b.z = cuts.ball{k}b.b.z" for k in (1, 2, 3))
OMEGA3 = (*RODS, *(f"joints.{joint}{k}.origin.xyz" for joint in ("arm", "bar") for k in (1, 2, 3)))
UNFIT = ("floating_fourbar", "hexapod", "parallelogram_flat", "bricard", "upu_3_equal", "ball_rod_delta")
"""Not determined by their motors; singular at home; with freedoms that hang on how all lengths fit each other; with
idle rods, whose inertias are refused as parameters."""
FIVEBAR = ("joints.left_elbow.origin.x", "cuts.tip.b.x", "joints.right_shoulder.origin.z", "links.left_distal.com.y")


def physical(path: str) -> bool:
    """Whether a path is a place, an inertia, gravity or a gear's: what any robot has."""
    part, last = path.split(".")[0], path.rpartition(".")[2]
    places = ("x", "y", "z", "roll", "pitch", "yaw", "length")
    return part in ("links", "couplings", "tool", "gravity") or last in places


def free_paths(chain: ClosedChain, rng: np.random.Generator, count: int, among: Any = physical) -> list[str]:
    """Random paths that the loops leave free, one by one and together."""
    massive = {link.name for link in chain.description.links if link.inertial is not None and link.inertial.mass > 0}
    names = [path for path in paths(chain.description) if among(path)]
    names = [path for path in names if path.split(".")[0] != "links" or path.split(".")[1] in massive]
    inert = [path for path in names if path.startswith(("links.", "gravity."))]
    placed = [path for path in names if path not in inert]
    names = [str(one) for few in (inert, placed) for one in rng.permutation(few)[: 2 * count]]
    stuck = set(ChainSource(chain, names).fixed_by_loops())
    left = [name for name in names if name not in stuck]
    placing = set(ChainSource(chain, left).arguments.placing)
    places, others = [one for one in left if one in placing], [one for one in left if one not in placing]
    half = min(len(places), count // 2)
    return [
        *map(str, rng.choice(places, half, replace=False)),
        *map(str, rng.choice(others, count - half, replace=False)),
    ]


def rebuilt(machine: Any, values: dict[str, float]) -> ClosedChain:
    return machine.chain.rebuilt(machine.source.arguments.rebuilt(values))


def drawn(machine: Any, rng: np.random.Generator) -> dict[str, float]:
    source = machine.source
    return dict(zip(source.parameters, rng.uniform(source.low, source.high).tolist(), strict=True))


def off(found: Any, wanted: Any, floor: float) -> float:
    found, wanted = np.asarray(found), np.asarray(wanted)
    return float(np.abs(found - wanted).max(initial=0.0) / max(np.abs(wanted).max(initial=0.0), floor))


def differences(machine: Any, values: dict[str, float], rng: np.random.Generator) -> dict[str, float]:
    """Everything that a compiled robot says at other values, against the chain built anew; relative."""
    chain, n = rebuilt(machine, values), machine.n
    other = machine.with_parameters(values)
    turning = np.array([one.kind == "rotation" for one in machine.actuators])
    unit = np.where(turning, 1.0, chain.length)
    reach = 0.03
    while True:
        target = other.home.q + reach * unit * rng.uniform(-1, 1, n)
        try:
            there = chain.close(target)
            break
        except CutjointError:
            reach *= 0.5
            assert reach > 1e-3
    at = other.close(target)
    own = chain.posture(at.q_full)  # the same spins of idle freedoms, closed by the chain's own measure
    v, a = unit * rng.normal(size=n), unit * rng.normal(size=n)
    parameters = np.array([values[name] for name in machine.source.parameters])
    terms, wanted = other.terms(at, v), chain.terms(own, v)
    effort = chain.inverse_dynamics(own, v, a)
    load = float(np.abs(unit * effort).max() + np.abs(unit * wanted.gravity).max())
    found = {
        "close": 0.0 if machine.source.idle else off(at.q_full, there.q_full, chain.length),
        "mass": off(unit[:, None] * terms.mass * unit, unit[:, None] * wanted.mass * unit, 0.0),
        "coriolis": off(unit * terms.coriolis, unit * wanted.coriolis, load),
        "gravity": off(unit * terms.gravity, unit * wanted.gravity, load),
        "inverse": off(unit * other.inverse_dynamics(at, v, a), unit * chain.inverse_dynamics(own, v, a), load),
        "forward": off(unit * (wanted.mass @ (other.forward_dynamics(at, v, effort) - a)), 0.0, load),
    }
    functions = ["terms", "inverse", "forward", "step", "residual"]
    if machine.chain.description.tool is not None:
        tool, known = other.tool(at, v), chain.tool(own, v)
        for part in ("position", "rotation", "frame_jacobian", "frame_drift"):
            found[part] = off(getattr(tool, part), getattr(known, part), chain.length)
        functions.append("tool")
    for name in functions:
        given = {"q": at.q_full, "v": v, "a": a, "effort": effort, "target": target, "parameters": parameters}
        function = machine.library()[name]
        assert function(*(given[one] for one in function.row.arguments)) is not None, "the compiled code must answer"
    return found


def check(chain: ClosedChain, names: list[str], rng: np.random.Generator, samples: int) -> None:
    machine, worst = compiled(chain, parameters=names, cached=False), dict[str, float]()
    for _ in range(samples):
        for what, size in differences(machine, drawn(machine, rng), rng).items():
            worst[what] = max(worst.get(what, 0.0), size)
    assert max(worst.values()) < 1e-10, worst


@pytest.mark.parametrize("name", few(DETERMINED, "fourbar"))
def test_any_number_is_an_argument(name: str) -> None:
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(1)
    check(chain, free_paths(chain, rng, 8), rng, 2)


@pytest.mark.parametrize("name", few(DETERMINED, "fivebar"))
def test_any_number_of_a_robot_that_is_held_up(name: str) -> None:
    """Masses and centres that are arguments, and the direction of gravity, change what is compensated; payloads not."""
    rng = np.random.default_rng(4)
    robot = held_up(load_description(name), rng)
    chain = ClosedChain(robot)
    names = free_paths(chain, rng, 6)
    short = [one.name for one in robot.links if one.held_up and not any(f"links.{one.name}." in at for at in names)]
    check(chain, [*names, *short[:1]], rng, 2)
    if robot.tool is not None:
        tool = robot.tool.link
        links = (replace(one, gravity_compensation=1.0) if one.name == tool else one for one in robot.links)
        check(ClosedChain(replace(robot, links=tuple(links))), ["payload", *short[:1]], rng, 2)


PHYSICS = ("damping", "friction", "friction_speed", "stiffness", "rest", "rotor", "gear")


@pytest.mark.parametrize("name", few(DETERMINED, "fourbar"))
def test_what_joints_do_by_themselves(name: str) -> None:
    """Of a robot without any of it, each coefficient an argument, and then all of them at once."""
    robot, rng = load_description(name), np.random.default_rng(9)
    single = [joint.name for joint in robot.joints if joint.type.single]
    names = [f"joints.{joint}.{one}" for joint in rng.permutation(single)[:2] for one in PHYSICS]
    names += [f"cuts.{cut.name}.damping" for cut in robot.cuts[:1] if cut.type != "fixed"]
    chain = ClosedChain(robot)
    machine = compiled(chain, parameters=names, cached=False)
    plain = compiled(chain, cached=False)
    values = {one: float(rng.uniform(0.5, 1.5)) for one in names}
    assert max(differences(machine, values, rng).values()) < 1e-10
    at, v, a = chain.home, rng.normal(size=chain.n), rng.normal(size=chain.n)
    bare = plain.inverse_dynamics(at, v, a)
    zero = {one: 0.0 for one in names if not one.endswith(("speed", "gear"))}
    assert off(machine.with_parameters(zero).inverse_dynamics(at, v, a), bare, 1.0) < 1e-12
    for one in names:
        alone = {**zero, one: values[one]}
        if one.endswith("friction_speed"):
            alone[one.replace("friction_speed", "friction")] = 1.0
        if one.endswith(".stiffness"):
            alone[one.replace("stiffness", "rest")] = 1.0  # a joint may stand where its spring is at rest
        if one.endswith("rest"):
            alone[one.replace("rest", "stiffness")] = 1.0
        if one.endswith("gear"):
            alone[one.replace("gear", "rotor")] = 1.0
        changed = machine.with_parameters(alone)
        assert not np.allclose(changed.inverse_dynamics(at, v, a), bare, rtol=1e-9), f"{one} does nothing"
        wanted = changed.plain.inverse_dynamics(changed.plain.close(at.q), v, a)
        assert off(changed.inverse_dynamics(at, v, a), wanted, 1.0) < 1e-10, one


@pytest.mark.slow
@pytest.mark.parametrize("name", DETERMINED)
def test_a_hundred_samples_of_every_robot(name: str) -> None:
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(2)
    for _ in range(2):
        check(chain, free_paths(chain, rng, 14), rng, 50)


def test_what_is_handed_inwards_and_what_is_not() -> None:
    """A link whose inertia varies, its centre off the plane too, and one that is regrouped as far as its joint is."""
    robot = load_description("fivebar")
    names = ["joints.right_elbow.origin.x", "links.left_distal.mass", "links.left_distal.com"]
    names += ["links.left_distal.inertia", "links.left_proximal.com", "left_proximal", "payload"]
    names.remove("payload" if robot.tool is None else "left_proximal")
    ranges = {"links.left_distal.com.y": (0.02, 0.1), "links.left_distal.com.z": (0.02, 0.1)}
    chain, rng = ClosedChain(robot), np.random.default_rng(11)
    machine = compiled(chain, parameters=names, ranges=ranges, cached=False)
    for _ in range(3):
        assert max(differences(machine, drawn(machine, rng), rng).values()) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", [name for name in MECHANISMS if name not in UNFIT])
def test_random_mechanisms_anywhere(name: str, seed: int, tmp_path: Any) -> None:
    rng = np.random.default_rng(seed)
    MECHANISMS[name](rng).plan.write(tmp_path, random_mounting(rng))
    chain = ClosedChain(load_description(tmp_path))
    check(chain, free_paths(chain, rng, 10), rng, 5)


@pytest.mark.parametrize("kind", [*few(CUTS, "spherical"), *few(JOINTS, "planar")])
def test_every_cut_and_every_joint(kit: Any, kind: str) -> None:
    """In full coordinates: what one actuator cannot determine."""
    for made in (kit.two_bodies, kit.limb_and_body):
        if kind not in (CUTS if made is kit.two_bodies else JOINTS):
            continue
        chain, rng = ClosedChain(made(kind)), np.random.default_rng(3)
        machine = compiled(chain, parameters=free_paths(chain, rng, 10), cached=False)
        source = machine.source
        for row in source.wide_cloud[-4:]:
            q, values = row[: chain.nq], row[chain.nq :]
            other = rebuilt(machine, dict(zip(source.parameters, values.tolist(), strict=True)))
            other.posture(q)
            v, effort = kit.allowed_velocity(other, q, rng), rng.normal(size=chain.nv)
            y = machine.kernel("full_forward")(q, v, effort, values)
            assert y[-1] <= STRAIN_LIMIT
            wanted = other.full_acceleration(q, v, effort)
            assert off(y[:-1], wanted, 1.0) < 1e-9


def small(robot: RobotDescription, size: float) -> RobotDescription:
    """The robot so many times as large: lengths, and inertias with their squares; angles stay."""
    lengths = {}
    for path in paths(robot):
        head, last = path.split(".")[0], path.rpartition(".")[2]
        if head != "gravity" and last in ("x", "y", "z"):
            lengths[path] = size
        elif last in ("xx", "yy", "zz", "xy", "xz", "yz"):
            lengths[path] = size**2
    from cutjoint.description import value

    return with_values(robot, {path: factor * value(robot, path) for path, factor in lengths.items()})


@pytest.mark.parametrize("size", few((1e-3, 1e-1, 1e3), 1e-3))
def test_sizes(size: float) -> None:
    chain = ClosedChain(small(load_description("fivebar"), size))
    check(chain, [*FIVEBAR, "links.left_proximal.mass", "gravity.y"], np.random.default_rng(4), 4)


# -- ranges ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", few(("fivebar", "omega3"), "fivebar"))
def test_a_range_is_covered(name: str) -> None:
    """Lengths from half to one and a half times: the compiled code answers on the whole range, and is right."""
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(5)
    names = ("joints.left_elbow.origin.x", "joints.right_elbow.origin.x") if name == "fivebar" else RODS
    nominal = ChainSource(chain, names).nominal
    ranges = {one: (0.75 * x, 1.25 * x) for one, x in zip(names, nominal, strict=True)}
    machine = compiled(chain, parameters=names, ranges=ranges, cached=False)
    np.testing.assert_allclose([machine.source.low, machine.source.high], [0.75 * nominal, 1.25 * nominal])
    for _ in range(8):
        assert max(differences(machine, drawn(machine, rng), rng).values()) < 1e-10


def test_ranges_that_are_none() -> None:
    chain = ClosedChain(load_description("fivebar"))
    name = FIVEBAR[0]
    for bad, words in (((0.3, 0.2), "upside down"), ((0.1,), "numbers, numbers"), ((0.1, np.inf), "finite")):
        with pytest.raises(InputError, match=words):
            compiled(chain, parameters=[name], ranges={name: bad})  # type: ignore[dict-item]
    with pytest.raises(UnknownNameError):
        compiled(chain, parameters=[name], ranges={"payload": (0.0, 1.0)})


def test_what_the_loops_fix_is_named() -> None:
    """A planar robot whose elbow leaves the plane cannot be closed."""
    machine = compiled(ClosedChain(load_description("fivebar")), parameters=[FIVEBAR[0], "joints.left_elbow.origin.z"])
    with pytest.raises(CompileError, match=r"whole range of joints\.left_elbow\.origin\.z alone.*PATH = PATH"):
        machine.kernel("tool")


# -- names -----------------------------------------------------------------------------------------------------------


def test_names_and_values() -> None:
    chain = ClosedChain(load_description("omega3"))
    machine = compiled(chain, parameters=["joints.arm1.origin.xyz", "rod1a_link", RODS[0], "payload"])
    assert list(machine.parameters) == [
        *(f"joints.arm1.origin.{axis}" for axis in "xyz"), "rod1a_link", RODS[0], "payload",
    ]  # fmt: skip
    place = np.array([0.001, 0.034, 0.074])
    other = machine.with_parameters(
        {"joints.arm1.origin.xyz": place, "cuts.ball1a.b.z=cuts.ball1b.b.z": 0.147}, payload=0.1
    )
    np.testing.assert_array_equal([other.parameters[f"joints.arm1.origin.{axis}"] for axis in "xyz"], place)
    assert (other.parameters[RODS[0]], other.parameters["payload"]) == (0.147, 0.1)
    np.testing.assert_array_equal(other.plain.description.joint("arm1").placement[:3, 3], place)
    assert pickle.loads(pickle.dumps(other)).parameters == other.parameters
    with pytest.raises(UnknownNameError, match=r"did you mean 'joints\.arm1\.origin\.x'"):
        machine.with_parameters({"joints.arm1.orign.x": 0.0})
    for bad in ({"rod1a_link": -1.0}, {"payload": np.nan}, {"joints.arm1.origin.xyz": 1.0}, {RODS[0]: [1.0, 2.0]}):
        with pytest.raises(InputError):
            machine.with_parameters(bad)
    for names, words in (
        (["rod1a_link", "links.rod1a_link.mass"], "given twice"),
        (["tool.x", "tool.xyz"], "given twice"),
        (["tool.x", "tool.x = tool.y"], "given twice"),
        (["tool.xyz = tool.x"], "not as many numbers"),
        (["cuts.ball1a.a.y = cuts.ball1b.a.y"], "not one number"),
    ):
        with pytest.raises(InputError, match=words):
            compiled(chain, parameters=names)
    with pytest.raises(UnknownNameError, match=r"did you mean 'links\.rod1a_link\.mass'"):
        compiled(chain, parameters=["links.rod1a_lnk.mass"])


# -- postures --------------------------------------------------------------------------------------------------------


def test_a_posture_of_other_lengths_is_refused() -> None:
    machine = compiled(ClosedChain(load_description("fivebar")), parameters=FIVEBAR)
    longer = machine.with_parameters({FIVEBAR[0]: machine.parameters[FIVEBAR[0]] + 0.01})
    at, zero = machine.home, np.zeros(2)
    assert max(longer.home.gap) < 1e-12
    np.testing.assert_allclose(longer.home.q, at.q, rtol=0, atol=1e-12)
    for call in (
        lambda: longer.tool(at),
        lambda: longer.terms(at),
        lambda: longer.forward_dynamics(at, zero, zero),
        lambda: longer.tool_by_parameters(at),
        lambda: machine.tool(longer.home),
        lambda: machine.batch.tool(at.q_full[None], parameters={FIVEBAR[0]: longer.parameters[FIVEBAR[0]]}),
        lambda: longer.batch.tool(at.q_full[None]),
    ):
        with pytest.raises(InputError, match="open by"):
            call()
    # a posture is where closing may start, whatever lengths it has
    assert max(longer.close(at.q, at).gap) < 1e-12


@pytest.mark.parametrize("name", few(("fivebar", "omega3", "cpm"), "fivebar"))
def test_a_batch_is_the_same_as_chains_built_anew(name: str) -> None:
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(6)
    names = OMEGA3 if name == "omega3" else tuple(free_paths(chain, rng, 6))
    machine = compiled(chain, parameters=names)
    count = 12
    given = {
        one: rng.uniform(low, high, count)
        for one, low, high in zip(machine.source.parameters, machine.source.low, machine.source.high, strict=True)
    }
    q = machine.home.q + 0.02 * chain.length * rng.uniform(-1, 1, (count, chain.n))
    v, a = rng.normal(size=(2, count, chain.n))
    closed = machine.batch.close(q, given)
    tools, effort = machine.batch.tool(closed, v, given), machine.batch.inverse_dynamics(q, v, a, given)
    np.testing.assert_allclose(machine.batch.forward_dynamics(closed, v, effort, given), a, rtol=0, atol=1e-9)
    one_row = machine.batch.tool(machine.home.q, parameters=given).position
    reached = machine.batch.reach(tools.position, given) if name != "fivebar" else closed
    np.testing.assert_allclose(reached, closed, rtol=0, atol=1e-9)
    for k in (0, 5, 11):
        values = {one: float(x[k]) for one, x in given.items()}
        other, anew = machine.with_parameters(values), rebuilt(machine, values)
        at = anew.close(q[k])
        np.testing.assert_allclose(closed[k], at.q_full, rtol=0, atol=1e-11)
        np.testing.assert_allclose(tools.position[k], anew.tool(at, v[k]).position, rtol=0, atol=1e-11)
        np.testing.assert_allclose(tools.twist[k], anew.tool(at, v[k]).twist, rtol=0, atol=1e-11)
        assert off(effort[k], anew.inverse_dynamics(at, v[k], a[k]), 1.0) < 1e-10
        np.testing.assert_allclose(one_row[k], anew.tool(anew.close(machine.home.q)).position, rtol=0, atol=1e-11)
        own = other.batch.close(q[k : k + 1])
        np.testing.assert_allclose(own[0], closed[k], rtol=0, atol=1e-12)
        if name != "fivebar":
            place = tools.position[k]
            np.testing.assert_allclose(other.reach(place).q, anew.reach(place).q, rtol=0, atol=1e-9)
    with pytest.raises(InputError, match=f"one number or {count} of them"):
        machine.batch.close(q, {next(iter(given)): np.zeros(3)})
    with pytest.raises(InputError, match="not an argument"):
        machine.batch.close(q, {"payloads": 0.0})


def test_rows_that_leave_the_short_ways_are_done_by_the_chain() -> None:
    """A rod of twice its length and one that cannot reach: the chain's posture, or its error with the row."""
    machine = compiled(ClosedChain(load_description("fivebar")), parameters=FIVEBAR[:1])
    name, x = FIVEBAR[0], machine.parameters[FIVEBAR[0]]
    lengths = x * np.array([1.0, 1.3, 1.6])
    closed = machine.batch.close(machine.home.q, {name: lengths})
    for q, length in zip(closed, lengths, strict=True):
        anew = rebuilt(machine, {name: float(length)})
        np.testing.assert_allclose(q, anew.close(machine.home.q).q_full, rtol=0, atol=1e-10)
    with pytest.raises(CutjointError) as caught:
        machine.batch.close(machine.home.q, {name: x * np.array([1.0, 40.0])})
    assert any("row 1" in note for note in caught.value.__notes__)


# -- derivatives -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", few(("fivebar", "omega3", "stewart", "cpm", "fourbar"), "fourbar"))
def test_derivatives_against_differences(name: str) -> None:
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(7)
    machine = compiled(chain, parameters=free_paths(chain, rng, 10), cached=False)
    values = drawn(machine, rng)
    other = machine.with_parameters(values)
    at = other.close(other.home.q + 0.02 * chain.length * rng.uniform(-1, 1, chain.n))
    v, a = rng.normal(size=(2, chain.n))
    tool, effort = other.tool_by_parameters(at), other.inverse_by_parameters(at, v, a)
    units = machine.source.arguments.units(machine.source.scale)
    for k, (one, unit) in enumerate(zip(machine.source.parameters, units, strict=True)):
        step = 3e-5 * unit
        ends = [rebuilt(machine, {**values, one: values[one] + sign * step}) for sign in (1.0, -1.0)]
        there = [end.assemble(at) for end in ends]
        (far, near), efforts = (
            [end.tool(x) for end, x in zip(ends, there, strict=True)],
            [end.inverse_dynamics(x, v, a) for end, x in zip(ends, there, strict=True)],
        )
        moved = np.concatenate([far.position - near.position, vector_of(far.rotation @ near.rotation.T)]) / (2 * step)
        assert off(unit * tool[:, k], unit * moved, np.abs(units * tool).max()) < 1e-6, one
        changed = (efforts[0] - efforts[1]) / (2 * step)
        assert off(unit * effort[:, k], unit * changed, np.abs(effort).max(axis=0) @ units) < 1e-6, one


def test_derivatives_by_the_implicit_function_theorem() -> None:
    """The joints' motion that keeps the loops closed comes from the chain's own Jacobian; the tool goes with it."""
    chain, names = ClosedChain(load_description("fivebar")), FIVEBAR[:3]
    machine = compiled(chain, parameters=names)
    at, step, zero = chain.home, 1e-6, np.zeros(2)
    passive = [k for k in range(chain.nv) if k not in machine.source.actuated_rates]
    jacobian, nominal = chain.constraint_jacobian(at)[:, passive], np.array(machine.source.nominal)
    residual, place = machine.kernel("residual"), machine.kernel("tool")
    found = machine.tool_by_parameters(at)
    for k in range(len(names)):
        change = step * np.eye(len(names))[k]
        opening = residual(at.q_full, nominal + change)[:-1] - residual(at.q_full, nominal - change)[:-1]
        motion = np.zeros(chain.nv)
        motion[passive] = np.linalg.lstsq(jacobian, -opening / 2, rcond=1e-9)[0]
        ends = [place(at.q_full + sign * motion, zero, nominal + sign * change)[:3] for sign in (1.0, -1.0)]
        np.testing.assert_allclose(found[:3, k], (ends[0] - ends[1]) / (2 * step), rtol=0, atol=1e-8)


def test_a_robot_without_parameters_has_no_derivatives_in_them(kit: Any) -> None:
    with pytest.raises(InputError, match="no number of fivebar is an argument"):
        kit.machine("fivebar").tool_by_parameters(kit.model("fivebar").home)


# -- many runs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", few(("omega3", "fivebar"), "fivebar"))
def test_runs_of_robots_with_other_lengths(name: str) -> None:
    """Each run is that of a chain built anew with its lengths."""
    chain = ClosedChain(load_description(name))
    own = [*RODS, "links.platform_link.mass"] if name == "omega3" else [*FIVEBAR, "links.left_distal.mass"]
    machine = compiled(chain, parameters=own)
    reference = Reference(JointSine.from_home(chain, 0.02, 2.0), chain, 0.05)
    rng = np.random.default_rng(8)
    given = {name: x * rng.uniform(0.99, 1.01, 6) for name, x in machine.parameters.items()}
    runs = simulate_many(machine, PD(kp=8.0, kd=0.4), reference, parameters=given, step=2e-3, every=0.01)
    assert not runs.failed
    assert not runs.slow
    for k in (0, 5):
        anew = rebuilt(machine, {name: float(x[k]) for name, x in given.items()})
        start = anew.close(runs.q[k, 0])
        one = simulate(
            ReducedPlant(anew), PD(kp=8.0, kd=0.4), reference, integrator=RungeKutta4(2e-3), duration=0.05, start=start
        )
        np.testing.assert_allclose(runs.q[k, -1], one.q[-1], rtol=0, atol=1e-10)
        np.testing.assert_allclose(runs.positions[k, -1], one.q_full[-1], rtol=0, atol=1e-9)
