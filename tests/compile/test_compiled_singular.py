"""Near singularities: the compiled robot says what the model says, a number or an error, and nothing in between."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, Options, compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.equations.elimination_order import Plan
from cutjoint.compile.equations.reduction import MASS_SHARE
from cutjoint.description import load_description
from cutjoint.description.catalogue import path
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
from cutjoint.errors import (
    ActuationError,
    ClosureError,
    CompileError,
    CutjointError,
    InputError,
    LimbReachError,
    SingularError,
    UnreachableError,
)
from cutjoint.mechanism import Posture


def outcome(call: Any) -> Any:
    """What a call gives: a value, or the class of its error."""
    try:
        return call()
    except CutjointError as error:
        return type(error)


def towards(model: Any, direction: np.ndarray, count: int) -> list[Posture]:
    """Postures ever nearer to where the model cannot go on in a direction of its actuators, found by halving steps."""
    found = [model.home]
    step = 0.2
    while len(found) < count and step > 1e-13:
        try:
            found.append(model.close(found[-1].q + step * direction, found[-1], limits="ignore"))
        except CutjointError:
            step /= 3.0
    return found


@pytest.mark.parametrize(
    ("name", "direction"),
    [("fivebar", [0.4, -1.0]), ("fivebar", [1.0, -1.0]), ("cpm", [0.0, 1.0, 0.3]), ("cpm", [-1.0, -0.4, 0.2])],
)
def test_on_the_way_to_a_singularity(kit: Any, name: str, direction: list[float]) -> None:
    model, machine = kit.model(name), kit.machine(name)
    rng = np.random.default_rng(0)
    strains = []
    for at in towards(model, np.array(direction), 60):
        v, x = rng.normal(size=model.n), rng.normal(size=model.n)
        strains.append(machine.kernel("forward")(at.q_full, v, x, np.zeros(0))[-1])
        for call in ("forward_dynamics", "inverse_dynamics"):
            wanted = outcome(lambda call=call, at=at, v=v, x=x: getattr(model, call)(at, v, x))
            found = outcome(lambda call=call, at=at, v=v, x=x: getattr(machine, call)(at, v, x))
            if isinstance(wanted, type):
                assert found is wanted
            else:
                size = max(1.0, np.abs(wanted).max())
                # half of the digits are gone where the model itself is at its limit
                np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * size)
    assert max(strains) > STRAIN_LIMIT, "the way must lead beyond what is compiled for"


def test_limbs_of_a_published_model_that_do_not_reach(kit: Any) -> None:
    machine = kit.machine("paper cpm")
    zero = np.zeros(3)
    with pytest.raises(LimbReachError):
        machine.close([5.0, 0.4, 0.3])
    with pytest.raises(LimbReachError) as caught:
        machine.batch.forward_dynamics([[0.4, 0.4, 0.3], [5.0, 0.4, 0.3]], zero, zero)
    assert "row 1" in "".join(caught.value.__notes__)
    with pytest.raises(InputError):
        machine.batch.reach([[0.4, 0.4, 0.3], [0.4, np.nan, 0.3]])
    with pytest.raises(InputError):
        machine.batch.inverse_dynamics([[0.4, np.nan, 0.3]], zero, zero)
    with pytest.raises(UnreachableError):
        kit.machine("paper omega3").batch.reach([[0.1, 0.0, 0.0], [9.0, 0.0, 0.0]])


def test_batches_raise_what_the_chain_raises(kit: Any) -> None:
    machine = kit.machine("fivebar")
    with pytest.raises(ClosureError) as caught:
        machine.batch.close(np.stack([machine.home.q, machine.home.q + np.array([1.0, -1.0])]))
    assert "row 1" in "".join(caught.value.__notes__)


def test_rows_beyond_the_limit_are_done_by_the_model(kit: Any) -> None:
    model, machine = kit.model("fivebar"), kit.machine("fivebar")
    way = towards(model, np.array([1.0, -1.0]), 60)
    strained = [at for at in way if not machine.kernel("terms")(at.q_full, [0, 0], np.zeros(0))[-1] <= STRAIN_LIMIT]
    good = [at for at in strained if not isinstance(outcome(lambda at=at: model.terms(at)), type)]
    assert good
    mass, _, gravity, *_ = machine.batch.terms(np.stack([good[0].q_full, model.home.q_full]))
    np.testing.assert_array_equal(mass[0], model.terms(good[0]).mass)
    np.testing.assert_array_equal(gravity[0], model.terms(good[0]).gravity)
    np.testing.assert_allclose(mass[1], model.terms(model.home).mass, rtol=1e-12)


def test_derivatives_too_near_to_a_singularity_are_refused(kit: Any) -> None:
    model, machine = kit.model("fivebar"), kit.machine("fivebar")
    at = towards(model, np.array([1.0, -1.0]), 60)[-1]
    with pytest.raises(SingularError):
        machine.forward_derivatives(at, np.zeros(2), np.zeros(2))


def test_a_bad_order_of_elimination_is_noticed_and_does_no_harm() -> None:
    """A pivot that is good at home and vanishes in the middle of the workspace, away from any singularity."""
    chain = ClosedChain(load_description(path("fivebar")))
    machine = compiled(chain, cached=False)
    plan: Plan = machine.source.plan
    jacobian = chain.constraint_jacobian(chain.home)
    others = [row for row in range(len(jacobian)) if np.abs(jacobian[row]).max() > 0.1]
    swapped = tuple(reversed([rate for _, rate in plan.pivots]))
    bad = replace(plan, pivots=tuple(zip(others, swapped, strict=True)))
    machine.source.__dict__["plan"] = bad
    rng = np.random.default_rng(0)
    strains = []
    for _ in range(300):
        q = chain.home.q + rng.uniform(-0.6, 0.6, 2)
        at = outcome(lambda q=q: chain.close(q))
        if isinstance(at, type):
            continue
        v, x = rng.normal(size=2), rng.normal(size=2)
        wanted = chain.forward_dynamics(at, v, x)
        found = machine.forward_dynamics(at, v, x)
        strains.append(machine.kernel("forward")(at.q_full, v, x, np.zeros(0))[-1])
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * max(1.0, np.abs(wanted).max()))
    assert max(strains) > 20.0 * min(strains), "the order must be bad somewhere for this test to mean anything"


def plain(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> np.ndarray:
    return placement((x, y, z), (0.0, 0.0, yaw))


def beam(mass: float, length: float) -> Inertial:
    across = mass * length**2 / 12.0
    return Inertial(mass, np.array([0.5 * length, 0.01, 0.0]), np.diag([1e-2 * across, across, across]))


def parallelogram() -> RobotDescription:
    """Flat at home, where the branch on which the sides stay parallel meets the one on which they cross."""
    axis = np.array([0.0, 0.0, 1.0])
    return RobotDescription(
        name="flat parallelogram",
        links=(
            Link("base"),
            Link("crank", beam(0.3, 0.3)),
            Link("coupler", beam(0.4, 0.5)),
            Link("rocker", beam(0.3, 0.3)),
        ),
        joints=(
            Joint("crank", JointType.CONTINUOUS, "base", "crank", axis=axis),
            Joint("elbow", JointType.CONTINUOUS, "crank", "coupler", plain(0.3, 0.0), axis=axis),
            Joint("rocker", JointType.CONTINUOUS, "base", "rocker", plain(0.5, 0.0), axis=axis),
        ),
        cuts=(CutJoint("pin", CutType.REVOLUTE, Frame("coupler", plain(0.5, 0)), Frame("rocker", plain(0.3, 0))),),
        actuators=("crank",),
        gravity=np.array([0.0, -9.81, 0.0]),
        homes=(Home("default", {"crank": 0.0}, {"elbow": 0.0, "rocker": 0.0}),),
    )


def three_upu() -> RobotDescription:
    """Equal plates: with its legs straight up the platform can also turn, in the first order."""
    x, y, z = np.eye(3)
    low = Inertial(0.5, np.array([0.0, 0.0, 0.1]), np.diag([2e-3, 2e-3, 1e-4]))
    up = Inertial(0.3, np.array([0.0, 0.0, -0.1]), np.diag([1e-3, 1e-3, 1e-4]))
    links = [Link("base"), Link("plate", Inertial(1.0, np.zeros(3), np.diag([1e-2, 1e-2, 2e-2])))]
    joints, cuts = [Joint("fly", JointType.FLOATING, "base", "plate")], []
    for k in range(3):
        turn = 2.0 * np.pi * k / 3.0
        foot = plain(0.2 * np.cos(turn), 0.2 * np.sin(turn), 0.0, turn)
        links += [Link(f"low{k}", low), Link(f"up{k}", up), Link(f"ear{k}", Inertial(0.05, z / 100, 1e-5 * np.eye(3)))]
        joints += [
            Joint(f"hip{k}", JointType.UNIVERSAL, "base", f"low{k}", foot, axis=y, axis2=x),
            Joint(f"leg{k}", JointType.PRISMATIC, f"low{k}", f"up{k}", plain(0.0, 0.0, 0.5), axis=z),
            Joint(f"foot{k}", JointType.UNIVERSAL, f"up{k}", f"ear{k}", axis=x, axis2=y),
        ]
        cuts.append(CutJoint(f"weld{k}", CutType.FIXED, Frame(f"ear{k}"), Frame("plate", foot)))
    return RobotDescription(
        name="3-UPU",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        actuators=("leg0", "leg1", "leg2"),
        tool=Frame("plate"),
        homes=(Home("default", dict.fromkeys(("leg0", "leg1", "leg2"), 0.0), {"fly": (0.0, 0.0, 0.5, 0.0, 0.0, 0.0)}),),
    )


@pytest.mark.parametrize("make", [parallelogram, three_upu])
def test_a_singular_home_spoils_no_other_posture(kit: Any, make: Any) -> None:
    chain = ClosedChain(make())
    assert not chain.mobility(chain.home).determined
    machine, numbers, rng = compiled(chain, cached=False), kit.numbers(chain), np.random.default_rng(0)
    source = machine.source
    assert source.idle == 0
    assert not any(np.array_equal(q, chain.home.q_full) for q in source.cloud)
    for q in source.cloud[:8]:
        here = chain.posture(q)
        v, a = rng.normal(size=chain.n), 5.0 * rng.normal(size=chain.n)
        strain = machine.kernel("inverse")(q, v, a, np.zeros(0))[-1]
        assert strain <= STRAIN_LIMIT, "the compiled code itself must answer here"
        effort = numbers.effort(q, v, a)
        size = np.abs(effort).max()
        np.testing.assert_allclose(machine.inverse_dynamics(here, v, a), effort, rtol=0, atol=1e-9 * size)
        np.testing.assert_allclose(machine.forward_dynamics(here, v, effort), a, rtol=0, atol=1e-9 * np.abs(a).max())
        near = machine.close(here.q + 1e-3, here)
        np.testing.assert_allclose(near.q, here.q + 1e-3, rtol=0, atol=1e-14)
        assert max(near.gap) < 1e-13
    with pytest.raises(CutjointError):
        machine.inverse_dynamics(machine.home, np.zeros(chain.n), np.zeros(chain.n))
    assert not machine.kernel("inverse")(chain.home.q_full, np.ones(chain.n), np.ones(chain.n), np.zeros(0))[-1] <= 1e3


def test_a_robot_that_cannot_leave_a_singular_home_is_refused_by_name() -> None:
    """Welded, the flat parallelogram is a structure that is shaky at home and nowhere else."""
    description = parallelogram()
    (pin,) = description.cuts
    chain = ClosedChain(replace(description, cuts=(replace(pin, type=CutType.FIXED),)))
    with pytest.raises(CompileError, match="cannot move there"):
        compiled(chain, cached=False).kernel("forward")


def sliders() -> RobotDescription:
    """One slider on another along the same line, and a pair of wheels that a gear couples."""
    axis = np.array([1.0, 0.0, 0.0])
    wheel = Inertial(0.1, np.zeros(3), 1e-4 * np.eye(3))
    return RobotDescription(
        name="sliders",
        links=(
            Link("base"),
            Link("carriage", Inertial(1.0, np.zeros(3), 1e-3 * np.eye(3))),
            Link("load", Inertial(2.0, np.zeros(3), 1e-3 * np.eye(3))),
            Link("wheel", wheel),
            Link("pinion", wheel),
        ),
        joints=(
            Joint("below", JointType.PRISMATIC, "base", "carriage", axis=axis),
            Joint("above", JointType.PRISMATIC, "carriage", "load", plain(0.1, 0.0), axis=axis),
            Joint("wheel", JointType.CONTINUOUS, "base", "wheel", plain(0.0, 0.3), axis=axis),
            Joint("pinion", JointType.CONTINUOUS, "base", "pinion", plain(0.0, 0.5), axis=axis),
        ),
        couplings=(Coupling.geared("gear", "pinion", "wheel", -2.0),),
        actuators=("below", "above", "wheel"),
    )


def test_digits_lost_in_the_mass_matrix_count_as_strain() -> None:
    """M = [m + c, m; m, m]: the lighter the carriage c, the more of the second pivot m c / (m + c) is rounding."""
    chain = ClosedChain(sliders())
    machine = compiled(chain, parameters=["carriage"], cached=False)
    at, zero = machine.home.q_full, np.zeros(3)
    load = 2.0
    for carriage in (1.0, 1e-3, 1e-6, 1e-9):
        strain = machine.kernel("forward")(at, zero, zero, np.array([carriage]))[-1]
        np.testing.assert_allclose(strain, max(1.0, MASS_SHARE * (load + carriage) / carriage), rtol=1e-6)
        found = machine.with_parameters(carriage=carriage).forward_dynamics(machine.home, zero, [3.0, 1.0, 0.0])
        # the force on the carriage is what is left of both motors'; what the load feels is the upper one's
        wanted = [(3.0 - 1.0) / carriage, 1.0 / load - (3.0 - 1.0) / carriage, 0.0]
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-9 * abs(wanted[0]))
    assert strain > STRAIN_LIMIT


class Lacking:
    """A chain whose loops close only with the last row left out."""

    def __init__(self, chain: Any) -> None:
        self._chain = chain

    def __getattr__(self, name: str) -> Any:
        return getattr(self._chain, name)

    def constraint_jacobian(self, q_full: np.ndarray) -> np.ndarray:
        return np.asarray(self._chain.constraint_jacobian(q_full)[:-1])


def test_loops_that_close_only_in_part_are_refused_by_name(kit: Any) -> None:
    lacking: Any = Lacking(kit.model("fivebar"))
    machine = CompiledChain(lacking, Options(cached=False))
    with pytest.raises(CompileError, match="left out"):
        machine.kernel("forward")
    with pytest.raises(CompileError, match="left out"):
        machine.forward_dynamics(machine.home, np.zeros(2), np.zeros(2))


def test_a_motion_that_moves_no_mass_is_refused_by_name() -> None:
    description = sliders()
    links = tuple(Link("load") if link.name == "load" else link for link in description.links)
    machine = compiled(ClosedChain(replace(description, links=links)), cached=False)
    with pytest.raises(CompileError, match="no mass"):
        machine.kernel("forward")


def test_what_cannot_move_is_refused_by_name() -> None:
    rigid = RobotDescription(name="stone", links=(Link("base"),), joints=())
    with pytest.raises(CompileError, match="nothing to compile"):
        compiled(ClosedChain(rigid), cached=False).kernel("full_forward")
    description = parallelogram()
    weld = CutJoint("weld", CutType.FIXED, Frame("coupler", plain(0.5, 0.0)), Frame("base", plain(0.8, 0.0)))
    structure = replace(description, cuts=(*description.cuts, weld), actuators=(), homes=(Home("default", {}, {}),))
    still = compiled(ClosedChain(structure), cached=False)
    with pytest.raises(ActuationError, match="0 actuators"):
        still.kernel("forward")
    # its acceleration is known all the same
    home = still.home.q_full
    assert np.abs(still.full_acceleration(home, np.zeros(3), np.ones(3))).max() < 1e-12


def test_trees_without_cuts_compile_too(kit: Any) -> None:
    """Two links one on the other, each with a motor, one of them, or none."""
    axis = np.array([0.0, 1.0, 0.0])
    arm = RobotDescription(
        name="arm",
        links=(Link("base"), Link("upper", beam(0.5, 0.3)), Link("lower", beam(0.4, 0.2))),
        joints=(
            Joint("shoulder", JointType.REVOLUTE, "base", "upper", axis=axis),
            Joint("elbow", JointType.REVOLUTE, "upper", "lower", plain(0.3, 0.0, 0.0, 0.4), axis=axis),
        ),
        actuators=("shoulder", "elbow"),
        tool=Frame("lower", plain(0.2, 0.0)),
        homes=(Home("default", {"shoulder": 0.3, "elbow": -0.5}),),
    )
    chain = ClosedChain(arm)
    machine, numbers = compiled(chain, cached=False), kit.numbers(chain)
    v, a, q = np.array([1.0, -2.0]), np.array([3.0, 4.0]), chain.home.q_full
    np.testing.assert_allclose(machine.inverse_dynamics(chain.home, v, a), numbers.forces(q, v, a), rtol=1e-13)
    assert error_free(machine.forward_dynamics(chain.home, v, numbers.forces(q, v, a)), a)
    for actuators in (("elbow",), ()):
        home = Home("default", dict.fromkeys(actuators, 0.2), {})
        free = ClosedChain(replace(arm, actuators=actuators, homes=(home,)))
        loose = compiled(free, cached=False)
        push = np.array([0.3, -0.1])
        found = loose.full_acceleration(free.home.q_full, v, push)
        assert error_free(numbers.forces(free.home.q_full, v, found), push)


def error_free(found: np.ndarray, wanted: np.ndarray) -> bool:
    return bool(np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max())
