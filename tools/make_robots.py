"""Writes the robots under urdf/: `python tools/make_robots.py`.

Every robot is a module of tools/robots/ with a function `robot()`; a folder of urdf/ is never edited by hand.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path, PurePosixPath

sys.path.insert(0, str(Path(__file__).resolve().parent))

from robots import cpm, cpm_rotary, fivebar, fourbar, omega3, redundant, stewart, underactuated, write

ROBOTS = (cpm, omega3, fourbar, fivebar, stewart, redundant, underactuated, cpm_rotary)
URDF = Path(__file__).resolve().parents[1] / "urdf"


def files() -> dict[PurePosixPath, str]:
    """Path below urdf/ -> text, for all robots."""
    return {path: text for module in ROBOTS for path, text in write.files(module.robot()).items()}


def main() -> None:
    """Write all files, each whole or not at all."""
    for path, text in files().items():
        target = URDF / path
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(target.name + ".part")
        part.write_text(text, encoding="utf-8", newline="\n")
        os.replace(part, target)
        print(f"urdf/{path}")


if __name__ == "__main__":
    main()
