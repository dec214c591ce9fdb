"""What the tests of the project itself share: where it is, which files it tracks, its tools as modules."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def tracked() -> list[Path]:
    """The files of the project: those git knows, or in an unpacked archive those that lie there."""
    if (ROOT / ".git").exists():
        names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        files = [ROOT / name for name in names.split("\0") if name]
    else:
        parts = ("src", "tests", "tools", "docs", "urdf", "examples")
        files = [*ROOT.glob("*.*"), ROOT / "Makefile", *(file for part in parts for file in (ROOT / part).rglob("*"))]
    return [file for file in files if file.is_file() and "__pycache__" not in file.parts]


@pytest.fixture(scope="session")
def layers() -> ModuleType:
    return _tool("layers")


@pytest.fixture(scope="session")
def house() -> ModuleType:
    return _tool("house")


@pytest.fixture(scope="session")
def pins() -> ModuleType:
    return _tool("pins")


@pytest.fixture(scope="session")
def try_examples() -> ModuleType:
    return _tool("try_examples")


def _tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"cutjoint_tools_{name}", ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def alike() -> Callable[[Any, Any], None]:
    """`alike(found, wanted)` holds where two values are the same to the last bit and both cannot be written into."""
    from kit.sharing import alike

    return alike


@pytest.fixture
def together() -> Iterator[Callable[[Sequence[Callable[[], Any]]], list[Any]]]:
    """`together(calls)`: what the calls return, made by eight threads that take turns every tenth of a millisecond.

    Every twentieth round they even take turns at every line of the package, so that a shared workspace is met for sure
    and not by luck.
    """
    from kit.sharing import together

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield together
    sys.setswitchinterval(before)
