"""Workspaces against closed forms: annuli of planar robots, spheres on tori of Deltas, legs of platforms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kit.sized import Size
from scipy.ndimage import label
from scipy.spatial.transform import Rotation

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.description import load_description, with_values
from cutjoint.papers.omega3.parameters import Omega3Parameters
from cutjoint.robots import published
from cutjoint.workspace import MAPS, Workspace, orientation_workspace, workspace, workspaces

Array = np.ndarray
ELBOW, TIP = "joints.{}_elbow.origin.x", ("cuts.tip.a.x", "cuts.tip.b.x", "joints.tool_mount.origin.x")


def joined(mask: Array, at: tuple[int, ...]) -> Array:
    """The part of a mask that is joined with a cell or one beside it."""
    parts, _ = label(mask, structure=np.ones((3,) * mask.ndim))
    around = parts[tuple(slice(max(k - 1, 0), k + 2) for k in at)]
    return np.asarray(parts == around[around > 0][0])


def centres(found: Workspace) -> Array:
    return np.stack(np.meshgrid(*(axis.values for axis in found.axes), indexing="ij"), axis=-1)


def away_from_edges(mask: Array) -> Array:
    """Cells all of whose neighbours are like them, two cells deep."""
    near = np.zeros_like(mask)
    for axis in range(mask.ndim):
        for step in (1, -1, 2, -2):
            near |= np.roll(mask, step, axis) != mask
    return ~near


# ---- five-bars: two annuli, parted where the distal links are parallel -----------------------------------------------


def five_bar(point: Array, base: float, near: tuple[float, float], far: float, signs: tuple[int, int]) -> Array:
    """Sine between the distal links with the tool at points (..., 2), NaN where a limb does not reach; `signs` are
    those of the elbows' bends."""
    distal = []
    for side, length, sign in zip((-1, 1), near, signs, strict=True):
        way = point - [side * base, 0.0]
        distance = np.hypot(way[..., 0], way[..., 1])
        cosine = (distance**2 + length**2 - far**2) / (2.0 * length * distance)
        with np.errstate(invalid="ignore"):
            angle = np.arctan2(way[..., 1], way[..., 0]) - sign * np.arccos(
                np.where(np.abs(cosine) < 1, cosine, np.nan)
            )
        distal.append(way - length * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    return np.asarray(distal[0][..., 0] * distal[1][..., 1] - distal[0][..., 1] * distal[1][..., 0]) / far**2


def five_bar_of(left: float, right: float, far: float) -> ClosedChain:
    values = {ELBOW.format("left"): left, ELBOW.format("right"): right, **dict.fromkeys(TIP, far)}
    return ClosedChain(with_values(load_description("fivebar"), values))


@pytest.mark.parametrize(
    "lengths",
    [(0.2, 0.2, 0.25)]
    + [
        pytest.param(one, marks=pytest.mark.slow)
        for one in ((0.17, 0.23, 0.26), (0.21, 0.19, 0.24), (0.18, 0.18, 0.27))
    ],
)
def test_five_bar(lengths: tuple[float, float, float]) -> None:
    robot = five_bar_of(*lengths)
    found = workspace(robot, limits="ignore", cells=40)
    home = robot.tool(robot.home).position[[0, 2]]
    links = robot.link_placements(robot.home)
    signs = []
    for side in ("left", "right"):
        elbow = links[f"{side}_distal"][[0, 2], 3]
        pivot = links[f"{side}_proximal"][[0, 2], 3]
        first, second = elbow - pivot, home - elbow
        signs.append(int(np.sign(first[0] * second[1] - first[1] * second[0])))
    # the chain's axes point along -y where the plane is looked at with x to the right and z up: bends are in the plane
    sine = five_bar(centres(found), 0.1, lengths[:2], lengths[2], (signs[0], signs[1]))
    at_home = five_bar(home[None], 0.1, lengths[:2], lengths[2], (signs[0], signs[1]))[0]
    truth = np.nan_to_num(sine * np.sign(at_home)) > 0.0
    cell = tuple(int(np.argmin(np.abs(axis.values - x))) for axis, x in zip(found.axes, home, strict=True))
    truth = joined(truth, cell)
    sure = away_from_edges(truth)
    assert np.array_equal(truth[sure], found.inside[sure])
    assert found.extent == pytest.approx(truth.sum() * found.cell, rel=0.04)
    # a fine grid of the closed form alone
    x, z = np.meshgrid(np.linspace(-0.7, 0.7, 600), np.linspace(-0.7, 0.7, 600), indexing="ij")
    fine = (
        np.nan_to_num(
            five_bar(np.stack([x, z], -1), 0.1, lengths[:2], lengths[2], (signs[0], signs[1])) * np.sign(at_home)
        )
        > 0.0
    )
    place = tuple(round((c + 0.7) / 1.4 * 599) for c in home)
    assert found.extent == pytest.approx(joined(fine, place).sum() * (1.4 / 599) ** 2, rel=0.01)


# ---- Deltas: spheres on tori, parted where the rods are parallel to a plane ------------------------------------------


def rods_volume(p: Omega3Parameters, points: Array, signs: tuple[int, int, int] = (-1, -1, -1)) -> Array:
    """Volume of the three rods' directions with the tool at points (N, 3), NaN where a limb does not reach."""
    rods = []
    for i, sign in enumerate(signs):
        phi = 2.0 * np.pi * i / 3.0
        x = points[:, 0]
        tangential = np.cos(phi) * points[:, 1] + np.sin(phi) * points[:, 2]
        radial = np.cos(phi) * points[:, 2] - np.sin(phi) * points[:, 1] - (p.R_A - p.R_B)
        # the arm's end lies on a circle of radius L_A in the plane of x and the radius, at L_B from the tool
        distance = np.hypot(x, radial)
        cosine = (distance**2 + tangential**2 + p.L_A**2 - p.L_B**2) / (2.0 * p.L_A * distance)
        bent = np.arccos(np.where(np.abs(cosine) < 1.0, cosine, np.nan))
        angle = np.arctan2(x, radial) + sign * bent
        ahead, out = x - p.L_A * np.sin(angle), radial - p.L_A * np.cos(angle)
        rods.append(
            np.stack(
                [ahead, np.cos(phi) * tangential - np.sin(phi) * out, np.sin(phi) * tangential + np.cos(phi) * out], 1
            )
        )
    return np.einsum("ij,ij->i", rods[0], np.cross(rods[1], rods[2])) / p.L_B**3


def delta_volumes(p: Omega3Parameters, samples: int) -> tuple[float, float]:
    """Of the assembly mode of home, and of both."""
    rng = np.random.default_rng(0)
    half = p.L_A + p.L_B + 0.01 * p.L_B
    volume = rods_volume(p, rng.uniform(-half, half, (samples, 3)))
    part = (2.0 * half) ** 3 / samples
    return float((np.nan_to_num(volume) > 0.0).sum()) * part, float(np.isfinite(volume).sum()) * part


def test_published_delta() -> None:
    one, both = delta_volumes(Omega3Parameters(), 400_000)
    model = published("omega3")
    # 400 000 points tell 1 %
    assert workspace(model).extent == pytest.approx(one, rel=0.015)
    assert workspace(model).extent == pytest.approx(8.83e-3, rel=0.005)
    assert workspace(model, assembly="any").extent == pytest.approx(both, rel=0.015)
    assert workspace(model, assembly="any").extent == pytest.approx(16.87e-3, rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["published", "chain"])
def test_omega3_of_the_paper(robot: str) -> None:
    one, both = delta_volumes(Omega3Parameters(), 6_000_000)
    assert (1e3 * one, 1e3 * both) == (pytest.approx(8.83, abs=0.02), pytest.approx(16.87, abs=0.03))
    model = published("omega3") if robot == "published" else cutjoint.load("omega3")
    close = 0.005 if robot == "published" else 0.01
    assert workspace(model, limits="ignore").extent == pytest.approx(one, rel=close)
    assert workspace(model, assembly="any", limits="ignore").extent == pytest.approx(both, rel=close)


# ---- the CPM: three annuli, and the strokes of its sliders -----------------------------------------------------------


def cpm_reach(points: Array) -> Array:
    x, y, z = points.T
    ends = np.array([np.hypot(y - 0.105, z), np.hypot(z, x - 0.105), np.hypot(x, 0.9144 - 0.105 - y)])
    return np.asarray(((ends > 0.5 - 0.373) & (ends < 0.5 + 0.373)).all(axis=0))


def test_cpm() -> None:
    rng = np.random.default_rng(1)
    wide = rng.uniform([-0.9, -0.1, -0.9], [0.9, 1.0, 0.9], (500_000, 3))
    truth = cpm_reach(wide).mean() * 1.8 * 1.1 * 1.8
    assert workspace(published("cpm")).extent == pytest.approx(truth, rel=0.006)  # half a million points tell 0.2 %
    assert workspace(published("cpm")).extent == pytest.approx(1.681, rel=0.005)
    for cells in range(24, 49, 4):
        assert workspace(published("cpm"), cells=cells).extent == pytest.approx(1.681, rel=0.005)


@pytest.mark.slow
def test_cpm_in_its_strokes() -> None:
    rng = np.random.default_rng(1)
    robot = cutjoint.load("cpm")
    box = rng.uniform(0.0, 0.9, (2_000_000, 3))
    assert workspace(robot).extent == pytest.approx(cpm_reach(box).mean() * 0.9**3, rel=0.005)
    assert workspace(robot, limits="ignore").extent == pytest.approx(1.681, rel=0.005)


# ---- platforms: six legs ---------------------------------------------------------------------------------------------


def stewart_reach(robot: ClosedChain, points: Array, rotation: Array) -> Array:
    """Whether all legs of the Stewart platform are within their limits, and its type-2 measure has home's sign."""
    here, there = robot.tool(robot.home), {cut.name: cut for cut in robot.description.cuts}
    links, joints = robot.link_placements(robot.home), {one.name: one for one in robot.description.joints}
    limits = {name: (one.limits.lower, one.limits.upper) for name, one in joints.items()}
    good, lines, home_lines = np.ones(len(points), dtype=bool), [], []
    for k in range(1, 7):
        foot = joints[f"leg{k}_swing"].placement
        ball = (links["platform_link"] @ there[f"ball{k}"].a.placement)[:3, 3]
        arm = here.rotation.T @ (ball - here.position)
        top = points + rotation @ arm
        length = np.linalg.norm(top - foot[:3, 3], axis=1)
        at_home = float(np.linalg.norm(ball - foot[:3, 3]))
        slide = robot.home.q[k - 1] + length - at_home
        along = (top - foot[:3, 3]) / length[:, None] @ foot[:3, :3]
        tilt, swing = np.arcsin(along[:, 0]), np.arctan2(-along[:, 1], along[:, 2])
        for name, value in (("slide", slide), ("tilt", tilt), ("swing", swing)):
            low, high = limits[f"leg{k}_{name}"]
            assert low is not None
            assert high is not None
            good &= (value >= low) & (value <= high)
        direction = (top - foot[:3, 3]) / length[:, None]
        lines.append(np.concatenate([direction, np.cross(top - points, direction)], axis=1))
        unit = (ball - foot[:3, 3]) / at_home
        home_lines.append(np.concatenate([unit, np.cross(ball - here.position, unit)]))
    sign = np.sign(np.linalg.det(np.array(home_lines)))
    return np.asarray(good & (np.linalg.det(np.stack(lines, axis=1)) * sign > 0.0))


def scattered(low: Array, high: Array, count: int, seed: int) -> Array:
    """Random points between corners, one in each of `count` parts along every axis, shape (count^3, 3)."""
    rng = np.random.default_rng(seed)
    parts = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.asarray(low + (parts + rng.random(parts.shape)) / count * (high - low))


@pytest.mark.slow
def test_stewart_of_constant_orientation() -> None:
    robot = cutjoint.load("stewart")
    low, high = np.array([-0.45, -0.4, 0.2]), np.array([0.45, 0.4, 0.7])
    points = scattered(low, high, 70, 2)
    for turn in ((0.0, 0.0, 0.0), (0.2, -0.1, 0.3)):
        truth = stewart_reach(robot, points, Rotation.from_rotvec(turn).as_matrix()).mean() * np.prod(high - low)
        held = dict(zip(("rx", "ry", "rz"), turn, strict=True))
        assert workspace(robot, held=held).extent == pytest.approx(truth, rel=0.01)


@pytest.mark.slow
def test_sets_of_orientations() -> None:
    """Union and intersection of what the legs allow at every orientation."""
    robot, tilt = cutjoint.load("stewart"), 0.2
    low, high = np.array([-0.45, -0.4, 0.2]), np.array([0.45, 0.4, 0.7])
    points = scattered(low, high, 50, 3)
    turns = [tilt * np.array([a, b, 0.0]) / max(np.hypot(a, b), 1.0) for a in (0, 1, -1) for b in (0, 1, -1)]
    each = [stewart_reach(robot, points, Rotation.from_rotvec(turn).as_matrix()) for turn in turns]
    for kind, truth in (("reachable", np.any(each, axis=0)), ("dextrous", np.all(each, axis=0))):
        found = orientation_workspace(robot, kind, tilt, held={"rz": 0.0}, cells=30)  # type: ignore[arg-type]
        assert found.extent == pytest.approx(truth.mean() * np.prod(high - low), rel=0.02), kind


# ---- laws ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("length", [1e-3, 100.0])
def test_size_and_mounting_do_not_matter(length: float) -> None:
    plain = load_description("fivebar")
    size = Size(
        length=length, rotation=Rotation.from_rotvec([0.7, -0.4, 1.1]).as_matrix(), offset=3.0 * length * np.ones(3)
    )
    one = workspace(ClosedChain(plain), cells=24)
    other = ClosedChain(size.of(plain))
    found = workspace(other, cells=24)
    assert found.extent / length ** len(found.axes) == pytest.approx(one.extent, rel=0.02)


@pytest.mark.slow
def test_cells_are_postures_with_the_tool_there() -> None:
    robot = cutjoint.load("fivebar")
    found = workspace(robot, cells=10, maps=["type1", "type2", "condition", "isotropy", "effort", "speed", "stiffness"])
    assert found.inside.any()
    assert found.inside.shape == tuple(len(axis.values) for axis in found.axes)
    for k in np.argwhere(found.inside)[::7]:
        at = tuple(int(one) for one in k)
        posture = robot.close(found.q[at])
        tool, report = robot.tool(posture), robot.mobility(posture)
        assert np.allclose(tool.position[[0, 2]], [a.values[i] for a, i in zip(found.axes, at, strict=True)], atol=1e-9)
        value = {name: float(one.values[at]) for name, one in found.maps.items()}
        assert value["type1"] == pytest.approx(report.type1, rel=1e-6)
        assert value["type2"] == pytest.approx(report.type2, rel=1e-6)
        assert value["condition"] == pytest.approx(report.condition, rel=1e-6)
        assert value["isotropy"] == pytest.approx(1.0 / report.condition, rel=1e-6)
        # by trying forces and speeds all around
        around = np.linspace(0.0, 2.0 * np.pi, 721)
        jacobian = tool.frame_jacobian[[0, 2]]
        directions = np.array([np.cos(around), np.sin(around)])
        assert value["effort"] == pytest.approx(np.abs(jacobian.T @ directions).max(), rel=1e-4)
        assert value["speed"] == pytest.approx(np.abs(np.linalg.solve(jacobian, directions)).max(), rel=1e-4)
        given = np.linalg.norm(jacobian @ jacobian.T @ directions, axis=0)
        assert value["stiffness"] == pytest.approx(1.0 / given.max(), rel=1e-4)
        # a straight way from home may end at the hole in the middle; one from a cell beside does not
        near = {a.name: float(a.values[i]) + 0.2 * a.step for a, i in zip(found.axes, at, strict=True)}
        assert found.ways is not None
        if (found.ways[(slice(None), *at)] == 1.0).all():
            moved = robot.tool(robot.reach(near, near=posture)).position[[0, 2]]
            assert np.allclose(moved, list(near.values()), atol=1e-9)
    assert all(np.isnan(one.values[~found.inside]).all() for one in found.maps.values())


@pytest.mark.slow
def test_every_robot_with_a_task() -> None:
    """Cells are reached by the robot itself too, from home, and maps are those of its own report."""
    for name in ("omega3", "cpm", "cpm_rotary", "stewart"):
        robot = cutjoint.load(name)
        found = workspace(robot, cells=8, maps=["type1", "condition", "effort", "bearing"])
        cells = np.argwhere(found.inside)[:: max(int(found.inside.sum()) // 12, 1)]
        for k in cells:
            at = tuple(int(one) for one in k)
            target = {a.name: float(a.values[i]) for a, i in zip(found.axes, at, strict=True)}
            posture = robot.reach({**found.held, **target})
            assert np.allclose(np.sin(posture.q - found.q[at]), 0.0, atol=1e-6), name
            report = robot.mobility(posture)
            assert found.maps["type1"].values[at] == pytest.approx(report.type1, rel=1e-5), name
            assert found.maps["condition"].values[at] == pytest.approx(report.condition, rel=1e-5), name
        assert np.nanmin(found.maps["bearing"].values) > 0.3, name
    for name in ("fourbar", "redundant"):
        assert workspace(cutjoint.load(name), cells=8).inside.any()


@pytest.mark.slow
def test_working_modes() -> None:
    robot = cutjoint.load("fivebar")
    found = workspaces(robot, cells=20)
    assert len(found) == len(robot.working_modes())
    # the mirror image of the robot is the robot, with limbs exchanged
    sizes = sorted(one.extent for one in found)
    assert sizes[0] == pytest.approx(sizes[1], rel=0.03)
    assert sizes[2] == pytest.approx(sizes[3], rel=0.03)


def test_held_and_within_ranges() -> None:
    robot = cutjoint.load("fivebar")
    whole = workspace(robot, cells=24)
    part = workspace(robot, region={"x": (-0.1, 0.1)}, cells=24)
    home = robot.tool(robot.home).position[[0, 2]]
    cell = tuple(int(np.argmin(np.abs(axis.values - x))) for axis, x in zip(whole.axes, home, strict=True))
    # within the range what lies behind the hole in the middle is not joined with home
    inner = joined(whole.inside & (np.abs(centres(whole)[..., 0]) < 0.1), cell)
    assert np.abs(part.points[:, 0]).max() < 0.1
    assert part.extent == pytest.approx(inner.sum() * whole.cell, rel=0.1)
    line = workspace(robot, axes=["z"], held={"x": 0.0}, cells=50)
    assert [axis.name for axis in line.axes] == ["z"]
    assert line.held == {"x": 0.0}


@pytest.mark.slow
def test_collisions_leave_cells_out() -> None:
    plain = load_description("fivebar")
    shaped = tuple(replace(link, collisions=link.visuals) for link in plain.links)
    robot = ClosedChain(replace(plain, links=shaped))
    free, kept = workspace(robot, cells=10), workspace(robot, cells=10, collisions=True)
    assert 0 < kept.inside.sum() <= free.inside.sum()
    with pytest.raises(cutjoint.errors.InputError, match="collision"):
        workspace(ClosedChain(plain), cells=10, collisions=True)


def test_wrong_input_is_refused() -> None:
    robot, error = cutjoint.load("fivebar"), cutjoint.errors.InputError
    for wrong, told in (
        ({"cells": 0}, "3 to"),
        ({"cells": 10**12}, "3 to"),
        ({"region": {"x": (0.2, 0.1)}}, "growing"),
        ({"region": {"x": (0.1, 0.2)}}, "start"),
        ({"held": {"x": 0.0}, "axes": ["x"]}, "held"),
        ({"axes": []}, "1 to 3"),
        ({"assembly": "some"}, "assembly"),
        ({"maps": ["type1", "type1"]}, "twice"),
    ):
        with pytest.raises(error, match=told):
            workspace(robot, **wrong)  # type: ignore[arg-type]
    for wrong in ({"axes": ["y"]}, {"held": {"yy": 0.1}}, {"maps": ["condtion"]}):
        with pytest.raises(cutjoint.errors.UnknownNameError):
            workspace(robot, **wrong)  # type: ignore[arg-type]
    with pytest.raises(cutjoint.errors.ActuationError):
        workspace(cutjoint.load("underactuated"))
    with pytest.raises(error, match="closed chain"):
        workspace(published("omega3"), maps=["type2"])
    assert set(MAPS) >= {"condition", "type1"}


def test_batches_mask_what_is_not_reached() -> None:
    from cutjoint.compile import compiled

    model, rng = compiled(published("omega3")), np.random.default_rng(4)
    points = rng.uniform(-0.2, 0.2, (2000, 3))
    q, reached = model.batch.reached(points)
    assert np.array_equal(reached, np.isfinite(q).all(axis=1))
    sure = np.abs(np.nan_to_num(rods_volume(Omega3Parameters(), points))) > 1e-2
    assert np.array_equal(reached[sure], (rods_volume(Omega3Parameters(), points) > 0.0)[sure])
    other = compiled(published("cpm"))
    _, reached = other.batch.reached(points)
    assert np.array_equal(reached, cpm_reach(points))
    with pytest.raises(cutjoint.errors.UnreachableError):
        other.batch.reach([[100.0, 100.0, 100.0]])
