"""The search for the smallest gain, on functions whose answer is known."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutjoint.errors import InputError
from cutjoint.tuning.smallest import smallest_gain


@given(st.integers(50, 20000), st.floats(0.3, 3.0), st.floats(-2.0, -0.3), st.floats(0.0, 0.999))
def test_it_finds_the_smallest_integer(answer, off, power, fraction):
    """error = gain^power falls; the bound is met between answer - 1 and answer."""
    bound = (answer - 1 + fraction) ** power
    found = smallest_gain(lambda gain: gain**power, bound, max(2, round(off * answer)))
    assert found.gain == answer
    assert found.error < bound <= found.error_below
    assert found.runs < 25
    assert found.error_of_guess == max(2, round(off * answer)) ** power


def test_a_bound_that_no_gain_keeps_is_an_error():
    with pytest.raises(InputError, match="no gain near 100"):
        smallest_gain(lambda gain: 1.0 + 1.0 / gain, 1.0, 100)
    with pytest.raises(InputError, match="no gain near 100"):
        smallest_gain(lambda gain: 0.5, 1.0, 100)


def test_a_right_guess_costs_two_runs():
    assert smallest_gain(lambda gain: 1.0 / gain, 1.0 / 99.5, 100).runs == 2
