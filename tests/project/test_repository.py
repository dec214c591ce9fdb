"""What any file of the project must keep to."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

# In pieces, so that this file does not hold what it looks for.
HOSTS = ["pypi" + ".org", "python" + "hosted", "npmjs" + ".org", "debian" + ".org/debian", "conda" + ".anaconda"]
FOLDERS = ["/root" + "/", "/home" + "/", "/mnt" + "/"]
FORBIDDEN = re.compile("|".join([*map(re.escape, HOSTS), *(rf"(?<![\w.-]){re.escape(one)}" for one in FOLDERS)]))


def texts(tracked: list[Path]) -> dict[Path, str]:
    found = {}
    for file in tracked:
        data = file.read_bytes()
        if b"\0" not in data:
            found[file] = data.decode("utf-8", errors="replace")
    return found


def test_no_path_of_a_machine_and_no_package_host(tracked: list[Path]) -> None:
    found = [
        f"{file}:{number}: {line.strip()[:100]}"
        for file, text in texts(tracked).items()
        for number, line in enumerate(text.splitlines(), start=1)
        if FORBIDDEN.search(line)
    ]
    assert found == []


def test_the_search_for_paths_finds_them() -> None:
    for sample in [*HOSTS, *(f"cd {folder}x" for folder in FOLDERS)]:
        assert FORBIDDEN.search(sample), sample
    assert not FORBIDDEN.search("frame" + FOLDERS[1])


def test_license(root: Path) -> None:
    text = (root / "LICENSE").read_text()
    assert "Redistribution and use in source and binary forms" in text
    assert tomllib.loads((root / "pyproject.toml").read_text())["project"]["license"] == "BSD-2-Clause"


def test_version_heads_the_changelog(root: Path) -> None:
    version = tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"]
    headings = re.findall(r"^## \[?([^\]\s]+)", (root / "CHANGELOG.md").read_text(), flags=re.MULTILINE)
    released = [one for one in headings if one.lower() != "unreleased"]
    assert released, "CHANGELOG.md has no release"
    assert released[0] == version


def test_installed_version_is_the_project_s(root: Path) -> None:
    from importlib.metadata import version

    assert version("cutjoint") == tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"]


def test_every_module_says_what_it_is(tracked: list[Path], root: Path) -> None:
    silent = [
        str(file.relative_to(root))
        for file in tracked
        if file.suffix == ".py"
        and file.relative_to(root).parts[0] in ("src", "tools")
        and not ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert silent == []


def test_files_end_their_last_line_and_use_unix_line_ends(tracked: list[Path]) -> None:
    ours = {".py", ".md", ".toml", ".urdf", ".sh", ".txt"}
    bad = [
        str(file)
        for file, text in texts(tracked).items()
        if file.suffix in ours and "bad" not in str(file) and text and ("\r" in text or not text.endswith("\n"))
    ]
    assert bad == []


def test_scripts_can_be_run(root: Path) -> None:
    for file in root.glob("tools/*.sh"):
        assert file.stat().st_mode & 0o111, f"{file} is not executable"
        assert file.read_text().startswith("#!"), file


@pytest.fixture(scope="module")
def wheel(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    run = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False, timeout=120)
    assert run.returncode == 0, run.stderr
    return next(folder.glob("*.whl"))


def test_wheel_holds_the_robots_and_the_typing_marker(wheel: Path, root: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    robots = [file.relative_to(root / "urdf") for file in (root / "urdf").rglob("*") if file.is_file()]
    assert robots
    assert {f"cutjoint/urdf/{robot.as_posix()}" for robot in robots} <= names
    assert "cutjoint/py.typed" in names
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_wheel_holds_every_file_of_the_package_and_nothing_else(wheel: Path, root: Path, tracked: list[Path]) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert {name.split("/")[0] for name in names} == {"cutjoint"}
    assert not [name for name in names if "__pycache__" in name or "/tests/" in name]
    package = root / "src/cutjoint"
    assert {f"cutjoint/{file.relative_to(package).as_posix()}" for file in tracked if package in file.parents} <= names
