"""Timing in interleaved rounds: every contender in every round, CPU time of the process, medians.

A machine that other work slows down slows all contenders of a round alike, so ratios are taken within rounds.
"""

from __future__ import annotations

import gc
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median


@dataclass(frozen=True)
class Contender:
    """Something to time.

    Attributes:
        run: does the work once.
        units: pieces of work in one run (states, runs); times are per piece.
        scale: what one measured piece stands for, where the whole would take too long.
    """

    run: Callable[[], object]
    units: float = 1.0
    scale: float = 1.0


@dataclass(frozen=True)
class Timing:
    """CPU seconds a piece, one number a round."""

    rounds: tuple[float, ...]

    @property
    def median(self) -> float:
        """Median over the rounds [s]."""
        return median(self.rounds)

    def ratio(self, other: Timing) -> float:
        """How many times longer the other took: median of the ratios within rounds."""
        return median(theirs / ours for ours, theirs in zip(self.rounds, other.rounds, strict=True))


def measure(contenders: Mapping[str, Contender], rounds: int) -> dict[str, Timing]:
    """Time all contenders in interleaved rounds, after one that does not count."""
    found: dict[str, list[float]] = {name: [] for name in contenders}
    for contender in contenders.values():
        contender.run()
    gc.disable()
    try:
        for number in range(rounds):
            order = list(contenders.items())
            for name, contender in order if number % 2 == 0 else reversed(order):
                start = time.process_time()
                contender.run()
                spent = time.process_time() - start
                found[name].append(max(spent, 1e-9) * contender.scale / contender.units)
    finally:
        gc.enable()
    return {name: Timing(tuple(values)) for name, values in found.items()}


def repeated(call: Callable[[], object], times: int) -> Callable[[], None]:
    """The same call many times over."""

    def run() -> None:
        for _ in range(times):
            call()

    return run


def machine() -> str:
    """Processor, cores, operating system and versions, in one line."""
    from importlib.metadata import version

    cpu = platform.processor() or platform.machine()
    try:
        rows = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        cpu = next(row.split(":", 1)[1].strip() for row in rows if row.startswith("model name"))
    except (OSError, StopIteration):
        pass
    from cutjoint.compile.batch import cores
    from cutjoint.compile.machine.llvm.native import host

    versions = ", ".join(
        f"{name} {version(name)}" for name in ("pin", "mujoco", "drake", "pybullet", "llvmlite", "numpy") if _has(name)
    )
    return (
        f"{cpu} ({host().name}, {host().lanes} lanes), {cores()} cores, {platform.system()}, "
        f"Python {platform.python_version()}, {versions}"
    )


def _has(name: str) -> bool:
    from importlib.metadata import PackageNotFoundError, version

    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True


def duration(seconds: float) -> str:
    """A time with three digits and a fitting unit."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.2g} ns"
