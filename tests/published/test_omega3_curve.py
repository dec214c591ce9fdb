"""The claim of the Omega-3's paper, with both controllers, from rest, and under worse plants."""

from functools import cache

import numpy as np
import pytest

from cutjoint.experiments import omega3
from cutjoint.papers.omega3.published import ERROR_BOUND, SETTLING_TIME
from cutjoint.tuning.known import GAINS, default_gains

curve_run = cache(omega3.curve_run)


# One case in every run of the tests, the others in the slow ones.
CASES = [
    pytest.param(name, setup, marks=() if (name, setup) == ("computed-torque", "lumped") else pytest.mark.slow)
    for name in omega3.LAWS
    for setup in omega3.SETUPS
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "setup"), CASES)
def test_error_is_below_three_millimetres(name, setup):
    result = curve_run(name, setup)
    assert result.worst_error(SETTLING_TIME) < ERROR_BOUND
    assert result.worst_error() > ERROR_BOUND, "from rest it starts with a larger error"
    assert np.abs(result.v[0]).max() == 0.0
    assert max(result.loop_gap()) < 1e-9
    assert result.energy_drift() < 1e-6


@pytest.mark.slow
def test_worse_plants_are_worse():
    """Lumped rods are what the controller believes; uniform rods and an unknown payload cost accuracy."""
    late = [curve_run("feedforward", setup).worst_error(1.0) for setup in ("lumped", "distributed", "heavy")]
    assert late[0] < late[1] < late[2]


def test_heavy_is_twenty_percent_of_the_payload():
    assert omega3.SETUPS["heavy"].payload == pytest.approx(0.2 * 0.070)


def test_arm_assumptions_move_the_torque_more_than_the_rods_do():
    shapes = omega3.arm_assumptions(101)
    default = shapes[0]
    assert np.abs(default.change).max() == 0.0
    assert default.inertia == pytest.approx(0.100 * 0.070**2 / 2.0)
    for shape in shapes[1:]:
        change = float((shape.change / default.peak).max())
        assert 0.03 < change < 0.25, shape.about


def test_unknown_gains_are_an_error():
    from cutjoint.errors import InputError

    with pytest.raises(InputError, match="no gains are known for controller 'pid'"):
        default_gains("cpm", "pid")
    with pytest.raises(InputError, match="no gains are known for controller 'pd' on 'fivebar'"):
        default_gains("fivebar", "pd")
    assert default_gains("fivebar", "computed-torque") == GAINS["omega3"]["computed-torque"]
    assert default_gains("cpm", "none") == {}
