"""The laws by the names that the command line uses.  A new law: its file, and a row here.

The gains of a law are those parameters of its constructor that carry a `GainHelp`; nothing else lists them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from inspect import signature

import numpy.typing as npt

from cutjoint.control.computed_torque import ComputedTorque
from cutjoint.control.feedforward import Feedforward
from cutjoint.control.law import GainHelp, Law
from cutjoint.control.none import NoControl
from cutjoint.control.pd import PD
from cutjoint.control.pd_gravity import PDGravity
from cutjoint.control.pid import PID
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism


@dataclass(frozen=True)
class LawRow:
    """A law's class and a line about it.  Its constructor takes the gains and, where it has a model inside, `model`."""

    make: Callable[..., Law]
    about: str

    @property
    def gains(self) -> dict[str, GainHelp]:
        """The gains that the law takes, by name, in the order of its constructor."""
        parameters = signature(self.make, eval_str=True).parameters.values()
        notes = ((one.name, note) for one in parameters for note in getattr(one.annotation, "__metadata__", ()))
        return {name: note for name, note in notes if isinstance(note, GainHelp)}


LAWS: dict[str, LawRow] = {
    "none": LawRow(NoControl, "no effort: free fall"),
    "pd": LawRow(PD, "PD"),
    "pid": LawRow(PID, "PID with anti-windup"),
    "pd-gravity": LawRow(PDGravity, "PD + gravity"),
    "feedforward": LawRow(Feedforward, "PD + full feedforward"),
    "computed-torque": LawRow(ComputedTorque, "feedback linearisation"),
}


def law_row(name: str) -> LawRow:
    """The row of `LAWS` called `name`.

    Raises:
        UnknownNameError: no such law.
    """
    if name not in LAWS:
        raise UnknownNameError("controller", name, list(LAWS))
    return LAWS[name]


def law(name: str, model: Mechanism, gains: Mapping[str, npt.ArrayLike]) -> Law:
    """The law called `name`, with `model` inside where it needs one.

    Raises:
        UnknownNameError: no such law.
        InputError: a gain is missing, too many, or of the wrong shape.
    """
    row = law_row(name)
    if set(gains) != set(row.gains):
        wanted, found = ", ".join(row.gains) or "none", ", ".join(sorted(gains)) or "none"
        raise InputError(f"controller '{name}' takes the gains {wanted}; found {found}")
    inside = {"model": model} if "model" in signature(row.make).parameters else {}
    made = row.make(**inside, **gains)
    made.memory(model.n)
    return made
