"""Blocks on a Dask cluster: the recipe travels, files of blocks come back, and this process alone writes them.

Workers share no folder.  A block whose worker dies is simulated by another one: its file is the same, and is taken
once.
"""

from __future__ import annotations

import logging
import pickle
import queue
import re
import socket
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING, cast

from cutjoint.errors import CutjointError, InputError, StudyError, shown
from cutjoint.extras import needed
from cutjoint.findings import listing
from cutjoint.reprs import counted, line
from cutjoint.studies.blocks import BlockPlan, Prepared, processor
from cutjoint.studies.cases import Recipe
from cutjoint.studies.taking import Taken

if TYPE_CHECKING:
    from distributed import Client, Future

ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?(?P<host>[^\s/:]+|\[[0-9a-fA-F:.]+\]):(?P<port>[0-9]{1,5})/?")
ANSWER = 10.0
"""Seconds in which a scheduler must answer."""
PATIENCE = 120.0
"""Seconds without any worker until the study is given up."""
STRANGER = "something listens there that is no Dask scheduler"
LOOK = 0.25
AHEAD = 2
"""Blocks a thread that are handed out."""
DEATHS = 10
"""Times that workers may die of one block, beyond those that Dask itself passes over."""
SAME = ("cutjoint", "numpy", "scipy", "llvmlite", "pyarrow")
"""Packages of which workers must have the versions that are here."""
SCHEDULERS = ("distributed", "dask")
"""Packages of which scheduler and workers must have the versions that are here."""

_PREPARED: dict[str, Prepared] = {}
_LOCK = threading.Lock()


def work(packed: bytes, key: str, plan: BlockPlan, block: int) -> tuple[str, bytes]:
    """A block, as a worker makes it: the kind of its processor, and the file."""
    with _LOCK:
        if key not in _PREPARED:
            _PREPARED.clear()
            _PREPARED[key] = Prepared(cast(Recipe, pickle.loads(packed)))
        prepared = _PREPARED[key]
    return processor(), prepared.block(plan, block)


class DaskCluster:
    """A Dask cluster; a context.

    Args:
        address: of its scheduler, such as tcp://10.0.0.1:8786.

    Attributes:
        threads: of all workers.
        processors: the kinds of the workers' processors.

    Raises:
        MissingPackageError: Dask is not installed.
        InputError: the scheduler does not answer, there is no worker, or versions differ.
    """

    __repr__ = line("address", "threads", "processors")

    def __init__(self, address: str) -> None:
        self.address = address
        found = _parsed(address)
        needed("distributed", "a study on a Dask cluster (--scheduler)")
        _check_listening(address, found)
        self._client = _client(address)
        try:
            self._check_versions()
            self.threads = sum(self._workers().values())
            kinds = self._client.run(processor)
            self.processors = sorted(set(cast(dict[str, str], kinds).values()))
        except BaseException:
            self._close()
            raise

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def run(
        self, prepared: Prepared, plan: BlockPlan, blocks: Iterable[int], taken: Taken, *, any_processor: bool
    ) -> None:
        """Simulate blocks and hand each on.

        Raises:
            StudyError: the cluster is gone, or workers die of a block.
            CutjointError: of a block that cannot be simulated.
        """
        with _quiet():
            self._run(prepared, plan, blocks, taken, any_processor=any_processor)

    def _run(
        self, prepared: Prepared, plan: BlockPlan, blocks: Iterable[int], taken: Taken, *, any_processor: bool
    ) -> None:
        recipe = prepared.recipe
        key, packed, todo = recipe.key, recipe.packed, iter(blocks)
        going: dict[Future[tuple[str, bytes]], int] = {}
        deaths: dict[int, int] = {}
        alive = time.monotonic()

        def submit(block: int) -> None:
            name = f"cutjoint-{key[:16]}-{block}-{deaths.get(block, 0)}-{id(self)}"
            future = self._client.submit(work, packed, key, plan, block, key=name, pure=False)
            going[future] = block

        try:
            while True:
                room = AHEAD * max(1, self.threads) - len(going)
                for block in islice(todo, max(0, room)):
                    submit(block)
                if not going:
                    return
                finished = [one for one in going if one.status != "pending"]
                for one in finished:
                    block = going.pop(one)
                    answer = self._answer(one, block, deaths, taken)
                    if answer is None:
                        submit(block)
                        continue
                    self._check_processor(answer[0], taken, any_processor=any_processor)
                    span = plan.span(block)
                    taken.block(block, answer[1], span.end - span.begin)
                if workers := self._workers():
                    alive, self.threads = time.monotonic(), sum(workers.values())
                elif time.monotonic() - alive > PATIENCE:
                    raise StudyError(
                        f"the cluster at {self.address} has had no worker for {PATIENCE:g} s; what is done is kept, "
                        "and the same command goes on",
                        done=len(taken.folder.done),
                    )
                taken.look()
                if not finished:
                    time.sleep(LOOK / 10.0 if self.threads > 8 else LOOK / 5.0)
        finally:
            if self._client.status == "running" and going:
                self._client.cancel(list(going), force=True)

    def _answer(
        self, one: Future[tuple[str, bytes]], block: int, deaths: dict[int, int], taken: Taken
    ) -> tuple[str, bytes] | None:
        """What came of a block, or None where it shall be simulated again."""
        from distributed import KilledWorker

        try:
            if one.status == "finished":
                return cast("tuple[str, bytes]", one.result(timeout=60.0))
            error = one.exception(timeout=60.0) if one.status == "error" else RuntimeError(f"it was {one.status}")
        except (TimeoutError, OSError, RuntimeError) as found:  # what the worker had is gone with it
            error = found
        if isinstance(error, CutjointError):
            raise error
        deaths[block] = deaths.get(block, 0) + 1
        if self._client.status != "running":
            raise StudyError(
                f"the scheduler at {self.address} does not answer any more; what is done is kept, and the same command "
                "goes on",
                done=len(taken.folder.done),
            )
        passing = isinstance(error, KilledWorker | TimeoutError | OSError | RuntimeError)
        if passing and deaths[block] <= DEATHS:
            return None
        raise StudyError(
            f"block {block} cannot be simulated on the cluster ({type(error).__name__}: {str(error)[:200]}); what is "
            "done is kept, and the same command goes on",
            done=len(taken.folder.done),
        )

    def _check_processor(self, kind: str, taken: Taken, *, any_processor: bool) -> None:
        if kind in self.processors:
            return
        if not any_processor:
            raise StudyError(
                f"a worker came with another kind of processor ({kind}; the others have {listing(self.processors)}), "
                "whose last digits may differ; take workers of one kind, or --any-processor",
                done=len(taken.folder.done),
            )
        self.processors = sorted([*self.processors, kind])
        taken.folder.also(kind)

    def _workers(self) -> dict[str, int]:
        """Threads of every worker."""
        known = self._client.scheduler_info(n_workers=-1)["workers"]
        return {name: int(one["nthreads"]) for name, one in known.items()}

    def _check_versions(self) -> None:
        """Raises InputError where there is no worker, or scheduler or workers have other versions."""
        found = self._client.get_versions(packages=[*SAME, *SCHEDULERS])
        workers = found["workers"]
        if not workers:
            raise InputError(
                f"the Dask scheduler at {self.address} has no workers; start some (dask worker {self.address})"
            )
        here = found["client"]
        there: dict[str, tuple[dict[str, dict[str, str]], tuple[str, ...]]] = {}
        there["the scheduler"] = (found["scheduler"], SCHEDULERS)
        there |= {f"worker {name}": (one, (*SCHEDULERS, *SAME)) for name, one in workers.items()}
        wrong = []
        for name, (one, packages) in there.items():
            python, own = (str(side["host"]["python"]).rsplit(".", 3)[0] for side in (one, here))
            if python.split(".")[:2] != own.split(".")[:2]:
                wrong.append(f"{name} has Python {python}, here is {own}")
            for package in packages:
                was, now = one["packages"].get(package), here["packages"].get(package)
                if was != now:
                    wrong.append(f"{name} has {package} {was or '(not installed)'}, here is {now}")
        if wrong:
            more = f" and {counted(len(wrong) - 3, 'more')}" if len(wrong) > 3 else ""
            raise InputError(f"{'; '.join(wrong[:3])}{more}: the same study needs the same versions everywhere")

    def _close(self) -> None:
        with _quiet():
            self._client.close(timeout=2.0)


def _parsed(address: str) -> tuple[str, int]:
    """Host and port of an address; raises InputError where it is none."""
    found = ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found["port"]) < 2**16:
        raise InputError(f"a scheduler's address is such as tcp://10.0.0.1:8786, found '{shown(address)}'")
    return found["host"].strip("[]"), int(found["port"])


def _check_listening(address: str, place: tuple[str, int]) -> None:
    """Raises InputError where nobody listens at a place, or one who waits to be spoken to: a scheduler speaks first."""
    try:
        with socket.create_connection(place, timeout=ANSWER) as line_to:
            if address.startswith(("ws:", "wss:", "tls:", "ucx:")):
                return
            try:
                greeting = line_to.recv(1)
            except TimeoutError:
                greeting = b""
    except (OSError, UnicodeError) as error:
        raise InputError(_no_answer(address, getattr(error, "strerror", None) or str(error))) from error
    if not greeting:
        raise InputError(_no_answer(address, STRANGER))


def _client(address: str) -> Client:
    """A client, made in a thread: Dask waits without end for a program that listens and says nothing it knows.

    Raises:
        InputError: no scheduler answers.
    """
    import distributed

    made: queue.SimpleQueue[Exception | None] = queue.SimpleQueue()
    client = distributed.Client.__new__(distributed.Client)

    def connect() -> None:
        try:
            client.__init__(address, timeout=ANSWER, set_as_default=False)
        except Exception as error:  # whatever Dask and the other side make of each other
            made.put(error)
        else:
            made.put(None)

    with _quiet():
        threading.Thread(target=connect, name="cutjoint-connect", daemon=True).start()
        try:
            found = made.get(timeout=1.5 * ANSWER)
        except queue.Empty:
            found = TimeoutError(STRANGER)
    if found is None:
        return client
    client.status = "closed"  # or it would wait for the other side when this program ends
    why = str(found).splitlines()[0][:120] if str(found) else type(found).__name__
    raise InputError(_no_answer(address, why)) from found


def _no_answer(address: str, why: str) -> str:
    return (
        f"no Dask scheduler answers at '{shown(address)}' within {ANSWER:g} s ({why}); is one running there "
        f"(dask scheduler), of the version that is here?"
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask's own log lines are left out: what matters is told as an error."""
    names = ["distributed", *(one for one in logging.root.manager.loggerDict if one.startswith("distributed."))]
    logs = [logging.getLogger(name) for name in names]
    before = [log.level for log in logs]
    for log in logs:
        log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for log, level in zip(logs, before, strict=True):
            log.setLevel(level)
