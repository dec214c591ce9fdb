"""The child process of parsers: values come back, failures have reasons, and nothing outlives its parent."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from cutjoint.description.formats.common.child import ChildFailed, in_child

pytestmark = pytest.mark.slow


def test_values_come_back() -> None:
    assert in_child("math:sqrt", 16.0, 10.0, 100) == 4.0
    assert in_child("builtins:sorted", [3, 1, 2] * 100_000, 10.0, 100) == sorted([3, 1, 2] * 100_000)


@pytest.mark.parametrize(
    ("function", "argument", "reason"),
    [
        ("signal:raise_signal", int(signal.SIGSEGV), "crashed (SIGSEGV)"),
        ("signal:raise_signal", int(signal.SIGABRT), "crashed (SIGABRT)"),
        ("os:_exit", 3, "ended with status 3"),
        ("time:sleep", 30.0, "took longer than 0.3 s"),
        ("builtins:bytearray", 300 * 2**20, "ran out of memory"),
        ("math:sqrt", -1.0, "raised ValueError: math domain error"),
        ("math:squareroot", 1.0, "raised AttributeError: module 'math' has no attribute 'squareroot'"),
        ("no_such_module:read", 1.0, "raised ModuleNotFoundError: No module named 'no_such_module'"),
        ("threading:Lock", None, "raised TypeError"),
    ],
)
def test_failures_have_reasons_and_the_next_call_works(function: str, argument: object, reason: str) -> None:
    with pytest.raises(ChildFailed) as caught:
        in_child(function, argument, 0.3 if function == "time:sleep" else 10.0, 100)
    assert caught.value.reason.startswith(reason)
    assert in_child("math:sqrt", 4.0, 10.0, 100) == 2.0


def test_the_child_is_kept() -> None:
    first = in_child("os:getsid", 0, 10.0, 100)
    assert first != os.getsid(0)
    assert in_child("os:getsid", 0, 10.0, 100) == first
    os.kill(int(str(first)), signal.SIGKILL)  # by somebody else
    time.sleep(0.2)
    assert in_child("os:getsid", 0, 10.0, 100) != first


def test_the_terminal_is_not_its_business(capfd: pytest.CaptureFixture[str]) -> None:
    in_child("builtins:print", "hello", 10.0, 100)
    in_child("os:system", "echo hello; echo hello >&2", 10.0, 1000)
    assert tuple(capfd.readouterr()) == ("", "")


def test_threads_share_it() -> None:
    found: dict[int, object] = {}

    def ask(number: int) -> None:
        for _ in range(20):
            found[number] = in_child("math:sqrt", float(number**2), 10.0, 100)

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {number: float(number) for number in range(4)}


def _parent(code: str) -> subprocess.Popen[str]:
    """Another Python that uses a child."""
    start = "import os, sys, threading, time\nfrom cutjoint.description.formats.common.child import in_child\n"
    return subprocess.Popen([sys.executable, "-c", start + code], stdout=subprocess.PIPE, text=True)


def _gone(pid: int) -> bool:
    end = time.monotonic() + 5.0
    while Path(f"/proc/{pid}").exists():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("busy", ["time:sleep", "builtins:sum"])
def test_it_ends_with_its_parent(how: signal.Signals, busy: str) -> None:
    # A sum over a long range keeps the interpreter busy in C, where no thread of Python could notice anything.
    argument = "60.0" if busy == "time:sleep" else "range(10**11)"
    parent = _parent(
        f"print(in_child('os:getsid', 0, 10.0, 100), flush=True)\nin_child('{busy}', {argument}, 60.0, 100)"
    )
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    time.sleep(0.3)
    parent.send_signal(how)
    parent.wait(5.0)
    assert _gone(child)


def test_a_fork_has_a_child_of_its_own() -> None:
    parent = _parent(
        "print(in_child('os:getsid', 0, 10.0, 100), flush=True)\n"
        "if os.fork() == 0:\n"
        "    print(in_child('os:getsid', 0, 10.0, 100), flush=True)\n"
        "    sys.exit()\n"
        "os.wait()\n"
        "print(in_child('os:getsid', 0, 10.0, 100), flush=True)\n"
    )
    assert parent.stdout is not None
    mine, forked, again = (int(line) for line in parent.stdout.read().split())
    assert mine == again != forked
    assert parent.wait(5.0) == 0
    assert _gone(mine)
    assert _gone(forked)


def test_an_interrupted_call_leaves_no_answer_behind() -> None:
    parent = _parent(
        "in_child('math:sqrt', 4.0, 10.0, 100)\n"
        "threading.Timer(0.3, lambda: os.kill(os.getpid(), 2)).start()\n"
        "try:\n    in_child('time:sleep', 1.0, 10.0, 100)\n"
        "except KeyboardInterrupt:\n    print('interrupted')\n"
        "time.sleep(1.0)\n"
        "print(in_child('math:sqrt', 9.0, 10.0, 100))\n"
    )
    assert parent.stdout is not None
    assert parent.stdout.read().split() == ["interrupted", "3.0"]
