"""Modes of robots whose number of solutions is known otherwise: by a polynomial, by hand, by solving a few equations
with numpy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    return chain.link_placements(at)[chain.description.tool.link]


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
                Joint(
                    f"elbow{i}", JointType.CONTINUOUS, f"crank{i}", f"rod{i}", placement((self.cranks[i], 0, 0)), axis=Z
                ),
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
    for _ in range(150):
        one = Triangle.random(rng)
        found[len(one.poses())].append(one)
    return found


@pytest.mark.parametrize("count", [2, 4, 6])
def test_planar_3rrr_has_the_real_roots_of_its_sixth_degree_polynomial(count: int) -> None:
    for triangle in triangles()[count][:1]:
        poses = triangle.poses()
        chain = ClosedChain(triangle.description(*poses[0]))
        modes = chain.assembly_modes()
        assert len(modes) == count
        tool = chain.description.tool.placement
        found = np.array([np.r_[(m @ tool)[:2, 3], m[:2, 0]] for m in (pose(chain, at) for at in modes)])
        wanted = np.array([[p.real, p.imag, np.cos(a), np.sin(a)] for p, a in poses])
        apart = np.abs(found[:, None] - wanted[None]).max(axis=2)
        assert apart.min(axis=0).max() < 1e-6
        assert apart.min(axis=1).max() < 1e-6


# ---- Stewart platforms ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Octopod:
    """Six legs between points a (6, 3) of the base and b (6, 3) of a platform."""

    base: np.ndarray
    platform: np.ndarray

    @staticmethod
    def random(rng: np.random.Generator) -> Octopod:
        return Octopod(rng.uniform(-1, 1, (6, 3)), 0.7 * rng.uniform(-1, 1, (6, 3)))

    def lengths(self, place: np.ndarray) -> np.ndarray:
        """Leg lengths (6,) with the platform at `place` (4, 4)."""
        return np.linalg.norm(self.platform @ place[:3, :3].T + place[:3, 3] - self.base, axis=1)

    def poses(self, lengths: np.ndarray, starts: int, seed: int = 0) -> np.ndarray:
        """Placements (k, 4, 4) with these leg lengths, by Newton's method from many random ones at once; knows neither
        Pinocchio nor cutjoint.  Solves |p + R b - a|^2 = l^2 and |quaternion|^2 = 1."""
        rng = np.random.default_rng(seed)
        x = np.concatenate([rng.normal(size=(starts, 4)), 1.5 * rng.uniform(-1, 1, (starts, 3))], axis=1)
        x[:, :4] /= np.linalg.norm(x[:, :4], axis=1, keepdims=True)
        with np.errstate(all="ignore"):
            for _ in range(60):
                value, slope = self._equations(x, lengths)
                step = np.linalg.solve(slope + 1e-14 * np.eye(7), value[..., None])[..., 0]
                size = np.linalg.norm(step, axis=1, keepdims=True)
                x = x - step * np.minimum(1.0, 0.5 / np.maximum(size, 1e-300))
            value, _ = self._equations(x, lengths)
        x = x[np.isfinite(x).all(axis=1) & (np.abs(value).max(axis=1) < 1e-11)]
        found: list[np.ndarray] = []
        for one in x:
            place = np.eye(4)
            place[:3, :3], place[:3, 3] = _rotation(one[None, :4])[0], one[4:]
            if all(np.abs(place - other).max() > 1e-5 for other in found):
                found.append(place)
        return np.array(found)

    def _equations(self, x: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w, v, p = x[:, :1, None], x[:, None, 1:4], x[:, None, 4:]
        b = self.platform[None]
        # R b = (w^2 - v.v) b + 2 (v.b) v + 2 w v x b, homogeneous of second degree in the quaternion
        along, across = (v * b).sum(axis=2, keepdims=True), np.cross(v, b)
        turned = (w**2 - (v * v).sum(axis=2, keepdims=True)) * b + 2.0 * along * v + 2.0 * w * across
        legs = p + turned - self.base[None]
        value = np.empty((len(x), 7))
        value[:, :6] = (legs**2).sum(axis=2) - lengths**2
        value[:, 6] = (x[:, :4] ** 2).sum(axis=1) - 1.0
        slope = np.zeros((len(x), 7, 7))
        slope[:, :6, 0] = 2.0 * (legs * (2.0 * w * b + 2.0 * across)).sum(axis=2)
        for i in range(3):
            e = np.eye(3)[i][None, None]
            turning = (
                -2.0 * v[..., i : i + 1] * b + 2.0 * b[..., i : i + 1] * v + 2.0 * along * e + 2.0 * w * np.cross(e, b)
            )
            slope[:, :6, 1 + i] = 2.0 * (legs * turning).sum(axis=2)
        slope[:, :6, 4:] = 2.0 * legs
        slope[:, 6, :4] = 2.0 * x[:, :4]
        return value, slope

    def description(self, place: np.ndarray, universal: bool = False) -> RobotDescription:
        """The robot with its platform there: every leg a ball or universal joint, a slide and a ball cut; between two
        balls it spins idly."""
        links, joints, cuts, passive = [Link("base"), Link("platform")], [], [], {}
        joints.append(Joint("free", JointType.FLOATING, "base", "platform"))
        passive["free"] = (*place[:3, 3], *_rpy(place[:3, :3]))
        lengths = self.lengths(place)
        for i in range(6):
            links += [Link(f"cylinder{i}"), Link(f"piston{i}")]
            joints += [
                _foot(f"foot{i}", f"cylinder{i}", placement(self.base[i]), universal),
                Joint(f"slide{i}", JointType.PRISMATIC, f"cylinder{i}", f"piston{i}", axis=Z, limits=Limits(0.0, 9.0)),
            ]
            cuts.append(
                CutJoint(
                    f"ball{i}", CutType.SPHERICAL, Frame("platform", placement(self.platform[i])), Frame(f"piston{i}")
                )
            )
            x, y, z = (place[:3, :3] @ self.platform[i] + place[:3, 3] - self.base[i]) / lengths[i]
            swing, lean = float(np.arctan2(-y, z)), float(np.arcsin(x))
            # direction (x, y, z) = Rx(swing) Ry(lean) e_z; the same as roll, pitch, yaw for the ball
            turn = placement((0, 0, 0), (swing, 0, 0)) @ placement((0, 0, 0), (0, lean, 0))
            passive[f"foot{i}"] = (swing, lean) if universal else _rpy(turn[:3, :3])
        motors = tuple(f"slide{i}" for i in range(6))
        home = Home("default", dict(zip(motors, lengths.tolist(), strict=True)), passive)
        return RobotDescription(
            "6-SPS", tuple(links), tuple(joints), tuple(cuts), actuators=motors, tool=Frame("platform"), homes=(home,)
        )


def _foot(name: str, child: str, at: np.ndarray, universal: bool) -> Joint:
    if universal:
        x, y = readonly([1.0, 0.0, 0.0]), readonly([0.0, 1.0, 0.0])
        return Joint(name, JointType.UNIVERSAL, "base", child, at, axis=x, axis2=y)
    return Joint(name, JointType.SPHERICAL, "base", child, at)


def _rotation(q: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions (k, 4), w first, shape (k, 3, 3)."""
    w, x, y, z = q.T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)


def _rpy(r: np.ndarray) -> tuple[float, float, float]:
    return (
        float(np.arctan2(r[2, 1], r[2, 2])),
        float(np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))),
        float(np.arctan2(r[1, 0], r[0, 0])),
    )


def places(chain: ClosedChain, modes: Sequence[Posture]) -> np.ndarray:
    """Placements of the tool's link, shape (k, 4, 4)."""
    return np.array([pose(chain, at) for at in modes])


def same(one: np.ndarray, two: np.ndarray) -> bool:
    """Whether two sets of placements are the same."""
    apart = np.abs(one[:, None] - two[None]).max(axis=(2, 3))
    return bool((apart.min(axis=0) < 1e-6).all() and (apart.min(axis=1) < 1e-6).all() and len(one) == len(two))


@pytest.mark.parametrize("seed", [5])
def test_a_stewart_platform_has_the_solutions_of_its_six_distances(seed: int) -> None:
    """Its legs spin between balls: six idle freedoms, which make no modes of their own."""
    rng = np.random.default_rng(seed)
    robot = Octopod.random(rng)
    place = placement(0.5 * rng.normal(size=3), rng.normal(size=3))
    wanted = robot.poses(robot.lengths(place), 2000)
    chain = ClosedChain(robot.description(place))
    assert len(chain.mobility().free) == 6
    modes = chain.assembly_modes()
    assert same(places(chain, modes), wanted)
    for at in modes:
        np.testing.assert_allclose(robot.lengths(pose(chain, at)), modes[0].q, atol=1e-10)


# P. Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures, Advances in Robot Kinematics:
# Analysis and Control, 1998
FORTY = Octopod(
    np.array(
        [
            [0.0, 0.0, 0.0],
            [1.107915, 0.0, 0.0],
            [0.549094, 0.756063, 0.0],
            [0.735077, -0.223935, 0.525991],
            [0.514188, -0.526063, -0.368418],
            [0.590473, 0.094733, -0.205018],
        ]
    ),
    np.array(
        [
            [0.0, 0.0, 0.0],
            [0.542805, 0.0, 0.0],
            [0.956919, -0.528915, 0.0],
            [0.665885, -0.353482, 1.402538],
            [0.478359, 1.158742, 0.107672],
            [-0.137087, -0.235121, 0.353913],
        ]
    ),
)
FORTY_LENGTHS = np.array([1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071])


@pytest.mark.slow
def test_dietmaiers_platform_has_forty_assembly_modes_of_which_some_hide() -> None:
    """Five of them lie on a curve along which the robot nearly moves by itself, and one start in thousands leads there:
    a list that misses one says that it is not sure."""
    wanted = FORTY.poses(FORTY_LENGTHS, 20000)
    assert len(wanted) == 40
    chain = ClosedChain(FORTY.description(wanted[0]))
    modes = chain.assembly_modes()
    apart = np.abs(places(chain, modes)[:, None] - wanted[None]).max(axis=(2, 3))
    assert apart.min(axis=1).max() < 1e-6
    assert len(np.unique(apart.argmin(axis=1))) == len(modes) >= 38
    assert len(modes) == 40 or (modes.unseen > 0.0 and not modes.settled)


@pytest.mark.slow
def test_legs_on_universal_joints_without_limits_can_turn_over() -> None:
    """A universal joint holds its leg in two ways: 2^6 working modes, and as many ways of the limbs in each assembly
    mode."""
    rng = np.random.default_rng(3)
    robot = Octopod.random(rng)
    place = placement(0.5 * rng.normal(size=3), rng.normal(size=3))
    description = robot.description(place, universal=True)
    chain = ClosedChain(description)
    working = chain.working_modes()
    assert (len(working), working.held, working.settled) == (64, "pose", True)
    wanted = robot.poses(robot.lengths(place), 2000)
    modes = chain.assembly_modes()
    assert same(places(chain, modes), wanted)
    assert len(chain.assembly_modes(limbs=True)) == 64 * len(wanted)


# ---- 3-PRS ---------------------------------------------------------------------------------------------------------


def prs(tilt: tuple[float, float], ball_in_tree: bool) -> RobotDescription:
    """Three vertical slides at 120 degrees, each with a rod on a tangential hinge, ball joints to a platform, which
    hangs on the first rod or flies."""
    outer, inner, rod, height = 0.5, 0.3, 0.6, 0.7
    links, joints, cuts = [Link("base"), Link("platform")], [], []
    passive: dict[str, float | tuple[float, ...]] = {}
    actuated: dict[str, float] = {}
    x, y = tilt
    # the platform turns about a level axis, so the shift that keeps its balls in their planes is known
    turn = placement((0.0, 0.0, 0.0), (x, 0.0, 0.0)) @ placement((0.0, 0.0, 0.0), (0.0, y, 0.0))
    turn, shift = _in_planes(turn[:3, :3], inner)
    corners = []
    for i in range(3):
        angle = 2.0 * np.pi * i / 3
        mount = placement((outer * np.cos(angle), outer * np.sin(angle), 0.0), (0.0, 0.0, angle))
        ball = np.array([inner * np.cos(angle), inner * np.sin(angle), 0.0])
        corners.append(ball)
        reach = outer - (turn @ ball + shift) @ np.array([np.cos(angle), np.sin(angle), 0.0])
        swing = float(np.arcsin(reach / rod))
        links += [Link(f"carriage{i}"), Link(f"rod{i}")]
        joints += [
            Joint(f"slide{i}", JointType.PRISMATIC, "base", f"carriage{i}", mount, axis=Z),
            Joint(f"hinge{i}", JointType.CONTINUOUS, f"carriage{i}", f"rod{i}", axis=readonly([0.0, 1.0, 0.0])),
        ]
        actuated[f"slide{i}"] = height + float((turn @ ball)[2]) - rod * float(np.cos(swing))
        passive[f"hinge{i}"] = -swing
        if not (ball_in_tree and i == 0):
            end = Frame(f"rod{i}", placement((0.0, 0.0, rod)))
            cuts.append(CutJoint(f"ball{i}", CutType.SPHERICAL, end, Frame("platform", placement(ball))))
    at = np.eye(4)
    at[:3, :3], at[:3, 3] = turn, shift + height * Z
    if ball_in_tree:
        joints.append(Joint("ball0", JointType.SPHERICAL, "rod0", "platform", placement((0.0, 0.0, rod))))
        rod0 = placement((0, 0, 0), (0.0, passive["hinge0"], 0.0))[:3, :3]
        passive["ball0"] = _rpy(rod0.T @ turn)
    else:
        joints.append(Joint("free", JointType.FLOATING, "base", "platform"))
        passive["free"] = (*at[:3, 3], *_rpy(turn))
    tool = Frame("platform", placement(-corners[0]) if ball_in_tree else np.eye(4))
    return RobotDescription(
        "3-PRS",
        tuple(links),
        tuple(joints),
        tuple(_shifted(cuts, -corners[0]) if ball_in_tree else cuts),
        actuators=tuple(actuated),
        tool=tool,
        homes=(Home("default", actuated, passive),),
    )


def _shifted(cuts: list[CutJoint], by: np.ndarray) -> list[CutJoint]:
    """The cuts' frames on the platform with its frame moved to the first ball."""
    return [replace(cut, b=Frame("platform", placement(by + cut.b.placement[:3, 3]))) for cut in cuts]


def _in_planes(turn: np.ndarray, inner: float) -> tuple[np.ndarray, np.ndarray]:
    """The platform's rotation, spun about the vertical, and its level shift, with which all balls are in the planes of
    their limbs: three equations, solved by Newton's method."""
    angles = 2.0 * np.pi * np.arange(3) / 3
    balls = inner * np.array([np.cos(angles), np.sin(angles), 0.0 * angles]).T
    across = np.array([-np.sin(angles), np.cos(angles), 0.0 * angles]).T
    x = np.zeros(3)

    def spun(spin: float) -> np.ndarray:
        return placement((0.0, 0.0, 0.0), (0.0, 0.0, spin))[:3, :3] @ turn

    def off(x: np.ndarray) -> np.ndarray:
        return ((balls @ spun(x[0]).T + [x[1], x[2], 0.0]) * across).sum(axis=1)

    for _ in range(20):
        slope = np.array([(off(x + 1e-6 * e) - off(x - 1e-6 * e)) / 2e-6 for e in np.eye(3)]).T
        x = x - np.linalg.solve(slope, off(x))
    assert np.abs(off(x)).max() < 1e-14
    return spun(x[0]), np.array([x[1], x[2], 0.0])


@pytest.mark.parametrize("ball_in_tree", [False, True])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.2, -0.1)])
def test_3prs_has_eight_working_modes(tilt: tuple[float, float], ball_in_tree: bool) -> None:
    """Every rod leans in or out; the platform's tilt is a part of the task, the shift that comes with it is not."""
    level = ClosedChain(prs((0.0, 0.0), ball_in_tree))
    at = level.posture(ClosedChain(prs(tilt, ball_in_tree)).home.q_full)
    modes = level.working_modes(at)
    assert (len(modes), modes.held, modes.settled) == (8, "pose", True)
    for mode in modes:
        np.testing.assert_allclose(pose(level, mode), pose(level, at), atol=1e-10)
    assert len({tuple(np.round(mode.q, 8)) for mode in modes}) == 8


# ---- solutions that can still move ---------------------------------------------------------------------------------


def test_solutions_that_can_move_are_counted_apart() -> None:
    """With its platform as large as the triangle of the elbows and equal rods, a 3-RRR can swing with its motors held;
    its other postures are modes."""
    base = np.exp(2j * np.pi * np.array([0.0, 0.3, 0.65]))
    cranks, angles = np.full(3, 0.5), np.full(3, 0.4)
    elbows = base + cranks * np.exp(1j * angles)
    triangle = Triangle(base, cranks, angles, elbows - elbows.mean(), np.full(3, 1.1))
    regular = [(p, a) for p, a in triangle.poses() if abs(np.exp(1j * a) - 1.0) > 1e-3]
    assert regular
    chain = ClosedChain(triangle.description(*regular[0]))
    modes = chain.assembly_modes()
    assert len(modes) == len(regular)
    assert modes.loose > 10
