"""A workspace as VTK image data in XML (.vti), which ParaView, PyVista and others read: a point a cell centre.

The format is that of the VTK file formats guide (Kitware): arrays are appended to their elements as base64, packed by
zlib in blocks, the x axis running fastest.
"""

from __future__ import annotations

import base64
import zlib
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from cutjoint.workspace.region import Workspace

BLOCK = 2**20
"""Bytes that are packed at a time."""


def vti(space: Workspace) -> str:
    """The text of the file."""
    cells = [len(axis.values) for axis in space.axes] + [1] * (3 - len(space.axes))
    start = [float(axis.values[0]) for axis in space.axes] + [0.0] * (3 - len(space.axes))
    steps = [axis.step for axis in space.axes] + [1.0] * (3 - len(space.axes))
    extent = " ".join(f"0 {count - 1}" for count in cells)
    told = {
        "robot": space.robot,
        "axes": "; ".join(f"{axis.name} [{axis.unit}]" for axis in space.axes),
        "held": "; ".join(f"{name} = {value!r}" for name, value in space.held.items()),
    }
    count = len(space.axes)
    arrays = [_array("inside", np.asarray(space.inside, dtype=np.uint8), count)]
    arrays += [_array(titled(name, one.unit), one.values, count) for name, one in space.maps.items()]
    arrays.append(_array("q", space.q, count))
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
            'compressor="vtkZLibDataCompressor">',
            f'<ImageData WholeExtent="{extent}" Origin="{_numbers(start)}" Spacing="{_numbers(steps)}">',
            "<FieldData>",
            *(_text(name, text) for name, text in told.items() if text),
            "</FieldData>",
            f'<Piece Extent="{extent}">',
            '<PointData Scalars="inside">',
            *arrays,
            "</PointData>",
            "</Piece>",
            "</ImageData>",
            "</VTKFile>",
            "",
        ]
    )


def titled(name: str, unit: str) -> str:
    """A map's name with its unit."""
    return f"{name} [{unit}]" if unit else name


def _numbers(values: list[float]) -> str:
    return " ".join(map(repr, values))


def _array(name: str, values: npt.NDArray[np.generic], axes: int) -> str:
    """An array over the cells of so many axes, the first running fastest, with one number a cell or a vector."""
    parts = values.shape[axes] if values.ndim > axes else 1
    rows = values.transpose([*reversed(range(axes)), *range(axes, values.ndim)])
    kind = "UInt8" if values.dtype == np.uint8 else "Float64"
    content = np.ascontiguousarray(rows).astype("<f8" if kind == "Float64" else "u1").tobytes()
    head = f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{parts}" format="binary">'
    return f"{head}{_packed(content)}</DataArray>"


def _packed(content: bytes) -> str:
    """Blocks packed by zlib; before them, in base64 of its own, how many, how large, the rest, and all packed sizes."""
    blocks = [zlib.compress(content[i : i + BLOCK]) for i in range(0, len(content), BLOCK)]
    head = np.array([len(blocks), BLOCK, len(content) % BLOCK, *map(len, blocks)], dtype="<u8").tobytes()
    return (base64.b64encode(head) + base64.b64encode(b"".join(blocks))).decode()


def _text(name: str, text: str) -> str:
    codes = " ".join(str(one) for one in [*text.encode(), 0])
    return f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="1" format="ascii">{codes}</Array>'
