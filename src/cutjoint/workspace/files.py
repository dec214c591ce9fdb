"""Workspaces on disk: .npz (complete, and read again), .vti for ParaView and PyVista, .parquet a row a reached cell.

A file that is read is strangers' work: its kind and size are looked at first, then the headings of all its arrays, and
what does not fit together is refused before anything is unpacked.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np

from cutjoint.arrays import Array, readonly, readonly_mapping
from cutjoint.doors import door
from cutjoint.errors import FileError, InputError, ResultFileError
from cutjoint.extras import needed
from cutjoint.files import check_place, read_file, write_whole
from cutjoint.simulation.array_archive import ArchiveError, ArrayArchive
from cutjoint.workspace.region import FieldMap, GridAxis, Workspace
from cutjoint.workspace.vtk_image import vti

SCHEMA = 1
KIND = "cutjoint workspace"
SUFFIXES = (".npz", ".vti", ".parquet")
LARGEST = 2**30
"""Bytes of a file, and four times that unpacked: cells that are not reached pack well."""
LARGEST_NUMBER = 1e300
UNITS = ("m", "rad")
T = TypeVar("T")


def check_target(path: str | os.PathLike[str]) -> Path:
    """`path` as a place where a workspace can be written; worth asking before the work.

    Raises:
        InputError: unknown suffix, no such folder, or a folder of that name.
        MissingPackageError: a .parquet file needs pyarrow, which is not installed.
    """
    target = check_place(path)
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"'{target}': workspaces are written as {', '.join(SUFFIXES)}; found '{target.suffix}'")
    if suffix == ".parquet":
        needed("pyarrow", "a Parquet file")
    return target


@door
def save(space: Workspace, path: str | Path) -> Path:
    """Write a workspace; the suffix picks the format.

    - .npz: complete; `load` gives the same workspace again.
    - .vti: VTK image data, a point a cell centre: `inside`, every map and the actuated coordinates with their units.
    - .parquet: a row a reached cell: its coordinates, actuated coordinates q1, q2, ... and every map; the unit of a
      column is in its metadata, and what is said about the workspace in those of the table, as JSON under `cutjoint`.

    Raises:
        InputError: as of `check_target`.
        MissingPackageError: a .parquet file needs pyarrow, which is not installed.
    """
    target = check_target(path)
    suffix = target.suffix.lower()
    return write_whole(target, vti(space) if suffix == ".vti" else (_npz if suffix == ".npz" else _parquet)(space))


@door
def load(path: str | Path) -> Workspace:
    """Read a workspace that `save` wrote as .npz.

    Raises:
        ResultFileError: no such file or none at all, cut short, damaged, too large, of another schema version, or with
            contents that are no workspace.
    """

    def refused(why: str) -> ResultFileError:
        return ResultFileError(f"{path}{why}", path=str(path))

    try:
        with ArrayArchive(read_file(path, LARGEST), 4 * LARGEST) as archive:
            if "kind" not in archive.names or archive.text("kind") != KIND:
                raise refused(" does not hold a workspace; `cutjoint workspace ROBOT --save FILE.npz` writes one")
            schema = archive.number("schema")
            if schema != SCHEMA:
                mend = "compute it again or use the version of cutjoint that wrote it"
                raise refused(f" has workspace schema {schema}, this version reads {SCHEMA}; {mend}")
            return _workspace(archive)
    except FileError as error:
        raise refused(f": {error.why}{error.mend and f' ({error.mend})'}") from error
    except ArchiveError as error:
        raise refused(f" is not a whole file of a workspace ({error}); save it again") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise refused(f" does not hold a workspace: {error}") from error


def _about(space: Workspace) -> dict[str, object]:
    """What is said of a workspace besides its arrays."""
    return {
        "robot": space.robot,
        "axes": [[axis.name, axis.unit] for axis in space.axes],
        "held": dict(space.held),
        "extent": space.extent,
        "maps": [[name, one.title, one.unit, one.best] for name, one in space.maps.items()],
        "told": list(space.told),
    }


def _npz(space: Workspace) -> bytes:
    arrays: dict[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]] = {
        f"axis{k}": axis.values for k, axis in enumerate(space.axes)
    }
    arrays |= {"inside": np.asarray(space.inside, dtype=bool), "q": space.q}
    if space.ways is not None:
        arrays["ways"] = space.ways
    arrays |= {f"map{k}": one.values for k, one in enumerate(space.maps.values())}
    buffer = io.BytesIO()
    # numpy's stubs take any array for its option allow_pickle.
    np.savez_compressed(buffer, kind=KIND, schema=SCHEMA, about=json.dumps(_about(space)), **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


def _workspace(archive: ArrayArchive) -> Workspace:
    """The workspace in an archive.

    Raises:
        ValueError: it is none.
        ArchiveError: it is damaged.
    """
    about = json.loads(archive.text("about"))
    if not isinstance(about, dict):
        raise ValueError("what is said about it is no JSON object")
    named = _part(about, "axes", lambda one: _texts(one, 2) and 1 <= len(one) <= 3, "1 to 3 names with units")
    mapped = _part(about, "maps", lambda one: _texts(one, 4), "names, titles, units and what is best")
    _check_names([name for name, _ in named], [name for name, *_ in mapped])
    if bad := [unit for _, unit in named if unit not in UNITS]:
        raise ValueError(f"an axis is in '{bad[0]}', expected m or rad")
    if bad := [best for *_, best in mapped if best not in ("high", "low")]:
        raise ValueError(f"of a map '{bad[0]}' is best, expected high or low")
    held = _part(about, "held", _numbers_by_name, "numbers by name")
    told = _part(about, "told", lambda one: isinstance(one, list) and all(isinstance(x, str) for x in one), "texts")
    extent = _part(about, "extent", lambda one: _finite(one) and one >= 0.0, "a number of 0 or more")
    robot = _part(about, "robot", lambda one: isinstance(one, str), "a name")
    _check_arrays(archive, len(named), len(mapped))
    axes = tuple(GridAxis(name, unit, _numbers(archive, f"axis{k}")) for k, (name, unit) in enumerate(named))
    for axis in axes:
        steps = np.diff(axis.values)
        if not np.isfinite(axis.values).all() or not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.max():
            raise ValueError(f"the centres of cells along {axis.name} do not grow evenly")
    inside = np.array(archive.array("inside"), dtype=bool)
    inside.setflags(write=False)
    maps = {row[0]: FieldMap(row[1], row[2], _numbers(archive, f"map{k}"), row[3]) for k, row in enumerate(mapped)}
    if bad := [name for name, one in maps.items() if not np.isnan(one.values[~inside]).all()]:
        raise ValueError(f"map '{bad[0]}' has numbers in cells that are not reached")
    held = readonly_mapping({name: float(value) for name, value in held.items()})
    ways = _numbers(archive, "ways") if "ways" in archive.names else None
    if ways is not None and not ((ways >= 0.0) & (ways <= 1.0)).all():
        raise ValueError("its ways are parts, and some are not between 0 and 1")
    q = _numbers(archive, "q")
    return Workspace(robot, axes, held, inside, float(extent), q, readonly_mapping(maps), tuple(told), ways)


def _numbers(archive: ArrayArchive, name: str) -> Array:
    return readonly(np.asarray(archive.array(name), dtype=np.float64))


def _part(about: Mapping[str, T], name: str, fits: Callable[[T], bool], expected: str) -> T:
    """One thing that is said of a workspace.

    Raises:
        ValueError: it is missing, or not what is expected.
    """
    if name not in about or not fits(about[name]):
        raise ValueError(f"its '{name}' is {str(about.get(name))[:60]!r}, expected {expected}")
    return about[name]


def _texts(value: object, size: int) -> bool:
    """Whether it is a list of lists of so many texts."""
    return isinstance(value, list) and all(
        isinstance(row, list) and len(row) == size and all(isinstance(one, str) for one in row) for row in value
    )


def _numbers_by_name(value: object) -> bool:
    return isinstance(value, dict) and all(map(_finite, value.values()))


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST_NUMBER


def _check_names(axes: list[str], maps: list[str]) -> None:
    for what, names in (("axis", axes), ("map", maps)):
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"there are two of the {what} '{twice[0]}'")


def _check_arrays(archive: ArrayArchive, axes: int, maps: int) -> None:
    """That the arrays of a workspace are there and fit together, before one is unpacked.

    Raises:
        ValueError: they do not.
    """
    wanted = [f"axis{k}" for k in range(axes)] + ["inside", "q"] + [f"map{k}" for k in range(maps)]
    there = [name for name in archive.names if name not in ("kind", "schema", "about")]
    wanted += ["ways"] if "ways" in there else []
    if missing := [name for name in wanted if name not in there]:
        raise ValueError(f"it lacks {', '.join(missing)}")
    if unknown := [name for name in there if name not in wanted]:
        raise ValueError(f"it also holds {', '.join(unknown)}, which no workspace of its description has")
    cells = tuple(archive.shape(f"axis{k}")[0] if len(archive.shape(f"axis{k}")) == 1 else -1 for k in range(axes))
    shapes = {"inside": cells, **{f"map{k}": cells for k in range(maps)}}
    wrong = [f"{name} {archive.shape(name)}" for name, shape in shapes.items() if archive.shape(name) != shape]
    if archive.shape("q")[:-1] != cells:
        wrong.append(f"q {archive.shape('q')}")
    if "ways" in there and archive.shape("ways") != (2 * axes, *cells):
        wrong.append(f"ways {archive.shape('ways')}")
    if wrong or min(cells) < 2:
        raise ValueError(f"over a grid of {cells} cells its arrays do not fit: {', '.join(wrong) or 'too few cells'}")
    kinds = {name: "bool" if name == "inside" else "float64" for name in wanted}
    if other := [f"{name} ({archive.kind(name)})" for name, kind in kinds.items() if archive.kind(name) != kind]:
        raise ValueError(f"expected truth values of inside and else 64-bit numbers, found {', '.join(other)}")


def _parquet(space: Workspace) -> bytes:
    pa = needed("pyarrow", "a Parquet file")
    from pyarrow.parquet import write_table

    rows, columns, fields = np.nonzero(space.inside), [], []
    named = [(axis.name, axis.unit, axis.name, axis.values[at]) for axis, at in zip(space.axes, rows, strict=True)]
    named += [(f"q{k + 1}", "", "actuated coordinate", q) for k, q in enumerate(space.q[rows].T)]
    named += [(name, one.unit, one.title, one.values[rows]) for name, one in space.maps.items()]
    for name, unit, title, values in named:
        columns.append(pa.array(values))
        about = {"unit": unit, "title": title}
        fields.append(pa.field(name, pa.float64(), metadata={k: v for k, v in about.items() if v}))
    schema = pa.schema(fields, metadata={"cutjoint": json.dumps(_about(space))})
    buffer = io.BytesIO()
    write_table(pa.Table.from_arrays(columns, schema=schema), buffer)
    return buffer.getvalue()
