"""Works through the tutorials as a reader would, and holds what they show against what comes out.

    python tools/tutorials.py                 exit status 1 and a line per difference
    python tools/tutorials.py --write         puts in what comes out now

In the order of the text, in an empty folder of its own:

    ```console                      each line after `$ ` is run by the shell and must succeed; what stands below it is
                                    what it prints to its standard output, if anything does
    ```python                       is run, with what the blocks before it defined; a block of `text` right below it is
                                    what it prints
    ```LANGUAGE title="NAME"        is the file NAME

`...` stands for anything: within a line, or as a line for any number of them.  Spaces count as one, as long as there
are any.  Other blocks are only shown.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "tutorials"
FENCE = re.compile(
    r"^(?P<open>```(?P<language>\w+)(?: +title=\"(?P<title>[^\"]+)\")?)[ \t]*\n(?P<text>.*?)^```[ \t]*$",
    re.MULTILINE | re.DOTALL,
)
ANYTHING = "..."
SECONDS = 300.0


@dataclass
class Worked:
    """A tutorial that was worked through.

    Attributes:
        text: it, with what came out where that differs from what it shows.
        differences: a message each.
        steps: how many commands and blocks of Python were run.
    """

    text: str = ""
    differences: list[str] = field(default_factory=list)
    steps: int = 0


def same(shown: str, printed: str) -> bool:
    """Whether what a tutorial shows is what came out."""
    pattern = ""
    for line in shown.splitlines():
        words = line.split()
        if words == [ANYTHING]:
            pattern += r"(?:[^\n]*\n)*?"
        elif words:
            pattern += r"\s+".join(re.escape(word).replace(re.escape(ANYTHING), ".*?") for word in words) + r"[ \t]*\n"
    there = "\n".join(" ".join(line.split()) for line in printed.splitlines() if line.strip()) + "\n"
    return re.fullmatch(pattern, there) is not None


class Work:
    """Goes through one tutorial in `folder`; `commands` is where the program `cutjoint` is, put before the path."""

    def __init__(self, folder: Path, commands: Path) -> None:
        self.folder, self.done = folder, Worked()
        self._space: dict[str, object] = {"__name__": "__main__"}
        path = f"{commands}{os.pathsep}{os.environ['PATH']}"
        self._settings = os.environ | {"PATH": path, "NO_COLOR": "1", "COLUMNS": "80", "MPLBACKEND": "Agg"}

    def through(self, text: str) -> Worked:
        """Every block of it."""
        last, printed = 0, None
        for block in FENCE.finditer(text):
            between = text[last : block.start()]
            self.done.text += between
            language, inside = block["language"], block["text"]
            if block["title"] is not None:
                file = self.folder / block["title"]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(inside, encoding="utf-8")
            elif language == "console":
                inside = self._console(inside)
            elif language == "text" and printed is not None and not between.strip():
                inside = self._held(inside, printed, "the Python above it")
            printed = self._python(inside) if language == "python" and block["title"] is None else None
            self.done.text += f"{block['open']}\n{inside}```"
            last = block.end()
        self.done.text += text[last:]
        return self.done

    def _held(self, shown: str, printed: str, of: str) -> str:
        """What is shown where it is right, else what came out."""
        if same(shown, printed):
            return shown
        self.done.differences.append(f"{of} prints\n{printed}and not\n{shown}")
        return printed

    def _python(self, text: str) -> str:
        self.done.steps += 1
        out = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(out):
            exec(compile(text, "tutorial", "exec"), self._space)
        return out.getvalue()

    def _console(self, text: str) -> str:
        made = ""
        for line, shown in re.findall(r"^\$ ((?:.*\\\n)*.*\n)((?:(?!\$ ).*\n)*)", text, flags=re.MULTILINE):
            printed = self._run(line)
            made += f"$ {line}" + (self._held(shown, printed, line.strip()) if shown.strip() else shown)
        return made

    def _run(self, line: str) -> str:
        self.done.steps += 1
        command = line.split(" # ")[0]
        run = subprocess.run(
            ["bash", "-c", command],
            cwd=self.folder,
            env=self._settings,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
        if run.returncode != 0:
            raise SystemExit(f"$ {command}\n{run.stdout}{run.stderr}exit status {run.returncode}")
        return "".join(f"{row.rstrip()}\n" for row in run.stdout.splitlines())


def work(text: str, folder: Path) -> Worked:
    """A tutorial's text, worked through in `folder`, an empty one, by the cutjoint that this Python imports."""
    commands = folder / ".bin"
    commands.mkdir()
    program = commands / "cutjoint"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m cutjoint "$@"\n')
    program.chmod(0o755)
    return Work(folder, commands).through(text)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Works through the tutorials.")
    parser.add_argument("files", nargs="*", type=Path, help="default: all")
    parser.add_argument("--write", action="store_true", help="put in what comes out now")
    asked = parser.parse_args()
    bad = 0
    for file in asked.files or sorted(FOLDER.glob("*.md")):
        with tempfile.TemporaryDirectory() as folder:
            done = work(file.read_text(encoding="utf-8"), Path(folder))
        print(f"{file.name}: {done.steps} steps, {len(done.differences)} differences")
        for difference in done.differences:
            print(difference)
        bad += len(done.differences)
        if asked.write:
            file.write_text(done.text, encoding="utf-8")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
