"""How to compile, and what is said of a function that was made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cutjoint.compile.machine.backends import backend


@dataclass(frozen=True)
class Made:
    """How a function came about.

    Attributes:
        what: its name.
        operations: arithmetic instructions.
        cached: whether the instructions came from the cache.
        trace_time, compile_time: seconds.
    """

    what: str
    operations: int
    cached: bool
    trace_time: float
    compile_time: float


@dataclass(frozen=True)
class Options:
    """How to compile.

    Attributes:
        parameters: inertial parameters that stay arguments (see `ChainSource`, `PaperSource`).
        fast: let the compiler reassociate sums (fast-math): a little quicker, other digits in the last places.
        cached: use the cache folder.
        report: called with every function that was made.
        backend: what makes machine code of the instructions, a name of `cutjoint.compile.machine.backends`.

    Raises:
        UnknownNameError: no such back end.
    """

    parameters: tuple[str, ...] = ()
    fast: bool = False
    cached: bool = True
    report: Callable[[Made], None] | None = None
    backend: str = "llvm"

    def __post_init__(self) -> None:
        backend(self.backend)  # raises: there is none of that name
