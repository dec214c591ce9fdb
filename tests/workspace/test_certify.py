"""Certified boxes against closed forms of inverse kinematics that know nothing of them: families of robots, sizes and
mountings, and boxes that a singularity or a limit cuts by a thousandth of their size."""

from __future__ import annotations

from contextlib import suppress
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from kit.led import Standing, stand, with_limits
from kit.led_robots import LED, drawn, somewhere
from kit.sized import Size

import cutjoint
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.errors import ActuationError, CutjointError, InputError, UnknownNameError
from cutjoint.workspace import Certificate, certify
from cutjoint.workspace.certified import cover
from cutjoint.workspace.certified.enclosing import cosine, enclose, reciprocal, root, sine
from cutjoint.workspace.certified.forms import form, terms_of
from cutjoint.workspace.certified.goals import BoxGoals
from cutjoint.workspace.certified.proof import _apart, prove
from cutjoint.workspace.certified.system import LedSystem

Array = np.ndarray
Box = dict[str, tuple[float, float]]


# ---- enclosures ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("shares", [1, 2, 3])
def test_forms_hold_what_is_computed(shares: int, order: int) -> None:
    rng, terms = np.random.default_rng(shares), terms_of(shares, order)
    graph = Graph()
    x, y, z = graph.symbols(3)
    two = functions.sqrt(2.0 + x * y) / (3.0 + functions.sin(z) * functions.cos(x - y))
    picked = functions.where_less(z, -40.0, x, two * x)
    results = [x * y - z, functions.sin(x + 2.0 * y) * functions.cos(z) * x, two, -picked + 0.1 * x * x * x]
    program = assemble(graph, "test", {"x": [x, y, z]}, {"r": results}, fused=False)
    boxes, size = 40, terms.size
    lines = rng.normal(size=(3, size, boxes)) * np.where(np.arange(size) > 0, 0.1, 0.5)[:, None]
    lines *= np.where(np.arange(size)[:, None] > 0, 10.0 ** rng.uniform(-6.0, 0.0, boxes), 1.0)
    rests = np.abs(lines[:, 1:]).sum(axis=1) * rng.uniform(0.0, 0.1, (3, boxes))
    found = enclose(program, [form(terms, line, rest) for line, rest in zip(lines, rests, strict=True)])
    for _ in range(60):
        share = rng.uniform(-1.0, 1.0, shares).round(int(rng.integers(0, 4)))
        values = terms.values(share)
        a, b, c = (
            values @ line + rng.uniform(-1.0, 1.0, boxes) * rest for line, rest in zip(lines, rests, strict=True)
        )
        two_at = np.sqrt(2.0 + a * b) / (3.0 + np.sin(c) * np.cos(a - b))
        picked_at = np.where(c < -40.0, a, two_at * a)
        known = [a * b - c, np.sin(a + 2.0 * b) * np.cos(c) * a, two_at, -picked_at + 0.1 * a**3]
        for one, value in zip(found, known, strict=True):
            away = np.abs(value - values @ one.line) - one.rest
            sure = np.isfinite(one.rest)
            assert (away[sure] <= 1e-15 * (1.0 + np.abs(value[sure]))).all()
            assert sure.sum() > 0.7 * boxes


@pytest.mark.parametrize("order", [2, 3])
def test_bounds_of_functions_hold_at_the_ends_and_are_near(order: int) -> None:
    """Of x = m + g s alone, at s = -1 and 1, where the rest is all that is left; and it is no more than needed."""
    middle, slope = np.linspace(0.5, 3.5, 60), np.linspace(0.05, 0.25, 60)
    x = form(terms_of(1, order), np.array([middle, slope, *[0.0 * slope] * (order - 1)]), np.zeros(60))
    for led, function in ((sine, np.sin), (cosine, np.cos), (root, np.sqrt), (reciprocal, np.reciprocal)):
        found = led(x)
        away = [np.abs(function(middle + s * slope) - s ** np.arange(order + 1) @ found.line) for s in (-1.0, 1.0)]
        assert (np.maximum(*away) <= found.rest + 1e-15).all()
        assert (np.maximum(*away) / found.rest).max() > 0.2


@pytest.mark.parametrize("order", [2, 3])
def test_goals_hold_all_targets_of_a_box(order: int) -> None:
    chain = cutjoint.load("stewart")
    rng = np.random.default_rng(0)
    goals = BoxGoals(chain, chain.task.names, (0, 2, 5))
    middles, halves = rng.uniform(-0.8, 0.8, (20, 6)), np.zeros((20, 6))
    halves[:, [0, 2, 5]] = 10.0 ** rng.uniform(-6.0, -0.5, (20, 3))
    found = goals.forms(middles, halves, order)
    for _ in range(20):
        share = rng.uniform(-1.0, 1.0, 3)
        at = middles.copy()
        at[:, [0, 2, 5]] += share * halves[:, [0, 2, 5]]
        values = terms_of(3, order).values(share)
        for k, number in enumerate(goals.numbers(at).T):
            assert (np.abs(number - values @ found[k].line) <= found[k].rest + 1e-15).all()


@pytest.mark.parametrize("shares", [1, 2, 3])
def test_a_matrix_is_as_far_from_its_moving_inverse_as_told(shares: int) -> None:
    """For matrices of every goal and every rest; near where the rest is small, and not at all told too far."""
    rng, terms, size, boxes = np.random.default_rng(shares), terms_of(shares), 4, 6
    line = rng.normal(size=(terms.size, boxes, size, size)) * 0.04
    line[0] = np.eye(size) + 0.2 * rng.normal(size=(boxes, size, size))
    rest = 0.01 * rng.uniform(0.0, 1.0, (boxes, size, size)) * np.arange(boxes)[:, None, None] / boxes
    inverse = np.linalg.inv(line[0]) * (1.0 + 1e-3 * rng.uniform(-1.0, 1.0, (boxes, 1, 1)))
    bound, grown, _ = _apart(terms, inverse, line, rest)
    turned, worst = inverse @ line, np.zeros_like(bound)
    for share in rng.uniform(-1.0, 1.0, (60, shares)).round(int(rng.integers(0, 3))):
        values = terms.values(share)
        m = np.tensordot(values[1 : 1 + shares], turned[1 : 1 + shares], 1)
        follows = np.eye(size) - m + m @ m - np.tensordot(values[1 + shares :], turned[1 + shares :], 1)
        matrix = np.tensordot(values, line, 1) + rest * rng.choice([-1.0, 1.0], rest.shape)
        away = np.abs(np.eye(size) - follows @ inverse @ matrix)
        assert (away <= bound).all()
        assert (np.abs(follows) <= grown).all()
        worst = np.maximum(worst, away)
    assert (worst / bound).mean() > 0.1


# ---- families --------------------------------------------------------------------------------------------------------


def box_around(standing: Standing, part: float, over: int) -> Box:
    """A box around home, over some of the led coordinates."""
    task = standing.chain.task
    at = task.coordinates(task.home)
    spread = float(np.min(standing.led.spread)) * (0.1 if standing.led.plan.name == "pan_tilt" else 1.0)
    edges = [part * spread * (standing.size.length if name in "xyz" else 1.0) for name in task.names]
    rows = list(range(over))
    if len(task.names) > standing.chain.n:  # on a surface: the coordinates that tell most
        jacobian = standing.chain.tool(standing.chain.home).jacobian
        rows = list(max(combinations(range(3), 2), key=lambda pair: abs(np.linalg.det(jacobian[list(pair)]))))
    return {task.names[k]: (at[k] - edges[k], at[k] + edges[k]) for k in rows}


def poses_in(standing: Standing, certificate: Certificate, shares: Array) -> list[Array]:
    task = standing.chain.task
    middle, half = 0.5 * (certificate.lower + certificate.upper), 0.5 * (certificate.upper - certificate.lower)
    names = certificate.names
    held = dict(certificate.held)
    return [task.pose({**held, **dict(zip(names, middle + share * half, strict=True))}).matrix for share in shares]


def regular_throughout(standing: Standing, certificate: Certificate, rng: np.random.Generator) -> None:
    """The closed form reaches all of a certified box, and its Jacobian's determinant keeps its sign."""
    d = len(certificate.names)
    shares = np.array([*product((-1.0, 1.0), repeat=d), *rng.uniform(-1.0, 1.0, (40, d))])
    chain, signs = standing.chain, set[float]()
    if len(chain.task.names) > chain.n:
        middle, half = 0.5 * (certificate.lower + certificate.upper), 0.5 * (certificate.upper - certificate.lower)
        for share in shares:
            chain.reach(dict(zip(certificate.names, (middle + share * half).tolist(), strict=True)), free=True)
        return
    for pose, share in zip(poses_in(standing, certificate, shares), shares, strict=True):
        known = standing.joints_at(pose)
        steps = [share + 1e-4 * step for step in np.eye(d)]
        rates = np.array([standing.joints_at(one) - known for one in poses_in(standing, certificate, np.array(steps))])
        if d == chain.n:
            signs.add(float(np.sign(np.linalg.det(rates))))
        unit = standing.length if standing.led.slides else 1.0
        assert np.abs(rates).max() < 0.1 * unit
    assert len(signs) <= 1
    assert 0.0 not in signs
    if standing.led.plan.name == "tripod":
        return  # what is not led moves along, and the closed form wants to know how
    for pose in poses_in(standing, certificate, shares[:: len(shares) // 4]):
        reached = chain.reach(pose, free=True)
        away = reached.q - standing.joints_at(pose)
        away = away / standing.length if standing.led.slides else np.arctan2(np.sin(away), np.cos(away))
        assert np.abs(away).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", list(LED))
def test_families_are_certified_where_their_closed_form_is_regular(name: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng([seed, *name.encode()])
    standing = somewhere(name, seed, tmp_path, rng)
    found = certify(standing.chain, box_around(standing, 0.1, min(2 if seed else 3, standing.chain.n)), most=2000)
    assert found.is_certified, (found, found.counter_example)
    regular_throughout(standing, found, rng)


# ---- boxes that are cut --------------------------------------------------------------------------------------------


class FiveBarMap:
    """How far the tool of a five-bar is from its singularities, in closed form, in its plane; 0 is singular.

    A limb is stretched or folded where the tool is l1 + l2 or |l1 - l2| from its motor (type 1); both rods are on one
    line where their cross product is zero (type 2).
    """

    def __init__(self, standing: Standing) -> None:
        self.form = standing.led.form

    def margin(self, points: Array) -> Array:
        """Of points (N, 2): positive on the side of home."""
        form, rods, room = self.form, [], np.full(len(points), np.inf)
        for k in range(2):
            away = points - form.feet[k, :2]
            r, a, b = np.linalg.norm(away, axis=1), form.radii[k], form.rods[k]
            room = np.minimum(room, np.minimum(a + b - r, r - abs(a - b)))
            along = (a * a - b * b + r * r) / (2.0 * r)
            aside = np.sqrt(np.maximum(a * a - along * along, 0.0)) * (1.0 if k == 0 else -1.0)
            elbow = (along / r)[:, None] * away + (aside / r)[:, None] * np.stack([-away[:, 1], away[:, 0]], axis=1)
            rods.append(elbow - away)
        (a, b), (c, d) = rods[0].T, rods[1].T
        return np.minimum(room, (a * d - b * c) * np.sign(self.turn))

    @property
    def turn(self) -> float:
        """Sign of the cross product at home."""
        bends = np.array(self.form.bends(self.form.centre, np.eye(3)))[:, :2] - self.form.centre[:2]
        return float(bends[0, 0] * bends[1, 1] - bends[0, 1] * bends[1, 0])


@pytest.mark.slow
def test_no_sub_box_is_proven_that_a_singularity_cuts(tmp_path: Path) -> None:
    """The proof alone, without a search for counter-examples, on sub-boxes of all sizes near singularities."""
    standing = stand(drawn("fivebar", 1), tmp_path)
    chain, known, rng = standing.chain, FiveBarMap(standing), np.random.default_rng(0)
    task = chain.task
    home = task.coordinates(task.home)
    system = LedSystem(ChainSource(chain), BoxGoals(chain, task.names, (0, 1)), chain.home)
    middles, q = [], []
    for shift in rng.uniform(-0.3, 0.3, (200, 2)):
        if known.margin((known.form.centre[:2] + shift)[None])[0] > 0.0 and len(q) < 40:
            with suppress(CutjointError):
                q.append(chain.reach(dict(zip(task.names, home + shift, strict=True))).q_full)
                middles.append(home + shift)
    count, share = 5 * len(q), np.linspace(-1.0, 1.0, 41)
    halves = 10.0 ** rng.uniform(-3.0, -0.7, (count, 2))
    centres = np.tile(middles, (5, 1))
    found = prove(system, centres, halves, np.tile(q, (5, 1)))
    points = np.stack(np.meshgrid(share, share), axis=-1).reshape(1, -1, 2) * halves[:, None] + centres[:, None]
    margins = known.margin((points - home).reshape(-1, 2) + known.form.centre[:2]).reshape(count, -1).min(axis=1)
    assert (margins[found.good] > 0.0).all()
    assert found.good.sum() > 0.2 * count
    assert (~found.good[margins <= 0.0]).sum() > 0.1 * count
    assert (found.good & (margins < 0.02)).any()


def largest(known: FiveBarMap, edges: Array) -> float:
    """Scale of a box around home that touches a singularity, found on a fine grid."""
    line = np.linspace(-1.0, 1.0, 201)
    shares = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    low, high = 0.05, 8.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        inside = (known.margin(known.form.centre[:2] + middle * edges * shares) > 0.0).all()
        low, high = (middle, high) if inside else (low, middle)
    return low


def centred(standing: Standing, edges: Array) -> Box:
    task = standing.chain.task
    at = task.coordinates(task.home)
    return {name: (x - e, x + e) for name, x, e in zip(task.names, at.tolist(), edges.tolist(), strict=True)}


def cut_by_a_thousandth(seed: int, size: Size, folder: Path) -> None:
    """A random five-bar: what a singularity cuts by a thousandth is refused, what is as much smaller is proven."""
    standing = stand(drawn("fivebar", seed), folder, size)
    known = FiveBarMap(standing)
    edges = np.random.default_rng(seed).uniform(0.02, 0.06, 2)
    scale = largest(known, edges) * edges * size.length
    wrong = certify(standing.chain, centred(standing, 1.001 * scale), most=4000)
    assert wrong.status == "refused", wrong
    assert wrong.counter_example is not None
    at = np.array([wrong.counter_example.at[name] for name in wrong.names])
    home = standing.chain.task.coordinates(standing.chain.task.home)
    assert known.margin((at - home)[None] / size.length + known.form.centre[:2])[0] < 1e-6
    right = certify(standing.chain, centred(standing, 0.995 * scale), most=20_000)
    assert right.is_certified, right


@pytest.mark.slow
def test_what_a_singularity_cuts_by_a_thousandth_is_refused(tmp_path: Path) -> None:
    cut_by_a_thousandth(0, Size(), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("size", [Size(length=1e-3), Size(length=1e3), Size(offset=np.array([1e4, -1e4, 10.0]))])
def test_so_it_is_at_any_size_and_place(seed: int, size: Size, tmp_path: Path) -> None:
    cut_by_a_thousandth(seed, size, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planar_3rrr", "cpm"])
def test_between_proven_and_refused_is_next_to_nothing(name: str, tmp_path: Path) -> None:
    """Grown until it is refused, a box was proven until a few thousandths before, and every counter-example counts."""
    chain = stand(drawn(name, 0), tmp_path).chain if name in LED else cutjoint.load(name)
    at = chain.task.coordinates(chain.task.home)
    over = chain.task.names[:2]
    low, high = 0.001 * chain.length, 4.0 * chain.length
    while high / low > 1.01:
        edge = float(np.sqrt(low * high))
        found = certify(chain, {one: (at[k] - edge, at[k] + edge) for k, one in enumerate(over)}, most=2000)
        assert found.status != "open", found
        low, high = (edge, high) if found.is_certified else (low, edge)


def test_a_box_that_a_joint_limit_cuts_is_refused_and_one_that_touches_it_is_proven() -> None:
    description = with_limits(cutjoint.load("cpm").description, {"limb1_slide": (0.5, 0.63)})
    chain = cutjoint.ClosedChain(description)
    for beyond, status in ((0.0, "certified"), (2e-5, "refused")):
        found = certify(chain, {"x": (0.62, 0.63 + beyond)})
        assert found.status == status, (found, found.counter_example)
    assert found.counter_example is not None
    assert found.counter_example.why == "joint limit"
    assert found.counter_example.joint == "limb1_slide"


# ---- answers ---------------------------------------------------------------------------------------------------------


def test_answers() -> None:
    chain = cutjoint.load("fivebar")
    told: list[float] = []
    box = {"x": (-0.03, 0.03), "z": (0.28, 0.32)}
    found = certify(chain, box, told=told.append)
    assert found.is_certified
    assert found.part == 1.0
    assert told == sorted(told)
    assert found.proven.all()
    assert np.isclose(np.prod(found.highs - found.lows, axis=1).sum(), 0.06 * 0.04)
    few = certify(chain, box, most=1)
    assert few.status == "open"
    assert few.part < 1.0
    assert not few.is_certified
    held = certify(chain, {"x": (-0.05, 0.05)}, held={"z": 0.3})
    assert held.is_certified
    assert held.held == {"z": 0.3}


def test_a_caller_can_end_a_proof() -> None:
    chain, told = cutjoint.load("fivebar"), list[float]()
    found = certify(chain, {"x": (-0.12, 0.12)}, held={"z": 0.3}, told=lambda part: bool(told.append(part)))
    assert found.status == "open"
    assert told == [0.0]
    assert found.doubtful == {"x": (-0.12, 0.12)}


def test_what_is_too_small_to_be_halved_is_never_certified(monkeypatch: pytest.MonkeyPatch) -> None:
    chain, box = cutjoint.load("fivebar"), {"x": (-0.12, 0.12)}
    assert certify(chain, box).is_certified
    monkeypatch.setattr(cover, "LEAST", 1.0)
    found = certify(chain, box)
    assert found.status == "open"
    assert list(found.doubtful) == ["x"]
    assert found.looked < 4


def test_another_assembly_mode_is_told_and_can_be_chosen() -> None:
    chain = cutjoint.load("fivebar")
    box = {"x": (-0.01, 0.01), "z": (0.09, 0.11)}
    found = certify(chain, box)
    assert found.counter_example is not None
    assert found.counter_example.why == "another assembly mode"
    assert certify(chain, box, near=chain.reach({"x": 0.0, "z": 0.1})).is_certified


def test_what_is_no_box_is_refused() -> None:
    chain = cutjoint.load("fivebar")
    with pytest.raises(UnknownNameError, match="'y'"):
        certify(chain, {"y": (0.0, 1.0)})
    for box, held in (({}, {}), ({"x": (0.1, 0.1)}, {}), ({"x": (0.0, np.inf)}, {}), ({"x": (0.0, 0.1)}, {"x": 0.0})):
        with pytest.raises(InputError):
            certify(chain, box, held=held)
    with pytest.raises(InputError, match="most"):
        certify(chain, {"x": (-0.1, 0.1)}, most=0)
    with pytest.raises(InputError, match="chain"):
        certify(cutjoint.published("cpm"), {"x": (0.5, 0.6)})
    with pytest.raises(InputError, match="half a turn"):
        certify(cutjoint.load("stewart"), {"rz": (-4.0, 4.0)})
    with pytest.raises(ActuationError):
        certify(cutjoint.load("redundant"), {"x": (-0.1, 0.1)})
