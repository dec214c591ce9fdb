"""A small reader and closer of urdf/<robot> for these tests alone: tomllib, ElementTree and pinocchio, nothing of
cutjoint, so that a mistake in the library cannot hide one in the data."""

from __future__ import annotations

import importlib
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

ROOT = Path(__file__).resolve().parents[2]
FREE = {"fixed": [], "spherical": [3, 4, 5], "revolute": [5], "prismatic": [2]}


class Tree:
    """A robot as pinocchio reads it, its cuts, and Newton's method on its passive joints."""

    def __init__(self, name: str, variant: str | None = None) -> None:
        folder = ROOT / "urdf" / name
        self.loops: dict[str, Any] = tomllib.loads((folder / "loops.toml").read_text(encoding="utf-8"))
        self.xml = ET.parse(folder / "robot.urdf").getroot()
        self.model = pin.buildModelFromUrdf(str(folder / "robot.urdf"))
        self.model.gravity.linear = np.array(self.loops["gravity"])
        for link, body in self.loops.get("variant", {}).get(variant, {}).get("inertial", {}).items():
            frame = self.model.frames[self.model.getFrameId(link, pin.BODY)]
            assert frame.placement.isIdentity()
            xx, yy, zz, xy, xz, yz = body["inertia"]
            about_com = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            self.model.inertias[frame.parentJoint] = pin.Inertia(body["mass"], np.array(body["com"]), about_com)
        self.data = self.model.createData()
        self.actuated = [self._joint(name).idx_v for name in self.loops["actuators"]]
        self.passive = [k for k in range(self.model.nv) if k not in self.actuated]
        self.cuts = [(cut["type"], *map(self._frame, cut["frames"])) for cut in self.loops["cut"]]

    def _joint(self, name: str) -> Any:
        return self.model.joints[self.model.getJointId(name)]

    def _frame(self, entry: str | dict[str, Any]) -> tuple[int, pin.SE3]:
        place = {"link": entry} if isinstance(entry, str) else entry
        frame = self.model.frames[self.model.getFrameId(place["link"], pin.BODY)]
        turn = pin.rpy.rpyToMatrix(*place.get("rpy", (0.0, 0.0, 0.0)))
        return frame.parentJoint, frame.placement * pin.SE3(turn, np.array(place.get("xyz", (0.0, 0.0, 0.0))))

    def home(self, name: str = "default") -> np.ndarray:
        """The home as written, passive joints rough."""
        q = pin.neutral(self.model)
        home = self.loops["home"][name]
        for joint_name, value in (home["actuated"] | home["passive"]).items():
            joint = self._joint(joint_name)
            if joint.nv == 6:
                placement = pin.SE3(pin.rpy.rpyToMatrix(*value[3:]), np.array(value[:3]))
                q[joint.idx_q : joint.idx_q + 7] = pin.SE3ToXYZQUAT(placement)
            else:
                q[joint.idx_q] = value
        return q

    def gap(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residual of all cut rows and their Jacobian."""
        pin.computeJointJacobians(self.model, self.data, q)
        residual, jacobian = [], []
        for kind, (joint_a, in_a), (joint_b, in_b) in self.cuts:
            between = (self.data.oMi[joint_a] * in_a).actInv(self.data.oMi[joint_b] * in_b)
            vel_a = in_a.toActionMatrixInverse() @ pin.getJointJacobian(self.model, self.data, joint_a, pin.LOCAL)
            vel_b = in_b.toActionMatrixInverse() @ pin.getJointJacobian(self.model, self.data, joint_b, pin.LOCAL)
            turn = between.rotation
            linear = turn @ vel_b[:3] - vel_a[:3] + pin.skew(between.translation) @ vel_a[3:]
            rows = np.vstack([linear, turn @ vel_b[3:] - vel_a[3:]])
            error = np.r_[between.translation, pin.log3(turn)]
            keep = [k for k in range(6) if k not in FREE[kind]]
            residual.append(error[keep])
            jacobian.append(rows[keep])
        return np.concatenate(residual), np.vstack(jacobian)

    def close(self, q: np.ndarray) -> np.ndarray:
        """`q` with the passive joints moved until the cuts close."""
        for _ in range(50):
            error, jacobian = self.gap(q)
            if np.abs(error).max() < 1e-14:
                break
            step = np.zeros(self.model.nv)
            step[self.passive] = -np.linalg.lstsq(jacobian[:, self.passive], error, rcond=1e-9)[0]
            q = pin.integrate(self.model, q, step * min(1.0, 0.3 / max(np.abs(step).max(), 1e-12)))
        assert np.abs(self.gap(q)[0]).max() < 1e-12
        return q

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The closed posture whose actuated coordinates lie `step` from those of `q`."""
        v = np.zeros(self.model.nv)
        v[self.actuated] = step
        return self.close(pin.integrate(self.model, q, v))

    def tangent(self, q: np.ndarray) -> np.ndarray:
        """All velocities per actuated velocity, (nv, n), where the actuators determine the motion."""
        jacobian = self.gap(q)[1]
        full = np.zeros((self.model.nv, len(self.actuated)))
        full[self.actuated] = np.eye(len(self.actuated))
        full[self.passive] = -np.linalg.lstsq(jacobian[:, self.passive], jacobian[:, self.actuated], rcond=1e-9)[0]
        return full

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix of the tree, symmetric."""
        upper = np.triu(pin.crba(self.model, self.data, q))
        return upper + np.triu(upper, 1).T


@pytest.fixture
def tree() -> Callable[..., Tree]:
    """Makes a `Tree` of a robot's name and variant."""
    return Tree


@pytest.fixture
def generator(monkeypatch: pytest.MonkeyPatch) -> Any:
    """tools/make_robots.py as a module."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    import make_robots

    yield make_robots
    for name in [name for name in sys.modules if name == "make_robots" or name.split(".")[0] == "robots"]:
        del sys.modules[name]


@pytest.fixture
def oracles(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """Imports a module of tests/oracles."""
    monkeypatch.syspath_prepend(str(ROOT / "tests"))
    return lambda name: importlib.import_module(f"oracles.{name}")
