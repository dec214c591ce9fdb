"""Attacks cutjoint with spoiled and hostile input: no traceback, nothing over 5 s, nothing wrong accepted.

    python tools/fuzz.py [KIND=COUNT ...] [--seed N] [--show N]

KIND is one of results, meshes, robots, typos, arguments, names, methods; default all of them with the counts of a
release: 1000 results, 300 meshes, 10 000 robots, 3000 slips of the keyboard, 400 command lines, 300 hostile names,
2000 calls of methods.
`typos=ALL` is every slip, some 30 000.  Exit status 1 where anything is at fault;
each fault is told with a name that finds it again (kind, seed and number).
"""

from __future__ import annotations

import argparse
import faulthandler
import sys
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent))

from attacks.judging import Tally, judge

COUNTS = {
    "results": 1000,
    "meshes": 300,
    "robots": 10_000,
    "typos": 3000,
    "arguments": 400,
    "names": 300,
    "methods": 2000,
}
STUCK = 120.0
"""Seconds after which the process is given up: code that is not Python's cannot be interrupted."""


def attack(kind: str, seed: int, count: int) -> Tally:
    """What came of `count` attacks of one kind."""
    with TemporaryDirectory(prefix="cutjoint-fuzz-") as folder:
        return judge(import_module(f"attacks.{kind}").attacks(seed, count, Path(folder)))


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", metavar="KIND=COUNT")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", type=int, default=5, help="faults to show of each kind")
    given = parser.parse_args()
    wanted = dict(one.partition("=")[::2] for one in given.what) or dict.fromkeys(COUNTS, "")
    bad = 0
    for kind, count in wanted.items():
        tally = attack(kind, given.seed, 10**9 if count == "ALL" else int(count or COUNTS[kind]))
        print(f"{kind}: {tally}", flush=True)
        for fault in tally.faults[: given.show]:
            print(f"  {fault}")
        bad += len(tally.faults)
    return 1 if bad else 0


if __name__ == "__main__":
    faulthandler.enable()
    sys.exit(main())
