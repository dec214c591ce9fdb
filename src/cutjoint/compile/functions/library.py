"""The compiled functions of one model, made on demand: from the cache or traced anew, checked, in machine code."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite, prod

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions import cache
from cutjoint.compile.functions.table import Function, function
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.interpreter import Interpreter
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.sources.interface import Source, size
from cutjoint.doors import door
from cutjoint.errors import CompileError
from cutjoint.reprs import line


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

    __repr__ = line(trace_time="s", compile_time="s")


@door
@dataclass(frozen=True)
class Options:
    """How to compile.

    Attributes:
        parameters: what stays an argument (see `ChainSource`, `PaperSource`).
        fast: let the compiler reassociate sums (fast-math): a little quicker, other digits in the last places.
        cached: use the cache folder.
        report: called with every function that was made.
        backend: what makes machine code of the instructions, a name of `cutjoint.compile.machine.backends`.
        ranges: of parameters of a chain, see `ChainSource`.
        quick: machine code that is made in a third of the time, and a third as quick; the digits are the same.

    Raises:
        UnknownNameError: no such back end.
    """

    parameters: tuple[str, ...] = ()
    fast: bool = False
    cached: bool = True
    report: Callable[[Made], None] | None = None
    backend: str = "llvm"
    ranges: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]] = field(default_factory=dict)
    quick: bool = False

    __repr__ = line()

    def __post_init__(self) -> None:
        backend(self.backend)  # raises: there is none of that name


class CompiledFunction:
    """One function of one model: its results come by name and in their shapes, or not at all.

    Args:
        row: what it is.
        kernel: the machine code; whoever calls that directly looks at the strain himself.
        source: the model.
    """

    __repr__ = line("row", "source")

    def __init__(self, row: Function, kernel: Kernel, source: Source) -> None:
        self.row, self.kernel = row, kernel
        self._parts: list[tuple[str, slice, tuple[int, ...] | None]] = []
        start = 0
        for part in row.parts:
            shape = tuple(size(source, symbol) for symbol in part.shape.split(","))
            stop = start + prod(shape)
            self._parts.append((part.name, slice(start, stop), shape if len(shape) > 1 else None))
            start = stop

    def __call__(self, *arguments: Array) -> dict[str, Array] | None:
        """One evaluation: the parts of the result by name, read-only; None where it must not be trusted."""
        y = self.kernel(*arguments)
        # a sum is finite only if all its terms are; the strain stands last
        if not (y[-1] <= STRAIN_LIMIT and isfinite(np.add.reduce(y))):
            return None
        y.flags.writeable = False
        return {name: y[at] if shape is None else y[at].reshape(shape) for name, at, shape in self._parts}

    def place(self, part: str) -> slice:
        """Where a part stands in a result of the kernel."""
        return next(at for name, at, _ in self._parts if name == part)

    def parts(self, y: Array) -> dict[str, Array]:
        """The parts of a result of the kernel."""
        return {name: y[at] if shape is None else y[at].reshape(shape) for name, at, shape in self._parts}

    def batch(self, arguments: Sequence[Array], threads: int = 1) -> tuple[dict[str, Array], npt.NDArray[np.bool_]]:
        """Many evaluations: arrays of shape (N, ...) by name, and which of the N may be trusted."""
        *results, strain = self.kernel.batch(arguments, threads=threads)
        # one pass over the data: a row with anything not finite has no finite sum
        total = np.einsum("ij->i", results[0])
        for result in results[1:]:
            total += np.einsum("ij->i", result)
        good = (strain[:, 0] <= STRAIN_LIMIT) & np.isfinite(total)
        named = zip(self._parts, results, strict=True)
        return {name: y if shape is None else y.reshape(-1, *shape) for (name, _, shape), y in named}, good


Check = Callable[[CompiledFunction], str]
"""What is wrong with a function; empty if nothing is."""


class Library:
    """Compiled functions by name, made when first asked for.

    Args:
        source: the model.
        check: compares a function with the model it was made from, before it is handed out.
        options: how to compile.
    """

    __repr__ = line("source", "options")

    def __init__(self, source: Source, check: Check, options: Options) -> None:
        self.source, self.options, self._check = source, options, check
        self._functions: dict[str, CompiledFunction] = {}
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        # a library that was pickled makes its functions anew, from the cache as a rule, and reports to nobody
        return Library, (self.source, self._check, replace(self.options, report=None))

    def __getitem__(self, what: str) -> CompiledFunction:
        """The function called `what`.

        Raises:
            UnknownNameError: there is none.
            InputError: this model does not have it.
            CompileError: what was traced does not agree with the model.
        """
        found = self._functions.get(what)
        if found is None:
            with self._lock:
                found = self._functions.get(what) or self._make(function(what))
                self._functions[what] = found
        return found

    def program(self, what: str) -> Program:
        """The instructions of the function called `what`, checked but not compiled; errors as of it."""
        return self.soon(what).kernel.program

    def soon(self, what: str) -> CompiledFunction:
        """The function called `what`, for what is done once: in machine code where that is kept from process to
        process, or there already, else interpreted; errors as of it."""
        if self.options.cached or what in self._functions:
            return self[what]
        return self._made(function(what), interpreted=True)[0]

    def _make(self, row: Function) -> CompiledFunction:
        start = time.perf_counter()
        made, cached = self._made(row, interpreted=False)
        return self._reported(made, cached, time.perf_counter() - start)

    def _made(self, row: Function, *, interpreted: bool) -> tuple[CompiledFunction, bool]:
        """A function that was checked, and whether its instructions came from the cache."""
        fused = backend(self.options.backend).fused()
        name = cache.key(self.source.content, row.name, f"fused={fused}") if self.options.cached else ""
        stored = cache.read(name) if self.options.cached else None
        if stored is not None:
            if (stored.name, stored.arguments, stored.results) == (row.name, *row.lengths(self.source)):
                kept = self._compiled(row, stored, interpreted)
                if not self._check(kept):
                    return kept, True
                kept.kernel.forget()
            cache.drop(name)
        program = row.program(self.source, fused=fused)
        made = self._compiled(row, program, interpreted)
        wrong = self._check(made)
        if wrong:  # machine code of an earlier process is wrong, if anything
            made.kernel.forget()
            made = self._compiled(row, program, interpreted)
            wrong = self._check(made)
        if wrong:
            raise CompileError(
                f"'{row.name}' of {self.source.name}, compiled, does not agree with the model it was made from: "
                f"{wrong}. Use the model itself, and report this robot as a bug"
            )
        if self.options.cached:
            cache.write(name, program)
        return made, False

    def _compiled(self, row: Function, program: Program, interpreted: bool) -> CompiledFunction:
        options = self.options
        kind = Interpreter if interpreted else backend(options.backend).kernel
        return CompiledFunction(
            row, kind(program, fast=options.fast, quick=options.quick, kept=options.cached), self.source
        )

    def _reported(self, made: CompiledFunction, cached: bool, seconds: float) -> CompiledFunction:
        if self.options.report is not None:
            kernel, spent = made.kernel, made.kernel.compile_time
            self.options.report(
                Made(made.row.name, kernel.program.operations, cached, max(seconds - spent, 0.0), spent)
            )
        return made
