"""What the guides tell a stranger to write, applied to a copy of the package: new files, and rows of tables.

A fenced block of a guide says in its info string what becomes of it (paths count from src/cutjoint):

    ```python new=control/lead.py               the whole content of a new file
    ```python row=control/catalogue.py table=LAWS    lines that go to the end of that table
    ```python import=control/catalogue.py       lines that go after the last import of that file
    ```toml file=robot/loops.toml               a file of the user's, in the folder where the commands run
    ```console exercise                         commands (after `$ `) that must succeed in the changed copy
    ```python exercise                          a program that must succeed in the changed copy

A table is a dict, tuple or list that is bound to a name at the top of its module, or the class of that name, whose rows
are the plain assignments of members at its head.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^(```+)(\w+)[ \t]+([^\n`]+)\n(.*?)^\1[ \t]*$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Piece:
    """A fenced block that is more than something to look at: its language, what its info string says, its text."""

    language: str
    said: dict[str, str]
    text: str


def pieces(guide: str) -> list[Piece]:
    """Those of a guide, in its order."""
    found = []
    for _, language, info, text in FENCE.findall(guide):
        said = dict((*word.split("=", 1), "")[:2] for word in info.split())
        found.append(Piece(language, said, text))
    return found


class Exercise:
    """A guide's exercise, done in `folder`: a copy of the package with what the guide adds.

    Attributes:
        new: paths of the files that were added to the package.
        rows: file and table -> the file, of the tables that got a row.
    """

    def __init__(self, guide: Path, folder: Path) -> None:
        self.folder, self.source = folder, folder / "src" / "cutjoint"
        self.new: list[str] = []
        self.rows: dict[str, str] = {}
        self.tried: list[str] = []
        shutil.copytree(ROOT / "src" / "cutjoint", self.source, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / "urdf").symlink_to(ROOT / "urdf")
        self._work = folder / "work"
        self._work.mkdir()
        self._pieces = pieces(guide.read_text(encoding="utf-8"))
        for piece in self._pieces:
            self._add(piece)

    @property
    def touched(self) -> set[str]:
        """Paths of all files of the package that are new or changed."""
        changed = set()
        for file in self.source.rglob("*"):
            name = file.relative_to(self.source)
            if file.is_file() and "__pycache__" not in name.parts:
                before = ROOT / "src" / "cutjoint" / name
                if not before.is_file() or before.read_bytes() != file.read_bytes():
                    changed.add(name.as_posix())
        return changed

    def run(self) -> None:
        """Everything that the guide tries, in its order.

        Raises:
            AssertionError: something does not succeed.
        """
        for piece in self._pieces:
            if "exercise" not in piece.said:
                continue
            if piece.language == "console":
                lines = piece.text.replace("\\\n", " ").splitlines()
                for line in [line[2:] for line in lines if line.startswith("$ ")]:
                    self._try(line, ["bash", "-c", line])
            else:
                self._try(piece.text.strip().splitlines()[0], [sys.executable, "-c", piece.text])
        assert self.tried, "the guide tries nothing"

    def _try(self, what: str, words: list[str]) -> None:
        commands = self.folder / "bin"
        if not commands.is_dir():
            commands.mkdir()
            command = commands / "cutjoint"
            command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "from cutjoint.cli import main; main()" "$@"\n')
            command.chmod(0o755)
        settings = os.environ | {
            "PYTHONPATH": str(self.source.parent),
            "PATH": f"{commands}{os.pathsep}{os.environ['PATH']}",
            "NO_COLOR": "1",
            "COLUMNS": "120",
        }
        run = subprocess.run(
            words, cwd=self._work, env=settings, capture_output=True, text=True, timeout=300, check=False
        )
        assert run.returncode == 0, f"{what}\n{run.stdout[-2000:]}\n{run.stderr[-3000:]}"
        self.tried.append(what)

    def _add(self, piece: Piece) -> None:
        said = piece.said
        if "new" in said:
            file = self.source / said["new"]
            assert not file.exists(), f"{said['new']} is there already"
            file.parent.mkdir(parents=True, exist_ok=True)
            for above in _rooms_without_init(file.parent, self.source):
                (above / "__init__.py").write_text('"""A folder of the exercise."""\n')
            file.write_text(piece.text, encoding="utf-8")
            self.new.append(said["new"])
        elif "row" in said:
            self._insert(said["row"], table_end(self._read(said["row"]), said["table"]), piece.text)
            self.rows[f"{said['row']}: {said['table']}"] = said["row"]
        elif "import" in said:
            self._insert(said["import"], last_import(self._read(said["import"])), piece.text)
        elif "file" in said:
            file = self._work / said["file"]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(piece.text, encoding="utf-8")

    def _read(self, name: str) -> str:
        return (self.source / name).read_text(encoding="utf-8")

    def _insert(self, name: str, line: int, text: str) -> None:
        """Put `text` after so many lines of a file, as far in as the line above it."""
        lines = self._read(name).splitlines(keepends=True)
        (self.source / name).write_text("".join([*lines[:line], text, *lines[line:]]), encoding="utf-8")
        ast.parse(self._read(name))


def table_end(text: str, name: str) -> int:
    """After how many lines of a module a new last row of the table called `name` goes.

    Raises:
        LookupError: the module has no such table, or its closing bracket does not stand on a line of its own.
    """
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef) and node.name == name:
            rows = [one for one in node.body if isinstance(one, ast.Assign)]
            if rows:
                assert rows[-1].end_lineno is not None
                return rows[-1].end_lineno
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if any(isinstance(one, ast.Name) and one.id == name for one in targets):
            assert node.end_lineno is not None
            if text.splitlines()[node.end_lineno - 1].strip().strip("})]"):
                raise LookupError(f"the table {name} must end with its bracket on a line of its own")
            return node.end_lineno - 1
    raise LookupError(f"no table {name}")


def last_import(text: str) -> int:
    """The line of the last import at the top level of a module."""
    ends = [node.end_lineno for node in ast.parse(text).body if isinstance(node, ast.Import | ast.ImportFrom)]
    assert ends
    assert ends[-1] is not None
    return max(end for end in ends if end is not None)


def _rooms_without_init(folder: Path, source: Path) -> Iterator[Path]:
    """Folders from `folder` up to the package that are no packages yet; only those that the exercise made."""
    while folder != source:
        if not any(folder.iterdir()):
            yield folder
        folder = folder.parent
