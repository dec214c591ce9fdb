from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from kit.quickly import few

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


def heed_interrupts() -> None:
    """Tests that run in the background of a shell inherit an interrupt that is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def start(*arguments: str) -> tuple[subprocess.Popen[str], int]:
    """The program in a session of its own, and the port that it prints."""
    process = subprocess.Popen(
        [*CUTJOINT, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        preexec_fn=heed_interrupts,
    )
    assert process.stdout is not None
    # read beside Python's buffer, in which a line could wait while nothing more comes
    output, until, seen = process.stdout.fileno(), time.monotonic() + SECONDS, ""
    while select.select([output], [], [], max(until - time.monotonic(), 0.0))[0] and (piece := os.read(output, 4096)):
        seen += piece.decode()
        if found := re.search(r"http://[\d.]+:(\d+)/", seen):
            return process, int(found[1])
    process.kill()
    raise AssertionError(f"no address printed: {seen}")


def answers(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(2)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def fields(entry: Path) -> list[str]:
    """What /proc tells of a process, from its state on."""
    return entry.joinpath("stat").read_text().rpartition(")")[2].split()


def parent_and_session(entry: Path) -> tuple[int, int]:
    return int(fields(entry)[1]), int(fields(entry)[3])


def words_of(entry: Path) -> str:
    try:
        return entry.joinpath("cmdline").read_text().replace("\0", " ")
    except (FileNotFoundError, ProcessLookupError):
        return "(gone)"


def alive(of: Callable[[Path], bool]) -> list[Path]:
    """Processes (dead ones that nobody has fetched do not count) for which `of` holds: their folders in /proc."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if fields(entry)[0] not in "ZX" and of(entry):
                    found.append(entry)
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue
    return found


def still_open(process: Path) -> list[str]:
    """What a process has open, as far as that stays so while it is read; nothing of one that has ended."""
    found = []
    try:
        for fd in process.joinpath("fd").iterdir():
            with contextlib.suppress(FileNotFoundError):
                found.append(os.readlink(fd))
    except (FileNotFoundError, ProcessLookupError):
        return []
    return found


def listening(processes: list[Path]) -> list[str]:
    """Where these processes can be reached: TCP sockets that listen, UDP sockets that are bound."""
    inodes, seen = set(), 0
    for process in processes:
        links = still_open(process)
        seen += bool(links)
        inodes.update(found[1] for link in links if (found := re.fullmatch(r"socket:\[(\d+)\]", link)))
    assert seen, "all of them have ended"
    places = []
    for table, state in (("tcp", "0A"), ("tcp6", "0A"), ("udp", "07"), ("udp6", "07")):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            cells = line.split()
            if cells[3] == state and cells[9] in inodes:
                places.append(cells[1])
    return places


def in_session(leader: int) -> list[str]:
    return [words_of(entry) for entry in alive(lambda entry: parent_and_session(entry)[1] == leader)]


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
        assert listening([Path(f"/proc/{process.pid}")]) == [f"0100007F:{port:04X}"]
    finally:
        process.kill()
        process.wait(20)


@LINUX
@pytest.mark.slow
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


@pytest.mark.slow
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


SHOOTER = """
import sys
from cutjoint.robots import load
from cutjoint.viewer import show
from cutjoint.viewer.browser import camera, devtools

# a page that is never ready, and a word when it is there
camera.READY = "false"
rest = devtools.Devtools.rest
def tell(self, seconds):
    print("drawing", flush=True)
    devtools.Devtools.rest = rest
devtools.Devtools.rest = tell
show(load("cpm")).picture(sys.argv[1])
"""


class Shooter:
    """The program while it takes a picture that does not come, and the browser that it runs.

    Chromium changes what the system shows of its processes' words and surroundings, so they are told by the keeper's
    session, and the helpers that open sessions of their own by the folder in their words.
    """

    def __init__(self, place: Path, picture: Path, **environment: str) -> None:
        self.place = place
        self.process = subprocess.Popen(
            [sys.executable, "-c", SHOOTER, str(picture)],
            env={**os.environ, "TMPDIR": str(place), **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,
            preexec_fn=heed_interrupts,
        )
        self._session: int | None = None

    def browsers(self) -> list[Path]:
        """Folders in /proc of the keeper and of all that it started."""
        if self._session is None:
            for entry in alive(lambda entry: parent_and_session(entry)[0] == self.process.pid):
                self._session = parent_and_session(entry)[1]
        return alive(
            lambda entry: (
                str(self.place) in entry.joinpath("cmdline").read_text()
                or (self._session is not None and parent_and_session(entry)[1] == self._session)
            )
        )

    def end(self, end: signal.Signals) -> None:
        """Send a signal to the program's process group, as a terminal does and whoever wants to be thorough."""
        os.killpg(self.process.pid, end)
        self.process.wait(SECONDS)

    def words(self) -> list[str]:
        return [entry.name + " " + words_of(entry) for entry in self.browsers()]


@pytest.fixture
def shoot(short_folder: Path, tmp_path: Path) -> Iterator[Callable[..., Shooter]]:
    shooters = []

    def start(**environment: str) -> Shooter:
        shooters.append(Shooter(short_folder, tmp_path / "a.png", **environment))
        return shooters[-1]

    yield start
    for shooter in shooters:
        shooter.process.kill()
        shooter.process.communicate()
    assert not (tmp_path / "a.png").exists()


@pytest.fixture
def drawing(shoot: Callable[..., Shooter], chromium: str) -> Shooter:
    """A real browser has opened the page."""
    shooter = shoot(CUTJOINT_BROWSER=chromium)
    assert shooter.process.stdout is not None
    assert select.select([shooter.process.stdout], [], [], SECONDS)[0]
    assert shooter.process.stdout.readline() == "drawing\n"
    assert len(shooter.browsers()) > 3
    return shooter


@pytest.mark.slow
@LINUX
@pytest.mark.browser
def test_a_browser_that_takes_a_picture_opens_no_port(drawing: Shooter) -> None:
    assert len(listening([Path(f"/proc/{drawing.process.pid}")])) == 1
    assert listening(drawing.browsers()) == []


@pytest.mark.slow
@LINUX
@pytest.mark.browser
@pytest.mark.parametrize("end", few([signal.SIGKILL, signal.SIGTERM, signal.SIGINT], signal.SIGTERM))
def test_killed_while_it_takes_a_picture_it_leaves_no_browser(drawing: Shooter, end: signal.Signals) -> None:
    drawing.end(end)
    assert eventually(lambda: drawing.browsers() == []), drawing.words()
    assert list(drawing.place.iterdir()) == []


@LINUX
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.slow
def test_killed_while_a_browser_hangs_at_its_start_it_leaves_none(
    shoot: Callable[..., Shooter], tmp_path: Path, end: signal.Signals
) -> None:
    fake, started = tmp_path / "fake", tmp_path / "started"
    fake.write_text(f"#!/bin/sh\ntrap '' TERM INT HUP PIPE\nmkdir $TMPDIR/profile\ntouch {started}\nsleep 1000\n")
    fake.chmod(0o755)
    shooter = shoot(CUTJOINT_BROWSER=str(fake))
    assert eventually(started.exists, SECONDS)
    assert len(shooter.browsers()) >= 2
    shooter.end(end)
    assert eventually(lambda: shooter.browsers() == []), shooter.words()
    assert list(shooter.place.iterdir()) == []


@pytest.mark.slow
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
