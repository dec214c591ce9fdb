"""A study run plainly, on a Dask cluster that loses a worker, and killed and resumed: walls, and files byte by byte.

Each is a process of its own, started like the command, so that imports and compiling count.
"""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

STUDY = """
robot = "cpm"
method = "random"
runs = {runs}
seed = 1
duration = {span}
trajectory = "paper"
integrator = "midpoint"
controller = {{ name = "pd", gains = {{ kp = 7600.0, kd = 260.0 }} }}
[hardware]
rate = 1000.0
delay = 1e-3
command_delay = 1e-3
noise = 2e-6
resolution = 1e-5
limits = 300.0
filter = 200.0
[[vary]]
path = "links.limb1_distal.mass"
relative = 0.1
[[vary]]
path = "payload"
uniform = [0.0, 1.0]
[[vary]]
path = "hardware.noise"
log-uniform = [1e-6, 1e-5]
"""
"""The CPM's chain behind hardware."""
PATIENCE = 600.0
Row = tuple[str, float, float]
CLUSTER = """
import os, signal, sys
from distributed import LocalCluster
from cutjoint.studies import begun
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster:
        killed = []
        def kill(done):
            if done > 0 and not killed:
                killed.append(next(iter(cluster.workers.values())).process.pid)
                os.kill(killed[0], signal.SIGKILL)
        with begun(sys.argv[1], sys.argv[2], scheduler=cluster.scheduler_address) as ready:
            ready.run(kill)
        assert killed
"""


def command(file: Path, folder: Path) -> list[str]:
    """The study as a user starts it."""
    return [sys.executable, "-m", "cutjoint", "study", str(file), "-o", str(folder), "--json", "--no-report"]


def on_a_cluster(file: Path, folder: Path) -> list[str]:
    """On two workers, of which one is killed."""
    script = file.parent / "cluster.py"
    script.write_text(CLUSTER, encoding="utf-8")
    return [sys.executable, str(script), str(file), str(folder)]


def finished(words: list[str]) -> None:
    """A process, to its end."""
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)


def killed_and_resumed(file: Path, folder: Path) -> None:
    """Killed when the first blocks are there, and started again."""
    one = subprocess.Popen(command(file, folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + PATIENCE
    while one.poll() is None and len(list(folder.glob("parts/part-*"))) < 3 and time.monotonic() < until:
        time.sleep(0.02)
    one.send_signal(signal.SIGKILL)
    one.wait()
    finished(command(file, folder))


def sums(folder: Path) -> dict[str, str]:
    """SHA-256 of the files of all blocks."""
    return {one.name: hashlib.sha256(one.read_bytes()).hexdigest() for one in sorted(folder.glob("parts/*"))}


def timings(runs: int, span: float) -> tuple[list[Row], float]:
    """What was done, its wall and CPU time [s] with all processes; and how many blocks differ from the plain ones."""
    ways: dict[str, Callable[[Path, Path], None]] = {
        "on all cores": lambda file, folder: finished(command(file, folder)),
        "on 2 Dask workers, one killed": lambda file, folder: finished(on_a_cluster(file, folder)),
        "killed and started again": killed_and_resumed,
    }
    rows: list[Row] = []
    with TemporaryDirectory() as place:
        file = Path(place) / "wear.toml"
        file.write_text(STUDY.format(runs=runs, span=span), encoding="utf-8")
        found = []
        for name, run in ways.items():
            folder = Path(place) / name.replace(" ", "-")
            began, before = time.monotonic(), os.times()
            run(file, folder)
            after = os.times()
            used = after.children_user + after.children_system - before.children_user - before.children_system
            rows.append((name, time.monotonic() - began, used))
            found.append(sums(folder))
    differing = sum(found[0] != other for other in found[1:])
    return rows, float(differing)
