"""Machine code for programs: compiled by LLVM for this processor, loaded into memory, called through ctypes.

It is kept for the next process where that is asked for (`cutjoint.compile.machine.llvm.objects`).  A call releases
Python's lock, so batches run on all cores.
"""

from __future__ import annotations

import ctypes
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.machine.kernel import Kernel, LoopParts, MotionPrograms, RunLoop
from cutjoint.compile.machine.llvm import objects
from cutjoint.compile.machine.llvm.advance import AdvanceText
from cutjoint.compile.machine.llvm.run_loop import RunLoopText
from cutjoint.compile.machine.llvm.text import FlatFunction, declarations, row_loop
from cutjoint.compile.once import once
from cutjoint.extras import needed

if TYPE_CHECKING:
    import llvmlite.binding as llvm

_LOCK = threading.Lock()
"""LLVM is used by one thread at a time."""
_LOOP = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p)
_RUNS = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 4, ctypes.c_double, ctypes.c_double, ctypes.c_void_p)
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
    needed("llvmlite.binding", "machine code")
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    found = llvm.get_host_cpu_features()
    lanes = 8 if found.get("avx512f") else 4 if found.get("avx") else 2
    arm = llvm.get_process_triple().startswith(("aarch64", "arm64"))
    return Host(llvm.get_host_cpu_name(), found.flatten(), lanes, bool(found.get("fma")) or arm)


def _module(assembly: str, target: llvm.TargetMachine) -> llvm.ModuleRef:
    import llvmlite.binding as llvm

    module = llvm.parse_assembly(assembly)
    module.triple, module.data_layout = target.triple, str(target.target_data)
    return module


def _circumstances(quick: bool) -> tuple[bytes, ...]:
    """What decides, beside the functions, what becomes of them."""
    import llvmlite.binding as llvm

    processor, version = host(), llvm.llvm_version_info
    return tuple(str(part).encode() for part in (version, llvm.get_process_triple(), processor, quick))


class Machine:
    """Machine code of functions in LLVM assembly; keeps it alive.

    Args:
        write: writes the functions in assembly, where they are not kept.
        kept: everything that decides what is written; None keeps nothing.
        quick: made in a third of the time, and a third as quick; the digits are the same.
    """

    def __init__(
        self, write: Callable[[], Sequence[str]], kept: Sequence[bytes] | None = None, *, quick: bool = False
    ) -> None:
        import llvmlite.binding as llvm

        start, processor = time.perf_counter(), host()
        name = None if kept is None else objects.key(*_circumstances(quick), *kept)
        code = None if name is None else objects.read(name)
        with _LOCK:
            target = llvm.Target.from_default_triple().create_target_machine(
                cpu=processor.name, features=processor.features, opt=0 if quick else 2, jit=True
            )
        if code is None:
            assembly = "\n".join((PREAMBLE, declarations(processor.lanes), *write()))
            with _LOCK:
                module = _module(assembly, target)
                module.verify()
                code = target.emit_object(module)
            if name is not None:
                objects.write(name, code)
        with _LOCK:
            self._engine = llvm.create_mcjit_compiler(_module("", target), target)
            self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self._engine.finalize_object()
        self._name = name
        self.compile_time = time.perf_counter() - start

    def forget(self) -> None:
        """See `Kernel.forget`."""
        if self._name is not None:
            objects.drop(self._name)

    def address(self, symbol: str) -> int:
        """Address of a function."""
        return int(self._engine.get_function_address(symbol))


class NativeKernel(Kernel):
    """A program as machine code.

    Attributes:
        lanes: states that a batch evaluates side by side.
        compile_time: seconds that LLVM took.
    """

    def __init__(self, program: Program, *, fast: bool = False, quick: bool = False, kept: bool = False) -> None:
        super().__init__(program, fast=fast, quick=quick, kept=kept)
        self.lanes = host().lanes
        self._machine = self._compiled(1, quick)
        self.compile_time = self._machine.compile_time
        self._address = self._machine.address("flat")
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(self._address)
        self._rows = _LOOP(self._machine.address("rows"))
        self._own = threading.local()
        self._lock = threading.RLock()

    def forget(self) -> None:
        """See `Kernel.forget`."""
        self._machine.forget()

    @property
    def address(self) -> int:
        return self._address

    @once
    def _rows_lanes(self) -> Callable[[int, int, int], int]:
        """The loop over rows, several side by side; compiled when a batch is first asked for."""
        self._machine_lanes = self._compiled(self.lanes, self.quick)
        self.compile_time += self._machine_lanes.compile_time
        return _LOOP(self._machine_lanes.address("rows"))

    def _compiled(self, lanes: int, quick: bool = False) -> Machine:
        def write() -> tuple[str, str]:
            return _flat(self.program, "flat", lanes, self.fast), row_loop(self.program, "rows", "flat", lanes)

        what = (b"kernel", f"{lanes} {self.fast}".encode(), self.program.to_bytes()) if self.kept else None
        return Machine(write, what, quick=quick)

    def __call__(self, *arguments: Array) -> Array:
        own = self._own
        if not hasattr(own, "x"):
            own.x = np.zeros(max(self.program.n_in, 1))
            own.y = np.zeros(max(self.program.n_out, 1))
            own.at = (own.x.ctypes.data, own.y.ctypes.data)
            ends = np.cumsum([size for _, size in self.program.arguments])
            own.views = np.split(own.x[: self.program.n_in], ends[:-1])
        for view, argument in zip(own.views, arguments, strict=True):
            view[:] = argument
        self._call(*own.at)
        result: Array = own.y.copy()
        return result

    def fill(self, results: list[Array], given: list[Array], count: int, threads: int, lanes: bool) -> None:
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


class NativeAdvance:
    """See `Advance`.

    Args:
        motion: the equations of motion.
        relative, absolute: tolerance of a step.
        limit: of the strain.
        kept: whether the machine code is kept for the next process.
    """

    def __init__(
        self, motion: MotionPrograms, relative: float, absolute: float, limit: float, *, kept: bool = False
    ) -> None:
        programs = {"rate": motion.rate} if motion.settle is None else {"rate": motion.rate, "settle": motion.settle}

        def write() -> list[str]:
            parts = [_flat(program, name, 1, False) for name, program in programs.items()]
            return [*parts, AdvanceText("advance", motion).text()]

        what = (b"advance", str(motion.actuated).encode(), *(program.to_bytes() for program in programs.values()))
        self._machine = Machine(write, what if kept else None, quick=True)
        self.compile_time = self._machine.compile_time
        kinds = [ctypes.c_int64, *[ctypes.c_void_p] * 4, *[ctypes.c_double] * 4]
        self._call = ctypes.CFUNCTYPE(*kinds)(self._machine.address("advance"))
        self._settings = (relative, absolute, limit)

    def __call__(self, state: Array, given: Array, found: Array, step: Array, span: float) -> int:
        """See `Advance`."""
        data = [x.ctypes.data for x in (state, given, found, step)]
        return int(self._call(*data, span, *self._settings))


class NativeRuns:
    """See `Runs`.

    Args:
        parts: the programs of the loop, and its numbers.
        fast: sums may be reassociated.
    """

    def __init__(self, parts: LoopParts, *, fast: bool = False) -> None:
        self._programs = {"rate": parts.rate, **{f"event{k}": one.program for k, one in enumerate(parts.events)}}
        if parts.settle is not None:
            self._programs["settle"] = parts.settle
        if parts.begin is not None:
            self._programs["begin"] = parts.begin.program
        self._parts, self._fast = parts, fast
        self._lock = threading.Lock()
        self._loops: dict[int, tuple[Machine, RunLoop]] = {}

    @property
    def lanes(self) -> int:
        return host().lanes

    def loop(self, lanes: int) -> RunLoop:
        with self._lock:
            if lanes not in self._loops:
                flat = [_flat(program, name, lanes, self._fast) for name, program in self._programs.items()]
                machine = Machine(partial(list, [*flat, RunLoopText("runs", self._parts, lanes).text()]))
                self._loops[lanes] = machine, _RUNS(machine.address("runs"))
            return self._loops[lanes][1]


def _flat(program: Program, symbol: str, lanes: int, fast: bool) -> str:
    return FlatFunction(program, symbol, lanes, host().lanes, host().fused, fast).text()
