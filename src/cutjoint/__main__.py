"""The program `cutjoint`, also as `python -m cutjoint`: signals are watched before anything else is loaded."""

from __future__ import annotations

import os

from cutjoint import interrupts

THREADS = "OPENBLAS_NUM_THREADS"
"""Of numpy's linear algebra.  Matrices of robots are small: more than one thread costs more than it brings, up to
twenty times as much where other programs are busy."""


def main() -> None:
    """Entry point of `cutjoint`; see `cutjoint.cli.main`."""
    interrupts.watch()
    os.environ.setdefault(THREADS, "1")
    from cutjoint.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
