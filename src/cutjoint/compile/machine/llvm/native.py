"""Machine code for a program: compiled in memory by LLVM for this processor, called through ctypes.

Nothing executable is ever read from or written to disk.  A call releases Python's lock, so batches run on all cores.
"""

from __future__ import annotations

import ctypes
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.machine.llvm.text import declarations, flat_function, row_loop
from cutjoint.compile.once import once

_LOCK = threading.Lock()
"""LLVM is used by one thread at a time."""
_LOOP = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p)
PREAMBLE = 'attributes #0 = { nounwind "min-legal-vector-width"="512" "prefer-vector-width"="512" }'


@dataclass(frozen=True)
class Host:
    """What the processor offers: its name, the lanes of its vector registers, whether it fuses multiply and add."""

    name: str
    features: str
    lanes: int
    fused: bool


def host() -> Host:
    """This processor."""
    with _LOCK:
        return _host()


@cache
def _host() -> Host:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    found = llvm.get_host_cpu_features()
    lanes = 8 if found.get("avx512f") else 4 if found.get("avx") else 2
    arm = llvm.get_process_triple().startswith(("aarch64", "arm64"))
    return Host(llvm.get_host_cpu_name(), found.flatten(), lanes, bool(found.get("fma")) or arm)


class Machine:
    """Machine code of an LLVM module; keeps it alive."""

    def __init__(self, assembly: str, level: int = 2) -> None:
        import llvmlite.binding as llvm

        start = time.perf_counter()
        processor = host()
        with _LOCK:
            module = llvm.parse_assembly(assembly)
            module.verify()
            target = llvm.Target.from_default_triple().create_target_machine(
                cpu=processor.name, features=processor.features, opt=level, jit=True
            )
            module.triple = target.triple
            module.data_layout = str(target.target_data)
            self._module = module
            self._engine = llvm.create_mcjit_compiler(module, target)
            self._engine.finalize_object()
        self.assembly_lines = assembly.count("\n")
        self.compile_time = time.perf_counter() - start

    def address(self, symbol: str) -> int:
        """Address of a function."""
        return int(self._engine.get_function_address(symbol))


class NativeKernel(Kernel):
    """A program as machine code.

    Attributes:
        lanes: states that a batch evaluates side by side.
        compile_time: seconds that LLVM took.
    """

    def __init__(self, program: Program, *, fast: bool = False) -> None:
        super().__init__(program, fast=fast)
        self.lanes = host().lanes
        self._machine = Machine(self._assembly(1))
        self.compile_time = self._machine.compile_time
        self._address = self._machine.address("flat")
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(self._address)
        self._rows = _LOOP(self._machine.address("rows"))
        self._own = threading.local()
        self._lock = threading.RLock()

    @property
    def address(self) -> int:
        """See `Kernel.address`."""
        return self._address

    @once
    def _rows_lanes(self) -> Callable[[int, int, int], int]:
        """The loop over rows, several side by side; compiled when a batch is first asked for."""
        self._machine_lanes = Machine(self._assembly(self.lanes))
        self.compile_time += self._machine_lanes.compile_time
        return _LOOP(self._machine_lanes.address("rows"))

    def _assembly(self, lanes: int) -> str:
        flat = flat_function(self.program, "flat", lanes, width=self.lanes, fused=host().fused, fast=self.fast)
        return "\n".join((PREAMBLE, declarations(self.lanes), flat, row_loop(self.program, "rows", "flat", lanes)))

    def __call__(self, *arguments: Array) -> Array:
        """One evaluation: arguments of the program's lengths in, all results one after another out."""
        own = self._own
        if not hasattr(own, "x"):
            own.x = np.zeros(max(self.program.n_in, 1))
            own.y = np.zeros(max(self.program.n_out, 1))
            own.at = (own.x.ctypes.data, own.y.ctypes.data)
            own.views = []
            start = 0
            for _, size in self.program.arguments:
                own.views.append(own.x[start : start + size])
                start += size
        for view, argument in zip(own.views, arguments, strict=True):
            view[:] = argument
        self._call(*own.at)
        result: Array = own.y.copy()
        return result

    def fill(self, results: list[Array], given: list[Array], count: int, threads: int, lanes: bool) -> None:
        """See `Kernel.fill`."""
        table: list[int] = []
        for values in (*given, *results):
            table += [values.ctypes.data, 8 * values.shape[-1] if values.ndim == 2 else 0]
        where = np.array(table, dtype=np.int64)
        at = where.ctypes.data
        side_by_side = self._rows_lanes if lanes and count >= self.lanes else None

        def run(begin: int, end: int) -> None:
            done = begin if side_by_side is None else side_by_side(begin, end, at)
            self._rows(done, end, at)

        if threads <= 1 or count < 1024:
            run(0, count)
        else:
            edges = np.linspace(0, count, threads + 1).astype(int).tolist()
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(run, edges[:-1], edges[1:]))
