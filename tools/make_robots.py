"""Writes the robots under urdf/: `python tools/make_robots.py`.

Every robot is a module of tools/robots/ with a function `robot()` and its `NOTES`; a folder of urdf/ is never edited by
hand.
"""

from __future__ import annotations

import sys
from pathlib import Path, PurePosixPath

sys.path.insert(0, str(Path(__file__).resolve().parent))

from robots import cpm, cpm_rotary, fivebar, fourbar, omega3, redundant, stewart, underactuated, write

from cutjoint.files import write_whole

ROBOTS = (cpm, omega3, fourbar, fivebar, stewart, redundant, underactuated, cpm_rotary)
URDF = Path(__file__).resolve().parents[1] / "urdf"


def files() -> dict[PurePosixPath, str]:
    """Path below urdf/ -> text, for all robots."""
    return {path: text for module in ROBOTS for path, text in write.files(module.robot(), module.NOTES).items()}


def main() -> None:
    """Write all files, each whole or not at all."""
    for path, text in files().items():
        (URDF / path).parent.mkdir(parents=True, exist_ok=True)
        write_whole(URDF / path, text)
        print(f"urdf/{path}")


if __name__ == "__main__":
    main()
