"""Makes the gallery: every robot that comes with cutjoint and one of every template of `cutjoint new`, moving as
`cutjoint simulate` moves them by default, as a page of one file and a picture.

    python tools/gallery.py [--output out/gallery] [--only NAME ...]

The site has them as its page Gallery (tools/pages/gallery.py).  Pictures need a Chromium; without one the pages come
without, and that is said.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import cutjoint
from cutjoint.description import catalogue
from cutjoint.drafting import TEMPLATES
from cutjoint.viewer.browser.camera import find_browser

OUTPUT = Path(__file__).resolve().parents[1] / "out" / "gallery"
SIZE = "960x600"
SECONDS = 600.0


@dataclass(frozen=True)
class Shown:
    """A robot of the gallery.

    Attributes:
        name: its title.
        mobility: that and its motors, in words.
        line: the command that gives it.
        page: file of the animation.
        picture: file of the picture; empty without a browser.
    """

    name: str
    mobility: str
    line: str
    page: str
    picture: str


def show(robot: str, called: str, line: str, folder: Path, picture: bool) -> Shown:
    """Simulate a robot with what `cutjoint simulate` takes by default, and write its page and picture to `folder`.

    Raises:
        SystemExit: a command fails; it has what the command said.
    """
    chain = cutjoint.load(robot)
    report, motors = chain.mobility(), len(chain.description.actuators)
    with tempfile.TemporaryDirectory() as work:
        run = str(Path(work) / "run.npz")
        _command("simulate", robot, "--save", run)
        files = ["--html", str(folder / f"{called}.html")]
        if picture:
            files += ["--png", str(folder / f"{called}.png"), "--size", SIZE]
        _command("play", run, "--robot", robot, *files)
    cuts = len(chain.description.cuts)
    words = f"mobility {report.mobility}, {_count(motors, 'motor')}, {_count(cuts, 'cut joint')}"
    title = chain.description.title or chain.description.name
    return Shown(title, words, line, f"{called}.html", f"{called}.png" if picture else "")


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _command(*words: str) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "cutjoint", *words],
        env=os.environ | {"NO_COLOR": "1"},
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    if run.returncode != 0:
        raise SystemExit(f"cutjoint {' '.join(words)}\n{run.stdout}{run.stderr}exit status {run.returncode}")


def gallery(output: Path, only: Sequence[str] = ()) -> list[Shown]:
    """The whole of it, in `output`, with a list of what there is in gallery.json."""
    output.mkdir(parents=True, exist_ok=True)
    picture = find_browser() is not None
    if not picture:
        print("no Chromium: the gallery has no pictures (Debian: apt-get install chromium)", file=sys.stderr)
    with tempfile.TemporaryDirectory() as drafts:
        asked = [(name, name, f"cutjoint simulate {name}") for name in catalogue.names()]
        for template in TEMPLATES:
            folder = Path(drafts) / template
            _command("new", f"my-{template}", "--template", template, "-o", str(folder))
            asked.append((str(folder), f"new-{template}", f"cutjoint new mine --template {template}"))
        asked = [one for one in asked if not only or one[1] in only]
        with ThreadPoolExecutor(os.cpu_count() or 1) as workers:
            made = list(workers.map(lambda one: show(one[0], one[1], one[2], output, picture), asked))
    (output / "gallery.json").write_text(json.dumps([asdict(one) for one in made], indent=1), encoding="utf-8")
    return made


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Makes the gallery.")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    parser.add_argument("--only", nargs="+", default=(), metavar="NAME")
    asked = parser.parse_args()
    for one in gallery(asked.output, asked.only):
        print(f"{one.name}: {one.page}, {one.picture or 'no picture'}")


if __name__ == "__main__":
    main()
