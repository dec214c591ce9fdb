"""Robots of templates, in their own sizes and in random ones: closed, checked, and as geometry has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit import closed_forms
from kit.quickly import few

import cutjoint
from cutjoint.description import check
from cutjoint.description.transforms import rotation_from_rpy
from cutjoint.drafting import TEMPLATES, draft, write_draft
from cutjoint.drafting.sketch import LinkSketch, Solid, ball, box
from cutjoint.errors import CutjointError, InputError

MOBILITY = {"fourbar": 1, "fivebar": 2, "delta": 3, "stewart": 6, "leg": 1, "blank": 1}
CASES = [
    pytest.param(template, seed, marks=[] if (template, seed) == ("fivebar", 0) else pytest.mark.slow)
    for template in TEMPLATES
    for seed in range(12)
]


def random_sizes(template: str, seed: int) -> dict[str, float]:
    """Sizes of a template: its own with seed 0, else each by a factor of its own, and all by another."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-1.2, 1.2) if seed else 1.0
    spread = 2.0 if seed else 1.0
    sizes = TEMPLATES[template].sizes
    return {name: float(size.default * scale * spread ** rng.uniform(-1.0, 1.0)) for name, size in sizes.items()}


def postures(chain, seed: int):
    """Home, and postures around it with each actuator elsewhere."""
    rng = np.random.default_rng(seed)
    yield chain.home
    for _ in range(4):
        step = 0.03 * rng.uniform(-1.0, 1.0, chain.n)
        lengths = [one.kind == "translation" for one in chain.actuators]
        yield chain.close(chain.home.q + step * np.where(lengths, 0.2 * chain.home.q, 1.0))


@pytest.mark.parametrize(("template", "seed"), CASES)
def test_a_template_closes_moves_and_follows_its_geometry(template: str, seed: int, tmp_path: Path) -> None:
    sizes = random_sizes(template, seed)
    if not closed_forms.CLOSES[template](sizes):
        with pytest.raises(InputError, match=r"cannot|too flat"):
            draft("robot", template, sizes)
        return
    made = draft("robot", template, sizes)
    write_draft(made, tmp_path / "robot")
    assert [one for one in check(tmp_path / "robot") if one.severity == "error" or not made.told] == []
    chain = cutjoint.load(str(tmp_path / "robot"))
    assert max(chain.home.gap) <= 1e-12 * max(1.0, chain.length)
    report = chain.mobility()
    assert (report.mobility, report.determined) == (MOBILITY[template], True)
    size = max([*sizes.values(), 0.1])
    for at in postures(chain, seed):
        tool, q = chain.tool(at).pose, dict(zip([one.name for one in chain.actuators], at.q, strict=True))
        place = (tool.position, tool.rotation) if template == "stewart" else (tool.position,)
        assert getattr(closed_forms, template)(sizes, q, *place) < 1e-9 * size
        assert np.allclose(chain.close(at.q, near=at).q_full, at.q_full, atol=1e-9)
        mass = chain.terms(at).mass
        assert np.linalg.eigvalsh(mass)[0] > 0.0


@pytest.mark.parametrize("template", few(["fivebar", "delta", "stewart"], "delta"))
def test_the_tool_is_reached_and_the_motors_bring_it_back(template: str, tmp_path: Path) -> None:
    write_draft(draft("robot", template), tmp_path / "robot")
    chain = cutjoint.load(str(tmp_path / "robot"))
    rng = np.random.default_rng(3)
    for at in list(postures(chain, 5))[1:3]:
        pose = chain.tool(at).pose
        target = pose if template == "stewart" else pose.position[[0, 2]] if template == "fivebar" else pose.position
        there = chain.reach(target) if template != "fivebar" else chain.reach(pose.position)
        assert np.allclose(there.q, at.q, atol=1e-8)
        effort = rng.normal(size=chain.n)
        a = chain.forward_dynamics(there, np.zeros(chain.n), effort)
        assert np.allclose(chain.inverse_dynamics(there, np.zeros(chain.n), a), effort, atol=1e-8)


def test_masses_are_those_of_the_solids() -> None:
    light, heavy = draft("robot", "fourbar"), draft("robot", "fourbar", density=5400.0)
    masses = [
        [float(line.split('"')[1]) for line in one.files["robot.urdf"].splitlines() if "<mass" in line]
        for one in (light, heavy)
    ]
    assert np.allclose(2.0 * np.array(masses[0]), masses[1], rtol=1e-5)
    # the crank: a box of 0.1 m with the section 0.45 w by w, w a tenth of the mean length
    w = 0.1 * (0.1 * 0.25 * 0.25) ** (1 / 3)
    assert masses[0][0] == pytest.approx(2700.0 * 0.1 * 0.45 * w * w, rel=1e-5)


def test_inertias_are_those_of_points_in_the_solids() -> None:
    rng = np.random.default_rng(8)
    count, turn = 60_000, (0.3, -0.8, 1.1)
    solids = (
        box((0.1, 0.2, 0.3), "grey", (0.3, -0.1, 0.2), turn),
        Solid("cylinder", (0.1, 0.4), "grey", (-0.2, 0.1, 0.0), turn),
        ball(0.12, "grey", (0.0, 0.3, -0.1)),
    )
    drawn = (
        rng.uniform(-0.5, 0.5, (count, 3)) * [0.1, 0.2, 0.3],
        np.column_stack([*in_disc(rng, count, 0.1), rng.uniform(-0.2, 0.2, count)]),
        in_ball(rng, count, 0.12),
    )
    volumes = (0.1 * 0.2 * 0.3, np.pi * 0.1**2 * 0.4, 4.0 / 3.0 * np.pi * 0.12**3)
    points = np.concatenate(
        [one @ rotation_from_rpy(solid.rpy).T + solid.xyz for one, solid in zip(drawn, solids, strict=True)]
    )
    weights = np.repeat(1000.0 * np.array(volumes) / count, count)
    mass, com, inertia = LinkSketch("it", "", solids).inertial(1000.0)
    assert mass == pytest.approx(weights.sum())
    middle = weights @ points / weights.sum()
    assert np.allclose(com, middle, atol=3e-4)
    d = points - middle
    second = (weights[:, None] * d).T @ d
    assert np.allclose(inertia, np.trace(second) * np.eye(3) - second, atol=3e-3 * np.abs(inertia).max())


def in_disc(rng: np.random.Generator, count: int, radius: float) -> tuple[np.ndarray, np.ndarray]:
    r, angle = radius * np.sqrt(rng.uniform(size=count)), rng.uniform(0.0, 2.0 * np.pi, count)
    return r * np.cos(angle), r * np.sin(angle)


def in_ball(rng: np.random.Generator, count: int, radius: float) -> np.ndarray:
    way = rng.normal(size=(count, 3))
    return radius * way / np.linalg.norm(way, axis=1)[:, None] * np.cbrt(rng.uniform(size=(count, 1)))


def test_a_crank_that_cannot_go_round_has_limits_inside_which_it_closes(tmp_path: Path) -> None:
    sizes = {"crank": 0.3, "coupler": 0.25, "rocker": 0.2, "ground": 0.35, "tracer": 0.1}
    write_draft(draft("robot", "fourbar", sizes), tmp_path / "robot")
    chain = cutjoint.load(str(tmp_path / "robot"))
    limits = chain.description.joint("crank").limits
    assert limits.lower < chain.home.q[0] < limits.upper < limits.lower + 2 * np.pi
    for angle in np.linspace(limits.lower, limits.upper, 9):
        at = chain.close([angle])
        assert closed_forms.fourbar(sizes, {"crank": angle}, chain.tool(at).pose.position) < 1e-9
    for beyond in (limits.lower - 0.5, limits.upper + 0.5):
        with pytest.raises(CutjointError):
            chain.close([beyond], limits="ignore")
    assert draft("robot", "fourbar").files["robot.urdf"].count('name="crank" type="continuous"') == 1


@pytest.mark.parametrize(
    ("template", "sizes", "told"),
    [
        ("fourbar", {"crank": 1.0}, "crank is 1 m, the other three together reach 0.7 m"),
        ("fourbar", {"rocker": 0.55}, "rocker is 0.55 m"),
        ("fivebar", {"base": 1.0}, "0.3 m, which the distal link of 0.25 m"),
        ("delta", {"base": 2.0}, "the rod is 0.4 m long"),
        ("stewart", {"stroke": 0.6}, "cannot be built"),
        ("stewart", {"base": 5.0}, "stand too flat"),
        (
            "stewart",
            {"base": 0.0015, "platform": 0.0045, "height": 10.0, "stroke": 1.0},
            "singular at home: with its motors locked",
        ),
        ("fourbar", {"crank": -0.1}, "from 0.001 to 100 m, found -0.1"),
        ("fourbar", {"crank": 0.0}, "found 0"),
        ("fourbar", {"crank": float("nan")}, "found nan"),
        ("fourbar", {"crank": 1e9}, "found 1e+09"),
        ("fourbar", {"distal": 0.1}, "Known: crank, coupler"),
        ("blank", {"crank": 0.1}, "has no sizes"),
        ("fourbr", {}, "did you mean 'fourbar'"),
    ],
)
def test_what_cannot_be_is_told_before_anything_is_written(template: str, sizes: dict[str, float], told: str) -> None:
    with pytest.raises(CutjointError) as error:
        draft("robot", template, sizes)
    assert told in str(error.value)


@pytest.mark.parametrize("name", ["con", "NUL", "Com1"])
def test_names_of_devices_are_no_folder_everywhere(name: str) -> None:
    with pytest.raises(InputError, match="Windows has a device"):
        draft(name)


@pytest.mark.parametrize("name", ["", "a b", "1arm", "../arm", "arm.urdf", "Arm<", "é", "a" * 64, "-arm", "arm\n"])
def test_names_that_no_robot_can_have(name: str) -> None:
    with pytest.raises(InputError, match="cannot be the name"):
        draft(name)


def test_the_name_of_a_shipped_robot_would_mean_that_one() -> None:
    with pytest.raises(InputError, match=r"ships with cutjoint.*my_stewart"):
        draft("stewart", "stewart")
