"""Wrong objects are refused at the door: by one error of cutjoint's own, which says what was wanted."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from kit.doors import GROUPS, Door, fivebar, odd_values, reference

import cutjoint
from cutjoint import control, motion, simulation
from cutjoint.doors import door, door_but
from cutjoint.errors import CutjointError, InputError

MEANT: dict[str, str] = {
    "number": "kp kd ki limits resolution noise delay offset duration rate every radius tick mass x y z ramp turns "
    "width amplitude low high hertz seconds height furthest t rated peak max_speed rotor inertia pitch brake_factor "
    "ambient brake constant knee_speed rated_speed resistance thermal_resistance max_temperature payload "
    "tool_speed tool_acceleration condition expansion",
    "negative": "offset rate x y z turns amplitude after t ambient expansion",
    "list": "parameters states kp kd ki lock loads names given joints motors ratios",
    "dict": "ranges stiffness loads",
    "texts": "parameters names given",
    "text": "name robot link",
    "flag": "lenient quick fast cached free keep_actuators limbs closed project bearings exact",
    "class": "report progress efforts",
    "function": "report progress given efforts",
    "chain": "model mechanism checked reference robot chain",
    "description": "robot description",
    "trajectory": "trajectory",
    "reference": "reference references",
    "law": "law given",
    "result": "result",
}
"""Odd values -> the arguments where they mean something."""
OPTIONAL = (
    "a angular_acceleration angular_velocity at backlash duration effort every given hardware hold home brake "
    "constant gearing integrator knee_speed law limits link loads names max_temperature near pitch progress "
    "ranges rate reference report resolution rated_speed resistance rotation start springs start_velocity stiffness "
    "thermal_resistance tick torque_speed turn_speed turn_acceleration v variant"
)
"""Arguments that may be None."""


def _complete(one: Door) -> Door:
    """With the defaults of all other arguments."""
    try:
        parameters = inspect.signature(one.call).parameters
    except (TypeError, ValueError):
        return one
    plain = (bool, int, float, str, tuple, type(None))
    rest = {name: p.default for name, p in parameters.items() if type(p.default) in plain and name not in one.usual}
    return one if any(name.isdigit() for name in one.usual) else Door(one.name, one.call, {**one.usual, **rest})


def _call(one: Door, **other: object) -> object:
    given = {**one.usual, **other}
    return one.call(
        *(x for name, x in given.items() if name.isdigit()), **{k: x for k, x in given.items() if not k.isdigit()}
    )


def _wrong(one: Door) -> list[str]:
    """What a door lets in that it should not, or lets fall on its nose behind."""
    _call(one)
    tried = ((name, what, value) for name in one.usual for what, value in odd_values().items())
    return [
        f"{one.name}({name}={what}) {why}"
        for name, what, value in tried
        # what a user's own function raises is its own
        if not (name in ("progress", "report", "loads") and callable(value)) and (why := _why(one, name, what, value))
    ]


def _why(one: Door, name: str, what: str, value: object) -> str:
    """Why an odd value in place of one argument went wrong; empty where it did not."""
    try:
        _call(one, **{name: value})
    except CutjointError as error:
        return "" if str(error) else "is refused without a word"
    except Exception as error:  # whatever falls on its nose
        return f"falls on its nose: {type(error).__name__}: {error}"
    meant = OPTIONAL if what == "None" else MEANT.get(what, "")
    return "" if name in meant.split() else "is taken"


@pytest.mark.parametrize("group", ["control"])
def test_some_doors(group: str, tmp_path: Path) -> None:
    tried = list(GROUPS[group](tmp_path))
    assert len(tried) > 5
    assert [line for one in tried for line in _wrong(_complete(one))] == []


@pytest.mark.slow
@pytest.mark.parametrize("group", sorted(GROUPS.keys() - {"control"}))
def test_all_doors(group: str, tmp_path: Path) -> None:
    assert [line for one in GROUPS[group](tmp_path) for line in _wrong(_complete(one))] == []


@door
def _mixed(
    size: float, count: int = 1, *more: float, names: tuple[str, ...] = (), at: cutjoint.Posture | None = None
) -> float:
    return size * count + sum(more)


@pytest.mark.parametrize("size", [1, 1.5, np.float32(2.0), np.int64(3), Fraction(1, 3), np.array(2.0)])
def test_numbers_of_any_kind_are_numbers(size: float) -> None:
    assert _mixed(size) == pytest.approx(float(size))


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: _mixed("1"), r"size of _mixed must be a number, found the text '1'"),
        (lambda: _mixed(True), r"size of _mixed must be a number, found True"),
        (lambda: _mixed(1.0, 2.0), r"count of _mixed must be a whole number, found the number 2.0"),
        (lambda: _mixed(1.0, 2, 3.0, None), r"more of _mixed must be a number, found None"),
        (lambda: _mixed(1.0, names="ab"), r"names of _mixed must be a list of texts, found the text 'ab' \(put it"),
        (
            lambda: _mixed(1.0, at=[0.1]),
            r"at of _mixed must be a Posture or None, found the number 0.1 in a list \(close",
        ),
    ],
)
def test_a_refusal_says_what_was_found_and_wanted(call: Callable[[], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        call()


def test_usual_mistakes_are_told_how_to_mend_them() -> None:
    robot, hold, law = fivebar(), motion.Hold.at_home(fivebar(), 1.0), control.NoControl()
    for mend, call in {
        r"Reference\(trajectory, robot\)": lambda: simulation.run(robot, law, hold),
        r"its .trajectory is one": lambda: motion.Reference(reference(), robot),
        r"cutjoint.load": lambda: motion.Reference(hold, "fivebar"),
        r"ClosedChain\(description\)": lambda: simulation.run(robot.description, law, reference()),
        r"simulation.load": lambda: simulation.save("run.npz", "run.npz"),
        r"MinimalPlant": lambda: simulation.run(robot.minimal(), duration=0.1),
    }.items():
        with pytest.raises(InputError, match=mend):
            call()


def test_a_law_that_lacks_something_is_told_what() -> None:
    class Nameless:
        gains: dict[str, list[list[float]]] = {}  # noqa: RUF012

        def memory(self, n: int) -> int:
            return 0

        def effort(self, *given: object) -> list[float]:
            return [0.0, 0.0]

        memory_rate = effort

    with pytest.raises(InputError, match="a Nameless, which as a Law lacks name"):
        simulation.run(fivebar(), Nameless(), reference(), duration=0.01)


def test_what_is_left_to_the_function_is_not_looked_at() -> None:
    @door_but("size")
    def taken(size: float, count: int) -> object:
        return size

    assert taken("any", 1) == "any"
    with pytest.raises(InputError, match="count of taken"):
        taken("any", "one")


def test_a_class_keeps_what_it_is() -> None:
    assert inspect.signature(motion.Hold).parameters.keys() == {"position", "duration", "name"}
    assert str(motion.Hold.__doc__).startswith("The tool stays")
    assert simulation.run.__name__ == "run"
    assert isinstance(motion.Trapezoidal(np.zeros(3), np.ones(3)), motion.PointToPoint)


def test_a_protocol_is_not_asked_for_its_properties() -> None:
    class Dear:
        name = "dear"
        duration = 1.0

        @property
        def at(self) -> object:
            raise AssertionError("a door asks for what it need not know")

    @door
    def follow(trajectory: motion.Trajectory) -> str:
        return trajectory.name

    assert follow(Dear()) == "dear"


def test_iterators_are_not_used_up() -> None:
    @door
    def total(numbers: Iterator[float]) -> float:
        return sum(numbers)

    assert total(iter([1.0, 2.0])) == 3.0
