"""constraints.txt: exact, complete, without addresses."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest


def test_every_line_is_an_exact_version_and_nothing_else(pins: ModuleType) -> None:
    assert pins.read(pins.FILE.read_text())


@pytest.mark.parametrize("line", ["numpy>=2", "numpy", "x @ https://host/x.whl", "--index-url https://host", "x==1; y"])
def test_other_lines_are_refused(pins: ModuleType, line: str) -> None:
    with pytest.raises(ValueError, match="line 2"):
        pins.read(f"a==1\n{line}\n")


def test_every_requirement_is_pinned(pins: ModuleType, root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text())
    wanted = [*project["project"]["dependencies"], *project["build-system"]["requires"]]
    wanted += [one for extra in project["project"]["optional-dependencies"].values() for one in extra]
    names = {pins.normal(re.split(r"[^A-Za-z0-9._-]", one)[0]) for one in wanted} - pins.NOT_OURS
    assert names <= set(pins.read(pins.FILE.read_text()))


def test_make_environment_holds_the_pinned_versions(pins: ModuleType, root: Path) -> None:
    if Path(sys.prefix).resolve().parent != root or not (Path(sys.prefix) / ".ready").exists():
        pytest.skip("not running in the environment that make sets up")
    found, wanted = pins.installed(), pins.read(pins.FILE.read_text())
    assert {name: version for name, version in found.items() if wanted.get(name, version) != version} == {}
