"""Screws of SDF, of Drake and in `<gazebo>`: a body on a thread falls as one degree of freedom does."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from kit.sdf_text import model

from cutjoint.chain import ClosedChain
from cutjoint.description import read_checked

MASS, SPIN, GRAVITY = 2.0, 0.003, 9.81
INERTIA = {"ixx": 0.01, "iyy": 0.01, "izz": SPIN, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
IN_SDF = "".join(f"<{key}>{value}</{key}>" for key, value in INERTIA.items())
MOMENTS = " ".join(f'{key}="{value}"' for key, value in INERTIA.items())
IN_URDF = f'<inertial><mass value="{MASS}"/><inertia {MOMENTS}/></inertial>'
ENDS = '<parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>'


def in_sdf(pitch: str, version: str = "1.10") -> str:
    body = f'<link name="b"><inertial><mass>{MASS}</mass><inertia>{IN_SDF}</inertia></inertial></link>'
    ends = "<parent>world</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>"
    return model(f'{body}<joint name="s" type="screw">{ends}{pitch}</joint>', version=version)


def in_urdf(joints: str, links: str = "") -> str:
    body = f'<link name="o"/><link name="b">{IN_URDF}</link>{links}'
    return f'<robot name="r" xmlns:drake="http://drake.mit.edu">{body}{joints}</robot>'


def of_drake(pitch: float) -> str:
    own = f'<drake:screw_thread_pitch value="{pitch}"/>'
    return in_urdf(f'<drake:joint name="s" type="screw">{ENDS.format("o", "b")}{own}</drake:joint>')


def in_gazebo(pitch: str) -> str:
    tree = f'<joint name="up" type="prismatic">{ENDS.format("o", "a")}<limit lower="-1" upper="1"/></joint>'
    tree += f'<joint name="s" type="continuous">{ENDS.format("a", "b")}</joint>'
    own = f"<parent>o</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>{pitch}"
    tree += '<transmission name="m"><joint name="s"/></transmission>'
    return in_urdf(f'{tree}<gazebo><joint name="t" type="screw">{own}</joint></gazebo>', '<link name="a"/>')


def told(path: Path, text: str) -> list[str]:
    path.write_text(text, encoding="utf-8")
    return [one.found for one in read_checked(path).problems]


@pytest.mark.parametrize("word", ["screw_thread_pitch", "thread_pitch", "drake", "gazebo"])
@pytest.mark.parametrize("pitch", [0.04, -1.3])
def test_a_body_on_a_thread_falls_turning(word: str, pitch: float, tmp_path: Path) -> None:
    lead = pitch / math.tau
    new, old = f"<screw_thread_pitch>{pitch}</screw_thread_pitch>", f"<thread_pitch>{-1.0 / lead}</thread_pitch>"
    text = {
        "screw_thread_pitch": in_sdf(new),
        "thread_pitch": in_sdf(old, "1.6"),
        "drake": of_drake(pitch),
        "gazebo": in_gazebo(old),
    }[word]
    path = tmp_path / ("r.urdf" if word in ("drake", "gazebo") else "r.sdf")
    path.write_text(text, encoding="utf-8")
    robot = read_checked(path).description
    chain = ClosedChain(robot)
    assert chain.mobility().mobility == 1
    names = [joint.name for joint in robot.joints if joint.type.moves]
    q, (column,) = chain.home.q_full, chain.tangent(chain.home).T
    turn = 0.7 * column / column[names.index("s")]
    at = chain.link_placements(chain.integrate(q, turn))["b"]
    cos, sin = math.cos(0.7), math.sin(0.7)
    np.testing.assert_allclose(at[:2, :2], [[cos, -sin], [sin, cos]], atol=1e-12)
    np.testing.assert_allclose(at[:3, 3], [0.0, 0.0, 0.7 * lead], atol=1e-12)
    fall = chain.full_acceleration(q, 0.0 * turn, 0.0 * turn)
    assert fall[names.index("s")] == pytest.approx(-MASS * GRAVITY * lead / (SPIN + MASS * lead**2), rel=1e-9)


def test_screws_that_say_no_pitch_or_two_are_told(tmp_path: Path) -> None:
    path, urdf = tmp_path / "r.sdf", tmp_path / "r.urdf"
    two = in_sdf("<screw_thread_pitch>0.1</screw_thread_pitch><thread_pitch>{}</thread_pitch>")
    assert "screw joint 's' without <screw_thread_pitch>" in told(path, in_sdf(""))
    assert "thread_pitch of joint 's' is 0" in told(path, in_sdf("<thread_pitch>0</thread_pitch>", "1.6"))
    (found,) = told(path, two.format(20 * math.pi))
    assert found == "the two pitches of joint 's' are 0.1 and -0.1 metres per turn"
    assert told(path, two.format(-20 * math.pi)) == []
    missing = "drake:screw_thread_pitch of joint 's' is missing"
    assert missing in told(urdf, of_drake(0.1).replace("value=", "v="))
