"""The keys of joint physics: of [joint.NAME] and of [[cut]], a bushing included; read and written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

from cutjoint.description.formats.common.exact import number
from cutjoint.description.formats.common.physics import CUT_KEYS, largest, leftover
from cutjoint.description.model import Bushing, CutJoint
from cutjoint.description.numbers import LARGEST_PHYSICS
from cutjoint.mechanism.physics import NO_PHYSICS
from cutjoint.toml.table import TomlTable

_BUSHING = tuple(field.name for field in fields(Bushing))


def take_physics(table: TomlTable, keys: Sequence[str]) -> dict[str, float]:
    """Those of the `keys` that the table gives."""
    values = {key: table.number(key, None, largest=largest(key)) for key in keys}
    return {key: value for key, value in values.items() if value is not None}


def take_bushing(table: TomlTable) -> Bushing | None:
    """The bushing of a cut, or None where there is none or its stiffness cannot be read."""
    inner = table.table("bushing")
    if inner is None:
        return None
    stiffness = inner.number("stiffness", required=True, largest=LARGEST_PHYSICS)
    others = {key: inner.number(key, 0.0, largest=LARGEST_PHYSICS) or 0.0 for key in _BUSHING[1:]}
    inner.finish()
    return None if stiffness is None else Bushing(stiffness, **others)


def cut_lines(cut: CutJoint) -> list[str]:
    """The lines of the length of a cut, of its physics and of its bushing."""
    own = leftover(cut.physics, NO_PHYSICS)
    lines = [f"length = {number(cut.length)}"] if cut.type.has_length else []
    lines += [f"{key} = {number(own[key])}" for key in CUT_KEYS if key in own]
    if cut.bushing is not None:
        inside = ", ".join(f"{key} = {number(getattr(cut.bushing, key))}" for key in _BUSHING)
        lines.append(f"bushing = {{ {inside} }}")
    return lines
