"""What a study will take, said before it begins: a few runs of every case are simulated, timed and weighed."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.studies.blocks import BlockPlan, BlockSpan, Prepared, written

TRIED = 64
"""Runs of a case that are timed."""
SPARE = 1.1
"""Disk that must be free, times what is needed."""
SLOWEST = 365.25 * 86400.0
"""Seconds beyond which a study is refused: a year."""


@dataclass(frozen=True)
class StudyEstimate:
    """What a study will take.

    Attributes:
        runs, blocks: how many, of which `done` blocks are there already.
        workers: threads that simulate.
        per_run: seconds of one thread.
        seconds: until it is done [s].
        disk: bytes of the blocks that are still to come, and `free` what there is.
        memory: bytes of this process, and `available` what there is.
    """

    runs: int
    blocks: int
    done: int
    workers: int
    per_run: float
    seconds: float
    disk: int
    free: int
    memory: int
    available: int

    __repr__ = line("runs", "seconds", "disk", "memory", seconds="s", disk="B", memory="B")


def estimate_of(
    prepared: Prepared,
    plan: BlockPlan,
    folder: Path,
    workers: int,
    done: int = 0,
    told: Callable[[float], None] | None = None,
) -> StudyEstimate:
    """Try some runs of every case; `told` hears how many cases are tried."""
    seconds, size = 0.0, 0.0
    for case in range(plan.cases):
        count = min(TRIED, plan.samples, plan.size)
        prepared.rows(BlockSpan(case, 0, min(8, count)))  # compiles
        began = time.perf_counter()
        table = prepared.rows(BlockSpan(case, 0, count))
        seconds += (time.perf_counter() - began) / count / plan.cases
        size += _weight(table.nbytes, count, len(written(table)), len(written(table.slice(0, 0)))) / plan.cases
        if told is not None:
            told(case + 1.0)
    left = plan.runs * (1.0 - done / max(plan.count, 1))
    record = prepared.case(0).record
    return StudyEstimate(
        runs=plan.runs,
        blocks=plan.count,
        done=done,
        workers=workers,
        per_run=seconds,
        seconds=left * seconds / max(1, workers),
        disk=int(left * size + (plan.count - done) * 6000.0),
        free=_free(folder),
        memory=int(_resident() + 3 * workers * record * plan.size),
        available=_available(),
    )


def _weight(plain: int, count: int, packed: int, empty: int) -> float:
    """Bytes of a run in a file: few runs pack as well as many, but for what every file has."""
    return min(max((packed - empty) / count, 1.0), 1.2 * plain / count)


def check_fits(estimate: StudyEstimate) -> None:
    """Refuse what cannot fit.

    Raises:
        InputError: too little disk or memory, or more than a year.
    """
    if fault := why_not(estimate):
        raise InputError(fault)


def why_not(estimate: StudyEstimate) -> str:
    """Why a study cannot be; nothing where it can."""
    if estimate.disk * SPARE > estimate.free:
        return (
            f"{estimate.runs:.4g} runs need {size_of(estimate.disk)} of disk and {size_of(estimate.free)} are free; "
            "take fewer runs, keep fewer columns, or give another folder (--out)"
        )
    if estimate.memory > estimate.available:
        return (
            f"a block needs {size_of(estimate.memory)} of memory and {size_of(estimate.available)} are available; "
            "give a smaller block, or take samples less often (keep.every)"
        )
    if estimate.seconds > SLOWEST:
        return (
            f"{estimate.runs:.4g} runs take {estimate.seconds / 86400.0:.4g} days on {estimate.workers} workers; take "
            "fewer, or a cluster (--scheduler)"
        )
    return ""


def size_of(count: float) -> str:
    """Bytes in words."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000.0 or unit == "TB":
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return ""


def time_of(seconds: float) -> str:
    """Seconds in words."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.2g} s"


def _free(folder: Path) -> int:
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return shutil.disk_usage(folder).free


def _resident() -> int:
    """Bytes of this process."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0


def _available() -> int:
    """Bytes that programs may still take, this one's included; a great many where the system does not tell."""
    try:
        for row in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if row.startswith("MemAvailable:"):
                return int(row.split()[1]) * 1024 + _resident()
    except (OSError, ValueError, IndexError):
        pass
    return 2**62
