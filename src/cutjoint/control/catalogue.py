"""The laws by the names that the command line uses.  A new law: its file, and a row here;
or a law from outside the package, which is looked for where it is named (`cutjoint.plugins`).

The gains of a law are those parameters of its constructor that carry a `GainHelp`; nothing else lists them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from inspect import Parameter

import numpy.typing as npt

from cutjoint.control.computed_torque import ComputedTorque
from cutjoint.control.feedforward import Feedforward
from cutjoint.control.law import GainHelp, Law
from cutjoint.control.none import NoControl
from cutjoint.control.outside import GROUP, maker, outside_law
from cutjoint.control.pd import PD
from cutjoint.control.pd_gravity import PDGravity
from cutjoint.control.pid import PID
from cutjoint.doors import door_but, of_type
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.plugins import installed, installed_part, is_outside, parameters, part


@dataclass(frozen=True)
class LawRow:
    """A law's class and a line about it.  Its constructor takes the gains and, where it has a model inside, `model`.

    Of a class from outside the package (`told` says which) every parameter but `model` is a gain, and one with a
    default may be left out.
    """

    make: Callable[..., object]
    about: str
    told: str = ""

    @property
    def gains(self) -> dict[str, GainHelp]:
        """The gains that the law takes, by name, in the order of its constructor."""
        found = {}
        for name, one in self._parameters.items():
            notes = [note for note in getattr(one.annotation, "__metadata__", ()) if isinstance(note, GainHelp)]
            if notes or (self.told and name != "model"):
                found[name] = notes[0] if notes else GainHelp("", "")
        return found

    @property
    def needed(self) -> list[str]:
        """The gains that must be given."""
        return [name for name in self.gains if self._parameters[name].default is Parameter.empty]

    @property
    def has_model(self) -> bool:
        """Whether it has a model of the robot inside."""
        return "model" in self._parameters

    @property
    def _parameters(self) -> Mapping[str, Parameter]:
        return parameters(self.make, self.told or self.about)


LAWS: dict[str, LawRow] = {
    "none": LawRow(NoControl, "no effort: free fall"),
    "pd": LawRow(PD, "PD"),
    "pid": LawRow(PID, "PID with anti-windup"),
    "pd-gravity": LawRow(PDGravity, "PD + gravity"),
    "feedforward": LawRow(Feedforward, "PD + full feedforward"),
    "computed-torque": LawRow(ComputedTorque, "feedback linearisation"),
}


def law_row(name: str) -> LawRow:
    """The row of `LAWS` called `name`; or of a law from outside: FILE.py:NAME, PACKAGE.MODULE:NAME, or an entry point.

    Raises:
        UnknownNameError: no such law.
        InputError: there is something of that name, but it is no law.
    """
    if name in LAWS:
        return LAWS[name]
    others = installed(GROUP)
    if not (is_outside(name) or name in others):
        raise UnknownNameError("controller", name, [*LAWS, *others])
    found = installed_part(GROUP, name) if name in others else part(name)
    if found.rest:
        raise InputError(f"nothing goes behind {found.told}; give gains by name (--gain NAME=VALUE)")
    return LawRow(maker(found), "from outside", found.told)


@door_but("gains")
def law(name: str, model: Mechanism, gains: Mapping[str, npt.ArrayLike]) -> Law:
    """The law called `name` (see `law_row`), with `model` inside where it needs one.

    Raises:
        UnknownNameError: no such law.
        InputError: a gain is missing, too many, or of the wrong shape; or a part from outside is no law.
    """
    of_type("gains of law", gains, Mapping)
    row = law_row(name)
    if not set(row.needed) <= set(gains) <= set(row.gains):
        wanted, found = ", ".join(row.gains) or "none", ", ".join(sorted(gains)) or "none"
        raise InputError(f"controller '{name}' takes the gains {wanted}; found {found}")
    given = {**({"model": model} if row.has_model else {}), **gains}
    if row.told:
        return outside_law(row.make, row.told, model.n, **given)
    made = row.make(**given)
    assert isinstance(made, Law)
    made.memory(model.n)
    return made
