"""Trajectories from outside the package: followed by name, and refused at the door where they do not fit."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from cutjoint import plugins
from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.motion import Reference, Trajectory
from cutjoint.motion.catalogue import trajectory
from cutjoint.papers.cpm import CpmModel

MODEL = CpmModel()
SOURCE = '''
import numpy as np

from cutjoint.mechanism.rotations import turned
from cutjoint.motion import JointMotion, ToolMotion


class Rose:
    """r = size cos(k angle) in the plane of x and y, through home."""

    def __init__(self, mechanism, size=0.01, petals=3.0, duration=2.0):
        self.centre = mechanism.tool(mechanism.home).position
        self.size, self.petals, self.duration = size, petals, duration

    def at(self, t):
        w, k = 2.0 * np.pi / self.duration, self.petals
        a, b = (k + 1.0) * w, (k - 1.0) * w
        one, two = np.array([np.sin(a * t), 1 - np.cos(a * t), 0]), np.array([np.sin(b * t), np.cos(b * t) - 1, 0])
        v = np.array([a * np.cos(a * t) + b * np.cos(b * t), a * np.sin(a * t) - b * np.sin(b * t), 0])
        c = np.array([-a * a * np.sin(a * t) - b * b * np.sin(b * t), a * a * np.cos(a * t) - b * b * np.cos(b * t), 0])
        return self.centre + self.size * (one + two), self.size * v, self.size * c


def slow_rose(mechanism):
    return Rose(mechanism, duration=8.0)


class Changed(Rose):
    def at(self, t):
        return self.change(*super().at(t))


class WrongVelocity(Changed):
    def change(self, p, v, a):
        return p, 1.2 * v, a


class WrongAcceleration(Changed):
    def change(self, p, v, a):
        return p, v, -a


class Two(Changed):
    def change(self, p, v, a):
        return p, v


class Flat(Changed):
    def change(self, p, v, a):
        return p[:2], v[:2], a[:2]


class NaN(Changed):
    def change(self, p, v, a):
        return p, v * np.nan, a


class Fails(Changed):
    def change(self, p, v, a):
        return p, v, a[7]


class Nowhere(Rose):
    duration = None

    def __init__(self, mechanism):
        super().__init__(mechanism, duration=0.0)


class NoEnd:
    def __init__(self, mechanism):
        pass

    def at(self, t):
        pass


class Joints:
    duration, name = 2.0, "joints of mine"

    def __init__(self, mechanism, extra=0.0, wrong=1.0):
        self.q, self.extra, self.wrong = mechanism.home.q, int(extra), wrong

    def at(self, t):
        one = np.ones(len(self.q) + self.extra) * 0.01
        q = np.resize(self.q, one.shape) + one * np.sin(t)
        return JointMotion(q, one * np.cos(t) * self.wrong, -one * np.sin(t))


class Turning:
    duration = 1.0

    def __init__(self, mechanism, wrong=1.0):
        self.home = mechanism.tool(mechanism.home).pose
        self.wrong = wrong

    def at(self, t):
        s, axis, still = 0.05 * np.sin(t), np.array([0.0, 0.6, 0.8]), np.zeros(3)
        rate = 0.05 * np.cos(t) * axis * self.wrong
        return ToolMotion(
            self.home.position, still, still, turned(s * axis) @ self.home.rotation, rate, -0.05 * np.sin(t) * axis
        )


number = 3
'''


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> str:
    file: Path = tmp_path_factory.mktemp("paths") / "my_paths.py"
    file.write_text(SOURCE)
    return str(file)


def test_a_trajectory_from_outside_is_followed(paths: str) -> None:
    rose = trajectory(f"{paths}:Rose:0.02,4", MODEL)
    assert isinstance(rose, Trajectory)
    assert (rose.name, rose.duration) == ("Rose", 2.0)
    desired = Reference(rose, MODEL).at(0.3)
    h = 1e-5
    reference = Reference(rose, MODEL)
    rate = (reference.at(0.3 + h).q - reference.at(0.3 - h).q) / (2.0 * h)
    assert np.allclose(desired.v, rate, rtol=0.0, atol=1e-7)
    assert trajectory(f"{paths}:slow_rose", MODEL).duration == 8.0


def test_actuators_and_poses_may_be_told(paths: str) -> None:
    import cutjoint

    joints = trajectory(f"{paths}:Joints", MODEL)
    assert joints.name == "joints of mine"
    assert np.allclose(Reference(joints, MODEL).at(0.5).q, MODEL.home.q + 0.01 * np.sin(0.5))
    stewart = cutjoint.load("stewart")
    turning = Reference(trajectory(f"{paths}:Turning", stewart), stewart)
    tool = stewart.tool(turning.at(0.7).posture, turning.at(0.7).v)
    assert np.allclose(tool.twist[3:], 0.05 * np.cos(0.7) * np.array([0.0, 0.6, 0.8]), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize(
    ("spec", "about"),
    [
        ("WrongVelocity", "the velocity of .*WrongVelocity is not the derivative of its position: at"),
        ("WrongAcceleration", "the acceleration of .*WrongAcceleration is not the derivative of its velocity"),
        ("Joints:0,1.2", "the velocity of .*Joints is not the derivative of its position"),
        ("Turning:1.2", "the velocity of .*Turning is not the derivative of its position"),
        ("Two", r"Two.at\(0\) gives .*; a trajectory is made by NAME\(mechanism, \*numbers\)"),
        ("Flat", r"position of .*Flat.at\(0\) must have shape \(3,\)"),
        ("NaN", r"velocity of .*NaN.at\(0\) must be finite"),
        ("Fails", r"Fails.at\(0\) raised IndexError: .* at .*my_paths.py:\d+: return p, v, a\[7\]"),
        ("Nowhere", "ZeroDivisionError|duration of .*Nowhere must be finite and > 0"),
        ("NoEnd", "makes .*, which has no duration; a trajectory is made by"),
        ("Joints:1", r"q of .*Joints.at\(0\) must have shape \(3,\), found shape \(4,\)"),
        ("Rose:1,2,3,4", "Rose.*does not take what it is given .too many positional"),
        ("Rose:a", "there must be numbers with commas, found 'a'"),
        ("number", "is 3, which cannot be called; a trajectory is made by"),
    ],
)
def test_what_is_no_trajectory_is_refused_at_the_door(paths: str, spec: str, about: str) -> None:
    with pytest.raises(InputError, match=about):
        trajectory(f"{paths}:{spec}", MODEL)


def test_one_that_leaves_the_workspace_is_found_before_anything_moves(paths: str) -> None:
    with pytest.raises(CutjointError, match="'Rose' leaves the workspace"):
        Reference(trajectory(f"{paths}:Rose:5", MODEL), MODEL)


@pytest.fixture
def offering(paths: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    group = "cutjoint.trajectories"
    monkeypatch.syspath_prepend(str(Path(paths).parent))
    offers = {group: [EntryPoint("rose", "my_paths:Rose", group)]}
    monkeypatch.setattr(plugins, "entry_points", lambda group: offers.get(group, []))
    plugins.installed.cache_clear()
    yield
    plugins.installed.cache_clear()


@pytest.mark.usefixtures("offering")
def test_an_installed_trajectory_goes_by_its_name() -> None:
    assert trajectory("rose:0.005", MODEL).duration == 2.0
    with pytest.raises(UnknownNameError, match="did you mean 'rose'"):
        trajectory("ros", MODEL)
