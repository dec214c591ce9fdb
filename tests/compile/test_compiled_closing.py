"""Closing by compiled Newton steps: only where it is plainly on the same branch, one by one and side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cutjoint import tolerances
from cutjoint.compile.closing import ChainClosing
from cutjoint.compile.equations import newton
from cutjoint.errors import CutjointError


@pytest.mark.parametrize("name", ["fivebar", "omega3"])
def test_what_newton_reaches_is_what_the_chain_reaches(kit: Any, name: str) -> None:
    """From home to targets near and far: it gives up rather than ending on another branch."""
    chain, machine, rng = kit.model(name), kit.machine(name), np.random.default_rng(0)
    closing = ChainClosing(machine.source, machine.library(), np.zeros(0))
    home, scale = chain.home, machine.source.position_scale
    near = far = 0
    for reach in np.linspace(0.02, 2.5, 120):
        target = home.q + reach * rng.uniform(-1, 1, chain.n)
        found = closing.to(home.q_full, target)
        many, arrived = closing.walk(home.q_full[None], target[None], 1)
        try:
            wanted = chain.close(target).q_full
        except CutjointError:
            assert found is None
            assert not arrived[0]
            continue
        if found is not None:
            near += 1
            np.testing.assert_allclose(found.q_full, wanted, rtol=0, atol=1e-10)
            assert max(found.gap) < 1e-12
        if arrived[0]:
            np.testing.assert_allclose(many[0], wanted, rtol=0, atol=1e-10)
        if np.abs((wanted - home.q_full) / scale).max() > 3.0 * tolerances.STRIDE.value:
            far += 1
            assert found is None, "a step this long is for the chain's own continuation"
    assert near > 10
    assert far > 10


def test_the_rule_is_the_same_for_numbers_and_arrays() -> None:
    steps = np.array([1e-3, 0.2, 1e-12])
    np.testing.assert_array_equal(newton.longest(steps), [newton.longest(float(one)) for one in steps])
    assert newton.longest(None) == tolerances.STRIDE.value
    assert newton.arrived(1e-16, np.inf)
    assert newton.arrived(0.5 * tolerances.CLOSURE.value, tolerances.CLOSURE.value)
    assert not newton.arrived(1e-3 * tolerances.CLOSURE.value, tolerances.CLOSURE.value)
    assert not newton.arrived(2.0 * tolerances.CLOSURE.value, 2.0 * tolerances.CLOSURE.value)
