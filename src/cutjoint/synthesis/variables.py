"""Design variables: what of a robot may be chosen, between which values, and the robot with the values chosen.

Three kinds: a number of the description by its path (several paths joined by `=` have one value), the length of links
that are stretched with their section kept (`cutjoint.description.stretched`), and how the base is mounted in the field
of gravity (`cutjoint.description.mounted`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from cutjoint.description import RobotDescription, mounted, stretched, value, with_values
from cutjoint.errors import InputError
from cutjoint.reprs import line

Kind = Literal["path", "stretch", "mount"]
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
MOUNTS = ("roll", "pitch")


@dataclass(frozen=True)
class Variable:
    """One design variable.

    Attributes:
        name: in tables and files.
        kind: "path", "stretch" or "mount".
        what: paths; links; or ("roll",) or ("pitch",).
        low, high: least and largest value, in `unit`.
        along: of a stretch its direction in the frame of each link: "x", "y" or "z".
    """

    name: str
    kind: Kind
    what: tuple[str, ...]
    low: float
    high: float
    along: str = "x"

    __repr__ = line("name", "kind", "what", "low", "high")

    @property
    def unit(self) -> str:
        """Unit of its values: "" for a ratio, SI for a number of the description."""
        return {"path": "SI", "stretch": "", "mount": "rad"}[self.kind]

    def check(self, robot: RobotDescription) -> None:
        """Look whether the robot has what may be chosen, at both ends.

        Raises:
            UnknownNameError: there is no such path or link.
            InputError: an empty range, or values that mean nothing.
        """
        if not self.low < self.high:
            raise InputError(f"variable '{self.name}': the range must grow, found {self.low:g} to {self.high:g}")
        if self.kind == "stretch" and (self.along not in AXES or self.low <= 0.0):
            raise InputError(
                f"variable '{self.name}': links are stretched along x, y or z by ratios > 0, "
                f"found along '{self.along}' from {self.low:g}"
            )
        if self.kind == "mount" and (len(self.what) != 1 or self.what[0] not in MOUNTS):
            raise InputError(f"variable '{self.name}': mount is roll or pitch, found {', '.join(self.what)}")
        for end in (self.low, self.high):
            self.applied(robot, end)

    def now(self, robot: RobotDescription) -> float:
        """Its value in a robot as it is.

        Raises:
            InputError: paths that are joined have different values, or one means several numbers.
        """
        if self.kind != "path":
            return 1.0 if self.kind == "stretch" else 0.0
        found = [value(robot, path) for path in self.what]
        if any(isinstance(one, np.ndarray) for one in found):
            raise InputError(f"variable '{self.name}': '{' = '.join(self.what)}' is several numbers; name one of them")
        if len(set(map(float, found))) > 1:
            listed = ", ".join(f"{path} = {one:g}" for path, one in zip(self.what, found, strict=True))
            raise InputError(f"variable '{self.name}': its paths have different values now ({listed}); make them one")
        return float(found[0])

    def applied(self, robot: RobotDescription, chosen: float) -> RobotDescription:
        """The robot with this value.

        Raises:
            UnknownNameError, InputError: as of `check`.
        """
        match self.kind:
            case "path":
                return with_values(robot, dict.fromkeys(self.what, chosen))
            case "stretch":
                return stretched(robot, self.what, AXES[self.along], chosen)
            case _:
                return mounted(robot, **{self.what[0]: chosen})


def chosen(robot: RobotDescription, variables: Sequence[Variable], values: npt.ArrayLike) -> RobotDescription:
    """The robot with values of all variables: first its numbers, then its lengths, then its mounting.

    Raises:
        InputError: not a value for every variable.
    """
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.shape != (len(variables),):
        raise InputError(f"values must be {len(variables)} numbers, one a variable, found shape {numbers.shape}")
    order = {"path": 0, "stretch": 1, "mount": 2}
    for k in sorted(range(len(variables)), key=lambda k: order[variables[k].kind]):
        robot = variables[k].applied(robot, float(numbers[k]))
    return robot
