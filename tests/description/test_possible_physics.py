"""Numbers of joints and cuts that do nothing, or cannot be: in paths, Python and compiled arguments."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from kit.two_bodies import two_bodies

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.description import (
    Bushing,
    CutType,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    RobotDescription,
    check,
    load_description,
    paths,
    value,
    with_values,
)
from cutjoint.errors import DescriptionError, InputError, UnknownNameError
from cutjoint.mechanism.physics import NO_PHYSICS, JointPhysics

JOINT = "left_shoulder"
NO_LIMITS = Limits()
PHYSICS = tuple(one.name for one in fields(JointPhysics))


def fivebar(
    physics: JointPhysics = NO_PHYSICS,
    limits: Limits = NO_LIMITS,
    of_cut: JointPhysics = NO_PHYSICS,
    bushing: Bushing | None = None,
) -> RobotDescription:
    robot = load_description("fivebar")
    joints = tuple(replace(one, physics=physics, limits=limits) if one.name == JOINT else one for one in robot.joints)
    return replace(robot, joints=joints, cuts=(replace(robot.cuts[0], physics=of_cut, bushing=bushing),))


IMPOSSIBLE: dict[str, tuple[dict[str, object], str]] = {
    "negative": ({"physics": JointPhysics(damping=-1.0)}, f"damping of joint '{JOINT}' is -1"),
    "not finite": ({"physics": JointPhysics(friction=np.nan)}, f"friction of joint '{JOINT}' is nan"),
    "no number": ({"physics": JointPhysics(rotor="5")}, f"rotor of joint '{JOINT}' is '5'"),  # type: ignore[arg-type]
    "nothing": ({"physics": JointPhysics(damping=None)}, f"damping of joint '{JOINT}' is None"),  # type: ignore[arg-type]
    "no rest": ({"physics": JointPhysics(stiffness=5.0)}, "has no rest position"),
    "gear": ({"physics": JointPhysics(rotor=1.0, gear=0.0)}, f"gear of joint '{JOINT}' is 0"),
    "limits": ({"physics": JointPhysics(stop_stiffness=1.0), "limits": Limits(1.0, -1.0)}, "upside down"),
    "of a cut": ({"of_cut": JointPhysics(damping=-1.0)}, "damping of cut 'tip' is -1"),
    "rotor of a cut": ({"of_cut": JointPhysics(rotor=1.0)}, "rotor of cut 'tip'"),
    "bushing": ({"bushing": Bushing(-1.0)}, "stiffness of the bushing of cut 'tip' is -1"),
    "both": ({"bushing": Bushing(1.0), "of_cut": JointPhysics(friction=1.0)}, "friction of cut 'tip' beside a bushing"),
}


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_a_chain_of_what_cannot_be_is_refused(case: str) -> None:
    given, told = IMPOSSIBLE[case]
    robot = fivebar(**given)  # type: ignore[arg-type]
    assert any(told in one.found and one.severity == "error" for one in check(robot))
    with pytest.raises(DescriptionError, match=told.replace("'", ".")):
        ClosedChain(robot)


def everything(robot: RobotDescription) -> list[str]:
    """All that a joint or cut might have a path to."""
    return [
        *(f"joints.{joint.name}.{name}" for joint in robot.joints for name in PHYSICS),
        *(f"cuts.{cut.name}.{name}" for cut in robot.cuts for name in PHYSICS),
        *(f"cuts.{cut.name}.bushing.{one.name}" for cut in robot.cuts for one in fields(Bushing)),
    ]


def told(robot: RobotDescription) -> set[str]:
    return {one.found for one in check(robot)}


@pytest.mark.parametrize("limits", [Limits(), Limits(-2.0, 2.0)])
@pytest.mark.parametrize("kind", [*JointType, *CutType, "bushing"])
def test_a_number_that_does_nothing_has_no_path(kind: str, limits: Limits) -> None:
    """A path is there exactly where the check has nothing to say of what it leads to."""
    robot = two_bodies("spherical")
    if isinstance(kind, JointType):
        one = Joint("j", kind, "base", "a", limits=limits if kind.limited else Limits())
        robot = RobotDescription("r", (Link("base"), Link("a", Inertial(1.0))), (one,))
    if isinstance(kind, CutType):
        robot = two_bodies(kind.value)
    if kind == "bushing":
        robot = replace(robot, cuts=(replace(robot.cuts[0], bushing=Bushing(1e3)),))
    known, before = set(paths(robot)), told(robot)
    for joint in robot.joints:
        for name in PHYSICS:
            if name in ("friction_speed", "gear", "stop_damping", "rest"):
                continue  # they go with another one
            given = replace(JointPhysics(), **{name: 0.5}, **({"rest": 0.0} if name == "stiffness" else {}))
            there = tuple(replace(one, physics=given) if one is joint else one for one in robot.joints)
            silent = told(replace(robot, joints=there)) <= before
            assert (f"joints.{joint.name}.{name}" in known) == silent, f"{name} of {joint.type.value}"
    for path in set(everything(robot)) - known:
        with pytest.raises(UnknownNameError):
            value(robot, path)


def test_a_gear_of_nothing_and_paths_that_are_no_text() -> None:
    robot = fivebar()
    with pytest.raises(InputError, match="found 0; 1 without a gear"):
        with_values(robot, {f"joints.{JOINT}.gear": 0.0})
    with pytest.raises(InputError, match="a path is text"):
        with_values(robot, {5: 0.0})  # type: ignore[dict-item]
    with pytest.raises(InputError, match="found None"):
        compiled(ClosedChain(robot), parameters=[None], cached=False)  # type: ignore[list-item]


def test_a_spring_as_an_argument_rests_somewhere() -> None:
    """As a chain whose spring has no rest position is refused, so is one whose spring is an argument."""
    spring, rest = f"joints.{JOINT}.stiffness", f"joints.{JOINT}.rest"
    chain = ClosedChain(fivebar())
    with pytest.raises(InputError, match=f"name {rest} too"):
        compiled(chain, parameters=[spring], cached=False)
    with pytest.raises(DescriptionError, match="no rest position"):
        ClosedChain(with_values(chain.description, {spring: 1.0}))
    compiled(chain, parameters=[spring, rest], cached=False)


def test_stiction_as_an_argument_is_refused() -> None:
    path = f"joints.{JOINT}.friction_speed"
    machine = compiled(ClosedChain(fivebar(JointPhysics(friction=1.0))), parameters=[path], cached=False)
    with pytest.raises(InputError, match="stiction cannot be compiled"):
        machine.with_parameters({path: 0.0})
