"""What a back end makes of programs: a kernel, which is called with one state or with many, and a loop over runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeAlias

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import Program
from cutjoint.errors import InputError
from cutjoint.reprs import line


class Kernel:
    """A program that can be called.  A back end says how one evaluation is done, and may do many in its own way.

    Args:
        program: what it computes.
        fast: sums may be reassociated, where the back end can.
        quick: to be made soon rather than to be quick, where the back end has the choice.
        kept: what is made may be kept for the next process, where the back end can.

    Attributes:
        compile_time: seconds that making it took.
    """

    compile_time = 0.0

    __repr__ = line("program", "fast", "quick", "compile_time", compile_time="s")

    def __init__(self, program: Program, *, fast: bool = False, quick: bool = False, kept: bool = False) -> None:
        self.program, self.fast, self.quick, self.kept = program, fast, quick, kept

    def __reduce__(self) -> tuple[object, ...]:
        # what was made for this process and processor does not travel: it is made anew by whoever unpickles
        return partial(type(self), fast=self.fast, quick=self.quick, kept=self.kept), (self.program,)

    def __call__(self, *arguments: Array) -> Array:
        """One evaluation: arguments of the program's lengths in, all results one after another out."""
        raise AssertionError

    def forget(self) -> None:
        """Whatever is kept of it for the next process is not to be used."""

    @property
    def address(self) -> int:
        """Address of `void f(const double *x, double *y)`, to be called from other compiled code; x holds all arguments
        one after another, y all results.

        Raises:
            InputError: this back end has none.
        """
        raise InputError("this back end makes nothing that has an address; compile with backend='llvm'")

    def batch(self, arguments: Sequence[Array], *, threads: int = 1, lanes: bool = True) -> list[Array]:
        """Many evaluations.

        Args:
            arguments: of shape (N, size) each, or (size,) where all evaluations share it.
            threads: processor cores to use.
            lanes: False does one row after another (for comparison; the digits are the same).

        Returns:
            One (N, size) array a result.
        """
        given = [np.ascontiguousarray(x, dtype=np.float64) for x in arguments]
        for (name, size), x in zip(self.program.arguments, given, strict=True):
            if x.shape[-1] != size or x.ndim > 2:
                raise InputError(f"{name} must have shape (N, {size}) or ({size},), found {x.shape}")
        counts = {x.shape[0] for x in given if x.ndim == 2}
        if len(counts) != 1:
            raise InputError(f"the arguments must agree in their number of rows, found {sorted(counts)}")
        results = [np.empty((*counts, size)) for _, size in self.program.results]
        self.fill(results, given, counts.pop(), threads, lanes)
        return results

    def fill(self, results: list[Array], given: list[Array], count: int, threads: int, lanes: bool) -> None:
        """The evaluations of a batch: `given` are its arguments, in order and of the right shapes."""
        ends = np.cumsum([result.shape[1] for result in results])
        for row in range(count):
            y = self(*(x if x.ndim == 1 else x[row] for x in given))
            for result, part in zip(results, np.split(y, ends[:-1]), strict=True):
                result[row] = part


@dataclass(frozen=True)
class Sizes:
    """Numbers of a run."""

    state: int
    columns: int
    """Of the reference table."""
    given: int
    """Arguments that are each run's own."""
    watched: int
    """Values whose largest and whose mean square are kept."""
    settled: int
    """Leading part of the state that the settling function rewrites; 0 where there is none."""
    memory: int = 0
    """What only events change; 0 at the start."""
    noise: int = 0
    """Random numbers that an event reads."""
    shown: tuple[int, ...] = ()
    """Places of the memory that are recorded."""

    @property
    def changing(self) -> int:
        """Where the memory begins in the arguments: behind state, reference row and own arguments."""
        return self.state + self.columns + self.given

    @property
    def width(self) -> int:
        """Numbers of a record: state, watched values, what is shown of the memory."""
        return self.state + self.watched + len(self.shown)

    @property
    def totals(self) -> int:
        """Numbers that are kept of a run."""
        return 2 * self.watched + 2


@dataclass(frozen=True, eq=False)
class Event:
    """What happens at an instant: a program of (state, reference row, own arguments, memory, noise).

    Attributes:
        program: what it computes.
        targets: the places in these arguments that its results go to.
        draws: whether it reads noise, each time the next row of it.
    """

    program: Program
    targets: tuple[int, ...]
    draws: bool = False


@dataclass(frozen=True)
class Stages:
    """An explicit Runge-Kutta method each of whose slopes starts from the last one alone.

    Attributes:
        nodes: where in the step the second and the further slopes are taken: 1/2 or 1.
        weights: of all slopes, whole numbers.
        divisor: of the weighted sum.
    """

    nodes: tuple[float, ...]
    weights: tuple[int, ...]
    divisor: int


@dataclass(frozen=True, eq=False)
class LoopParts:
    """A loop over runs, in parts.

    Attributes:
        rate: program of the rates of the state, of what is watched, and of the strain.
        settle: program of the Newton step onto the loops, where there are any.
        stages: the integrator.
        sizes: the numbers of a run.
        begin: what happens before the first step, with the first row of noise, which is then drawn again.
        events: what changes the memory between steps, in this order where several fall due; with them the reference is
            read at whole steps only, without them at half steps too.
    """

    rate: Program
    settle: Program | None
    stages: Stages
    sizes: Sizes
    begin: Event | None = None
    events: tuple[Event, ...] = ()


RunLoop: TypeAlias = Callable[[int, int, int, int, float, float, int], None]
"""(first group, group after the last, steps, steps from record to record, step [s], limit of the strain, address of the
table of addresses); see `cutjoint.compile.machine.llvm.run_loop`."""


class Runs(Protocol):
    """A loop over runs that is compiled when asked for.

    Attributes:
        lanes: runs that go side by side, a group.
    """

    @property
    def lanes(self) -> int:
        """See the class."""

    def loop(self, lanes: int) -> RunLoop:
        """The loop over groups of so many runs: 1, or `lanes` of them."""


@dataclass(frozen=True)
class MotionPrograms:
    """Equations of motion for an integrator in machine code; see `cutjoint.compile.machine.llvm.advance`.

    Attributes:
        rate: program of (positions, velocities, efforts, parameters): rates of the first two, two powers, what else is
            asked for of a state, strain.
        settle: program of (positions, target, parameters): positions after a Newton step onto the loops, what they were
            open by before, strain; None where there are no loops.
        actuated: where in the positions the target is.
    """

    rate: Program
    settle: Program | None
    actuated: tuple[int, ...]

    @property
    def positions(self) -> int:
        """Position variables."""
        return self.rate.arguments[0][1]

    @property
    def velocities(self) -> int:
        """Velocities."""
        return self.rate.arguments[1][1]

    @property
    def integrated(self) -> int:
        """Positions, velocities and works."""
        return self.positions + self.velocities + 2

    @property
    def more(self) -> int:
        """Numbers that are asked for of a state."""
        return self.rate.n_out - self.integrated - 1

    @property
    def parameters(self) -> int:
        """Parameters that are arguments."""
        return self.rate.arguments[-1][1]

    @property
    def given(self) -> int:
        """Efforts and parameters."""
        return self.rate.arguments[2][1] + self.parameters

    @property
    def settled(self) -> bool:
        """Whether there are loops."""
        return self.settle is not None

    @property
    def rows(self) -> int:
        """Equations of the loops."""
        return 0 if self.settle is None else self.settle.results[1][1]

    @property
    def settle_in(self) -> int:
        """Numbers that `settle` takes."""
        return 0 if self.settle is None else self.settle.n_in

    @property
    def settle_out(self) -> int:
        """Numbers that `settle` gives."""
        return 0 if self.settle is None else self.settle.n_out


class Advance(Protocol):
    """An integrator in machine code."""

    def __call__(self, state: Array, given: Array, found: Array, step: Array, span: float) -> int:
        """Carry `state` on by `span` [s]; see `cutjoint.compile.machine.llvm.advance.AdvanceText`."""
