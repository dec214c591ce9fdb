"""One second of every shipped robot under sampled control, as a shell sees it, from the start of Python on."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time

MAIN = "import sys; from cutjoint.cli import main; sys.exit(main())"
WAYS: dict[str, tuple[str, ...]] = {
    "fourbar": ("--trajectory", "joint-sine:0.2"),
    "fivebar": ("--trajectory", "circle:0.02,1"),
    "stewart": ("--trajectory", "line:0.02,0.02,0.03"),
    "cpm": (),
    "cpm_rotary": (),
    "omega3": (),
    "redundant": ("--free",),
    "underactuated": ("--free",),
}
"""Robot -> what it does; the two that their motors do not determine fall."""


def seconds(robot: str, plant: str, rounds: int, span: float) -> tuple[float, float, float]:
    """Shortest time by the clock [s], shortest CPU time [s] of so many rounds after one that fills the cache, and the
    energy balance of the run."""
    command = [sys.executable, "-c", MAIN, "simulate", robot, *WAYS[robot], "--plant", plant, "--rate", "1000"]
    command += ["--duration", str(span), "--json"]
    clock, work, drift = [], [], 0.0
    for _ in range(rounds + 1):
        before, start = os.times(), time.perf_counter()
        told = subprocess.run(command, capture_output=True, check=True, text=True).stdout
        after = os.times()
        clock.append(time.perf_counter() - start)
        work.append(after.children_user - before.children_user + after.children_system - before.children_system)
        drift = float(json.loads(told)["energy_drift"])
    return min(clock[1:]), min(work[1:]), drift
