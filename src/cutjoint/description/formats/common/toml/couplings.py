"""[[coupling]] tables of a loops.toml, read and written.

driver = "a"                        ratio = 2.0              joint = offset + 2 a
driver = ["a", "b"]                 ratio = [0.5, 0.5]       joint = offset + 0.5 a + 0.5 b
driver = "a"                        polynomial = [c0, c1, c2, ...]    joint = offset + c0 + c1 a + c2 a^2 + ...
driver = "a"                        table = [[x, y], ...]    joint = offset + the spline through the points at a
drives = [{ driver = "a", ratio = 0.5 }, { driver = "b", table = [...] }]       their sum
(no driver)                                                  joint = offset
"""

from __future__ import annotations

from cutjoint.description.curves import Curve, Polynomial, Table
from cutjoint.description.formats.common.toml.scalars import number, numbers, text
from cutjoint.description.model import Coupling, DriverCurve
from cutjoint.description.numbers import LARGEST_PHYSICS
from cutjoint.findings import LARGEST_LENGTH
from cutjoint.toml.table import TomlTable

_FORMS = ("ratio", "polynomial", "table")


def take_coupling(table: TomlTable) -> Coupling | None:
    """A coupling, or None after noting what is wrong with it."""
    name, joint = table.string("name", required=True), table.string("joint", required=True)
    offset = table.number("offset", 0.0)
    several = isinstance(table.data.get("driver"), list)
    if "drives" in table.data:
        drives = [_drive(one) for one in table.tables("drives")]
        extra = [key for key in ("driver", *_FORMS) if key in table.data]
        if extra:
            table.wrong(extra[0], table.take(extra[0]), "either drives, or driver with ratio, polynomial or table")
    elif several:
        drives = list(_sum(table))
    else:
        drives = [_drive(table)] if any(key in table.data for key in ("driver", *_FORMS)) else []
        if not drives and "offset" not in table.data:
            table.take("driver", required=True, expected="the joint that drives it; or an offset at which it is held")
            drives = [None]
    if not drives and "offset" not in table.data:
        key = "drives" if "drives" in table.data else "driver"
        table.wrong(key, table.data.get(key), "at least one joint; or an offset at which the joint is held")
        drives = [None]
    table.finish()
    kept = [one for one in drives if one is not None]
    if not (name and joint) or offset is None or len(kept) < len(drives):
        return None
    return Coupling(name, joint, tuple(kept), offset, table.place())


def _drive(table: TomlTable) -> DriverCurve | None:
    """One driver with its curve, in a table of its own or in that of the coupling."""
    driver = table.string("driver", required=True)
    given = [key for key in _FORMS if key in table.data]
    curve: Curve | None = Polynomial()
    if len(given) > 1:
        for key in given:
            table.take(key)
        table.wrong(given[1], table.data[given[1]], f"one of {', '.join(_FORMS)}")
        curve = None
    elif given == ["ratio"]:
        ratio = table.number("ratio", 1.0)
        curve = None if ratio is None else Polynomial((0.0, ratio))
    elif given == ["polynomial"]:
        values = _list(table, "polynomial", "coefficients, as in [0.0, 1.0, 0.5]")
        curve = None if values is None else Polynomial(values)
    elif given == ["table"]:
        curve = _table(table)
    if table.path[-2:-1] == ("drives",):
        table.finish()
    return DriverCurve(driver, curve) if driver and curve is not None else None


def _sum(table: TomlTable) -> list[DriverCurve | None]:
    """Several drivers with a ratio each."""
    drivers = table.strings("driver", required=True) or ()
    ratios = _list(table, "ratio", "a number for every driver") if "ratio" in table.data else (1.0,) * len(drivers)
    for key in _FORMS[1:]:
        if key in table.data:
            table.wrong(key, table.take(key), "ratio; or drives = [{ driver = ..., polynomial = ... }, ...]")
    if ratios is None or len(ratios) != len(drivers):
        if ratios is not None:
            table.wrong("ratio", table.data.get("ratio"), f"{len(drivers)} numbers, one for every driver")
        return [None]
    return [DriverCurve(driver, Polynomial((0.0, ratio))) for driver, ratio in zip(drivers, ratios, strict=True)]


def _list(table: TomlTable, key: str, expected: str) -> tuple[float, ...] | None:
    """A list of numbers; they are derivatives of lengths by lengths, so small robots have large ones."""
    value = table.take(key)
    if not isinstance(value, list) or not value:
        table.wrong(key, value, expected)
        return None
    return table.numbers(key, value, LARGEST_PHYSICS)


def _table(table: TomlTable) -> Table | None:
    value = table.take("table")
    points: list[tuple[float, float]] = []
    for row in value if isinstance(value, list) else ():
        pair = table.numbers("table", row, LARGEST_LENGTH) if isinstance(row, list) and len(row) == 2 else None
        if pair is None:
            points = []
            break
        points.append((pair[0], pair[1]))
    if len(points) < 2:
        table.wrong("table", value, "two or more points, as in [[0.0, 0.0], [1.0, 0.5]]")
        return None
    return Table(tuple(points))


def coupling_lines(coupling: Coupling) -> list[str]:
    """The lines of a coupling, a blank one before them."""
    lines = ["", "[[coupling]]", f"name = {text(coupling.name)}", f"joint = {text(coupling.joint)}"]
    ratios = coupling.ratios
    if len(coupling.drives) == 1:
        lines += _drive_pairs(coupling.drives[0])
    elif ratios:
        lines.append(f"driver = [{', '.join(map(text, ratios))}]")
        lines.append(f"ratio = {numbers(tuple(ratios.values()))}")
    elif coupling.drives:
        lines += ["drives = [", *(f"  {{ {', '.join(_drive_pairs(one))} }}," for one in coupling.drives), "]"]
    return [*lines, f"offset = {number(coupling.offset)}"]


def _drive_pairs(drive: DriverCurve) -> list[str]:
    curve = drive.curve
    if isinstance(curve, Table):
        form = f"table = [{', '.join(map(numbers, curve.points))}]"
    elif isinstance(curve, Polynomial) and curve.ratio is None:
        form = f"polynomial = {numbers(curve.coefficients)}"
    else:
        form = f"ratio = {number(curve.ratio or 0.0)}"
    return [f"driver = {text(drive.driver)}", form]
