"""Physics that cannot be, or that is not computed: messages say what was found, what was expected, how to mend it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from cutjoint.description import (
    Bushing,
    CutJoint,
    CutType,
    Frame,
    Inertial,
    Joint,
    JointPhysics,
    JointType,
    Limits,
    Link,
    RobotDescription,
    check,
    read_checked,
)
from cutjoint.mechanism.physics import NO_PHYSICS

NO_LIMITS = Limits()


def with_joint(kind: JointType, physics: JointPhysics, limits: Limits = NO_LIMITS) -> RobotDescription:
    joint = Joint("j", kind, "base", "a", limits=limits, physics=physics)
    other = Joint("k", JointType.CONTINUOUS, "base", "b")
    return RobotDescription("r", (Link("base"), Link("a", Inertial(1.0)), Link("b", Inertial(1.0))), (joint, other))


def with_cut(kind: CutType, physics: JointPhysics = NO_PHYSICS, bushing: Bushing | None = None) -> RobotDescription:
    cut = CutJoint("c", kind, Frame("a"), Frame("b"), physics=physics, bushing=bushing)
    return replace(with_joint(JointType.CONTINUOUS, JointPhysics()), cuts=(cut,))


def bad(robot: RobotDescription) -> list[tuple[str, str, str, str]]:
    return [
        (one.severity, one.found, one.expected, one.mend)
        for one in check(robot)
        if "nothing with mass" not in one.found
    ]


NEVER_NEGATIVE = ("damping", "friction", "friction_speed", "stiffness", "rotor", "stop_stiffness", "stop_damping")


@pytest.mark.parametrize("value", [-1.0, -1e-300, math.inf, math.nan])
@pytest.mark.parametrize("key", NEVER_NEGATIVE)
def test_numbers_that_cannot_be(key: str, value: float) -> None:
    given = {"rest": 0.0} if key == "stiffness" else {}
    given |= {"stop_stiffness": 1.0} if key == "stop_damping" else {}
    robot = with_joint(JointType.REVOLUTE, JointPhysics(**(given | {key: value})), Limits(-1.0, 1.0))
    expected = "a number >= 0" if math.isfinite(value) else "a finite number"
    assert bad(robot) == [("error", f"{key} of joint 'j' is {value:g}", expected, "")]
    if not key.startswith(("stop", "rotor")):
        assert bad(with_cut(CutType.REVOLUTE, JointPhysics(**(given | {key: value})))) == [
            ("error", f"{key} of cut 'c' is {value:g}", expected, "")
        ]


@pytest.mark.parametrize(("key", "value"), [("rest", math.nan), ("gear", math.inf), ("gear", 0.0)])
def test_rest_and_gear_may_be_negative_but_numbers(key: str, value: float) -> None:
    given = JointPhysics(stiffness=1.0, rest=-1.0, gear=-2.0)
    assert bad(with_joint(JointType.REVOLUTE, given, Limits(-1.0, 1.0))) == []
    ((severity, found, _, _),) = bad(with_joint(JointType.REVOLUTE, replace(given, **{key: value}), Limits(-1.0, 1.0)))
    assert (severity, found.startswith(f"{key} of joint 'j' is")) == ("error", True)


def test_a_ball_rests_where_it_is_not_turned() -> None:
    for rest in (None, 0.0):
        given = JointPhysics(stiffness=3.0, rest=rest)
        assert bad(with_joint(JointType.SPHERICAL, given)) == []
        assert bad(with_cut(CutType.SPHERICAL, given)) == []


BUILT = {
    "a spring that rests nowhere": (
        with_joint(JointType.CONTINUOUS, JointPhysics(stiffness=3.0)),
        ("error", "the spring of joint 'j' has no rest position", "where the spring is at rest", "[joint.j]"),
    ),
    "a spring of a cut that rests nowhere": (
        with_cut(CutType.REVOLUTE, JointPhysics(stiffness=3.0)),
        ("error", "the spring of cut 'c' has no rest position", "where the spring is at rest", "[[cut]]"),
    ),
    "a rest without a spring": (
        with_joint(JointType.PRISMATIC, JointPhysics(rest=0.1)),
        ("warning", "rest of joint 'j' without a spring", "stiffness", "add stiffness"),
    ),
    "a ball that rests askew": (
        with_joint(JointType.SPHERICAL, JointPhysics(stiffness=3.0, rest=0.1)),
        ("error", "rest of joint 'j' is 0.1", "0: the spring of a ball", "turn"),
    ),
    "a ball cut that rests askew": (
        with_cut(CutType.SPHERICAL, JointPhysics(stiffness=3.0, rest=0.1)),
        ("error", "rest of cut 'c' is 0.1", "0: the spring of a ball", "turn"),
    ),
    "a fixed joint with a damper": (
        with_joint(JointType.FIXED, JointPhysics(damping=1.0, gear=2.0)),
        ("warning", "damping, gear of the fixed joint 'j' without effect", "moves", "remove"),
    ),
    "a fixed cut with a damper": (
        with_cut(CutType.FIXED, JointPhysics(damping=1.0)),
        ("warning", "damping of the fixed cut 'c' without effect", "motion free", "remove"),
    ),
    "a floating joint with a spring": (
        with_joint(JointType.FLOATING, JointPhysics(damping=1.0, stiffness=1.0, rest=0.0)),
        ("error", "stiffness of the floating joint 'j'", "damping only", "one coordinate"),
    ),
    "a planar joint with friction and a rotor": (
        with_joint(JointType.PLANAR, JointPhysics(friction=1.0, rotor=1.0)),
        ("error", "friction and rotor of the planar joint 'j'", "damping only", "one coordinate"),
    ),
    "stops without limits": (
        with_joint(JointType.CONTINUOUS, JointPhysics(stop_stiffness=1.0)),
        ("warning", "stop_stiffness of joint 'j', which has no limits", "limits", "give it limits"),
    ),
    "a stop that only damps": (
        with_joint(JointType.PRISMATIC, JointPhysics(stop_damping=1.0), Limits(0.0, 1.0)),
        ("warning", "stop_damping of joint 'j' without stop_stiffness", "both", "add stop_stiffness"),
    ),
    "a motor in a cut": (
        with_cut(CutType.REVOLUTE, JointPhysics(rotor=1.0, gear=3.0)),
        ("error", "rotor and gear of cut 'c'", "damping, friction and a spring only", "in the tree"),
    ),
    "a bushing that holds nothing": (
        with_cut(CutType.SPHERICAL, bushing=Bushing(0.0)),
        ("error", "stiffness of the bushing of cut 'c' is 0", "a number > 0", "remove the cut"),
    ),
    "a bushing that pushes": (
        with_cut(CutType.SPHERICAL, bushing=Bushing(-2.0)),
        ("error", "stiffness of the bushing of cut 'c' is -2", "a number >= 0", ""),
    ),
    "a bushing that drives": (
        with_cut(CutType.FIXED, bushing=Bushing(2.0, 0.0, 1.0, -1.0)),
        ("error", "turning_damping of the bushing of cut 'c' is -1", "a number >= 0", ""),
    ),
    "a bushing that lets turn": (
        with_cut(CutType.REVOLUTE, bushing=Bushing(2.0)),
        ("warning", "the bushing of cut 'c' lets it turn freely", "a turning_stiffness", "spherical"),
    ),
    "a bushing of a ball that holds turns": (
        with_cut(CutType.SPHERICAL, bushing=Bushing(2.0, 0.0, 1.0)),
        ("warning", "turning_stiffness or turning_damping of the bushing", "holds angles", "remove"),
    ),
}


@pytest.mark.parametrize("name", BUILT)
def test_what_is_wrong_with_a_description(name: str) -> None:
    robot, (severity, found, expected, mend) = BUILT[name]
    ((is_severity, is_found, is_expected, is_mend),) = bad(robot)
    assert (is_severity, is_found.startswith(found), expected in is_expected, mend in is_mend) == (
        severity,
        True,
        True,
        True,
    )


TOML = {
    "a key of a joint": ("[joint.crank_turn]\ndampng = 1.0", "unknown key 'dampng'", "did you mean 'damping'?"),
    "a number of a joint": ('[joint.crank_turn]\nfriction = "1"', "friction of [joint.crank_turn] is '1'", ""),
    "a joint": (
        "[joint.crank_trun]\nfriction = 1.0",
        "[joint.crank_trun] is for a joint that the tree",
        "'crank_turn'",
    ),
    "a spring": ("[joint.crank_turn]\nstiffness = 1.0", "the spring of joint 'crank_turn' has no rest", "add rest"),
    "a sign": ("[joint.crank_turn]\ndamping = -1", "damping of joint 'crank_turn' is -1", ""),
    "a gear": ("[joint.crank_turn]\nrotor = 1\ngear = 0", "gear of joint 'crank_turn' is 0", "1 without a gear"),
    "a bushing's key": (
        '[[cut]]\nname = "x"\ntype = "spherical"\nframes = ["crank", "rocker"]\nbushing = { stifness = 1.0 }',
        "unknown key 'stifness'",
        "'stiffness'",
    ),
    "a bushing": (
        '[[cut]]\nname = "x"\ntype = "spherical"\nframes = ["crank", "rocker"]\nbushing = 3.0',
        "bushing of [[cut]] 2 is 3.0",
        "",
    ),
    "a rotor of a cut": (
        '[[cut]]\nname = "x"\ntype = "spherical"\nframes = ["crank", "rocker"]\nrotor = 3.0',
        "unknown key 'rotor'",
        "",
    ),
}


@pytest.mark.parametrize("name", TOML)
def test_what_is_wrong_in_a_loops_toml(name: str, fourbar) -> None:
    text, found, mend = TOML[name]
    reading = read_checked(fourbar(loops=[("[home.default]", f"{text}\n\n[home.default]")]))
    assert reading.description is None
    assert any(one.found.startswith(found) and mend in one.mend for one in reading.problems), reading.problems


STICKY = JointPhysics(friction=1.0, friction_speed=0.0)


def test_only_angles_and_travels_of_joints_stick() -> None:
    for kind in (JointType.REVOLUTE, JointType.PRISMATIC, JointType.UNIVERSAL):
        assert bad(with_joint(kind, STICKY)) == []
    cuts = (CutType.REVOLUTE, CutType.PRISMATIC, CutType.UNIVERSAL, CutType.SPHERICAL)
    for robot in (with_joint(JointType.SPHERICAL, STICKY), *(with_cut(kind, STICKY) for kind in cuts)):
        ((severity, found, _, _),) = bad(robot)
        assert severity == "error"
        assert "stiction" in found
