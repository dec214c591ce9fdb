"""Integrators: the stated order is the measured order, on vector spaces and on rotations; tolerances are kept."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.control import NoControl
from cutjoint.description import CutJoint, CutType, Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion import Desired, Reference
from cutjoint.motion.paths import ToolMotion
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, RungeKutta4, State, run
from cutjoint.simulation.integrators import StepError


def solve(method, field, y, end):
    """March to `end`; returns the final state, the times and the number of evaluations."""
    count = 0

    def counted(t, x):
        nonlocal count
        count += 1
        return field(t, x)

    t, times, slope = 0.0, [0.0], counted(0.0, y)
    h = method.first(counted, t, y, slope, end)
    while t < end:
        step = method.step(counted, t, y, slope, h, end, end)
        t, y, h = step.t, step.y, step.ahead
        slope = counted(t, y) if step.slope is None else step.slope
        times.append(t)
    return y, np.array(times), count


def swing(t, y):
    """A pendulum driven in time, with a last component that rides along."""
    return np.array([y[1], -np.sin(y[0]) + 0.3 * np.cos(1.7 * t), y[1] ** 2])


START = np.array([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def exact():
    from scipy.integrate import solve_ivp

    found = solve_ivp(swing, (0.0, 3.0), START, method="DOP853", rtol=1e-13, atol=1e-14)
    return found.y[:, -1]


def test_runge_kutta_4_has_order_4(exact):
    errors = [np.abs(solve(RungeKutta4(h), swing, START, 3.0)[0] - exact).max() for h in (0.04, 0.02, 0.01)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.allclose(slopes, 4.0, atol=0.2), slopes


def test_dormand_prince_has_order_5(exact):
    """With a fixed step: the tolerance is out of reach of the error, the run cut into equal stretches."""
    method = DormandPrince(relative=1e3, absolute=1e3)

    def march(count):
        t, y = 0.0, START
        for end in np.linspace(0.0, 3.0, count + 1)[1:]:
            step = method.step(swing, t, y, swing(t, y), end - t, end, 1e6)
            t, y = step.t, step.y
            assert t == end
        return np.abs(y - exact).max()

    errors = [march(count) for count in (20, 40, 80)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.allclose(slopes, 5.0, atol=0.35), slopes


def test_dormand_prince_step_is_that_of_scipy():
    """The same pair, an independent implementation: one step of equal length agrees to rounding."""
    from scipy.integrate import RK45

    solver = RK45(swing, 0.0, START, 1.0, first_step=0.05, rtol=1e-3, atol=1e-3)
    solver.step()
    step = DormandPrince(1e-3, 1e-3).step(swing, 0.0, START, swing(0.0, START), 0.05, 10.0, 10.0)
    assert np.allclose(step.y, solver.y, rtol=1e-14)


def test_dormand_prince_step_rules():
    method = DormandPrince(1e-6, 1e-9)
    slope = swing(0.0, START)
    # First step: 0.8 relative^(1/5) over the largest scaled slope, the last component left out.
    rate = max(abs(slope[0]) / 1.0, abs(slope[1]) / 1e-3)
    assert np.isclose(method.first(swing, 0.0, START, slope, 100.0), 0.8 * 1e-6**0.2 / rate)
    # No step is longer than a tenth of the run, and one that would come within 10 % of the end reaches it.
    step = method.step(swing, 0.0, START, slope, 5.0, 3.0, 0.5)
    assert step.t <= 0.05
    step = method.step(swing, 0.0, START, slope, 0.0095, 0.01, 10.0)
    assert step.t == 0.01
    # A success that is far too accurate grows fivefold.
    assert np.isclose(step.ahead, 0.05)
    # A failure shrinks, and the next step does not grow right after it.
    failed = method.step(swing, 0.0, START, slope, 2.0, 100.0, 100.0)
    assert failed.t < 2.0
    assert failed.ahead == failed.t


@pytest.mark.parametrize("method", [DormandPrince(1e-8, 1e-10), Adaptive(1e-8, 1e-10), Adaptive(1e-8, 1e-10, "RK45")])
def test_adaptive_methods_keep_their_tolerance(method, exact):
    found, times, _ = solve(method, swing, START, 3.0)
    assert np.abs(found - exact).max() < 1e-6
    assert times[-1] == 3.0
    tighter, more, _ = solve(replace(method, relative=1e-10, absolute=1e-12), swing, START, 3.0)
    assert np.abs(tighter - exact).max() < np.abs(found - exact).max()
    assert more.size > times.size


@pytest.mark.parametrize("method", [DormandPrince(1e-6, 1e-8), Adaptive(1e-6, 1e-8), Adaptive(1e-6, 1e-8, "RK45")])
def test_the_last_component_rides_along_and_does_not_steer(method):
    def loud(t, y):
        return np.array([*swing(t, y)[:2], 1e9 * np.sin(40.0 * t)])

    quiet, loud_times = solve(method, swing, START, 3.0)[1], solve(method, loud, START, 3.0)[1]
    assert np.array_equal(quiet, loud_times)


@pytest.mark.parametrize("method", [DormandPrince(), Adaptive()])
def test_walls_are_found_by_shorter_steps(method):
    """Not a number beyond y = 2: the method creeps up to it and says that no step is small enough."""

    def wall(t, y):
        return np.array([1.0, 0.0]) if y[0] < 2.0 else np.full(2, np.nan)

    with pytest.raises(StepError), np.errstate(all="ignore"):
        solve(method, wall, np.zeros(2), 5.0)


@pytest.mark.parametrize(
    ("make", "error"),
    [
        (lambda: RungeKutta4(0.0), InputError),
        (lambda: RungeKutta4(-1.0), InputError),
        (lambda: DormandPrince(relative=0.0), InputError),
        (lambda: DormandPrince(absolute=np.nan), InputError),
        (lambda: Adaptive(relative=-1.0), InputError),
        (lambda: Adaptive(method="Euler"), UnknownNameError),
    ],
)
def test_bad_settings_are_refused(make, error):
    with pytest.raises(error):
        make()


# ---- rotations: a spinning body hung from a slider by a ball


class Still(Reference):
    """A reference that stands at nought, for robots whose tool nobody leads."""

    trajectory = type("Nothing", (), {"name": "none"})()
    duration = 0.2

    def __init__(self, mechanism):
        self.mechanism = mechanism

    def at(self, t):
        nought = np.zeros(3)
        motion = ToolMotion(nought, nought, nought)
        return Desired(t, np.zeros(1), np.zeros(1), np.zeros(1), motion, self.mechanism.home, self.mechanism)


def spinning(kind):
    """A slider and a body: in a free-flyer held by a spherical cut, or in a spherical joint of the tree."""
    inertia = np.diag([0.02, 0.035, 0.05])
    links = (
        Link("base"),
        Link("slider", Inertial(1.0, inertia=inertia)),
        Link("body", Inertial(2.0, [0.05, 0.02, -0.1], inertia)),
    )
    parent = "base" if kind is JointType.FLOATING else "slider"
    joints = (
        Joint("slide", JointType.PRISMATIC, "base", "slider"),
        Joint("ball", kind, parent, "body"),
    )
    cuts = (CutJoint("hang", CutType.SPHERICAL, Frame("slider"), Frame("body")),) if parent == "base" else ()
    return RobotDescription("spinner", links, joints, cuts, actuators=("slide",), tool=Frame("body"))


@pytest.mark.parametrize("kind", [JointType.FLOATING, JointType.SPHERICAL])
def test_order_4_on_rotations(kind):
    chain = ClosedChain(spinning(kind))
    plant = ConstrainedPlant(chain, project=False)
    v = np.zeros(chain.nv)
    v[-3:] = [9.0, -6.0, 4.0]
    start = State(chain.home.q_full, v)

    def final(method):
        result = run(plant, NoControl(), Still(chain), integrator=method, start=start)
        assert result.energy_drift() < 1e-3
        return result.q_full[-1]

    truth = final(Adaptive(1e-12, 1e-13))
    steps = (8e-3, 4e-3, 2e-3, 1e-3)
    errors = [np.linalg.norm(pin.difference(chain.model, truth, final(RungeKutta4(h)))) for h in steps]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.allclose(slopes, 4.0, atol=0.2), (slopes, errors)
