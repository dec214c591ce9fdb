"""The back ends: what makes of a program something that can be called.  A row each; `Options.backend` names one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from cutjoint.compile.machine.kernel import Advance, Kernel, LoopParts, MotionPrograms, Runs
from cutjoint.compile.machine.llvm.native import NativeAdvance, NativeKernel, NativeRuns, host
from cutjoint.errors import InputError, UnknownNameError


def _no_runs(parts: LoopParts, *, fast: bool = False) -> Runs:
    raise InputError("this back end does not simulate many runs in one loop; compile the plant with backend='llvm'")


def _no_advance(
    motion: MotionPrograms, relative: float, absolute: float, limit: float, *, kept: bool = False
) -> Advance:
    raise InputError("this back end does not integrate in machine code; compile the plant with backend='llvm'")


@dataclass(frozen=True)
class Backend:
    """A back end.

    Attributes:
        kernel: makes a program callable.
        fused: whether it computes a b + c in one instruction; programs are made accordingly.
        runs: makes a loop over many runs; by default it is refused.
        advance: makes an integrator of (equations of motion, relative and absolute tolerance, limit of the strain) and
            `kept`, whether machine code is kept for the next process; by default it is refused.
    """

    kernel: type[Kernel]
    fused: Callable[[], bool] = lambda: False
    runs: Callable[..., Runs] = _no_runs
    advance: Callable[..., Advance] = _no_advance


BACKENDS: Mapping[str, Backend] = {
    "llvm": Backend(NativeKernel, fused=lambda: host().fused, runs=NativeRuns, advance=NativeAdvance),
}


def backend(name: str) -> Backend:
    """The back end of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in BACKENDS:
        raise UnknownNameError("back end", name, list(BACKENDS))
    return BACKENDS[name]
