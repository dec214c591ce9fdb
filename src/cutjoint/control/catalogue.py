"""The laws by the names that the command line uses.  A new law: its file, and a row here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy.typing as npt

from cutjoint.control.computed_torque import ComputedTorque
from cutjoint.control.feedforward import Feedforward
from cutjoint.control.law import Law
from cutjoint.control.none import NoControl
from cutjoint.control.pd import PD
from cutjoint.control.pd_gravity import PDGravity
from cutjoint.control.pid import PID
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism


@dataclass(frozen=True)
class Row:
    """How to make a law: the gains it takes and a maker (model, gains) -> law."""

    gains: tuple[str, ...]
    make: Callable[[Mechanism, Mapping[str, npt.ArrayLike]], Law]
    about: str


LAWS: dict[str, Row] = {
    "none": Row((), lambda model, k: NoControl(), "no effort"),
    "pd": Row(("kp", "kd"), lambda model, k: PD(k["kp"], k["kd"]), "PD"),
    "pid": Row(("kp", "ki", "kd"), lambda model, k: PID(k["kp"], k["ki"], k["kd"]), "PID with anti-windup"),
    "pd-gravity": Row(("kp", "kd"), lambda model, k: PDGravity(model, k["kp"], k["kd"]), "PD + gravity"),
    "feedforward": Row(("kp", "kd"), lambda model, k: Feedforward(model, k["kp"], k["kd"]), "PD + full feedforward"),
    "computed-torque": Row(("kp", "kd"), lambda model, k: ComputedTorque(model, k["kp"], k["kd"]), "computed torque"),
}


def law(name: str, model: Mechanism, gains: Mapping[str, npt.ArrayLike]) -> Law:
    """The law called `name`, with `model` inside where it needs one.

    Raises:
        UnknownNameError: no such law.
        InputError: a gain is missing, too many, or of the wrong shape.
    """
    if name not in LAWS:
        raise UnknownNameError("controller", name, list(LAWS))
    row = LAWS[name]
    if set(gains) != set(row.gains):
        wanted, found = ", ".join(row.gains) or "none", ", ".join(sorted(gains)) or "none"
        raise InputError(f"controller '{name}' takes the gains {wanted}; found {found}")
    made = row.make(model, gains)
    made.memory(model.n)
    return made
