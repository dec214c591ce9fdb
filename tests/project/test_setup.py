"""tools/setup.sh: what it does when nothing is to be done, when it was interrupted, and with the wrong Python.

A shell script stands in for Python: it answers for its version, "makes" environments that hold a copy of itself, and
notes every call.
"""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

PYTHON = """#!/bin/sh
echo "$*" >>"{log}"
case "$*" in
*sys.exit*) exit {too_old} ;;
*version_info*) echo {version} ;;
*venv*) for folder; do :; done; rm -rf "$folder"; mkdir -p "$folder/bin"; cp "$0" "$folder/bin/python" ;;
*pip*) test ! -e "{folder}/no-network" ;;
esac
"""


@dataclass(frozen=True)
class Clone:
    """A folder with what setup.sh reads, and a stand-in for Python."""

    folder: Path
    log: Path

    def python(self, name: str = "fake-python", version: str = "3.12", *, too_old: bool = False) -> Path:
        file = self.folder / name
        text = PYTHON.format(log=self.log, version=version, too_old=int(too_old), folder=self.folder)
        file.write_text(text)
        file.chmod(0o755)
        return file

    def setup(self, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        self.log.write_text("")
        command = ["sh", "tools/setup.sh", ".venv", *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False, timeout=30)

    @property
    def calls(self) -> str:
        return self.log.read_text()

    @property
    def ready(self) -> bool:
        return (self.folder / ".venv/.ready").exists()


@pytest.fixture
def clone(root: Path, tmp_path: Path) -> Clone:
    folder = tmp_path / "a clone"
    (folder / "tools").mkdir(parents=True)
    shutil.copy(root / "tools/setup.sh", folder / "tools")
    (folder / "pyproject.toml").write_text("one\n")
    (folder / "constraints.txt").write_text("numpy==2\n")
    return Clone(folder, tmp_path / "calls")


def test_first_time_makes_an_environment_and_the_second_does_nothing(clone: Clone) -> None:
    python = clone.python()
    run = clone.setup(python)
    assert run.returncode == 0, run.stderr
    assert clone.ready
    assert "venv --clear" in clone.calls
    assert "--editable .[dev]" in clone.calls
    again = clone.setup()
    assert (again.returncode, again.stdout, clone.calls) == (0, "", "")


def test_failed_installation_is_not_ready_and_the_next_starts_anew(clone: Clone) -> None:
    python = clone.python()
    (clone.folder / "no-network").touch()
    run = clone.setup(python)
    assert run.returncode == 1
    assert "could not be installed" in run.stderr
    assert not clone.ready
    (clone.folder / "no-network").unlink()
    assert clone.setup(python).returncode == 0
    assert "venv --clear" in clone.calls
    assert clone.ready


def test_changed_pins_update_in_place(clone: Clone) -> None:
    python = clone.python()
    clone.setup(python)
    (clone.folder / "constraints.txt").write_text("numpy==3\n")
    assert clone.setup(python).returncode == 0
    assert "pip install" in clone.calls
    assert "venv --clear" not in clone.calls


def test_failed_update_is_not_ready(clone: Clone) -> None:
    python = clone.python()
    clone.setup(python)
    (clone.folder / "constraints.txt").write_text("numpy==3\n")
    (clone.folder / "no-network").touch()
    assert clone.setup(python).returncode == 1
    assert not clone.ready


def test_moved_clone_and_another_python_start_anew(clone: Clone) -> None:
    python = clone.python()
    clone.setup(python)
    assert clone.setup(clone.python("newer", "3.13")).returncode == 0
    assert "venv --clear" in clone.calls
    moved = Clone(clone.folder.with_name("moved"), clone.log)
    clone.folder.rename(moved.folder)
    assert moved.setup(moved.python("newer", "3.13")).returncode == 0
    assert "venv --clear" in moved.calls


def test_old_python_is_refused_with_its_version(clone: Clone) -> None:
    run = clone.setup(clone.python(version="3.9", too_old=True))
    assert run.returncode == 1
    assert "needs Python 3.11 or newer" in run.stderr
    assert "is 3.9" in run.stderr
    assert not (clone.folder / ".venv").exists()


def test_python_that_does_not_run_is_refused(clone: Clone) -> None:
    run = clone.setup("no-such-python")
    assert run.returncode == 1
    assert "no-such-python does not run" in run.stderr
