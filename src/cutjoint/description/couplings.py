"""Couplings: a joint whose coordinate is the sum of curves of other joints' coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cutjoint.description.curves import Curve, Polynomial, added_up
from cutjoint.findings import NOWHERE, Place
from cutjoint.reprs import line


@dataclass(frozen=True)
class DriverCurve:
    """What one joint adds to a coupling: a curve of its coordinate."""

    driver: str
    curve: Curve = field(default_factory=Polynomial)


@dataclass(frozen=True)
class Coupling:
    """A loop closed by gears, belts, tendons, a mimic or a cam: the coordinate of `joint` = `offset` + the sum of the
    curves of its drivers' coordinates.  Without drivers it holds the joint at `offset`."""

    name: str
    joint: str
    drives: tuple[DriverCurve, ...] = ()
    offset: float = 0.0
    place: Place = NOWHERE

    __repr__ = line("name", "joint", "drivers", "offset", offset="m or rad")

    @classmethod
    def geared(
        cls, name: str, joint: str, driver: str, ratio: float = 1.0, offset: float = 0.0, place: Place = NOWHERE
    ) -> Coupling:
        """Coordinate of `joint` = ratio * coordinate of `driver` + offset."""
        return cls.summed(name, joint, {driver: ratio}, offset, place)

    @classmethod
    def summed(
        cls, name: str, joint: str, ratios: Mapping[str, float], offset: float = 0.0, place: Place = NOWHERE
    ) -> Coupling:
        """Coordinate of `joint` = sum of ratio * coordinate over the drivers + offset."""
        drives = tuple(DriverCurve(driver, Polynomial((0.0, ratio))) for driver, ratio in ratios.items())
        return cls(name, joint, drives, offset, place)

    @property
    def drivers(self) -> tuple[str, ...]:
        """Names of the joints that drive it."""
        return tuple(one.driver for one in self.drives)

    @property
    def ratios(self) -> Mapping[str, float] | None:
        """Driver -> ratio where all curves are straight lines through zero, else None."""
        slopes = {one.driver: one.curve.ratio for one in self.drives}
        kept = {driver: ratio for driver, ratio in slopes.items() if ratio is not None}
        return kept if len(kept) == len(self.drives) else None

    @property
    def formula(self) -> str:
        """What it says, to be read: `carrier = 0.5 left + 0.5 right + 0.1`."""
        terms = [term for one in self.drives for term in one.curve.terms(one.driver)]
        constant = self.offset + sum(factor for factor, what in terms if not what)
        return f"{self.joint} = {added_up([*(one for one in terms if one[1]), (constant, '')])}"

    @property
    def gear(self) -> tuple[str, float] | None:
        """Driver and ratio where one joint drives it along a straight line through zero: what gears and `<mimic>` do;
        else None."""
        ratios = self.ratios
        return next(iter(ratios.items())) if ratios is not None and len(ratios) == 1 else None
