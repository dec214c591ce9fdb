"""What the README's first lines promise to somebody who has just installed cutjoint: three commands to the plot of a
run of a new robot, five to the same and a report for a file of one's own that has a loop.

The lines are taken from the README's text.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from kit.looped_files import FILES

from cutjoint.drafting import TEMPLATES
from cutjoint.simulation import load

ROOT = Path(__file__).resolve().parents[2]
MOST = {"cutjoint new ": 3, "cutjoint cut ": 5}
"""What the lines begin with -> how many there may be."""
LINE = re.compile(r"^(?:\$ )?(?P<line>cutjoint .*?)(?: +# .*)?$", re.MULTILINE)


def lines_of(text: str, first: str) -> list[str]:
    """The commands of the fenced block whose first one begins with `first`."""
    for block in re.findall(r"^```(?:console|sh)\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL):
        lines = [found["line"] for found in LINE.finditer(block)]
        if lines and lines[0].startswith(first):
            return lines
    raise LookupError(f"no block of commands begins with {first!r}")


def told(first: str) -> list[str]:
    """Those of the README."""
    return lines_of((ROOT / "README.md").read_text(encoding="utf-8"), first)


def enter(lines: list[str], folder: Path) -> None:
    """Run them one after the other in `folder` as a shell does, with nothing in reach but the command."""
    (folder / ".bin").mkdir()
    command = folder / ".bin" / "cutjoint"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m cutjoint "$@"\n')
    command.chmod(0o755)
    settings = os.environ | {"PATH": f"{folder / '.bin'}{os.pathsep}{os.environ['PATH']}", "NO_COLOR": "1"}
    for line in lines:
        run = subprocess.run(
            ["bash", "-c", line],
            cwd=folder,
            env=settings,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert run.returncode == 0, f"$ {line}\n{run.stdout[-1500:]}\n{run.stderr[-1500:]}"
        assert run.stdout.strip(), f"$ {line}\nsays nothing"


def long_curves(picture: Path) -> int:
    """How many curves of a picture have more than fifty points: not frames, ticks or letters."""
    drawn = re.findall(r'<path d="([^"]*)"', picture.read_text(encoding="utf-8"))
    return sum(len(re.findall(r"[ML] ", one)) > 50 for one in drawn)


def judge(run: Path) -> None:
    """The run moved, followed what it was to follow with its loops closed, and is drawn beside it."""
    result = load(run)
    assert np.ptp(result.q, axis=0).max() > 1e-3
    assert result.worst_error() < 1e-3
    assert result.loop_gap()[0] < 1e-9
    assert long_curves(run.with_suffix(".svg")) >= 3


def test_the_readme_has_the_lines() -> None:
    for first, most in MOST.items():
        assert len(told(first)) <= most
    assert told("cutjoint new ")[-1].startswith("cutjoint plot ")
    assert {"plot", "report"} <= {line.split()[1] for line in told("cutjoint cut ")}


@pytest.mark.slow
@pytest.mark.parametrize("template", [None, *TEMPLATES])
def test_a_new_robot_is_plotted(template: str | None, tmp_path: Path) -> None:
    lines = told("cutjoint new ")
    if template is not None:
        lines = [re.sub(r"--template \w+", f"--template {template}", line) for line in lines]
        assert f"--template {template}" in lines[0]
    enter(lines, tmp_path)
    judge(tmp_path / "run.npz")


@pytest.mark.slow
@pytest.mark.parametrize("kind", FILES)
def test_the_file_one_has_is_plotted(kind: str, tmp_path: Path) -> None:
    name, text = FILES[kind]
    (tmp_path / name).write_text(text, encoding="utf-8")
    enter([line.replace("robot.urdf", name) for line in told("cutjoint cut ")], tmp_path)
    judge(tmp_path / "mine.npz")
    assert len(tomllib.loads((tmp_path / "mine/loops.toml").read_text())["cut"]) == 1
    page = (tmp_path / "mine.html").read_text(encoding="utf-8")
    assert "This run can be believed" in page


def test_lines_are_read_with_prompts_and_remarks() -> None:
    text = "```sh\nmake demo\n```\n\n```sh\n$ cutjoint cut a.urdf -o b   # proposes\ncutjoint check b\n```\n"
    assert lines_of(text, "cutjoint cut ") == ["cutjoint cut a.urdf -o b", "cutjoint check b"]
    with pytest.raises(LookupError, match="cutjoint new"):
        lines_of(text, "cutjoint new ")


def test_a_picture_without_curves_is_noticed(tmp_path: Path) -> None:
    picture = tmp_path / "a.svg"
    picture.write_text('<path d="M 0 0 L 1 1"/>' + f'<path d="M 0 0 {"L 1 1 " * 60}"/>')
    assert long_curves(picture) == 1
