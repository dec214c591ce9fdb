"""The back ends: what makes of a program something that can be called.  A row each; `Options.backend` names one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from cutjoint.compile.machine.kernel import Kernel, LoopParts, Runs
from cutjoint.compile.machine.llvm.native import NativeKernel, NativeRuns, host
from cutjoint.errors import InputError, UnknownNameError


def _no_runs(parts: LoopParts, *, fast: bool = False) -> Runs:
    raise InputError("this back end does not simulate many runs in one loop; compile the plant with backend='llvm'")


@dataclass(frozen=True)
class Backend:
    """A back end.

    Attributes:
        kernel: makes a program callable.
        fused: whether it computes a b + c in one instruction; programs are made accordingly.
        runs: makes a loop over many runs; by default it is refused.
    """

    kernel: type[Kernel]
    fused: Callable[[], bool] = lambda: False
    runs: Callable[..., Runs] = _no_runs


BACKENDS: Mapping[str, Backend] = {
    "llvm": Backend(NativeKernel, fused=lambda: host().fused, runs=NativeRuns),
}


def backend(name: str) -> Backend:
    """The back end of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in BACKENDS:
        raise UnknownNameError("back end", name, list(BACKENDS))
    return BACKENDS[name]
