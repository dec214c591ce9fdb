"""The tools that try published robots: what they count in a file, hangs and crashes as verdicts, and what they see."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools"
FOUR_BAR = """\
<mujoco>
  <worldbody>
    <body name="crank"><joint name="motor" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.1 0 0.2" size="0.01"/>
      <body name="rod" pos="0.1 0 0.2"><joint name="free" axis="0 1 0" stiffness="0.3" springref="0.2"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0.1" size="0.01"/></body></body>
    <body name="rocker" pos="0.5 0 0"><joint name="passive" axis="0 1 0" damping="0.1" armature="0.001"/>
      <geom type="capsule" fromto="0 0 0 -0.1 0 0.3" size="0.01"/></body>
  </worldbody>
  <equality><connect body1="rod" body2="rocker" anchor="0.3 0 0.1"/><weld body1="rod" body2="rocker" active="false"/>
  </equality>
  <actuator><motor joint="motor"/></actuator>
</mujoco>
"""


@pytest.fixture
def tools(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(TOOLS))
    import corpus

    return corpus


def test_list(tools: ModuleType) -> None:
    text = tools.LIST.read_text(encoding="utf-8")
    robots = tools.entries(text)
    assert len(robots) >= 60
    assert len({one.name for one in robots}) == len(robots)
    assert all(one.commit or one.address.startswith("pypi:") for one in robots)
    assert tomllib.loads(text)["judged"].keys() <= {one.name for one in robots}


def test_contents(tools: ModuleType, tmp_path: Path) -> None:
    from published.contents import closures, contents

    (tmp_path / "bar.xml").write_text(FOUR_BAR)
    found = contents(tmp_path / "bar.xml")
    assert found == {"connect": 1, "inactive": 1, "actuator": 1}
    assert closures(found) == 1
    joints = "".join(f'<joint name="{n}"><parent link="{p}"/><child link="c"/></joint>' for n, p in ("ja", "kb"))
    extra = '<gazebo><joint name="g"/></gazebo><link name="closing_x_1"/><link name="closing_x_2"/><loop_joint/>'
    (tmp_path / "two.urdf").write_text(f'<robot name="r">{joints}{extra}</robot>')
    assert closures(contents(tmp_path / "two.urdf")) == 4
    (tmp_path / "hop.sdf").write_text(
        "<sdf><model><joint type='revolute'><child>world</child></joint><joint type='screw'/></model></sdf>"
    )
    assert closures(contents(tmp_path / "hop.sdf")) == 2


def test_page_tells_what_was_lost(tools: ModuleType) -> None:
    from published.page import page

    robot = {"name": "a", "address": "o/r", "commit": "c" * 40, "path": "a.xml", "format": "MJCF", "verdict": "loads"}
    robot |= {"contents": {"connect": 2}, "closures": 2, "made": 1, "mobility": 1, "velocities": 3}
    robot |= {"read": {"spherical": 1, "couplings": 0, "bushings": 0}, "mujoco": {"rest": 1e-12, "moving": 2e-9}}
    text = page([robot], {}, "nothing")
    assert "2 in the file, 1 made" in text
    assert "| 2 | 1c | 1 of 3 | = |" in text
    assert "2e-03" in page([robot | {"mujoco": {"rest": 2e-3, "moving": 0.0}}], {}, "nothing")


def test_hang_and_crash_are_verdicts(tools: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = tools.Entry("a", "o/r", "", "a.xml")
    assert tools.run(entry, tmp_path)["verdict"] == "not fetched"
    (tmp_path / "o+r").mkdir()
    (tmp_path / "o+r" / "a.xml").write_text(FOUR_BAR)
    monkeypatch.setattr(tools, "SECONDS", 0.05)
    assert tools.run(entry, tmp_path)["verdict"] == "hangs"
    monkeypatch.setattr(tools, "SECONDS", 20.0)
    monkeypatch.setattr(tools.sys, "executable", "/bin/false")
    assert tools.run(entry, tmp_path)["verdict"] == "crashed"


@pytest.mark.slow
def test_peer_sees_a_wrong_number(tools: ModuleType, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    from published.peer import compare, without_friction

    from cutjoint.chain import ClosedChain
    from cutjoint.description import load_description

    path = tmp_path / "bar.xml"
    path.write_text(FOUR_BAR)
    robot = without_friction(load_description(path))
    right = compare(path, ClosedChain(robot))
    assert (right.velocities, right.mobility) == (3, 1)
    assert right.gap < 1e-12
    assert right.pose < 1e-12
    assert right.rest < 1e-10
    assert right.moving < 1e-8
    rod = robot.link("rod").inertial
    assert rod is not None
    heavier = robot.with_inertial("rod", replace(rod, mass=1.001 * rod.mass))
    assert compare(path, ClosedChain(heavier)).rest > 1e-6
    assert compare(path, ClosedChain(replace(robot, cuts=()))).rest > 1e-3
    loose = replace(robot.joint("passive").physics, damping=0.0)
    joints = tuple(replace(one, physics=loose) if one.name == "passive" else one for one in robot.joints)
    assert compare(path, ClosedChain(replace(robot, joints=joints))).moving > 1e-6
