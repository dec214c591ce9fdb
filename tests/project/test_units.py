"""Units: one table, consistent in itself, however a unit is written."""

from __future__ import annotations

import itertools

import pytest

from cutjoint.errors import InputError
from cutjoint.units import UNITS, factor, handy, in_si, kinds_of, plainly_written


def test_the_first_unit_of_every_kind_is_that_of_si_and_no_unit_means_two_things_of_one_kind() -> None:
    for kind, units in UNITS.items():
        assert next(iter(units.values())) == 1.0, kind
        plain = [plainly_written(one) for one in units]
        assert len(set(plain)) == len(plain), kind


def test_quotients_and_products_are_those_of_their_parts() -> None:
    for (force, a), (length, b) in itertools.product(UNITS["force"].items(), UNITS["length"].items()):
        if force != "lbf":
            assert factor(f"{force}/{length}", "stiffness") == pytest.approx(a / b, rel=1e-15)
        torque = factor(f"{force} {length}", "torque")
        assert torque is None or torque == pytest.approx(a * b, rel=1e-15)
    for torque, a in UNITS["torque"].items():
        for angle, b in UNITS["angle"].items():
            stiff = factor(f"{torque}/{angle}", "turning stiffness")
            assert stiff is None or stiff == pytest.approx(a / b, rel=1e-15)
    for angle, b in UNITS["angle"].items():
        speed = factor(f"{angle}/s", "speed of rotation")
        assert speed is None or speed == pytest.approx(b, rel=1e-15)
    assert factor("mNm", "torque") == 1e-3  # not meganewtons
    assert factor("MN/m", "stiffness") == 1e6


@pytest.mark.parametrize(
    ("same", "kind"),
    [
        (("um", "µm", "\u03bcm"), "length"),
        (("N m", "Nm", "N*m", "N·m", "N.m"), "torque"),
        (("kg m2", "kg m²", "kg*m^2"), "inertia"),
        (("1/min", "rpm", "min⁻¹", "min-1", "r/min"), "speed of rotation"),
        (("deg", "°", "degrees"), "angle"),
        (("Ohm", "Ω", "\u2126", "ohm"), "resistance"),
    ],
)
def test_one_unit_written_in_several_ways(same, kind) -> None:
    assert len({factor(one, kind) for one in same}) == 1
    assert factor(same[0], kind) is not None
    assert all(kind in kinds_of(one) for one in same)


def test_quantities_with_and_without_units() -> None:
    for kind, units in UNITS.items():
        for unit, scale in units.items():
            if kind != "number":
                assert in_si("it", f"2.5 {unit}", kind) == pytest.approx(2.5 * scale, rel=1e-15)
        assert in_si("it", "2.5", kind) == in_si("it", 2.5, kind) == 2.5
        with pytest.raises(InputError, match=r"^it must be a .*, found the unit 'furlong'"):
            in_si("it", "1 furlong", kind)
        with pytest.raises(InputError, match=r"^it must be a .*, such as '"):
            in_si("it", "one", kind)


def test_a_handy_unit_keeps_the_quantity() -> None:
    for unit, kind in (("m", "length"), ("rad", "angle"), ("N/m", "stiffness"), ("N m/rad", "turning stiffness")):
        for power in range(-14, 12):
            scale, found = handy(3.0 * 10.0**power, unit)
            back = factor(found, kind)
            assert back is None or scale * back == pytest.approx(1.0, rel=1e-12)
