"""A child process for parsers that a spoiled file could crash, hang or fill the memory with.

`in_child` calls a function of a module there and hands back what it returns.  One child is kept for the calls that
follow; after a crash or a limit that was passed the next call has a new one.  It ends with its parent, whatever ended
that, has nothing of the terminal, and leaves no core file.  Function, argument and value travel as pickles.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import os
import pickle
import resource
import select
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

from cutjoint.errors import CutjointError

LENGTH = struct.Struct(">Q")
START_SECONDS = 60.0
"""More than a busy machine needs to start Python and numpy."""
QUIET = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MUJOCO_GL": "off"}
"""What keeps packages from mapping memory for threads, and from loading windows, that a parser has no use for."""
CODE = f"import sys; sys.path[:] = sys.argv[1:]; from {__spec__.name if __spec__ else __name__} import main; main()"


class ChildFailed(CutjointError):
    """A call gave no value; `reason` goes on from "the reader ...": "crashed (SIGSEGV)", "took longer than 5 s"."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"the child process {reason}")
        self.reason = reason


def in_child(function: str, argument: object, seconds: float, megabytes: int) -> object:
    """What `function`, given as "package.module:name", returns for `argument`, called in a child process.

    Paths in the argument are absolute: the child works elsewhere.  `seconds` are of wall clock, the import of the
    function's module left out; `megabytes` is the memory that the call may take beside what is loaded (Linux only).

    Raises:
        ChildFailed: it crashed, took too long or too much memory, raised an exception, or could not be started.
    """
    with _kept.lock:
        return _kept.call(function, argument, seconds, megabytes)


class _Child:
    """The kept child, or none."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None

    def call(self, function: str, argument: object, seconds: float, megabytes: int) -> object:
        """See `in_child`."""
        if self.process is None or self.process.poll() is not None:
            self.end()
            self.process = _started()
        try:
            self._ask((function, megabytes), START_SECONDS)
            return self._ask(argument, seconds)
        except BaseException:  # an interrupt too: whatever the child would answer now belongs to nobody
            if self.process is not None and not isinstance(sys.exception(), _Told):
                self.end()
            raise

    def _ask(self, message: object, seconds: float) -> object:
        """The answer to one message, within so many seconds."""
        process = self.process
        assert process is not None
        expired = threading.Event()

        def expire() -> None:
            expired.set()
            process.kill()

        timer = threading.Timer(seconds, expire)
        timer.daemon = True
        timer.start()
        try:
            assert process.stdin is not None
            assert process.stdout is not None
            _send(process.stdin.fileno(), pickle.dumps(message))
            kind, value = pickle.loads(_receive(process.stdout.fileno()))
        except (EOFError, OSError):
            process.kill()
            code = process.wait()
            raise ChildFailed(f"took longer than {seconds:g} s" if expired.is_set() else _ending(code)) from None
        finally:
            timer.cancel()
        if kind != "value":
            raise _Told(str(value))
        return value

    def end(self) -> None:
        """End the child, if there is one."""
        process, self.process = self.process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()

    def forget(self) -> None:
        """In a forked process: the child is that of another."""
        process, self.process = self.process, None
        self.lock = threading.Lock()
        if process is not None:
            process.returncode = 0  # nothing to wait for here
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()


class _Told(ChildFailed):
    """A failure that the child told itself: it lives on."""


def _started() -> subprocess.Popen[bytes]:
    """A new child, with the modules of this process, in a session of its own."""
    paths = [str(Path(entry).absolute()) for entry in sys.path if entry]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-c", CODE, *paths],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            cwd="/",
            env={**os.environ, **QUIET},
            start_new_session=True,
        )
    except OSError as error:
        raise ChildFailed(f"could not be started: {error}") from None


def _ending(code: int) -> str:
    if code >= 0:
        return f"ended with status {code}"
    try:
        return f"crashed ({signal.Signals(-code).name})"
    except ValueError:
        return f"crashed (signal {-code})"


def _send(to: int, data: bytes) -> None:
    left = memoryview(LENGTH.pack(len(data)) + data)
    while left:
        left = left[os.write(to, left) :]


def _receive(source: int) -> bytes:
    """The next message; EOFError where the other end is gone."""
    return _exactly(source, LENGTH.unpack(_exactly(source, LENGTH.size))[0])


def _exactly(source: int, count: int) -> bytes:
    parts = []
    while count > 0:
        part = os.read(source, min(count, 1 << 20))
        if not part:
            raise EOFError
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def main() -> None:
    """The child: a function, then its argument, until the parent closes the pipe or is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    source, to = os.dup(0), os.dup(1)
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 0)
    os.dup2(null, 1)
    with contextlib.suppress(EOFError, BrokenPipeError):
        while True:
            function, megabytes = pickle.loads(_receive(source))
            try:
                call = _function(function)
            except Exception as error:
                _send(to, pickle.dumps(("failed", f"raised {type(error).__name__}: {error}")))
            else:
                _send(to, pickle.dumps(("value", None)))
                data = _receive(source)
                with _bound_to(source), _held_to(megabytes):
                    answer = _answer(call, data)
                _send(to, answer)


def _answer(call: Callable[[object], object], data: bytes) -> bytes:
    """What a call gives, or why it gives nothing, pickled."""
    try:
        return pickle.dumps(("value", call(pickle.loads(data))))
    except MemoryError:
        reason = "ran out of memory"
    except Exception as error:
        reason = f"raised {type(error).__name__}: {error}"
    return pickle.dumps(("failed", reason))


def _function(path: str) -> Callable[[object], object]:
    module, _, name = path.partition(":")
    found: Callable[[object], object] = getattr(import_module(module), name)
    return found


@contextlib.contextmanager
def _bound_to(source: int) -> Iterator[None]:
    """While this lasts, the end of the parent ends the process at once (Linux; elsewhere when the call is over)."""
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    flags = fcntl.fcntl(source, fcntl.F_GETFL)
    fcntl.fcntl(source, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(source, fcntl.F_SETFL, flags | os.O_ASYNC)
    if select.select([source], [], [], 0.0)[0]:  # gone already
        raise EOFError
    try:
        yield
    finally:
        fcntl.fcntl(source, fcntl.F_SETFL, flags)


@contextlib.contextmanager
def _held_to(megabytes: int) -> Iterator[None]:
    """While this lasts, the process may take so much memory beside what it has."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except OSError:
        yield
        return
    wished = pages * resource.getpagesize() + megabytes * 2**20
    limit = min(one for one in (wished, soft, hard) if one != resource.RLIM_INFINITY)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


_kept = _Child()
atexit.register(_kept.end)
os.register_at_fork(after_in_child=_kept.forget)
