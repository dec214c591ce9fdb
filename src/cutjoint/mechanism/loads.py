"""Forces from outside: what the world does to a robot at a link or at its tool.

A load is a force and a moment at a point.  Cutting forces, contacts, a hand, a rope: each is a few of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from cutjoint.arrays import Array, Frozen, as_vector, readonly
from cutjoint.errors import InputError

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

    def __post_init__(self) -> None:
        for name, unit in (("force", "N"), ("moment", "N m"), ("point", "m")):
            self.__dict__[name] = as_vector(name, self.__dict__[name], 3, unit)
        if self.axes not in ("world", "link"):
            raise InputError(f'axes of a load must be "world" or "link", found {self.axes!r}')
        super().__post_init__()
