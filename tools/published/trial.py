"""One published file, tried: is it read, do its loops close, how can it move, and does MuJoCo agree?

python tools/published/trial.py FILE            writes what was found as JSON
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.description import RobotDescription, read_checked
from cutjoint.description.formats import format_of
from cutjoint.errors import CutjointError, Problem
from published.contents import closures, contents

Found = dict[str, object]


def trial(path: Path) -> Found:
    """Everything that is to be known of one file, as values that JSON has.

    `verdict` is `loads`, `loads lenient`, `refused` (its file, or its loops at home) or `crashed`.
    """
    count, start = contents(path), time.perf_counter()
    found: Found = {"format": format_of(path).name, "contents": dict(count), "closures": closures(count)}
    try:
        _read(path, found)
    except CutjointError as error:
        found |= {"verdict": "refused", "stage": "chain", "reasons": [f"{type(error).__name__}: {_short(str(error))}"]}
    except Exception as error:
        trace = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(trace.filename).name}:{trace.lineno}"
        found |= {"verdict": "crashed", "reasons": [f"{type(error).__name__} at {where}: {_short(str(error))}"]}
    return found | {"seconds": round(time.perf_counter() - start, 2)}


def _read(path: Path, found: Found) -> None:
    reading, verdict = read_checked(path), "loads"
    if reading.description is None:
        found["strict"] = [_told(one) for one in reading.problems if one.severity == "error"]
        reading, verdict = read_checked(path, lenient=True), "loads lenient"
    found["warnings"] = [_told(one) for one in reading.problems if one.severity != "error"]
    if reading.description is None:
        reasons = [_told(one) for one in reading.problems if one.severity == "error"]
        found |= {"verdict": "refused", "stage": "file", "reasons": reasons}
        return
    _move(path, reading.description, found)
    found["verdict"] = verdict


def _move(path: Path, robot: RobotDescription, found: Found) -> None:
    cuts = Counter(str(one.type) for one in robot.closing)
    found["read"] = dict(cuts) | {"couplings": len(robot.couplings), "bushings": len(robot.cuts) - len(robot.closing)}
    found["made"] = len(robot.cuts) + len(robot.couplings)
    chain = ClosedChain(robot)
    report = chain.mobility()
    found |= {
        "links": len(robot.links),
        "velocities": report.velocities,
        "mobility": report.mobility,
        "redundant": len(report.redundant_rows),
        "dropped": list(report.dropped_rows),
        "actuators": report.actuators,
        "determined": report.determined,
        "gap": [float(one) for one in chain.gap(chain.home)],
    }
    try:
        _accelerate(chain)
    except CutjointError as error:
        found["dynamics"] = _short(f"{type(error).__name__}: {error}")
        return
    if found["format"] == "MJCF":
        from published.peer import compare, without_friction

        try:
            found["mujoco"] = dataclasses.asdict(compare(path, ClosedChain(without_friction(robot))))
        except ValueError as error:
            if isinstance(error, CutjointError):
                raise
            found["mujoco_refuses"] = _short(str(error))


def _accelerate(chain: ClosedChain) -> None:
    """The robot let go at home, at rest and in motion; raises what the chain raises."""
    speed = np.random.default_rng(0).uniform(-1.0, 1.0, chain.nv)
    for v in (np.zeros(chain.nv), chain.project(chain.home.q_full, speed)[1]):
        chain.full_forward_dynamics(chain.home, v, np.zeros(chain.nv))


def _told(problem: Problem) -> str:
    line = f":{problem.line}" if problem.line else ""
    told = f"{Path(problem.file).name}{line}: {problem.found}" if problem.file else problem.found
    return _short(told + (f"; expected {problem.expected}" if problem.expected else ""))


def _short(text: str, most: int = 300) -> str:
    flat = " ".join(text.split())
    return flat if len(flat) <= most else flat[: most - 3] + "..."


if __name__ == "__main__":
    print(json.dumps(trial(Path(sys.argv[1]))))
