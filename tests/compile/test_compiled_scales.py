"""A robot built larger, heavier, turned or further away is the same robot: compiled, it agrees as well as at scale 1.

Lengths times s, masses times m, times times t: inertias m s2, gravity s/t2, velocities of slides s/t, and so on.  What
is compared has no unit; the error is against variational principles (`Numbers` in conftest.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, CompiledChain, Options, compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.verify import Checker
from cutjoint.compile.machine.llvm.native import NativeKernel
from cutjoint.control import PD
from cutjoint.description.model import Inertial, Joint, JointType, Limits, Link, RobotDescription
from cutjoint.description.transforms import placement

LENGTHS: Mapping[JointType, tuple[int, ...]] = {
    JointType.PRISMATIC: (0,),
    JointType.FLOATING: (0, 1, 2),
    JointType.PLANAR: (0, 1),
}
"""Which home values of a joint are lengths."""
SIZES = [(1e-4, 1e-6, 1.0), (1e-4, 1e6, 1e-2), (1e4, 1e-6, 1.0), (1e4, 1e6, 1e2), (1.0, 1e-9, 1.0)]
"""The last one has links of micrograms."""


def scaled(description: RobotDescription, s: float = 1.0, m: float = 1.0, t: float = 1.0) -> RobotDescription:
    """The same robot with other units of length, mass and time."""
    types = {joint.name: joint.type for joint in description.joints}

    def place(given: np.ndarray) -> np.ndarray:
        made = np.array(given)
        made[:3, 3] *= s
        return made

    def start(name: str, value: Any) -> Any:
        lengths = LENGTHS.get(types[name], ())
        if np.ndim(value) == 0:
            return value * s if lengths else value
        return tuple(x * s if k in lengths else x for k, x in enumerate(value))

    def unit(name: str) -> float:
        return s if types[name] is JointType.PRISMATIC else 1.0

    def body(given: Inertial | None) -> Inertial | None:
        return None if given is None else Inertial(given.mass * m, given.com * s, given.inertia * (m * s * s))

    cuts = tuple(
        replace(
            cut, a=replace(cut.a, placement=place(cut.a.placement)), b=replace(cut.b, placement=place(cut.b.placement))
        )
        for cut in description.cuts
    )
    couplings = tuple(
        replace(
            one,
            drives=tuple(
                replace(own, curve=own.curve.scaled(1.0 / unit(own.driver), 1.0 / unit(one.joint)))
                for own in one.drives
            ),
            offset=one.offset * unit(one.joint),
        )
        for one in description.couplings
    )
    homes = tuple(
        replace(
            home,
            actuated={name: start(name, value) for name, value in home.actuated.items()},
            passive={name: start(name, value) for name, value in home.passive.items()},
        )
        for home in description.homes
    )
    tool = description.tool
    return replace(
        description,
        links=tuple(
            replace(link, inertial=body(link.inertial), visuals=(), collisions=()) for link in description.links
        ),
        joints=tuple(replace(one, placement=place(one.placement), limits=Limits()) for one in description.joints),
        cuts=cuts,
        couplings=couplings,
        tool=None if tool is None else replace(tool, placement=place(tool.placement)),
        gravity=description.gravity * s / t**2,
        homes=homes,
        variants=(),
    )


def mounted(description: RobotDescription, mount: np.ndarray) -> RobotDescription:
    """The robot with its base moved and gravity turned along."""
    root = description.root
    cuts = []
    for cut in description.cuts:
        a, b = (replace(f, placement=mount @ f.placement) if f.link == root else f for f in (cut.a, cut.b))
        cuts.append(replace(cut, a=a, b=b))
    joints = tuple(
        replace(one, placement=mount @ one.placement) if one.parent == root else one for one in description.joints
    )
    return replace(
        description, joints=joints, cuts=tuple(cuts), gravity=mount[:3, :3] @ description.gravity, variants=()
    )


def dimensionless(kit: Any, machine: Any, units: tuple[float, float, float], count: int) -> tuple[dict[str, Any], Any]:
    """What a robot computes at some states, in its own units, and the errors against the principles."""
    s, m, t = units
    chain = machine.chain
    numbers, rng = kit.numbers(chain), np.random.default_rng(0)
    q_unit = np.array([s if one.kind == "translation" else 1.0 for one in chain.actuators])
    rate, push = q_unit / t, m * s**2 / t**2 / q_unit
    found: dict[str, list[Any]] = {}
    errors: dict[str, float] = {}

    def note(name: str, value: np.ndarray, wanted: np.ndarray, unit: Any) -> None:
        found.setdefault(name, []).append(value / unit)
        size = np.abs(wanted / unit).max()
        errors[name] = max(errors.get(name, 0.0), float(np.abs((value - wanted) / unit).max() / size))

    for _ in range(count):
        here = machine.close(chain.home.q + 0.02 * q_unit * rng.uniform(-1, 1, chain.n))
        q = here.q_full
        v, a = rate * rng.normal(size=chain.n), rate / t * rng.normal(size=chain.n)
        tangent, effort = numbers.tangent(q), numbers.effort(q, v, a)
        weight = tangent.T @ numbers.forces(q, np.zeros(chain.nv), np.zeros(chain.nv))
        assert machine.kernel("forward")(q, v, effort, np.zeros(0))[-1] <= STRAIN_LIMIT
        note("inverse", machine.inverse_dynamics(here, v, a), effort, push)
        note("forward", machine.forward_dynamics(here, v, effort), a, rate / t)
        terms = machine.terms(here, v)
        note("mass", terms.mass, tangent.T @ numbers.mass(q) @ tangent, np.outer(push, 1.0 / rate) * t)
        note("gravity", terms.gravity, weight, push)
        coriolis = effort - tangent.T @ numbers.mass(q) @ tangent @ a - weight
        found.setdefault("coriolis", []).append(terms.coriolis / push)
        errors["coriolis"] = max(
            errors.get("coriolis", 0.0),
            float(np.abs((terms.coriolis - coriolis) / push).max() / np.abs(effort / push).max()),
        )
        found.setdefault("gap", []).append(np.array([here.gap[0] / s + here.gap[1]]))
        found.setdefault("tool", []).append(machine.tool(here, v).drift / (s / t**2))
    return {name: np.array(values) for name, values in found.items()}, errors


def agrees(kit: Any, name: str, sizes: list[tuple[float, float, float]], count: int) -> None:
    description = kit.model(name).description
    plain, usual = dimensionless(kit, compiled(ClosedChain(scaled(description)), cached=False), (1.0, 1.0, 1.0), count)
    for units in sizes:
        machine = compiled(ClosedChain(scaled(description, *units)), cached=False)
        assert machine.source.determined
        found, errors = dimensionless(kit, machine, units, count)
        for what, error in errors.items():
            assert error < 100.0 * max(usual[what], 1e-15), (name, units, what, error, usual[what])
        for what, values in found.items():
            if what == "gap":
                assert values.max() < 100.0 * max(plain[what].max(), 1e-15), (name, units)
            else:
                size = max(np.abs(plain[what]).max(), 1.0 if what == "tool" else 0.0)
                np.testing.assert_allclose(
                    values, plain[what], rtol=0, atol=1e-11 * size, err_msg=f"{name} {units} {what}"
                )


@pytest.mark.parametrize(("name", "units"), [("fourbar", SIZES[0]), ("cpm", SIZES[3]), ("fivebar", SIZES[4])])
def test_a_robot_of_another_size_is_the_same_robot(kit: Any, name: str, units: tuple[float, float, float]) -> None:
    agrees(kit, name, [units], 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourbar", "fivebar", "cpm", "omega3", "stewart"])
def test_every_robot_at_every_size(kit: Any, name: str) -> None:
    agrees(kit, name, SIZES, 4)


@pytest.mark.parametrize("name", ["fourbar", pytest.param("cpm", marks=pytest.mark.slow)])
def test_the_check_sees_errors_at_every_size(kit: Any, name: str) -> None:
    """A function that is wrong by a millionth is refused, however small the numbers are."""
    for units in (SIZES[0], SIZES[3], SIZES[4]):
        chain = ClosedChain(scaled(kit.model(name).description, *units))
        machine = compiled(chain, cached=False)
        check = Checker(machine.source, chain, np.zeros(0))
        for what in ("inverse", "forward", "terms"):
            function, right = machine.library()[what], machine.kernel(what).program
            assert not check(function)
            values = np.array(right.values)
            values[values != 0.0] *= 1.0 + 1e-6
            wrong = Program(right.name, right.arguments, right.results, right.op, right.operands, values, right.outputs)
            assert "off by" in check(CompiledFunction(function.row, NativeKernel(wrong), machine.source)), (units, what)


@pytest.mark.parametrize("name", ["fivebar", pytest.param("stewart", marks=pytest.mark.slow)])
def test_a_base_far_away_costs_no_digits(kit: Any, name: str) -> None:
    """The traced model stands near the robot; where that is in the world is added to the results."""
    chain = kit.model(name)
    origin = np.array([8e3, -5e3, 3e3])
    away: Any = Away(chain, origin)
    near, far = compiled(chain, cached=False), CompiledChain(away, Options(cached=False))
    at, v = near.home, np.full(chain.n, 0.3)
    one, other = near.tool(at, v), far.tool(at, v)
    np.testing.assert_array_equal(other.position, one.position + origin)
    np.testing.assert_array_equal(other.jacobian, one.jacobian)
    np.testing.assert_array_equal(other.drift, one.drift)
    mass = sum(inertia.mass for inertia in list(chain.model.inertias)[1:])
    lifted = near.potential_energy(at) - mass * float(np.array(chain.model.gravity.linear) @ origin)
    np.testing.assert_allclose(far.potential_energy(at), lifted, rtol=1e-14)
    np.testing.assert_array_equal(far.inverse_dynamics(at, v, v), near.inverse_dynamics(at, v, v))
    assert far.source.content != near.source.content


@pytest.mark.parametrize("name", ["fivebar", pytest.param("cpm", marks=pytest.mark.slow)])
def test_a_robot_on_a_base_far_away_is_the_same_robot(kit: Any, name: str) -> None:
    description = kit.model(name).description
    mount = placement((8e3, -5e3, 3e3), (0.3, -0.4, 1.0))
    stand = Joint("stand", JointType.FIXED, "ground", description.root, mount)
    away = replace(
        description,
        links=(Link("ground"), *description.links),
        joints=(stand, *description.joints),
        gravity=mount[:3, :3] @ description.gravity,
        variants=(),
    )
    far, near = compiled(ClosedChain(away), cached=False), kit.machine(name)
    assert any(far.source.origin)
    v, q = np.full(near.n, 0.3), near.home.q + 0.01
    here, there = near.close(q), far.close(q)
    assert max(there.gap) < 1e-14
    wanted = near.inverse_dynamics(here, v, v)
    np.testing.assert_allclose(far.inverse_dynamics(there, v, v), wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
    place = mount @ np.append(near.tool(here).position, 1.0)
    np.testing.assert_allclose(far.tool(there).position, place[:3], rtol=0, atol=4e-12)
    np.testing.assert_allclose(far.batch.tool(there.q_full[None]).position[0], far.tool(there).position, rtol=1e-15)


class Away:
    """A chain whose model stands at `origin` in the world."""

    def __init__(self, chain: Any, origin: np.ndarray) -> None:
        self._chain, self.origin = chain, origin

    def __getattr__(self, name: str) -> Any:
        return getattr(self._chain, name)

    def tool(self, at: Any, v: Any = None) -> Any:
        found = self._chain.tool(at, v)
        return replace(found, position=found.position + self.origin)

    def potential_energy(self, at: Any) -> float:
        mass = sum(inertia.mass for inertia in list(self._chain.model.inertias)[1:])
        gravity = np.array(self._chain.model.gravity.linear)
        return float(self._chain.potential_energy(at) - mass * gravity @ self.origin)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourbar", "cpm", "stewart"])
def test_a_base_turned_any_way(kit: Any, name: str) -> None:
    chain, rng = kit.model(name), np.random.default_rng(5)
    v, x = rng.normal(size=chain.n), rng.normal(size=chain.n)
    straight = compiled(chain)
    for _ in range(6):
        mount = placement(tuple(rng.normal(size=3)), tuple(rng.uniform(-np.pi, np.pi, 3)))
        turned = compiled(ClosedChain(mounted(chain.description, mount)), cached=False)
        for function in ("inverse_dynamics", "forward_dynamics"):
            wanted = getattr(straight, function)(straight.home, v, x)
            found = getattr(turned, function)(turned.close(straight.home.q), v, x)
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


def test_runs_are_the_same_at_every_size(kit: Any) -> None:
    """A five-bar under PD control, gains in its own units, from the same start: the same curve, nothing done slowly."""
    description = kit.model("fivebar").description
    curves = []
    for s, m, t in ((1.0, 1.0, 1.0), (1e-4, 1e6, 1e-2), (1e4, 1e-6, 1e2)):
        machine = compiled(ClosedChain(scaled(description, s, m, t)), cached=False)
        energy = m * s**2 / t**2
        loop = ClosedLoop(machine, PD(2.0 * energy, 0.1 * energy * t), machine)
        table = np.zeros((2 * 100 + 1, loop.sizes.columns))
        table[:, 1:3] = machine.home.q
        many = loop.run(table, step=1e-3 * t, every=0.02 * t, start=machine.home.q + 0.1)
        assert not many.failed
        assert not many.slow
        curves.append(many.q[0])
        assert np.abs(many.q[0] - machine.home.q).max() > 0.05
    for curve in curves[1:]:
        np.testing.assert_allclose(curve, curves[0], rtol=0, atol=1e-11)
