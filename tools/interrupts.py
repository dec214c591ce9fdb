"""Interrupts the long commands at random moments and looks at what is left.

    python tools/interrupts.py [MOMENTS] [NAME ...]     exit status 1 and a line per fault; 50 moments by default

Each command is run once to its end, for its length and what it writes; then, for SIGINT, SIGTERM and SIGKILL in turn,
from its first moment on.  What must hold: it ends within `PATIENCE` seconds, with exit status 130 or 143 and without a
traceback; no process of its session is left; every file is whole and none is left over, but for the hidden folder in
which SIGKILL found a new folder being made; and what it says it kept is there.
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PATIENCE = 5.0
PROGRAM = (sys.executable, "-m", "cutjoint")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)


PLACE = "{runs}"
"""In the words of a command: a folder with the run that some read, circle.npz."""


@dataclass(frozen=True)
class Long:
    """A command that takes its time.

    Attributes:
        words: its arguments.
        keeps: what of its files is kept of a part: ending of the name with `.stopped` in it.
        serves: it ends by a signal only, with exit status 0 at SIGINT.
        cold: it has an empty cache.
    """

    words: tuple[str, ...]
    keeps: str = ""
    serves: bool = False
    cold: bool = False


COMMANDS: Mapping[str, Long] = {
    "simulate": Long(
        ("simulate", "cpm", "--rate", "1000", "--trajectory", "hold:6", "--save", "run.npz"), "run.stopped.npz"
    ),
    "continuous": Long(
        ("simulate", "omega3", "--plant", "chain", "--step", "1e-3", "--duration", "1", "--save", "run.csv"),
        "run.stopped.csv",
    ),
    "reactions": Long(
        ("simulate", "omega3", "--step", "1e-3", "--duration", "0.3", "--save", "run.npz", "--reactions", "forces.csv"),
        "run.stopped.npz",
    ),
    "reproduce": Long(("reproduce", "omega3", "--output", "page.html"), "page.stopped.html", cold=True),
    "crosscheck": Long(("crosscheck", "omega3", "--samples", "500", "--json", "found.json"), "found.stopped.json"),
    "compile": Long(("compile", "omega3", "--functions", "all"), cold=True),
    "play": Long(("play", "cpm", "--trajectory", "circle:0.05,1", "--html", "play.html", "--png", "play.png")),
    "view": Long(("view", "omega3", "--html", "view.html")),
    "served": Long(("view", "cpm", "--port", "0", "--no-open"), serves=True),
    "plot": Long(("plot", f"{PLACE}/circle.npz", "--what", "joints,reactions", "-o", "plot.svg")),
    "plot-page": Long(("plot", f"{PLACE}/circle.npz", "-o", "plot.html")),
    "report": Long(("report", f"{PLACE}/circle.npz", "-o", "report.html")),
    "states": Long(("states", f"{PLACE}/circle.npz", "-o", "states.jsonl")),
    "states-bag": Long(("states", f"{PLACE}/circle.npz", "-o", "bag")),
    "new": Long(("new", "walker", "-t", "stewart")),
    "cut": Long(("cut", "stewart", "-o", "cut")),
    "info": Long(("info", "omega3")),
    "check": Long(("check", "omega3")),
    "export": Long(("export", "omega3", "--to", "loops")),
    "export-mjcf": Long(("export", "cpm", "--to", "mjcf", "--out", "robot.xml")),
}


@dataclass
class Outcome:
    """What came of an interrupt.

    Attributes:
        what: in a word.
        faults: what is wrong.
    """

    what: str
    faults: list[str]


def start(command: Long, folder: Path, cache: Path) -> subprocess.Popen[str]:
    """A command in a session of its own; SIGINT does to it what it does in a terminal."""

    def usual() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    return subprocess.Popen(
        [*PROGRAM, *(one.replace(PLACE, str(_runs())) for one in command.words)],
        cwd=folder,
        env=os.environ | {"CUTJOINT_CACHE": str(cache), "NO_COLOR": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=usual,
    )


def living(session: int) -> list[str]:
    """Processes of a session that are not dead."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                state, _, _, leader = (entry / "stat").read_text().rpartition(") ")[2].split()[:4]
                words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            except (OSError, ValueError):
                continue
            if int(leader) == session and state not in "ZX":
                found.append(words[:100])
    return found


def spoiled(file: Path) -> str:
    """What is wrong with a file; nothing where it is whole."""
    if file.name.startswith("."):
        return "is left over"
    data = file.read_bytes()
    try:
        if file.suffix == ".npz":
            with zipfile.ZipFile(file) as stored:
                return "" if stored.testzip() is None else "is damaged"
        if file.suffix == ".json":
            json.loads(data)
        if file.suffix == ".csv" and (
            not data.endswith(b"\n") or len({row.count(b",") for row in data.splitlines()}) != 1
        ):
            return "is half a table"
        if file.suffix == ".html" and not data.rstrip().endswith(b"</html>"):
            return "is half a page"
        if file.suffix == ".png" and not data.endswith(b"IEND\xaeB`\x82"):
            return "is half a picture"
        if file.suffix == ".jsonl":
            [json.loads(line) for line in data.splitlines()]
        if file.suffix == ".db3":
            with closing(sqlite3.connect(file)) as store:
                store.execute("select count(*) from messages").fetchone()
        ends = {".urdf": b"</robot>", ".xml": b"</mujoco>", ".svg": b"</svg>"}.get(file.suffix, b"")
        if not data.rstrip().endswith(ends):
            return "is half a robot"
        if file.suffix == ".toml":
            tomllib.loads(data.decode())
    except (ValueError, zipfile.BadZipFile, sqlite3.Error) as error:
        return f"is not whole: {error}"
    return "" if data else "is empty"


def interrupt(command: Long, number: signal.Signals, moment: float, whole: set[str]) -> Outcome:
    """Send a signal to a command after `moment` seconds, and look at all that is left 5 s later at the latest."""
    with tempfile.TemporaryDirectory() as place:
        folder, cache = Path(place) / "here", Path(place) / "cache" if command.cold else _cache()
        folder.mkdir()
        process = start(command, folder, cache)
        faults = []
        try:
            time.sleep(moment)
            early = process.poll() is not None
            process.send_signal(number)
            sent = time.monotonic()
            try:
                out, err = process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                faults.append(f"did not end within {PATIENCE:g} s")
                out = err = ""
            while living(process.pid) and time.monotonic() < sent + PATIENCE:
                time.sleep(0.05)
            faults += [f"left a process: {one}" for one in living(process.pid)]
        finally:
            for left in (process.pid,) if living(process.pid) else ():
                os.killpg(left, signal.SIGKILL)
            process.kill()
            process.wait()
        files = {file.name: file for file in folder.rglob("*") if file.is_file()}
        if number is signal.SIGKILL:  # a folder has no nameless beginning: a hidden one may stay
            files = {
                name: file
                for name, file in files.items()
                if not any(part.startswith(".") for part in file.relative_to(folder).parts[:-1])
            }
        faults += [f"{name} {wrong}" for name, file in files.items() if (wrong := spoiled(file))]
        if command.cold and cache.is_dir():
            faults += [f"cache: {file.name} is left over" for file in cache.rglob(".*") if file.is_file()]
        if number is signal.SIGKILL:
            return Outcome("killed" if not early else "done before", faults)
        if early:
            return Outcome("done before", faults)
        return _answer(command, number, Ended(process.returncode, out, err, files, whole), faults)


@dataclass(frozen=True)
class Ended:
    """A command that has ended: its status, what it wrote, and which files it would have written."""

    status: int
    out: str
    err: str
    files: Mapping[str, Path]
    whole: set[str]


def _answer(command: Long, number: signal.Signals, end: Ended, faults: list[str]) -> Outcome:
    """What a command said to a signal that can be answered."""
    said = re.search(r"interrupted \(SIG\w+\)(?:: | )(.*)", end.err)
    python = "Traceback" in end.err and "/cutjoint/" not in end.err
    if python or (end.status == -number and not end.err and not end.files):
        return Outcome("in Python's own start", faults)
    if "Traceback" in end.err or "Exception ignored" in end.err:
        faults.append(f"traceback: {end.err[-600:]}")
    serving = command.serves and "closed" in end.out
    right = {128 + number, *({0} if serving and number is signal.SIGINT else ())}
    # a signal that comes amid Python's own end is that of any program
    if end.status in (0, -number) and not command.serves and end.whole <= set(end.files):
        return Outcome("done by then", faults)
    if end.status not in right:
        faults.append(f"exit status {end.status}: {end.err[-300:]}")
    if serving:
        return Outcome("closed", faults)
    if said is None:
        faults.append(f"says nothing: {end.err[-300:]!r}")
        return Outcome("silent", faults)
    kept = [word.rstrip(",;.") for word in said[1].split() if re.search(r"\.(npz|csv|html|json)\b", word)]
    faults += [f"says it kept {name}, which is not there" for name in kept if Path(name).name not in end.files]
    if "before anything" in said[1] or "nothing was written" in said[1]:
        if end.files:
            faults.append(f"says that nothing was written, but there is {', '.join(end.files)}")
        return Outcome("nothing yet", faults)
    if "all was done" in said[1]:
        return Outcome("done by then", faults)
    if command.keeps and command.keeps not in end.files and not end.whole & set(end.files):
        faults.append(f"{command.keeps} is not there: {said[1]}")
    return Outcome("kept", faults)


def _cache() -> Path:
    return Path(tempfile.gettempdir()) / f"cutjoint-interrupts-{os.getuid()}"


@cache
def _runs() -> Path:
    """A folder with a run of some length."""
    folder = _cache() / "runs"
    folder.mkdir(parents=True, exist_ok=True)
    words = ("simulate", "cpm", "--duration", "1", "--rate", "1000", "--trajectory", "hold", "--save", "circle.npz")
    subprocess.run([*PROGRAM, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder


def length(command: Long) -> tuple[float, set[str]]:
    """Seconds that a command takes, and the names of the files that it writes."""
    if command.serves:
        return 4.0, set()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "here"
        folder.mkdir()
        began = time.monotonic()
        process = start(command, folder, Path(place) / "cache" if command.cold else _cache())
        _, err = process.communicate(timeout=600)
        if process.returncode != 0:
            raise SystemExit(f"{' '.join(command.words)} fails: {err}")
        return time.monotonic() - began, {file.name for file in folder.rglob("*") if file.is_file()}


def tried(name: str, moments: int, say: Callable[[str], None], seed: int = 0) -> list[str]:
    """Interrupt a command at so many moments; the faults."""
    command, faults = COMMANDS[name], list[str]()
    length(command)  # fills the cache
    span, whole = length(command)
    draw, outcomes = random.Random(f"{name} {seed}"), Counter[str]()
    for count in range(moments):
        number, moment = SIGNALS[count % len(SIGNALS)], draw.uniform(0.0, span)
        outcome = interrupt(command, number, moment, whole)
        outcomes[outcome.what] += 1
        for one in outcome.faults:
            faults.append(f"{name}, {number.name} after {moment:.3f} s of {span:.1f} s: {one}")
            say(faults[-1])
    told = ", ".join(f"{count} {what}" for what, count in sorted(outcomes.items()))
    say(f"{name}: {moments} moments in {span:.1f} s: {told}; {len(faults)} faults")
    return faults


def main(arguments: Sequence[str]) -> int:
    """Try the named commands, or all."""
    moments = int(arguments[0]) if arguments else 50
    return 1 if [fault for name in arguments[1:] or COMMANDS for fault in tried(name, moments, print)] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
