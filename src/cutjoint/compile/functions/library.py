"""The compiled functions of one model: from the cache or traced anew, checked, and turned into machine code on
demand."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions import cache
from cutjoint.compile.functions.table import BUILDERS, trace
from cutjoint.compile.machine.llvm.native import Kernel, host
from cutjoint.compile.sources.interface import Source
from cutjoint.errors import CompileError, UnknownNameError

Check = Callable[[str, Kernel], str]
"""(what, kernel) -> what is wrong with it; empty if nothing is."""


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


class Library:
    """Compiled functions by name, made when first asked for.

    Args:
        source: the model.
        check: compares a function with the model it was made from, before it is handed out.
        fast: allow reassociation (fast-math).
        cached: use the cache folder.
        report: called with every function that was made.
    """

    def __init__(
        self,
        source: Source,
        check: Check,
        *,
        fast: bool = False,
        cached: bool = True,
        report: Callable[[Made], None] | None = None,
    ) -> None:
        self.source, self.fast, self.cached = source, fast, cached
        self._check, self._report = check, report
        self._kernels: dict[str, Kernel] = {}
        self._lock = threading.RLock()

    def __reduce__(self) -> Any:
        # a library that was pickled makes its functions anew, from the cache as a rule, and reports to nobody
        return _library, (self.source, self._check, self.fast, self.cached)

    def __getitem__(self, what: str) -> Kernel:
        """The function called `what`.

        Raises:
            UnknownNameError: there is none.
            InputError: this model does not have it.
            CompileError: what was traced does not agree with the model.
        """
        found = self._kernels.get(what)
        if found is None:
            with self._lock:
                found = self._kernels.get(what) or self._make(what)
                self._kernels[what] = found
        return found

    def _make(self, what: str) -> Kernel:
        if what not in BUILDERS:
            raise UnknownNameError("compiled function", what, list(BUILDERS))
        fused = host().fused
        name = cache.key(self.source.content, what, f"fused={fused}") if self.cached else ""
        start = time.perf_counter()
        stored = cache.read(name) if self.cached else None
        if stored is not None:
            kernel = Kernel(stored, fast=self.fast) if self._fits(stored, what) else None
            if kernel is not None and not self._check(what, kernel):
                return self._made(what, kernel, True, time.perf_counter() - start)
            cache.drop(name)
        program = trace(self.source, what, fused=fused)
        kernel = Kernel(program, fast=self.fast)
        wrong = self._check(what, kernel)
        if wrong:
            raise CompileError(
                f"'{what}' of {self.source.name}, compiled, does not agree with the model it was made from: {wrong}. "
                "Use the model itself, and report this robot as a bug"
            )
        if self.cached:
            cache.write(name, program)
        return self._made(what, kernel, False, time.perf_counter() - start)

    def _fits(self, program: Program, what: str) -> bool:
        """Whether a stored program takes the arguments that this model gives."""
        sizes = dict(program.arguments)
        return (
            program.name == what
            and sizes.get("q") == self.source.positions
            and sizes.get("parameters") == len(self.source.parameters)
            and bool(program.results)
            and program.results[-1] == ("strain", 1)
        )

    def _made(self, what: str, kernel: Kernel, cached: bool, seconds: float) -> Kernel:
        if self._report is not None:
            spent = kernel.compile_time
            self._report(Made(what, kernel.program.operations, cached, max(seconds - spent, 0.0), spent))
        return kernel


def _library(source: Source, check: Check, fast: bool, cached: bool) -> Library:
    return Library(source, check, fast=fast, cached=cached)
