"""Linear loops, poles and onsets of instability against the loop as it is simulated, on families of robots.

Five-bars and Deltas of random sizes, a thousandth to a thousand times as large, mounted any way, and robots of which
some actuators slide and some turn.  What is derived here knows of a loop nothing but its runs: a column of the
transition matrix is what becomes of a little that is off at the beginning, and its eigenvalues are the poles.
"""

import numpy as np
import pytest
from kit.blueprint import Blueprint, random_rotation
from kit.mechanisms import limb
from kit.sized import Size

import cutjoint
from cutjoint.drafting import TEMPLATES, draft, write_draft
from cutjoint.motion import Reference, about_home
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware
from cutjoint.tuning import PaperRule, PolePlacement, margins_of, tune
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.linear import JointRest, steps_of
from cutjoint.tuning.poles import by_poles

pytest.importorskip("control")

LITTLE = 1e-5


def robot_of(kind, rng, folder):
    """A robot of random sizes, how large it is and how it stands; and its unit of time [s]."""
    if kind == "mixed":
        return cutjoint.load(mixed(rng).write(folder)), 1.0
    lengths = {name: one.default * rng.uniform(0.9, 1.1) for name, one in TEMPLATES[kind].sizes.items()}
    write_draft(draft("robot", kind, lengths), folder)
    length = 10.0 ** rng.uniform(-3.0, 3.0)
    size = Size(length=length, mass=length**3, rotation=random_rotation(rng))
    return cutjoint.ClosedChain(size.of(cutjoint.load(folder).description)), size.time


def mixed(rng):
    """A five-bar of which one crank is a slide."""
    plan, tilt = Blueprint("mixed", rng), random_rotation(rng)
    points = [[0.0, 0.0], [-0.1, 0.3], [0.15, 0.55], [0.4, 0.2]]
    at = [tilt @ np.append(np.array(point) + 0.02 * rng.normal(size=2), 0.0) for point in points]
    axis = tilt @ np.array([0.0, 0.0, 1.0])
    limb(plan, "a", "base", [("continuous", at[0], axis), ("continuous", at[1], axis)])
    slide = tilt @ np.append(np.array([1.0, 0.1]), 0.0) / np.hypot(1.0, 0.1)
    limb(plan, "b", "base", [("prismatic", at[3], slide), ("continuous", at[3], axis)])
    plan.cut("tip", "revolute", "a_link2", "b_link2", at[2], axis)
    plan.actuators, plan.tool = ["a1", "b1"], ("a_link2", at[2])
    return plan


def poles_of_runs(case, loop, gains, q, span):
    """Eigenvalues of how the simulated loop at rest at q goes on over `span` [s], as poles [1/s]."""
    n, sizes = case.robot.n, np.tile(steps_of(case.robot), 2)
    sizes[n:] /= span
    off = LITTLE * np.vstack([np.diag(sizes), -np.diag(sizes)])
    reference = Reference(JointRest(q, span), case.reference.mechanism, limits="ignore")
    many = loop.run(
        reference,
        step=span / 40,
        gains={name: np.tile(one, (4 * n, 1)) for name, one in gains.items()},
        start=q + off[:, :n],
        start_velocity=off[:, n:],
    )
    end = np.hstack([many.q[:, -1], many.v[:, -1]])
    return (
        np.log(np.linalg.eigvals(((end[: 2 * n] - end[2 * n :]) / (2.0 * LITTLE * sizes[:, None])).T).astype(complex))
        / span
    )


CASES = [
    pytest.param(kind, law, seed, marks=() if (kind, law, seed) == ("mixed", "feedforward", 0) else pytest.mark.slow)
    for kind, law in (
        ("fivebar", "pd-gravity"),
        ("delta", "pd-gravity"),
        ("mixed", "feedforward"),
        ("fivebar", "computed-torque"),
        ("delta", "computed-torque"),
    )
    for seed in range(1 if kind == "delta" else 2)
]


@pytest.mark.parametrize(("kind", "law", "seed"), CASES)
def test_the_simulated_loop_has_the_poles_that_were_asked_for(kind, law, seed, tmp_path):
    rng = np.random.default_rng(seed)
    robot, second = robot_of(kind, rng, tmp_path / "robot")
    w, z = rng.uniform(10.0, 40.0) / second, rng.uniform(0.5, 1.0)
    case = TuningCase(robot, law, Reference(about_home(robot, 0.05, second), robot))
    gains = {name: np.broadcast_to(one, robot.n) for name, one in by_poles(case, PolePlacement(w, z)).gains.items()}
    loop, found = case.loop(gains), []
    for desired, _ in case.plants:
        found.append(poles_of_runs(case, loop, gains, desired.q, 0.25 / w))
    poles = np.array(found)
    decay, damping = -poles.real.max(), (-poles.real / np.abs(poles)).min()
    if law == "computed-torque":
        assert np.allclose(np.abs(poles), w, rtol=1e-3)
        assert np.allclose(-poles.real, z * w, rtol=1e-3)
        return
    assert decay > z * w * 0.998
    assert damping > z * 0.998
    for one, own in zip(case.linear(gains), poles, strict=True):
        assert np.allclose(np.sort_complex(one.poles), np.sort_complex(own), rtol=2e-3, atol=2e-3 * w)
    assert min(decay / (z * w), damping / z) < 1.03  # no more than is needed


ONSETS = [("fivebar", 0), ("fivebar", 1), ("fivebar", 2), ("mixed", 0), ("delta", 0)]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), ONSETS)
def test_the_simulated_loop_begins_to_grow_where_a_pole_does(kind, seed, tmp_path):
    """With more and more gain, at a random rate, delays and filter; and its growth is the decay of the slowest pole."""
    rng = np.random.default_rng(10 + seed)
    robot, second = robot_of(kind, rng, tmp_path / "robot")
    w = 20.0 / second
    period = rng.uniform(0.02, 0.15) / w
    tick = period / 4.0
    late, acts = rng.integers(0, 7, 2) * tick
    speed = {} if rng.integers(2) else {"speed": Differences(rng.uniform(2.0, 10.0) * w / 6.0)}
    hardware = Hardware(Clock(1.0 / period, tick=tick), Encoder(delay=late), drive=Drive(delay=acts), **speed)
    case = TuningCase(robot, "pd-gravity", Reference(about_home(robot, 0.05, second), robot), hardware=hardware)
    base = by_poles(case, PolePlacement(w, rng.uniform(0.5, 1.0))).gains

    def loop_at(factor):
        return case.linear({name: factor * one for name, one in base.items()})[0]

    factors = np.geomspace(0.01, 1e3, 61)
    k = next(k for k in range(60) if loop_at(factors[k]).stable and not loop_at(factors[k + 1]).stable)
    low, high = factors[k : k + 2]
    for _ in range(20):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if loop_at(middle).stable else (low, middle)
    q, loop = case.reference.at(0.0).q, case.loop(base)
    for factor in (0.9 * low, 1.1 * low):
        about = loop_at(factor)
        assert about.stable == (margins_of(about, ("a",) * robot.n).delay > 0.0) == (factor < low)
        span = np.ceil(8.0 / abs(about.decay) / period) * period
        many = loop.run(
            Reference(JointRest(q, span), case.reference.mechanism, limits="ignore"),
            step=tick,
            every=period,
            gains={name: np.tile(factor * one, (2, 1)) for name, one in base.items()},
            start=np.vstack([q, q + 1e-7 * rng.normal(size=robot.n) * steps_of(robot)]),
        )
        off = ((many.q[1] - many.q[0]) / steps_of(robot)) ** 2
        quarter = len(off) // 4
        grown = 0.5 * np.log(off[-quarter:].mean() / off[-2 * quarter : -quarter].mean()) / (quarter * period)
        assert grown == pytest.approx(-about.decay, rel=0.15)


@pytest.mark.slow
def test_the_rule_gives_robots_that_slide_and_turn_gains_by_their_inertias(tmp_path):
    robot = cutjoint.load(mixed(np.random.default_rng(0)).write(tmp_path / "robot"))
    reference = Reference(about_home(robot), robot)
    found = tune(robot, "pd-gravity", reference, by=PaperRule(1e-3), limit=[200.0, 500.0])
    inertias = np.max([np.diag(plants[0].mass) for _, plants in TuningCase(robot, "pd", reference).plants], axis=0)
    kp, kd = (found.gains[name] / inertias for name in ("kp", "kd"))
    assert np.allclose(kp, kp[0])
    assert np.allclose(kd, 2.0 * np.sqrt(kp[0]), rtol=1e-5)
    less = {"kp": 0.99 * found.gains["kp"], "kd": np.sqrt(0.99) * found.gains["kd"]}
    again = tune(robot, "pd-gravity", reference, by=PaperRule(1e-3), limit=[200.0, 500.0], compare={"less": less})
    assert again.found.late < 1e-3 < next(row for row in again.rows if row.label == "less").late
    assert not again.unmet
    assert tune(robot, "pd", reference, by=PolePlacement(), of="actuators").error_unit == "rad or lengths"
