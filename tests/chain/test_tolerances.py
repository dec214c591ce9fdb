"""Every tolerance is positive and has its unit and its reason."""

from __future__ import annotations

from cutjoint import tolerances


def test_each_has_a_reason() -> None:
    found = [one for one in vars(tolerances).values() if isinstance(one, tolerances.Tolerance)]
    assert len(found) >= 10
    for one in found:
        assert one.value > 0.0
        assert one.unit
        assert len(one.reason) > 20
