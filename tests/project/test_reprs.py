"""Every public class shows itself: in one line or a table, with units, whatever its names are."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest
from kit.instances import quick_seeds, slow_seeds, walked
from kit.public import public_classes

import cutjoint
from cutjoint import control, motion
from cutjoint.chain import Modes, Reactions
from cutjoint.crosscheck import Comparison
from cutjoint.mechanism import Posture
from cutjoint.reprs import WIDTH, line, one_line, short

TABLES = (Posture, Reactions)
"""What shows itself in lines one below the other."""
UNIT = re.compile(r"\b(m|rad|s|N|kg|Hz|J|W|m2|m3|s2)\b")
NO_UNITS = (
    *("GearForce", "Linearisation", "Derivatives", "Loaded", "Options", "ComparisonRow", "Comparison", "Modes"),
    *("Stored", "Place", "CpmState", "Branch", "MobilityReport", "Kernel", "Program", "CompiledFunction", "Frame"),
    *("Panel", "Link", "DormandPrince", "Adaptive", "Differences", "RobotDescription", "CpmModel"),
    *("InferredCpmModel", "CpmRotaryModel", "JointPhysics", "Elastic", "ClosedLoop", "Batch", "Section"),
    *("TextTable", "Drawing", "Format", "Made", "Problem", "LiveView", "Bridge", "ChainBatch", "PaperBatch"),
    *("Coupling", "CutJoint", "Joint", "Variant", "Document", "Gain", "StudySummary", "BlockPlan", "PathEffect"),
    *(
        "LimitRows",
        "LinearLaw",
        "GainSearch",
        "Tuning",
        "SynthesisOrder",
        "Design",
        "Variable",
        "Contribution",
        "Cause",
    ),
    *("MotorFit", "Gearing", "Workspace", "FittedShape"),
)
"""Classes whose numbers are counts, or without a unit."""
HOSTILE = "a\n<script>alert(1)</script> [bold]\x1b[31m" + 1000 * "x"


@cache
def _found() -> dict[type, object]:
    return walked(quick_seeds())


def _look(one: object, *, units: bool = True) -> None:
    text = repr(one)
    assert " at 0x" not in text
    assert "array([" not in text
    assert all(len(row) <= WIDTH for row in text.splitlines()), text
    assert "\x1b" not in text
    if not isinstance(one, TABLES):
        assert "\n" not in text, text
        assert text.startswith(type(one).__name__) or "<" in text[:1], text
    if units and type(one).__name__ not in NO_UNITS and re.search(r"[=(]-?\d", text):
        assert UNIT.search(text), text


def test_what_users_meet_first() -> None:
    robot = cutjoint.load("fivebar")
    assert repr(robot).startswith(
        "ClosedChain('fivebar', actuators=('left_shoulder [rad]', 'right_shoulder [rad]'), 1 cut"
    )
    assert repr(motion.Hold([0.0, 0.0, 1.0], 2.0)) == "Hold(position=(0, 0, 1) m, duration=2 s, name='hold')"
    assert repr(control.PD(10.0, [1.0, 2.0])) == "PD(kp=10 N/m or N m/rad, kd=(1, 2) N s/m or N m s/rad)"
    told = str(robot.mobility())
    assert re.search(r"^mobility +2$", told, re.MULTILINE)
    assert "they determine the motion" in told
    assert all(len(row) <= 80 for row in told.splitlines())
    html = robot._repr_html_()
    assert all(f"<td>{name}</td>" in html for name in ("actuators", "cuts", "task"))
    assert "tip (revolute)" in html


@pytest.mark.slow
def test_every_public_class_shows_itself() -> None:
    found = {**walked(slow_seeds()), **_found()}
    missing = [
        one.__name__
        for one in public_classes()
        if one not in found and not any(issubclass(kind, one) for kind in found)
    ]
    assert missing == [], "give tests/kit/instances.py an object of them"
    for kind in public_classes() & found.keys():
        _look(found[kind])


@pytest.mark.slow
def test_hostile_names_do_no_harm() -> None:
    tried = 0
    for one in _found().values():
        if not is_dataclass(one):
            continue
        texts = {field.name: HOSTILE for field in fields(one) if field.init and field.type == "str"}
        try:
            made = replace(one, **texts)  # type: ignore[type-var]
        except cutjoint.CutjointError:
            continue
        if texts and type(one) in public_classes():
            _look(made, units=False)
            tried += 1
    assert tried > 15


def _hostile() -> Iterator[object]:
    robot = cutjoint.load("fivebar")
    link = replace(robot.description.links[0], name=robot.description.links[0].name)
    joints = tuple(replace(one, name=f"{one.name} {HOSTILE}") for one in robot.description.joints)
    names = {one.name: other.name for one, other in zip(robot.description.joints, joints, strict=True)}
    homes = tuple(
        replace(
            one,
            actuated={names[name]: value for name, value in one.actuated.items()},
            passive={names[name]: value for name, value in one.passive.items()},
        )
        for one in robot.description.homes
    )
    made = cutjoint.ClosedChain(
        replace(
            robot.description,
            name=HOSTILE,
            title=HOSTILE,
            links=(link, *robot.description.links[1:]),
            joints=joints,
            actuators=tuple(names[name] for name in robot.description.actuators),
            homes=homes,
        )
    )
    yield from (
        made,
        made.description,
        made.home,
        made.mobility(),
        made.reactions(made.home),
        made.minimal(),
        made.task,
    )
    yield from (made.working_modes(starts=3), motion.Reference(motion.Hold.at_home(made, 1.0), made))
    yield Comparison(HOSTILE, HOSTILE, 1, (), 1, HOSTILE)


def test_a_robot_of_hostile_names() -> None:
    tables = 0
    for one in _hostile():
        _look(one, units=False)
        if hasattr(one, "_repr_html_"):
            html = one._repr_html_()
            assert "<script" not in html
            assert "\n" not in html.replace(">\n", ">")
            tables += 1
    assert tables >= 5


def test_what_is_long_is_cut() -> None:
    assert short(np.arange(10.0), "m") == "(0, 1, 2, 3, 4, 5, ... 10 in all) m"
    assert short(np.array([1.0, 1e-17])) == "(1, 0)"
    assert short(np.eye(3)) == "array (3, 3)"
    assert len(short(1000 * "x")) < 50
    assert short({f"name{k}": 1.0 for k in range(9)}).endswith("... 9 in all}")
    assert len(one_line("Head", [50 * "a", 60 * "b", "c"])) <= WIDTH
    assert one_line("Head", [50 * "a", 60 * "b", "c"]).endswith("c, ...)")


def test_nothing_that_is_looked_at_raises() -> None:
    class Sour:
        @property
        def name(self) -> str:
            raise ValueError("not today")

        first = property(lambda self: 1 / 0)
        __repr__ = line("name", "first")

    assert short(Sour()) == "Sour"
    assert repr(Sour()) == "Sour()"


@pytest.mark.parametrize(
    "make", [lambda robot: robot.working_modes(starts=3), lambda robot: robot.reactions(robot.home)]
)
def test_tables_have_a_row_each(make: Callable[[cutjoint.ClosedChain], Modes | Reactions]) -> None:
    made = make(cutjoint.load("fivebar"))
    assert len(made.table().rows) == len(list(made))
    assert all("[" in column for column in made.table().columns[1:-1])
