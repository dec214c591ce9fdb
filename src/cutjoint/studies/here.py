"""Blocks in threads of this process: machine code and NumPy leave Python's lock free."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice

from cutjoint.studies.blocks import BlockPlan, Prepared
from cutjoint.studies.taking import Taken

AHEAD = 2
"""Blocks a thread that are handed out: enough that none waits."""
LOOK = 0.25
"""Seconds between two looks at how far it is."""


class _Stopped(Exception):
    """Somebody asked a block to stop."""


def run_here(prepared: Prepared, plan: BlockPlan, blocks: Iterable[int], workers: int, taken: Taken) -> None:
    """Simulate blocks and hand each on; whatever is raised meanwhile ends all of them within a step.

    Raises:
        CutjointError: of a block that cannot be simulated.
    """
    todo, stop, parts = iter(blocks), threading.Event(), dict[int, float]()

    def work(block: int) -> bytes:
        def told(part: float) -> None:
            if stop.is_set():
                raise _Stopped
            parts[block] = part

        return prepared.block(plan, block, told)

    def size(block: int) -> int:
        span = plan.span(block)
        return span.end - span.begin

    with ThreadPoolExecutor(workers, thread_name_prefix="cutjoint-study") as pool:
        going: dict[Future[bytes], int] = {}
        try:
            while True:
                going |= {pool.submit(work, block): block for block in islice(todo, AHEAD * workers - len(going))}
                if not going:
                    return
                done, _ = wait(going, timeout=LOOK, return_when=FIRST_COMPLETED)
                for one in done:
                    block = going.pop(one)
                    taken.block(block, one.result(), size(block))
                    parts.pop(block, None)
                taken.look(sum(part * size(block) for block, part in list(parts.items()) if block in going.values()))
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
