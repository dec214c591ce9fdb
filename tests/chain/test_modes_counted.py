"""Modes of robots whose number of solutions is known otherwise: by a polynomial, by hand, by solving a few equations with
numpy alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.description.model import CutJoint, CutType, Frame, Home, Joint, JointType, Limits, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.mechanism import Posture

Z = readonly([0.0, 0.0, 1.0])


def pose(chain: ClosedChain, at: Posture) -> np.ndarray:
    """World placement of the tool's link, shape (4, 4)."""
    return chain.link_placements(at.q_full)[chain.description.tool.link]


# ---- planar 3-RRR --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Triangle:
    """Planar 3-RRR with its motors held: elbows B (3,) and platform corners c (3,) as complex numbers, rods r (3,)."""

    base: np.ndarray
    cranks: np.ndarray
    angles: np.ndarray
    corners: np.ndarray
    rods: np.ndarray

    @staticmethod
    def random(rng: np.random.Generator) -> Triangle:
        """One that has at least one solution: the rods are as long as it takes at a random pose."""
        base = np.exp(2j * np.pi * np.arange(3) / 3) + 0.3 * rng.normal(size=3)
        corners = 0.5 * np.exp(2j * np.pi * np.arange(3) / 3) * rng.uniform(0.6, 1.4, 3)
        cranks, angles = rng.uniform(0.3, 0.9, 3), rng.uniform(-np.pi, np.pi, 3)
        elbows = base + cranks * np.exp(1j * angles)
        middle, turn = 0.3 * complex(*rng.normal(size=2)), np.exp(1j * rng.uniform(-np.pi, np.pi))
        return Triangle(base, cranks, angles, corners, abs(middle + turn * corners - elbows))

    @property
    def elbows(self) -> np.ndarray:
        return self.base + self.cranks * np.exp(1j * self.angles)

    def poses(self) -> list[tuple[complex, float]]:
        """Middle and angle of the platform in every solution.

        With the first circle taken off the other two the middle p follows from the angle: D p = N.  Put into the first
        circle that is a polynomial of sixth degree in z = e^(i angle); its coefficients come from values on the circle.
        """
        samples = np.exp(2j * np.pi * np.arange(32) / 32)
        coefficients = np.fft.fft([self._circle(z)[0] for z in samples]) / 32
        ordered = np.concatenate([coefficients[-3:], coefficients[:4]])  # of z^-3 ... z^3
        assert np.abs(coefficients[4:-3]).max() < 1e-12 * np.abs(ordered).max(), "the degree is six"
        roots = np.roots(ordered[::-1])
        return [(self._circle(z)[1], float(np.angle(z))) for z in roots if abs(abs(z) - 1.0) < 1e-7]

    def _circle(self, z: complex) -> tuple[float, complex]:
        at = z * self.corners - self.elbows  # the corners' offsets from the elbows with the middle at 0
        rows = 2.0 * np.array([[(at[i] - at[0]).real, (at[i] - at[0]).imag] for i in (1, 2)])
        right = np.array([self.rods[i] ** 2 - abs(at[i]) ** 2 - self.rods[0] ** 2 + abs(at[0]) ** 2 for i in (1, 2)])
        determinant = np.linalg.det(rows)
        n = np.array([[rows[1, 1], -rows[0, 1]], [-rows[1, 0], rows[0, 0]]]) @ right
        middle = complex(*n)
        value = abs(middle + determinant * at[0]) ** 2 - (determinant * self.rods[0]) ** 2
        return value, middle / determinant if determinant else complex("nan")

    def description(self, middle: complex, angle: float) -> RobotDescription:
        """The robot with its platform there; the platform hangs on the first limb."""
        links, joints, cuts, home = [Link("base")], [], [], {}
        for i in range(3):
            rod = middle + np.exp(1j * angle) * self.corners[i] - self.elbows[i]
            links += [Link(f"crank{i}"), Link(f"rod{i}")]
            start = placement((self.base[i].real, self.base[i].imag, 0.0))
            joints += [
                Joint(f"motor{i}", JointType.CONTINUOUS, "base", f"crank{i}", start, axis=Z),
                Joint(f"elbow{i}", JointType.CONTINUOUS, f"crank{i}", f"rod{i}", placement((self.cranks[i], 0, 0)), axis=Z),
            ]
            home[f"elbow{i}"] = float(np.angle(rod)) - self.angles[i]
            if i == 0:
                links.append(Link("platform"))
                end = placement((self.rods[0], 0, 0))
                joints.append(Joint("wrist", JointType.CONTINUOUS, "rod0", "platform", end, axis=Z))
                home["wrist"] = angle - float(np.angle(rod))
            else:
                corner = self.corners[i] - self.corners[0]
                end = Frame(f"rod{i}", placement((self.rods[i], 0, 0)))
                at = Frame("platform", placement((corner.real, corner.imag, 0.0)))
                cuts.append(CutJoint(f"corner{i}", CutType.REVOLUTE, end, at))
        tool = placement((-self.corners[0].real, -self.corners[0].imag, 0.0))
        motors = tuple(f"motor{i}" for i in range(3))
        return RobotDescription(
            "3-RRR",
            tuple(links),
            tuple(joints),
            tuple(cuts),
            actuators=motors,
            tool=Frame("platform", tool),
            homes=(Home("default", dict(zip(motors, self.angles.tolist(), strict=True)), home),),
        )


def triangles() -> dict[int, list[Triangle]]:
    """Random ones by their number of solutions."""
    rng, found = np.random.default_rng(4), {2: [], 4: [], 6: []}
    for _ in range(400):
        one = Triangle.random(rng)
        found[len(one.poses())].append(one)
    return found


@pytest.mark.parametrize("count", [2, 4, 6])
def test_planar_3rrr_has_the_real_roots_of_its_sixth_degree_polynomial(count: int) -> None:
    for triangle in triangles()[count][:3]:
        poses = triangle.poses()
        chain = ClosedChain(triangle.description(*poses[0]))
        modes = chain.assembly_modes()
        print(count, len(modes), modes.found, modes.starts, modes.unseen, modes.complete)
        assert len(modes) == count
        matrices = [pose(chain, at) for at in modes]
        tool = chain.description.tool.placement
        found = sorted((complex(*(m @ tool)[:2, 3]), complex(*m[:2, 0])) for m in matrices)
        wanted = sorted((p, np.exp(1j * a)) for p, a in poses)
        print(np.abs(np.array(found)-np.array(wanted)).max())
