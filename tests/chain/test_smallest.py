"""Robots with one velocity coordinate or none, and without actuators, cuts, tool or links: right numbers or one clear
error, from every method and command."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.small import ROBOTS, write
from typer.testing import CliRunner

from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.cli import app
from cutjoint.description import load_description
from cutjoint.errors import CutjointError, UnreachableError

G = 9.81
INERTIA = 0.1 + 2.0 * 0.5**2
"""Of the rod about its hinge."""


@pytest.fixture
def small(tmp_path: Path) -> Any:
    return lambda name: ClosedChain(load_description(write(name, tmp_path)))


def calls(chain: ClosedChain) -> dict[str, Any]:
    """Public method or property -> a call of it."""
    q, at = np.array(chain.home.q_full), chain.home
    v, full = 0.3 * np.ones(chain.n), 0.3 * np.ones(chain.nv)
    return {
        "actuated": lambda: chain.actuated(q),
        "actuated_velocity": lambda: chain.actuated_velocity(full),
        "actuators": lambda: chain.actuators,
        "assemble": lambda: chain.assemble(q),
        "actuation": lambda: chain.actuation,
        "constraint_models": lambda: len(chain.constraint_models()),
        "constraint_datas": lambda: len(chain.constraint_datas(chain.constraint_models())),
        "constraint_residual": lambda: chain.constraint_residual(q),
        "visual_model": lambda: chain.visual_model().ngeoms,
        "collision_model": lambda: chain.collision_model().ngeoms,
        "centre_of_mass": lambda: chain.centre_of_mass(q),
        "close": lambda: chain.close(chain.home.q + 0.1),
        "compile": lambda: None,
        "constraint_jacobian": lambda: chain.constraint_jacobian(q),
        "cut_placements": lambda: chain.cut_placements(q),
        "drift": lambda: chain.drift(at, v),
        "forward_dynamics": lambda: chain.forward_dynamics(at, v, v),
        "full_acceleration": lambda: chain.full_acceleration(q, full, full),
        "full_effort": lambda: chain.full_effort(v),
        "full_forward_dynamics": lambda: chain.full_forward_dynamics(at, full, full),
        "full_inverse_dynamics": lambda: chain.full_inverse_dynamics(at, full, full),
        "full_motion": lambda: chain.full_motion(at, np.zeros(3), np.zeros(3)),
        "full_velocity": lambda: chain.full_velocity(at, v),
        "gap": lambda: chain.gap(q),
        "goes_beyond": lambda: chain.goes_beyond(q, q + 0.1),
        "home": lambda: chain.home,
        "idle_is_cyclic": lambda: chain.idle_is_cyclic,
        "integrate": lambda: chain.integrate(q, full),
        "inverse_dynamics": lambda: chain.inverse_dynamics(at, v, v),
        "load_effort": lambda: chain.load_effort(at, Load([1.0, 2.0, 3.0], link=chain.description.links[-1].name)),
        "full_load_effort": lambda: chain.full_load_effort(at, Load([1.0, 2.0, 3.0])),
        "pushes_idle": lambda: chain.pushes_idle(at, Load([1.0, 2.0, 3.0])),
        "minimal": lambda: chain.minimal().terms(at).mass,
        "rebuilt": lambda: chain.rebuilt(chain.description).home.q_full,
        "sticking": lambda: np.array(list(chain.sticking.values())),
        "length": lambda: chain.length,
        "limit_violations": lambda: chain.limit_violations(at),
        "link_placements": lambda: chain.link_placements(q),
        "mobility": lambda: chain.mobility(at),
        "n": lambda: chain.n,
        "local_model": lambda: chain.local_model.name,
        "name": lambda: chain.name,
        "neutral": lambda: chain.neutral,
        "nq": lambda: chain.nq,
        "origin": lambda: chain.origin,
        "nv": lambda: chain.nv,
        "posture": lambda: chain.posture(q),
        "potential_energy": lambda: chain.potential_energy(at),
        "dissipates": lambda: None,
        "spring_energy": lambda: chain.spring_energy(at),
        "led_velocity": lambda: chain.led_velocity(at, v),
        "reactions": lambda: chain.reactions(at, v, v),
        "full_reactions": lambda: chain.full_reactions(at, full, full),
        "dissipation": lambda: chain.dissipation(at, v),
        "full_dissipation": lambda: chain.full_dissipation(at, full),
        "project": lambda: chain.project(q, full),
        "reach": lambda: chain.reach([0.0, 0.0, -1.0]),
        "tangent": lambda: chain.tangent(at),
        "task": lambda: chain.task,
        "terms": lambda: chain.terms(at, v),
        "to_mujoco": lambda: chain.to_mujoco(at),
        "from_mujoco": lambda: chain.from_mujoco(chain.to_mujoco(at)),
        "tool": lambda: chain.tool(at, v),
        "with_payload": lambda: chain.with_payload(0.1).home,
        "working_modes": lambda: chain.working_modes(),
        "assembly_modes": lambda: getattr(chain, "assembly_modes", lambda: ())(),
    }


def finite(value: Any) -> None:
    """All numbers in an answer are finite; NaN stands for `undefined` in a mobility report alone."""
    if isinstance(value, np.ndarray | float):
        assert np.isfinite(value).all()
    elif isinstance(value, dict):
        for one in value.values():
            finite(one)
    elif isinstance(value, tuple | list):
        for one in value:
            finite(one)
    elif hasattr(value, "__dataclass_fields__") and type(value).__name__ != "MobilityReport":
        for name in value.__dataclass_fields__:
            finite(getattr(value, name))


def test_no_method_is_left_out(small: Any) -> None:
    public = {name for name, _ in inspect.getmembers(ClosedChain) if not name.startswith("_")}
    assert public <= set(calls(small("pendulum")))


@pytest.mark.parametrize("name", ROBOTS)
def test_every_method_gives_numbers_or_one_clear_error(name: str, small: Any) -> None:
    chain = small(name)
    for call in calls(chain).values():
        try:
            answer = call()
        except CutjointError:
            continue
        finite(answer)


@pytest.mark.parametrize("json", [False, True])
@pytest.mark.parametrize("command", ["check", "info"])
@pytest.mark.parametrize("name", ROBOTS)
def test_every_command_answers(name: str, command: str, json: bool, tmp_path: Path) -> None:
    folder = write(name, tmp_path)
    done = CliRunner().invoke(app, [command, str(folder), *(["--json"] if json else [])])
    assert done.exception is None or isinstance(done.exception, SystemExit | CutjointError), done.exception
    assert done.exit_code in (0, 1, 2)
    assert "Traceback" not in done.output
    if name in ("pendulum", "slider", "door"):
        assert done.exit_code == 0, done.output


def test_a_pendulum(small: Any) -> None:
    chain = small("pendulum")
    report = chain.mobility()
    assert (report.velocities, report.rows, report.rank, report.mobility, report.determined) == (1, 0, 0, 1, True)
    assert (report.type1, report.condition) == (pytest.approx(1.0 / chain.length), 1.0)
    assert report.type2 == np.inf
    at = chain.close([0.7])
    assert chain.inverse_dynamics(at, [2.0], [3.0]) == pytest.approx(INERTIA * 3.0 + 2.0 * G * 0.5 * np.sin(0.7))
    assert chain.forward_dynamics(at, [2.0], chain.inverse_dynamics(at, [2.0], [3.0])) == pytest.approx(3.0)
    assert chain.terms(at, [2.0]).mass == pytest.approx(INERTIA)
    assert chain.terms(at, [2.0]).coriolis == pytest.approx(0.0, abs=1e-14)
    tool = chain.tool(at, [2.0])
    assert tool.position == pytest.approx(np.array([-np.sin(0.7), 0.0, -np.cos(0.7)]))
    assert tool.jacobian[:, 0] == pytest.approx(np.array([-np.cos(0.7), 0.0, np.sin(0.7)]))
    assert tool.drift == pytest.approx(4.0 * np.array([np.sin(0.7), 0.0, np.cos(0.7)]))
    assert chain.reach(tool.position).q == pytest.approx([0.7])
    with pytest.raises(UnreachableError):
        chain.reach([0.0, 0.5, -1.0])
    full = chain.full_forward_dynamics(at, np.array([2.0]), np.array([1.0]))
    assert full.acceleration == pytest.approx((1.0 - G * np.sin(0.7)) / INERTIA)
    assert chain.full_inverse_dynamics(at, np.array([2.0]), np.array([3.0])).effort == pytest.approx(
        INERTIA * 3.0 + G * np.sin(0.7)
    )


def test_a_slider(small: Any) -> None:
    chain = small("slider")
    assert chain.mobility().mobility == 1
    at = chain.close([0.2])
    assert chain.inverse_dynamics(at, [1.0], [3.0]) == pytest.approx(2.0 * (3.0 + G))
    assert chain.reach([0.0, 0.0, -0.5]).q == pytest.approx([0.5])
    assert chain.potential_energy(at) == pytest.approx(2.0 * G * (0.2 - 0.5))


@pytest.mark.parametrize("name", ["door", "door that swings free"])
def test_a_door_on_two_hinges(name: str, small: Any) -> None:
    chain = small(name)
    report = chain.mobility()
    assert (report.rows, report.rank, report.mobility) == (5, 0, 1)
    assert report.redundant_rows == tuple(f"upper.{row}" for row in ("x", "y", "z", "tilt_x", "tilt_y"))
    # without a tool what turns about one axis between two hinges is idle, like a rod between two balls
    assert report.determined
    assert report.free == report.idle == (() if chain.n else ("hinge",))
    motion = chain.full_forward_dynamics(chain.posture(np.array([0.7])), np.array([2.0]), np.array([1.0]))
    assert motion.acceleration == pytest.approx((1.0 - G * np.sin(0.7)) / INERTIA)
    # the hinge of the tree carries it all: what the cut carries is not told apart, and the least is nothing
    assert np.abs(motion.loop_forces["upper"].force).max() < 1e-12
    if chain.n:
        at = chain.close([0.7])
        assert chain.inverse_dynamics(at, [2.0], [3.0]) == pytest.approx(INERTIA * 3.0 + G * np.sin(0.7))
        assert chain.forward_dynamics(at, [2.0], [1.0]) == pytest.approx((1.0 - G * np.sin(0.7)) / INERTIA)


@pytest.mark.parametrize("name", ["locked door", "driven locked door"])
def test_a_locked_door_does_not_move(name: str, small: Any) -> None:
    chain = small(name)
    report = chain.mobility()
    assert (report.rank, report.mobility, len(report.redundant_rows)) == (1, 0, 5)
    assert report.determined is (chain.n == 0)
    push = chain.full_forward_dynamics(chain.home, np.zeros(1), np.array([5.0]))
    assert push.acceleration == pytest.approx(0.0, abs=1e-12)
    # the cut takes the whole moment about the hinge: x and z as far from it as they are, and the rest as moment
    wrench = push.loop_forces["upper"]
    assert wrench.moment[1] == pytest.approx(-5.0)


@pytest.mark.parametrize("name", ["two welded links", "base alone", "base with a tool"])
def test_nothing_moves(name: str, small: Any) -> None:
    chain = small(name)
    report = chain.mobility()
    assert (chain.n, chain.nv, chain.nq) == (0, 0, 0)
    assert (report.velocities, report.rank, report.mobility, report.determined) == (0, 0, 0, True)
    assert report.rows == len(report.redundant_rows)
    assert chain.close([]).q.shape == (0,)
    assert chain.forward_dynamics(chain.home, [], []).shape == (0,)
    assert chain.inverse_dynamics(chain.home, [], []).shape == (0,)
    assert chain.terms(chain.home, []).mass.shape == (0, 0)
    assert chain.potential_energy(chain.home) == pytest.approx(0.0)
    if chain.description.tool is not None:
        tool = chain.tool(chain.home, [])
        assert tool.position == pytest.approx(np.array([0.0, 0.0, -1.0]))
        assert tool.jacobian.shape == (3, 0)
        assert chain.reach([0.0, 0.0, -1.0]).q.shape == (0,)
        with pytest.raises(UnreachableError):
            chain.reach([0.1, 0.0, -1.0])
