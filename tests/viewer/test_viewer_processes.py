from __future__ import annotations

import os
import re
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

CUTJOINT = [sys.executable, "-c", "from cutjoint.cli import main; main()"]
LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
SECONDS = 60.0


def eventually(check: Callable[[], bool], seconds: float = 20.0) -> bool:
    until = time.monotonic() + seconds
    while not check():  # asked once a round: what was seen may be gone when it is asked again
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def start(*arguments: str) -> tuple[subprocess.Popen[str], int]:
    """The program in a session of its own, and the port that it prints."""
    process = subprocess.Popen(
        [*CUTJOINT, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        # tests that run in the background of a shell inherit an interrupt that is ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout is not None
    until, seen = time.monotonic() + SECONDS, ""
    while time.monotonic() < until and select.select([process.stdout], [], [], until - time.monotonic())[0]:
        line = process.stdout.readline()
        seen += line
        if found := re.search(r"http://[\d.]+:(\d+)/", line):
            return process, int(found[1])
        if not line:
            break
    process.kill()
    raise AssertionError(f"no address printed: {seen}")


def answers(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(2)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def alive(of: Callable[[Path], bool]) -> list[str]:
    """Processes (dead ones that nobody has fetched do not count) for which `of` holds."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if entry.joinpath("stat").read_text().rpartition(")")[2].split()[0] not in "ZX" and of(entry):
                    found.append(entry.joinpath("cmdline").read_text().replace("\0", " "))
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue
    return found


def in_session(leader: int) -> list[str]:
    return alive(lambda entry: int(entry.joinpath("stat").read_text().rpartition(")")[2].split()[3]) == leader)


@LINUX
@pytest.mark.parametrize(
    ("end", "arguments"),
    [
        (signal.SIGTERM, ("view", "cpm")),
        (signal.SIGKILL, ("view", "cpm")),
        (signal.SIGINT, ("view", "cpm")),
        (signal.SIGTERM, ("play", "cpm", "--trajectory", "circle:0.05,1")),
    ],
)
def test_however_it_ends_no_process_and_no_port_is_left(end: signal.Signals, arguments: tuple[str, ...]) -> None:
    process, port = start(*arguments, "--port", "0", "--no-open")
    try:
        assert answers(port)
        assert len(in_session(process.pid)) == 1
        process.send_signal(end)
        process.wait(20)
    finally:
        process.kill()
    assert not answers(port)
    assert in_session(process.pid) == []
    if end is signal.SIGINT:
        assert process.returncode == 0


@LINUX
def test_the_viewer_listens_on_one_loopback_port_only() -> None:
    process, port = start("view", "cpm", "--port", "0", "--no-open")
    try:
        inodes = set()
        for fd in Path(f"/proc/{process.pid}/fd").iterdir():
            if found := re.fullmatch(r"socket:\[(\d+)\]", os.readlink(fd)):
                inodes.add(found[1])
        listening = []
        for table in ("tcp", "tcp6"):
            for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
                fields = line.split()
                if fields[3] == "0A" and fields[9] in inodes:
                    listening.append(fields[1])
        assert listening == [f"0100007F:{port:04X}"]
    finally:
        process.kill()
        process.wait(20)


@LINUX
def test_a_second_viewer_takes_the_next_port() -> None:
    first, port = start("view", "cpm", "--port", "0", "--no-open")
    try:
        second, other = start("view", "cpm", "--port", str(port), "--no-open")
        second.kill()
        second.wait(20)
        assert port < other < port + 100
        assert answers(port)
    finally:
        first.kill()
        first.wait(20)


SHOOTER = """
import sys
from cutjoint.robots import load
from cutjoint.viewer import show
import cutjoint.viewer.browser as browser
browser._READY = "false"
print("started", flush=True)
show(load("cpm")).picture(sys.argv[1])
"""


def test_a_simulation_is_saved_and_played_into_one_file(tmp_path: Path) -> None:
    for arguments in (
        ("simulate", "cpm", "--trajectory", "circle:0.05,0.2", "--duration", "0.2", "--save", "run.npz"),
        ("play", "run.npz", "--html", "run.html"),
    ):
        done = subprocess.run([*CUTJOINT, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0, done.stderr
    assert "wrote run.html" in done.stdout
    assert re.search(r"\d\.\d\d MB", done.stdout)
    assert (tmp_path / "run.html").read_text().startswith("<!DOCTYPE html>")


@LINUX
@pytest.mark.browser
def test_killed_while_it_takes_a_picture_it_leaves_no_browser(tmp_path: Path, browser: Any) -> None:
    profiles = tmp_path / "profiles"
    profiles.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", SHOOTER, str(tmp_path / "a.png")], env={**os.environ, "TMPDIR": str(profiles)}
    )

    def browsers() -> list[str]:
        return alive(lambda entry: str(profiles) in entry.joinpath("cmdline").read_text())

    try:
        assert eventually(lambda: len(browsers()) > 2, SECONDS)
    finally:
        process.kill()
        process.wait(20)
    assert eventually(lambda: browsers() == []), browsers()
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("view", "no-such-robot"), "unknown robot"),
        (("view", "cpm", "--png", "a.png", "--size", "big"), "1280x800"),
        (("view", "cpm", "--html", "missing/folder/a.html"), "cannot write"),
        (("view", "cpm", "--host", "192.0.2.1"), "cannot listen"),
        (("play", "cpm"), "--trajectory"),
        (("play", "cpm", "--trajectory", "no-such"), "no-such"),
        (("play", "missing.npz"), "missing.npz"),
        (("play", "missing.npz", "--trajectory", "circle"), "--trajectory"),
    ],
)
def test_bad_input_gives_one_clear_error_and_no_file(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = subprocess.run([*CUTJOINT, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
