"""A template: the sizes that it asks for, and the function that draws it.  Sizes are lengths [m]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from cutjoint.drafting.sketch import Sketch
from cutjoint.reprs import one_line, quoted

Sizes = Mapping[str, float]


@dataclass(frozen=True)
class Size:
    """A length that a template asks for: what it is where nobody says [m], and what it measures."""

    default: float
    about: str


@dataclass(frozen=True)
class Template:
    """A kind of robot to begin with.

    Attributes:
        about: what it is, in a few words.
        sizes: what it asks for, by name.
        sketch: draws it for all of its sizes; raises `InputError` where they cannot close, with why.
    """

    about: str
    sizes: Mapping[str, Size]
    sketch: Callable[[Sizes], Sketch]

    def __repr__(self) -> str:
        return one_line(
            "Template", [quoted(self.about), *(f"{name}={one.default:g} m" for name, one in self.sizes.items())]
        )
