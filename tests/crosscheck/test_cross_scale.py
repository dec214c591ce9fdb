"""What a comparison of two models samples and notices does not depend on the robot's size, masses or place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pytest

from cutjoint.crosscheck import Comparison, compare, sample_states, workspace_box
from cutjoint.crosscheck.sampling import length_of
from cutjoint.errors import UnreachableError
from cutjoint.mechanism import Actuator, JointLimits, Mechanism, Posture, Task, Terms, Tool
from cutjoint.mechanism.loads import as_loads, tool_wrench

SIZES = [1e-4, 1.0, 1e4]
NEAR, OUT, UP = 0.51371, 1.63183, 0.31717


@dataclass(frozen=True)
class Polar:
    """A point mass on an arm that turns, slides and goes up: an angle and two lengths, right by inspection."""

    size: float = 1.0
    mass: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spoil: str = ""
    by: float = 0.0

    name = "polar"
    n = 3
    actuators = (Actuator("turn", "rotation"), Actuator("slide", "translation"), Actuator("lift", "translation"))

    @property
    def length(self) -> float:
        return self.size

    @property
    def home(self) -> Posture:
        return self.close([0.0, self.size, 0.0])

    @property
    def task(self) -> Task:
        return Task(("x", "y", "z"), self.tool(self.home).pose, self.name)

    def close(self, q: Any, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        return Posture(np.array(q), np.array(q))

    def reach(
        self, target: Any, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        p = self.task.target(target, free).pose.position
        x, y, z = p - self.origin
        radius = np.hypot(x, y)
        if not NEAR * self.size <= radius <= OUT * self.size or abs(z) > UP * self.size:
            raise UnreachableError("outside", target=np.array(p))
        return self.close([np.arctan2(y, x), radius, z])

    def off(self, name: str) -> float:
        return self.by if self.spoil == name else 0.0

    def tool(self, at: Posture, v: Any = None) -> Tool:
        turn, radius, lift = at.q_full
        c, s = np.cos(turn), np.sin(turn)
        jacobian = np.array([[-radius * s, c, 0.0], [radius * c * (1.0 + self.off("lever")), s, 0.0], [0.0, 0.0, 1.0]])
        w, out = (0.0, 0.0) if v is None else (v[0], v[1])
        drift = [-2.0 * out * w * s - radius * w * w * c, 2.0 * out * w * c - radius * w * w * s, 0.0]
        place = np.array([radius * c, radius * s, lift]) + self.origin
        return Tool.of_point(place + self.off("tool") * self.size, jacobian, np.array(drift))

    def terms(self, at: Posture, v: Any = None) -> Terms:
        radius = at.q_full[1]
        inertia = self.mass * radius * radius * (1.0 + self.off("inertia"))
        w, out = (0.0, 0.0) if v is None else (v[0], v[1])
        coriolis = self.mass * np.array([2.0 * radius * out * w * (1.0 + self.off("coriolis")), -radius * w * w, 0.0])
        return Terms(np.diag([inertia, self.mass, self.mass]), coriolis, np.array([0.0, 0.0, 9.81 * self.mass]))

    def potential_energy(self, at: Posture) -> float:
        return 9.81 * self.mass * float(at.q_full[2])

    @property
    def dissipates(self) -> bool:
        return False

    def dissipation(self, at: Posture, v: Any) -> float:
        return 0.0

    def load_effort(self, at: Posture, loads: Any) -> np.ndarray:
        return np.asarray(self.tool(at).frame_jacobian.T @ tool_wrench(as_loads(loads), self.tool(at), self.name))

    def inverse_dynamics(self, at: Posture, v: Any, a: Any, loads: Any = ()) -> np.ndarray:
        terms = self.terms(at, v)
        return np.asarray(terms.mass @ a + terms.coriolis + terms.gravity)

    def forward_dynamics(self, at: Posture, v: Any, effort: Any, loads: Any = ()) -> np.ndarray:
        terms = self.terms(at, v)
        return np.asarray(np.linalg.solve(terms.mass, effort - terms.coriolis - terms.gravity))

    def with_payload(self, mass: float) -> Self:
        return replace(self, mass=self.mass + mass)


class Nameless(Polar):
    """The same without a word on its size."""

    length = None  # type: ignore[assignment]


def compared(robot: Polar, **changes: Any) -> Comparison:
    return compare(replace(robot, **changes), robot, sample_states(robot, 40, 0))


@pytest.mark.parametrize("kind", [Polar, Nameless])
@pytest.mark.parametrize("size", SIZES)
def test_the_box_is_that_of_the_robot_at_every_size(kind: type[Polar], size: float) -> None:
    box = workspace_box(kind(size))
    np.testing.assert_allclose(box.upper / size, [OUT, np.sqrt(OUT**2 - 1.0), UP], rtol=2e-3)
    np.testing.assert_allclose(box.lower / size, [NEAR, -np.sqrt(OUT**2 - 1.0), -UP], rtol=2e-3)


def test_a_robot_that_says_nothing_is_as_long_as_its_levers_or_a_metre() -> None:
    assert length_of(Polar(3.0)) == 3.0
    assert length_of(Nameless(3.0)) == pytest.approx(3.0)
    assert isinstance(Nameless(), Mechanism)


@pytest.mark.parametrize("mass", [1e-6, 1e6])
@pytest.mark.parametrize("size", SIZES)
def test_the_same_postures_are_sampled_at_every_size_and_mass(size: float, mass: float) -> None:
    pairs = zip(sample_states(Polar(size, mass), 60, 3), sample_states(Polar(), 60, 3), strict=True)
    unit = np.array([1.0, size, size])
    for found, wanted in pairs:
        np.testing.assert_allclose(found.position / size, wanted.position, atol=1e-12)
        np.testing.assert_allclose(np.sqrt(size) * found.v / unit, wanted.v, rtol=1e-10)
        np.testing.assert_allclose(size * found.a / unit, wanted.a, rtol=1e-10)
        assert np.abs(found.effort * unit).min() > 0.0


@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("size", SIZES)
def test_what_is_off_is_noticed_at_every_size_and_mass(size: float, mass: float) -> None:
    """One part in 10^8 of the entry that a small or a large robot's other units would hide."""
    robot = Polar(size, mass)
    assert compared(robot).passes
    touched = {
        "lever": {"Jacobian"},
        "inertia": {"mass matrix", "inverse dynamics", "forward dynamics"},
        "coriolis": {"Coriolis C v", "inverse dynamics", "forward dynamics"},
        "tool": {"tool position"},
    }
    for name, rows in touched.items():
        found = compared(robot, spoil=name, by=1e-8)
        assert {row.quantity for row in found.rows if not row.passes} == rows
        assert all(row.error < 1e-5 for row in found.rows)


@pytest.mark.parametrize("size", [1e-2, 1.0, 1e4])
def test_a_tool_beside_its_place_is_noticed_ten_kilometres_from_the_origin(size: float) -> None:
    robot = Polar(size, origin=(1e4, -1e4, 3e3))
    assert compared(robot).passes
    found = compared(robot, spoil="tool", by=1e-7)
    assert [row.quantity for row in found.rows if not row.passes] == ["tool position"]


def test_rounding_far_from_the_origin_is_no_disagreement() -> None:
    """A robot of a centimetre ten kilometres off: 2e-12 m is the last digit of its coordinates."""
    robot = Polar(0.01, origin=(1e4, 0.0, 0.0))
    assert compared(robot, spoil="tool", by=4e-10).passes


@pytest.mark.parametrize("size", SIZES)
def test_coordinates_near_zero_are_measured_against_the_robot(size: float) -> None:
    """Coordinates count from home here, so that there is nothing of their own to measure them against."""

    class FromHome(Polar):
        def close(self, q: Any, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
            return Posture(self.by * np.array([1.0, self.size, self.size]), np.array(q))

    robot = FromHome(size)
    home = robot.tool(robot.home).position
    states = [replace(state, at=robot.home, position=home) for state in sample_states(robot, 3, 0)]
    assert compare(FromHome(size, by=1e-15), robot, states).passes
    found = compare(FromHome(size, by=1e-8), robot, states)
    assert [row.quantity for row in found.rows if not row.passes] == ["actuated coordinates"]
