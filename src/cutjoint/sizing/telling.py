"""What sizing found, as tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cutjoint.mechanism import Actuator
from cutjoint.reprs import clipped
from cutjoint.sizing.anywhere import Anywhere
from cutjoint.sizing.matching import MotorFit
from cutjoint.sizing.sizing import Sizing
from cutjoint.sizing.values import Extreme, SizedCycle
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

SHOWN = 3
"""Motors of an actuator in a table."""
LONGEST = 24
ROUNDING = 1e-11


def tables_of(found: Sizing) -> Iterator[TextTable]:
    """All tables that there are of it."""
    yield effort_table(found)
    yield power_table(found)
    yield cycle_table(found)
    if found.fits:
        yield motor_table(found)
    if found.bearings:
        yield bearing_table(found)


def _in(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}"


def _speed_unit(actuator: Actuator) -> str:
    return f"{actuator.unit}/s"


def _when(found: Sizing, one: Extreme) -> str:
    if len(found.cycles) == 1:
        return f"{one.time:.4g}"
    number = [cycle.name for cycle in found.cycles].index(one.trajectory) + 1
    return f"{one.time:.4g} ({number})"


def _quiet(value: float, beside: Iterable[float]) -> float:
    """A value; 0 where it is rounding beside others."""
    return value if abs(value) > ROUNDING * max(map(abs, beside), default=0.0) else 0.0


def effort_table(found: Sizing) -> TextTable:
    """Efforts and speeds of every actuator, the worst of all trajectories."""
    rows = []
    for one in found.worst:
        force, speed = one.actuator.effort_unit, _speed_unit(one.actuator)
        alike = [other for other in found.worst if other.actuator.kind == one.actuator.kind]
        efforts, speeds = [other.effort.value for other in alike], [other.speed.value for other in alike]
        rows.append(
            (
                clipped(one.actuator.name, LONGEST),
                _in(_quiet(one.effort.value, efforts), force),
                _when(found, one.effort),
                _in(_quiet(one.rms_effort, efforts), force),
                _in(_quiet(one.holding.value, efforts), force),
                _in(_quiet(one.speed.value, speeds), speed),
                _in(_quiet(one.rms_speed, speeds), speed),
            )
        )
    columns = ("actuator", "peak effort", "at [s]", "rms effort", "holding at rest", "peak speed", "rms speed")
    several = len(found.cycles) > 1
    note = "the worst of all trajectories; in ( ) the number of the trajectory" if several else ""
    return TextTable(f"{found.robot}: efforts and speeds", columns, rows, columns[1:], note)


def power_table(found: Sizing) -> TextTable:
    """Powers and energies of every actuator."""
    powers = [size for one in found.worst for size in (one.power.value, one.returned.value)]
    energies = [size for one in found.worst for size in (one.given, one.back)]
    rows = [
        (
            clipped(one.actuator.name, LONGEST),
            f"{_quiet(one.power.value, powers):.4g}",
            f"{_quiet(one.returned.value, powers):.4g}",
            f"{_quiet(one.given, energies):.4g}",
            f"{_quiet(one.back, energies):.4g}",
        )
        for one in found.worst
    ]
    columns = ("actuator", "peak power [W]", "peak coming back [W]", "energy given [J]", "energy coming back [J]")
    return TextTable(f"{found.robot}: power, and energy of a cycle", columns, rows, columns[1:])


def cycle_table(found: Sizing) -> TextTable:
    """The trajectories."""
    rows = [
        (
            f"{number}",
            clipped(one.name, LONGEST),
            f"{one.duration:.4g}",
            *(f"{_quiet(value, _moved(one)):.4g}" for value in (_work(one), one.lost, one.received, one.gained)),
            f"{max(one.balance, one.error):.1e}",
        )
        for number, one in enumerate(found.cycles, start=1)
    ]
    columns = (
        "", "trajectory", "time [s]", "work [J]", "friction [J]", "loads [J]", "gained [J]", "off by",
    )  # fmt: skip
    note = "off by: what the energies, or two orders of integration, miss each other by, relative"
    return TextTable(f"{found.robot}: energy of all actuators", columns, rows, columns[2:], note)


def _work(cycle: SizedCycle) -> float:
    """Work of all actuators [J]."""
    return sum(one.work for one in cycle.duties)


def _moved(cycle: SizedCycle) -> list[float]:
    """Energies that go to and fro [J]."""
    return [size for one in cycle.duties for size in (one.given, one.back)]


def motor_table(found: Sizing) -> TextTable:
    """The best motors of every actuator."""
    rows, left = [], 0
    for actuator in found.actuators:
        fits = found.fits_of(actuator.name)
        left += max(len(fits) - SHOWN, 0)
        rows += [_motor_row(one) for one in fits[:SHOWN]]
    columns = ("actuator", "motor", "gear", "best gear", "peak", "rms", "speed", "winding", "verdict")
    note = "peak, rms, speed: part of what the motor can give, at its gear"
    if any(one.motor.kind != one.actuator.kind for one in found.fits):
        note += f"; behind a screw of {found.gearing.pitch:g} m a turn"
    if left:
        note += f"; {left} more that fit less well, see --json"
    return TextTable(f"{found.robot}: motors", columns, rows, columns[2:8], note)


def _motor_row(one: MotorFit) -> tuple[str, ...]:
    warm = "" if one.temperature is None else f"{one.temperature:.0f} degC"
    verdict = Cell("fits", "good") if one.fits else Cell(f"no: {one.why_not}", "bad")
    return (
        clipped(one.actuator.name, LONGEST),
        clipped(one.motor.name, LONGEST),
        f"{one.ratio:.4g}",
        f"{one.best_ratio:.4g}",
        *(f"{100.0 * use:.0f} %" for use in (one.peak_use, one.heat_use, one.speed_use)),
        warm,
        verdict,
    )


def bearing_table(found: Sizing) -> TextTable:
    """What joints and cuts carry."""

    forces = [one.force.value for one in found.bearings]
    moments = [one.moment.value for one in found.bearings]

    def told(one: Extreme | None, beside: list[float]) -> str:
        return "" if one is None else f"{_quiet(one.value, beside):.4g}"

    rows = [
        (
            clipped(one.name, LONGEST),
            told(one.force, forces) + ("" if one.is_unique else "?"),
            told(one.radial, forces),
            told(one.axial, forces),
            told(one.moment, moments),
            told(one.tilting, moments),
            f"{_quiet(one.mean_force, forces):.4g}",
        )
        for one in found.bearings
    ]
    columns = (
        "joint or cut", "force [N]", "radial [N]", "axial [N]", "moment [N m]", "tilting [N m]", "mean [N]",
    )  # fmt: skip
    note = "" if all(one.is_unique for one in found.bearings) else "? one of many that are possible, the least"
    return TextTable(f"{found.robot}: largest loads of bearings", columns, rows, columns[1:], note)


def anywhere_table(robot: str, found: Anywhere) -> TextTable:
    """The worst case anywhere."""
    rows = [
        (
            clipped(actuator.name, LONGEST),
            _in(found.effort[i], actuator.effort_unit),
            _in(found.speed[i], _speed_unit(actuator)),
            f"{found.power[i]:.4g}",
            _in(found.holding[i], actuator.effort_unit),
            f"{found.reach[0, i]:.4g} to {found.reach[1, i]:.4g} {actuator.unit}",
        )
        for i, actuator in enumerate(found.actuators)
    ]
    columns = ("actuator", "effort", "speed", "power below [W]", "holding at rest", "looked at")
    title = f"{robot}: the worst case of {found.postures} postures"
    return TextTable(title, columns, rows, columns[1:])
