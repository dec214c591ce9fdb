"""Lengths, masses and cuts of a robot under urdf/, read without cutjoint and pinocchio, for the oracles beside this."""

from __future__ import annotations

import tomllib
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np

URDF = Path(__file__).resolve().parents[2] / "urdf"


@dataclass(frozen=True)
class Body:
    """Mass [kg], centre of mass (3,) [m] in the link frame, inertia (3, 3) [kg m2] about it."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray


class Tree:
    """What the files of a robot say."""

    def __init__(self, name: str) -> None:
        self._xml = ET.parse(URDF / name / "robot.urdf").getroot()
        self.loops = tomllib.loads((URDF / name / "loops.toml").read_text(encoding="utf-8"))
        self.gravity = np.array(self.loops["gravity"])

    def body(self, link: str) -> Body:
        """The inertia of a link; the link frames have no rotated inertial origin."""
        inertial = self._xml.find(f"link[@name='{link}']/inertial")
        assert inertial is not None
        origin, moments = inertial.find("origin"), inertial.find("inertia")
        assert not self._vector(origin, "rpy").any()
        xx, yy, zz, xy, xz, yz = (float(moments.get(k)) for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return Body(float(inertial.find("mass").get("value")), self._vector(origin, "xyz"), inertia)

    def origin(self, joint: str) -> tuple[np.ndarray, np.ndarray]:
        """Position and roll, pitch, yaw of a joint in its parent link."""
        origin = self._xml.find(f"joint[@name='{joint}']/origin")
        return self._vector(origin, "xyz"), self._vector(origin, "rpy")

    def cut(self, name: str, link: str) -> np.ndarray:
        """Where the named cut sits on `link`."""
        frames = next(cut["frames"] for cut in self.loops["cut"] if cut["name"] == name)
        return np.array(next(frame["xyz"] for frame in frames if isinstance(frame, dict) and frame["link"] == link))

    def home(self, joint: str) -> float:
        """Home coordinate of a joint."""
        home = self.loops["home"]["default"]
        return (home["actuated"] | home["passive"])[joint]

    @staticmethod
    def _vector(element: ET.Element, key: str) -> np.ndarray:
        return np.array([float(x) for x in element.get(key, "0 0 0").split()])
