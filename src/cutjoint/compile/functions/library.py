"""The compiled functions of one model, made on demand: from the cache or traced anew, checked, in machine code."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions import cache
from cutjoint.compile.functions.call import CompiledFunction
from cutjoint.compile.functions.options import Made, Options
from cutjoint.compile.functions.table import Function, function
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.sources.interface import Source
from cutjoint.errors import CompileError

Check = Callable[[CompiledFunction], str]
"""What is wrong with a function; empty if nothing is."""


class Library:
    """Compiled functions by name, made when first asked for.

    Args:
        source: the model.
        check: compares a function with the model it was made from, before it is handed out.
        options: how to compile.
    """

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

    def _make(self, row: Function) -> CompiledFunction:
        fused = backend(self.options.backend).fused()
        name = cache.key(self.source.content, row.name, f"fused={fused}") if self.options.cached else ""
        start = time.perf_counter()
        stored = cache.read(name) if self.options.cached else None
        if stored is not None:
            if (stored.name, stored.arguments, stored.results) == (row.name, *row.lengths(self.source)):
                kept = self._compiled(row, stored)
                if not self._check(kept):
                    return self._reported(kept, True, time.perf_counter() - start)
            cache.drop(name)
        program = row.program(self.source, fused=fused)
        made = self._compiled(row, program)
        wrong = self._check(made)
        if wrong:
            raise CompileError(
                f"'{row.name}' of {self.source.name}, compiled, does not agree with the model it was made from: "
                f"{wrong}. Use the model itself, and report this robot as a bug"
            )
        if self.options.cached:
            cache.write(name, program)
        return self._reported(made, False, time.perf_counter() - start)

    def _compiled(self, row: Function, program: Program) -> CompiledFunction:
        return CompiledFunction(row, backend(self.options.backend).kernel(program, fast=self.options.fast), self.source)

    def _reported(self, made: CompiledFunction, cached: bool, seconds: float) -> CompiledFunction:
        if self.options.report is not None:
            kernel, spent = made.kernel, made.kernel.compile_time
            self.options.report(
                Made(made.row.name, kernel.program.operations, cached, max(seconds - spent, 0.0), spent)
            )
        return made
