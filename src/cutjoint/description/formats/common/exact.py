"""What writers of formats share: numbers, file names and elements as text that reads back exactly, and the error where
a format has no word."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.model import CutJoint, Joint
from cutjoint.description.xml import Element
from cutjoint.errors import InputError


def number(value: float) -> str:
    """The shortest decimal that is exactly the same double."""
    return repr(float(value))


def words(values: Sequence[float] | Array) -> str:
    """Numbers as an XML attribute, exact."""
    return " ".join(number(value) for value in values)


def relative(mesh: Path | None, path: Path) -> str:
    """A mesh file as seen from the file that names it."""
    if mesh is None:
        return ""
    return Path(os.path.relpath(mesh.resolve(), path.resolve().parent)).as_posix()


def serialised(root: Element) -> bytes:
    """An element as an indented file."""
    etree.indent(root)
    content = etree.tostring(root, xml_declaration=True, encoding="utf-8")
    return bytes(content) + b"\n"


def unsaid(form: str, of: Joint | CutJoint) -> InputError:
    """The error of the format `form`, which has no word for the type of a joint or a cut joint."""
    what = "joint" if isinstance(of, Joint) else "cut"
    remedy = "write loops.toml (--to loops), which knows every type"
    return InputError(f"{form} cannot say {what} type '{of.type.value}' of {what} '{of.name}'; {remedy}")
