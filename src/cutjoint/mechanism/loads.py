"""Forces from outside: what the world does to a robot at a link or at its tool.

A load is a force and a moment at a point.  Cutting forces, contacts, a hand, a rope: each is a few of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

import numpy as np

from cutjoint.arrays import Array, Frozen, as_vector, readonly
from cutjoint.doors import described
from cutjoint.errors import InputError
from cutjoint.mechanism.types import Tool
from cutjoint.reprs import line

LoadAxes = Literal["world", "link"]
"""Along which axes a force is given: those of the world, or of the link (of the tool) it acts on."""
_ZERO = readonly([0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Load(Frozen):
    """A force and a moment on a link.

    Attributes:
        force: shape (3,) [N].
        moment: shape (3,) [N m].
        link: name of the link; None for the tool.
        point: where the force acts, in the frame of the link or of the tool, shape (3,) [m]; default its origin.
        axes: of force and moment.

    Raises:
        InputError: wrong shapes, not finite, or unknown axes.
    """

    force: Array = field(default_factory=lambda: _ZERO)
    moment: Array = field(default_factory=lambda: _ZERO)
    link: str | None = None
    point: Array = field(default_factory=lambda: _ZERO)
    axes: LoadAxes = "world"

    __repr__ = line(force="N", moment="N m", point="m")

    def __post_init__(self) -> None:
        for name, unit in (("force", "N"), ("moment", "N m"), ("point", "m")):
            self.__dict__[name] = as_vector(name, self.__dict__[name], 3, unit)
        if self.axes not in ("world", "link"):
            raise InputError(f'axes of a load must be "world" or "link", found {self.axes!r}')
        if not (self.link is None or isinstance(self.link, str)):
            raise InputError(f"link of a load must be the name of a link, or None for the tool, found {self.link!r}")
        super().__post_init__()

    def wrench(self, axes: Array, place: Array) -> tuple[Array, Array, Array]:
        """Force and moment along the axes of the world, and where they act.

        Args:
            axes: of the frame that the load is given in, as columns, shape (3, 3).
            place: its origin, shape (3,) [m].
        """
        force, moment = (self.force, self.moment) if self.axes == "world" else (axes @ self.force, axes @ self.moment)
        return force, moment, place + axes @ self.point


Loads: TypeAlias = Load | Iterable[Load]
"""One load, or several."""
NO_LOADS: Final[tuple[Load, ...]] = ()
"""Compared by identity, since loads may be anything; another empty tuple is the same one, or several that are none."""


def as_loads(loads: Loads) -> tuple[Load, ...]:
    """Loads as a tuple of them.

    Raises:
        InputError: something else.
    """
    found = (loads,) if isinstance(loads, Load) else tuple(loads) if _several(loads) else None
    if found is None or not all(isinstance(one, Load) for one in found):
        raise InputError(f"loads must be a Load or several, such as Load(force=[0, 0, -10]), found {described(loads)}")
    return found


def _several(loads: object) -> bool:
    """Whether these may be several loads."""
    return isinstance(loads, Iterable) and not isinstance(loads, type | str | bytes | Mapping)


def tool_wrench(loads: tuple[Load, ...], tool: Tool, robot: str) -> Array:
    """What loads at the tool are together: force [N], and moment [N m] about the tool point, in world axes, shape (6,).

    Raises:
        InputError: one acts on a link, of which a model that knows its tool alone cannot tell where it is.
    """
    total = np.zeros(6)
    for load in loads:
        if load.link is not None:
            raise InputError(
                f"a load acts on link '{load.link}', and {robot} knows where its tool is alone; "
                "leave out the link, or take the robot's closed chain"
            )
        force, moment, place = load.wrench(tool.rotation, tool.position)
        total[:3] += force
        total[3:] += moment + np.cross(place - tool.position, force)
    return total
