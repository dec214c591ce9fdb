"""Many runs of a closed loop as machine code."""

from __future__ import annotations

import ctypes
import threading

from cutjoint.compile.expressions.program import Program
from cutjoint.compile.machine.llvm.native import PREAMBLE, Machine, host
from cutjoint.compile.machine.llvm.run_loop import run_loop
from cutjoint.compile.machine.llvm.text import declarations, flat_function
from cutjoint.compile.machine.runs import RunLoop, Sizes

_CALL = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 4, ctypes.c_double, ctypes.c_double, ctypes.c_void_p)


class NativeRuns:
    """See `cutjoint.compile.machine.runs.Runs`.

    Args:
        rate, settle: the programs of the loop; nothing is settled where `settle` is None.
        sizes: their numbers.
        fast: sums may be reassociated.
    """

    def __init__(self, rate: Program, settle: Program | None, sizes: Sizes, *, fast: bool = False) -> None:
        self._programs = {"rate": rate, "settle": settle}
        self._sizes, self._fast = sizes, fast
        self._lock = threading.Lock()
        self._loops: dict[int, tuple[Machine, RunLoop]] = {}

    @property
    def lanes(self) -> int:
        """See `Runs`."""
        return host().lanes

    def loop(self, lanes: int) -> RunLoop:
        """See `Runs`."""
        with self._lock:
            if lanes not in self._loops:
                self._loops[lanes] = self._compiled(lanes)
            return self._loops[lanes][1]

    def _compiled(self, lanes: int) -> tuple[Machine, RunLoop]:
        processor = host()
        parts = [PREAMBLE, declarations(processor.lanes)]
        for name, program in self._programs.items():
            if program is not None:
                width, fused = processor.lanes, processor.fused
                parts.append(flat_function(program, name, lanes, width=width, fused=fused, fast=self._fast))
        parts.append(run_loop("runs", self._sizes, lanes))
        machine = Machine("\n".join(parts))
        return machine, _CALL(machine.address("runs"))
