"""What a search for modes hands out: the postures, and how sure it is that there are no others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

from cutjoint.mechanism import Posture


@dataclass(frozen=True, eq=False)
class Modes(Sequence[Posture]):
    """Postures found from many starts, as a sequence: `len(modes)`, `modes[0]`, `for mode in modes`.

    The first one is that of the posture asked about.  The others follow by how far their links are from it, so the
    order does not depend on the order in which they were found.

    Attributes:
        postures: the modes.
        found: how often each was found again, by independent starts; what is found once is rarely alone.
        starts: starts made, of which `closed` ended in a solution of the equations.
        closed: starts that ended in a solution, within the joint limits or not.
        loose: those of them that ended in a posture that can still move, which is no mode.
        unseen: share of further starts that would find something new, as Good and Turing estimate it: what was found
            once among what was found.  1 where nothing was found.
        settled: whether the search ended because all was found several times, not because it ran out of starts.
        held: what all of them have in common: "point" or "pose" of the tool, or "actuators".
    """

    postures: tuple[Posture, ...]
    found: tuple[int, ...]
    starts: int
    closed: int
    loose: int
    unseen: float
    settled: bool
    held: str

    def __len__(self) -> int:
        return len(self.postures)

    @overload
    def __getitem__(self, index: int) -> Posture: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Posture, ...]: ...

    def __getitem__(self, index: int | slice) -> Posture | tuple[Posture, ...]:
        return self.postures[index]

    def __iter__(self) -> Iterator[Posture]:
        return iter(self.postures)
