"""Joint physics of URDF, its dialects, and SDF: what each element means, and what is told of what is not used."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import JointPhysics, JointType, read_checked
from cutjoint.mechanism.physics import NO_PHYSICS

LINK = (
    '<link name="{name}"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
DRAKE = 'xmlns:drake="http://drake.mit.edu"'


def urdf(dynamics: str = "", more: str = "", attributes: str = "", kind: str = "continuous") -> str:
    joint = f'<joint name="j" type="{kind}"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>{dynamics}</joint>'
    other = '<joint name="k" type="continuous"><parent link="base"/><child link="b"/><axis xyz="0 1 0"/></joint>'
    links = '<link name="base"/>' + LINK.format(name="a") + LINK.format(name="b")
    return f'<robot name="r" {attributes}>{links}{joint}{other}{more}</robot>'


def sdf(dynamics: str = "", limit: str = "", kind: str = "revolute", second: str = "", more: str = "") -> str:
    inertial = "<inertial><mass>1</mass></inertial>"
    axis = f"<axis><xyz>0 1 0</xyz><limit>{limit}</limit><dynamics>{dynamics}</dynamics></axis>"
    return (
        f'<sdf version="1.7"><model name="m"><link name="base">{inertial}</link>'
        '<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>'
        f'<link name="a">{inertial}</link><link name="b">{inertial}</link>'
        f'<joint name="j" type="{kind}"><parent>base</parent><child>a</child>{axis}{second}</joint>'
        f'<joint name="k" type="revolute"><parent>base</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint>'
        f"{more}</model></sdf>"
    )


@pytest.fixture
def reading(tmp_path: Path):
    def make(text: str, loops: str = ""):
        path = tmp_path / ("model.sdf" if text.startswith("<sdf") else "robot.urdf")
        path.write_text(text, encoding="utf-8")
        if loops:
            path = tmp_path / "loops.toml"
            path.write_text(f'schema = 1\nurdf = "robot.urdf"\nactuators = ["j"]\n{loops}', encoding="utf-8")
        return read_checked(path)

    return make


def physics_of(one, name: str = "j") -> JointPhysics:
    assert one.description is not None, [str(problem) for problem in one.problems]
    return one.description.joint(name).physics


SAID = {
    '<dynamics damping="5" friction="2"/>': JointPhysics(damping=5.0, friction=2.0),
    '<dynamics armature="0.4"/>': JointPhysics(rotor=0.4),
    '<dynamics stiffness="30" rest="0.2"/>': JointPhysics(stiffness=30.0, rest=0.2),
    '<dynamics stiffness="30" springref="-1"/>': JointPhysics(stiffness=30.0, rest=-1.0),
    '<dynamics stiffness="30" spring_reference="0"/>': JointPhysics(stiffness=30.0, rest=0.0),
    '<dynamics friction="2" friction_speed="0"/>': JointPhysics(friction=2.0, friction_speed=0.0),
    '<dynamics damping="1e9"/>': JointPhysics(damping=1e9),
}


@pytest.mark.parametrize("dynamics", SAID)
def test_dynamics_of_a_urdf(dynamics: str, reading) -> None:
    found = reading(urdf(dynamics))
    assert physics_of(found) == SAID[dynamics]
    assert physics_of(found, "k") == NO_PHYSICS
    assert found.problems == ()


def test_a_spring_that_rests_nowhere_is_told_and_left_out(reading) -> None:
    found = reading(urdf('<dynamics damping="5" stiffness="30"/>'))
    assert physics_of(found) == JointPhysics(damping=5.0)
    (problem,) = found.problems
    assert (problem.severity, problem.line) == ("warning", 1)
    assert "stiffness 30 of joint 'j' is not used" in problem.found
    assert "[joint.j]" in problem.mend


@pytest.mark.parametrize("key", list(asdict(NO_PHYSICS)))
def test_a_loops_toml_changes_single_values(key: str, reading) -> None:
    """What it gives is what it says; all else stays what the tree's own file says."""
    dynamics = (
        '<limit lower="-1" upper="1"/><dynamics damping="5" friction="2" stiffness="30" rest="0.2" armature="0.4"/>'
    )
    before = physics_of(reading(urdf(dynamics, kind="revolute")))
    after = physics_of(reading(urdf(dynamics, kind="revolute"), f"[joint.j]\n{key} = 7.5\n"))
    assert asdict(after) == asdict(before) | {key: 7.5}


def test_a_loops_toml_says_where_the_spring_of_a_urdf_rests(reading) -> None:
    found = reading(urdf('<dynamics stiffness="30"/>'), "[joint.j]\nrest = 0.5\n")
    assert physics_of(found) == JointPhysics(stiffness=30.0, rest=0.5)
    assert found.problems == ()


def actuator(inside: str, joint: str = '<joint name="j"/>') -> str:
    return f'<transmission name="t">{joint}<actuator name="m">{inside}</actuator></transmission>'


MOTORS = {
    actuator("<mechanicalReduction>50</mechanicalReduction>"): (0.0, 50.0),
    actuator("", '<joint name="j"><mechanicalReduction>-7</mechanicalReduction></joint>'): (0.0, -7.0),
    actuator("<mechanicalReduction>50</mechanicalReduction><rotorInertia>0.1</rotorInertia>"): (0.1, 50.0),
    actuator('<drake:gear_ratio value="20"/><drake:rotor_inertia value="0.3"/>'): (0.3, 20.0),
    actuator('<drake:rotor_inertia value="0.3"/>'): (0.3, 1.0),
    f'<ros2_control name="c">{actuator("<mechanical_reduction>9</mechanical_reduction>")}</ros2_control>': (0.0, 9.0),
    actuator(
        "<mechanicalReduction>5</mechanicalReduction>",
        '<joint name="j"><mechanicalReduction>5</mechanicalReduction></joint>',
    ): (0.0, 5.0),
}


@pytest.mark.parametrize("attributes", [DRAKE, ""])
@pytest.mark.parametrize("transmission", MOTORS)
def test_transmissions(transmission: str, attributes: str, reading) -> None:
    """With the namespace of Drake declared, and with a prefix that nobody declared."""
    found = reading(urdf('<dynamics damping="1"/>', transmission, attributes))
    rotor, gear = MOTORS[transmission]
    assert physics_of(found) == JointPhysics(damping=1.0, rotor=rotor, gear=gear)
    assert found.problems == ()


@pytest.mark.parametrize("gear", [1e-3, 50.0, -3.0])
def test_an_armature_stays_what_it_is_at_the_joint(gear: float, reading) -> None:
    reduction = actuator(f"<mechanicalReduction>{gear}</mechanicalReduction>")
    physics = physics_of(reading(urdf('<dynamics armature="0.4"/>', reduction)))
    assert physics.gear == gear
    assert physics.armature == pytest.approx(0.4, rel=1e-15)


REFUSED = {
    "two reductions": (
        actuator("<mechanicalReduction>5</mechanicalReduction><mechanicalReduction>6</mechanicalReduction>"),
        "reduction of <transmission> 't' is 5 and 6",
    ),
    "no number": (
        actuator("<mechanicalReduction>five</mechanicalReduction>"),
        "reduction of <transmission> 't': 'five'",
    ),
    "a gear of nothing": (actuator("<mechanicalReduction>0</mechanicalReduction>"), "gear of joint 'j' is 0"),
    "a negative rotor": (actuator("<rotorInertia>-1</rotorInertia>"), "rotor of joint 'j' is -1"),
    "two motors": (
        2 * actuator("<mechanicalReduction>5</mechanicalReduction>"),
        "joint 'j' with a second reduction",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_transmissions_that_cannot_be(name: str, reading) -> None:
    more, found = REFUSED[name]
    problems = reading(urdf("", more)).problems
    assert any(one.severity == "error" and one.found.startswith(found) for one in problems), problems


def test_an_armature_and_a_rotor_are_one_too_many(reading) -> None:
    problems = reading(urdf('<dynamics armature="0.4"/>', actuator("<rotorInertia>1</rotorInertia>"))).problems
    assert any("with an armature and with the rotor inertia" in one.found for one in problems)


@pytest.mark.parametrize(
    ("joints", "found"),
    [
        (
            '<joint name="j"/><joint name="k"/>',
            "reduction and rotor of <transmission> 't' are not used: it drives j, k",
        ),
        ('<joint name="jj"/>', "<transmission> 't' names the unknown joint 'jj'"),
    ],
)
def test_transmissions_that_are_not_used(joints: str, found: str, reading) -> None:
    one = reading(urdf("", actuator("<mechanicalReduction>5</mechanicalReduction>", joints)))
    assert physics_of(one) == NO_PHYSICS
    assert [(problem.severity, problem.found) for problem in one.problems] == [("warning", found)]


LOOP = (
    '<{tag} name="c" type="revolute"><predecessor link="a"/><successor link="b"/><axis xyz="0 1 0"/>'
    '<dynamics damping="3" stiffness="2" rest="0.1"/></{tag}>'
)
CONSTRAINT = (
    '<constraint name="c" type="revolute"><parent link="a"/><child link="b"/><parent_axis xyz="0 1 0"/>'
    '<dynamics damping="3" stiffness="2" rest="0.1"/></constraint>'
)


@pytest.mark.parametrize("loop", [LOOP.format(tag="loop"), CONSTRAINT])
def test_loops_have_dynamics(loop: str, reading) -> None:
    (cut,) = reading(urdf("", loop)).description.cuts
    assert cut.physics == JointPhysics(damping=3.0, stiffness=2.0, rest=0.1)


SPRING = "<spring_stiffness>30</spring_stiffness>"
SDF = {
    ("<damping>5</damping><friction>2</friction>", ""): JointPhysics(damping=5.0, friction=2.0),
    (SPRING, ""): JointPhysics(stiffness=30.0, rest=0.0),
    (f"{SPRING}<spring_reference>0.3</spring_reference>", ""): JointPhysics(stiffness=30.0, rest=0.3),
    ("<spring_reference>0.3</spring_reference>", ""): NO_PHYSICS,
    ("", "<stiffness>1e5</stiffness>"): JointPhysics(stop_stiffness=1e5, stop_damping=1.0),
    ("", "<stiffness>1e5</stiffness><dissipation>4</dissipation>"): JointPhysics(stop_stiffness=1e5, stop_damping=4.0),
    ("", "<stiffness>1e8</stiffness><dissipation>4</dissipation>"): NO_PHYSICS,
    ("", "<dissipation>4</dissipation>"): NO_PHYSICS,
    ("", "<stiffness>0</stiffness>"): NO_PHYSICS,
}


@pytest.mark.parametrize("given", SDF)
def test_an_axis_of_sdf(given: tuple[str, str], reading) -> None:
    dynamics, limit = given
    found = reading(sdf(dynamics, f"<lower>-1</lower><upper>1</upper>{limit}"))
    assert physics_of(found) == SDF[given]
    assert found.problems == ()


def second(dynamics: str) -> str:
    return f"<axis2><xyz>1 0 0</xyz><dynamics>{dynamics}</dynamics></axis2>"


def test_a_universal_joint_with_unlike_axes_is_two_hinges(reading) -> None:
    same = reading(sdf("<damping>5</damping>", "", "universal", second("<damping>5</damping>")))
    assert physics_of(same) == JointPhysics(damping=5.0)
    for other in ("", "<damping>4</damping>"):
        found = reading(sdf("<damping>5</damping>", "", "universal", second(other)))
        assert physics_of(found) == JointPhysics(damping=5.0)
        assert physics_of(found, "j/2") == JointPhysics(damping=4.0 if other else 0.0)
        assert {found.description.joint(name).type for name in ("j", "j/2")} == {JointType.REVOLUTE}


def test_a_ball_of_sdf_has_no_axis(reading) -> None:
    found = reading(sdf("<damping>5</damping>", "", "ball"))
    assert physics_of(found) == NO_PHYSICS
    assert [one.severity for one in found.problems] == ["warning"]


@pytest.mark.parametrize("stop", ["", "<lower>-1</lower><upper>1</upper><stiffness>1e5</stiffness>"])
def test_a_joint_of_sdf_that_closes_a_loop_keeps_its_dampers(stop: str, reading) -> None:
    dynamics = f"<damping>3</damping>{SPRING}"
    loop = (
        '<joint name="c" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz>'
        f"<limit>{stop}</limit><dynamics>{dynamics}</dynamics></axis></joint>"
    )
    found = reading(sdf(more=loop))
    (cut,) = found.description.cuts
    assert cut.physics == JointPhysics(damping=3.0, stiffness=30.0, rest=0.0)
    assert [one.found for one in found.problems] == (
        [f"{what} of joint 'c', which closes a loop, are not used" for what in ("limits", "stops or rotor") if stop]
    )


CASES = Path(__file__).parent / "samples"


@pytest.mark.parametrize("angle", [-0.7, 0.0, 1.1])
def test_a_spring_of_sdf_pulls_back_to_its_reference_whichever_way_the_joint_is_used(angle: float, reading) -> None:
    """A joint that is turned round to reach its link keeps its coordinate, so its rest position as well."""
    from cutjoint.chain import ClosedChain

    dynamics = f"{SPRING}<spring_reference>0.3</spring_reference>"
    for text in (
        sdf(dynamics),
        sdf(dynamics).replace("<parent>base</parent><child>a", "<parent>a</parent><child>base"),
    ):
        robot = reading(text).description
        chain = ClosedChain(robot)
        joint = next(one for one in robot.joints if one.name == "j")
        assert joint.type is JointType.CONTINUOUS or joint.type is JointType.REVOLUTE
        q = np.array(chain.neutral.q_full if hasattr(chain.neutral, "q_full") else chain.neutral)
        q[chain.model.idx_qs[chain.model.getJointId("j")]] = angle
        assert chain.spring_energy(q) == pytest.approx(15.0 * (angle - 0.3) ** 2, rel=1e-12)
