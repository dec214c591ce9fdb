"""What the comparison of two mechanisms notices, whatever the mechanisms are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from kit.led_robots import LED, somewhere

from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import QUANTITIES, compare, effort_along, hypothesis_cost, sample_states, workspace_box
from cutjoint.errors import CutjointError, DynamicsError, ToleranceError, UnreachableError
from cutjoint.mechanism import Actuator, JointLimits, Mechanism, Posture, Task, Terms, Tool
from cutjoint.mechanism.loads import as_loads, tool_wrench
from cutjoint.mechanism.rotations import turned


@dataclass(frozen=True)
class Cart:
    """A point mass on three perpendicular sliders in a box: the plainest mechanism, right by inspection."""

    name: str = "cart"
    mass: float = 2.0
    reach_of: float = 0.5
    spoil: str = ""

    n = 3
    actuators = tuple(Actuator(axis, "translation") for axis in "xyz")

    @property
    def home(self) -> Posture:
        return Posture(np.zeros(3), np.zeros(3))

    @property
    def task(self) -> Task:
        return Task(("x", "y", "z"), self.tool(self.home).pose, self.name)

    def close(self, q: Any, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        return Posture(np.array(q), np.array(q))

    def reach(
        self, target: Any, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        p = self.task.target(target, free).pose.position
        if np.abs(p).max() > self.reach_of:
            raise UnreachableError("outside the box", target=np.array(p))
        return self.close(p)

    def off(self, quantity: str) -> float:
        return 1e-6 if quantity == self.spoil else 0.0

    def tool(self, at: Posture, v: Any = None) -> Tool:
        drift = np.zeros(3) if v is None else np.full(3, self.off("J_dot v"))
        tool = Tool.of_point(at.q + self.off("tool position"), np.eye(3) + self.off("Jacobian"), drift)
        return replace(tool, rotation=turned(self.off("tool orientation") * at.q))

    def terms(self, at: Posture, v: Any = None) -> Terms:
        gravity = np.array([0.0, 0.0, 9.81 * self.mass]) + self.off("gravity")
        coriolis = np.zeros(3) if v is None else np.full(3, self.off("Coriolis C v"))
        return Terms((self.mass + self.off("mass matrix")) * np.eye(3), coriolis, gravity)

    def potential_energy(self, at: Posture) -> float:
        return 9.81 * self.mass * float(at.q[2])

    @property
    def dissipates(self) -> bool:
        return False

    def dissipation(self, at: Posture, v: Any) -> float:
        return 0.0

    def load_effort(self, at: Posture, loads: Any) -> np.ndarray:
        return np.asarray(self.tool(at).frame_jacobian.T @ tool_wrench(as_loads(loads), self.tool(at), self.name))

    def inverse_dynamics(self, at: Posture, v: Any, a: Any, loads: Any = ()) -> np.ndarray:
        return self.mass * np.array(a) + [0.0, 0.0, 9.81 * self.mass] + np.full(3, self.off("inverse dynamics"))

    def forward_dynamics(self, at: Posture, v: Any, effort: Any, loads: Any = ()) -> np.ndarray:
        if self.spoil == "no answer":
            raise DynamicsError("lost", residual=1.0)
        found = (np.array(effort) - [0.0, 0.0, 9.81 * self.mass]) / self.mass + self.off("forward dynamics")
        return found * np.nan if self.spoil == "NaN" else found

    def with_payload(self, mass: float) -> Self:
        return replace(self, mass=self.mass + mass)


def test_a_mechanism_agrees_with_itself() -> None:
    assert isinstance(Cart(), Mechanism)
    found = compare(Cart(), Cart("twin"), sample_states(Cart(), 10, 0))
    assert found.passes
    assert (found.checked, found.reference, found.samples, found.refused) == ("cart", "twin", 10, 0)
    assert tuple(row.quantity for row in found.rows) == QUANTITIES
    assert all(row.error == 0.0 for row in found.rows)
    found.require()


@pytest.mark.parametrize("quantity", QUANTITIES[1:])
def test_each_quantity_is_compared_by_itself(quantity: str) -> None:
    found = compare(Cart(spoil=quantity), Cart(), sample_states(Cart(), 10, 0))
    assert [row.quantity for row in found.rows if not row.passes] == [quantity]
    with pytest.raises(ToleranceError, match=quantity.replace("_", ".")) as caught:
        found.require()
    assert list(caught.value.worst) == [quantity]
    assert all(0 <= row.sample < 10 for row in found.rows)


def test_a_nan_does_not_pass() -> None:
    found = compare(Cart(spoil="NaN"), Cart(), sample_states(Cart(), 5, 0))
    assert [row.quantity for row in found.rows if not row.passes] == ["forward dynamics"]


def test_states_that_are_refused_do_not_pass() -> None:
    states = list(sample_states(Cart(), 40, 0))
    smaller = Cart(reach_of=0.25)
    found = compare(smaller, Cart(), states)
    wanted = [k for k, state in enumerate(states) if np.abs(state.position).max() > 0.25]
    assert 0 < found.refused == len(wanted) < 40
    assert not found.passes
    assert all(row.passes and row.sample not in wanted for row in found.rows)
    with pytest.raises(ToleranceError, match="outside the box"):
        found.require()
    lost = compare(Cart(spoil="no answer"), Cart(), states)
    assert (lost.refused, lost.rows, lost.passes) == (40, (), False)


def test_no_state_is_no_agreement() -> None:
    found = compare(Cart(), Cart(), [])
    assert not found.passes
    with pytest.raises(ToleranceError, match="no state"):
        found.require()


def test_progress_counts_every_state() -> None:
    seen: list[int] = []
    compare(Cart(), Cart(), sample_states(Cart(), 7, 0), seen.append)
    assert seen == [1, 2, 3, 4, 5, 6, 7]


def test_sampling_is_reproducible_and_spreads_over_the_workspace() -> None:
    one, two, other = (list(sample_states(Cart(), 200, seed)) for seed in (0, 0, 1))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.effort, b.effort)
    assert not np.array_equal(one[0].position, other[0].position)
    positions = np.array([state.position for state in one])
    assert np.abs(positions).max() <= 0.5
    assert (positions.max(axis=0) > 0.45).all()
    assert (positions.min(axis=0) < -0.45).all()
    forward = [np.abs(Cart().forward_dynamics(state.at, state.v, state.effort) - state.a).max() for state in one]
    assert min(forward) > 0.0, "forward dynamics is not asked what inverse dynamics just answered"


def test_the_workspace_box_ends_where_the_robot_does() -> None:
    box = workspace_box(Cart(), resolution=1e-4)
    np.testing.assert_allclose(box.upper, 0.5, atol=2e-4)
    np.testing.assert_allclose(box.lower, -0.5, atol=2e-4)
    assert (np.abs(box.upper) <= 0.5).all()
    assert box.diagonal == pytest.approx(np.sqrt(3.0), rel=1e-3)


def test_a_mechanism_that_can_hardly_be_sampled_says_so() -> None:
    class Stubborn(Cart):
        def terms(self, at: Posture, v: Any = None) -> Terms:
            return Terms(np.diag([1.0, 1.0, 1e-9]), np.zeros(3), np.zeros(3))

    with pytest.raises(CutjointError, match="only 0 can be reached and are well conditioned"):
        list(sample_states(Stubborn(), 1, 0))


def test_what_a_heavier_cart_costs() -> None:
    path = [(np.array([0.0, 0.0, 0.1 * k]), np.zeros(3), np.array([1.0, 0.0, 0.5])) for k in range(3)]
    efforts, gravity = effort_along(Cart(), path)
    np.testing.assert_allclose(efforts, [[2.0, 0.0, 2.0 * 9.81 + 1.0]] * 3)
    np.testing.assert_allclose(gravity, [[0.0, 0.0, 2.0 * 9.81]] * 3)
    cost = hypothesis_cost(Cart(), Cart(mass=2.2), path)
    np.testing.assert_allclose(cost.error, [0.2, 0.0, 0.2 * (9.81 + 0.5)])
    np.testing.assert_allclose(cost.percent, [100.0 * 0.2 / 2.2, 0.0, 100.0 * 0.2 / 2.2])
    assert cost.actuators == ("x", "y", "z")
    with pytest.raises(UnreachableError):
        hypothesis_cost(Cart(), Cart(), [(np.array([2.0, 0.0, 0.0]), np.zeros(3), np.zeros(3))])


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(name, marks=pytest.mark.slow) for name in LED if name != "delta"),
    ],
)
def test_robots_whose_point_does_not_say_all_are_compared_as_they_are_led(name: str, seed: int, tmp_path: Path) -> None:
    """A tool that is led turned, or on a surface; a lever of the turning that is off is noticed."""
    chain = ClosedChain(somewhere(name, seed, tmp_path, np.random.default_rng(3)).description)
    states = list(sample_states(chain, 8, 0))
    spread = np.ptp([state.at.q for state in states], axis=0)
    assert (
        spread > 0.1 * np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    ).all()
    compare(chain, chain, states).require()

    class Wrong:
        def __getattr__(self, name: str) -> Any:
            return getattr(chain, name)

        def tool(self, at: Posture, v: Any = None) -> Tool:
            right = chain.tool(at, v)
            rows = np.array(right.frame_jacobian)
            rows[3:] *= 1.0 + 1e-7
            return replace(right, frame_jacobian=rows)

    off = compare(Wrong(), chain, states)
    assert [row.quantity for row in off.rows if not row.passes] == ["Jacobian"]
