"""What the tests of the project itself share: where it is, which files it tracks, its tools as modules."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import FrameType, MappingProxyType, ModuleType
from typing import Any

import numpy as np
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
        parts = ("src", "tests", "tools", "docs", "urdf")
        files = [*ROOT.glob("*.*"), ROOT / "Makefile", *(file for part in parts for file in (ROOT / part).rglob("*"))]
    return [file for file in files if file.is_file() and "__pycache__" not in file.parts]


@pytest.fixture(scope="session")
def layers() -> ModuleType:
    return _tool("layers")


@pytest.fixture(scope="session")
def pins() -> ModuleType:
    return _tool("pins")


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
    return _alike


def _alike(found: Any, wanted: Any) -> None:
    assert type(found) is type(wanted)
    if isinstance(wanted, np.ndarray):
        assert (found.dtype, found.shape) == (wanted.dtype, wanted.shape)
        assert found.tobytes() == wanted.tobytes()
        assert not found.flags.writeable
        assert not wanted.flags.writeable
    elif is_dataclass(wanted):
        for one in fields(wanted):
            _alike(getattr(found, one.name), getattr(wanted, one.name))
    elif isinstance(wanted, tuple | list):
        assert len(found) == len(wanted)
        for one, other in zip(found, wanted, strict=True):
            _alike(one, other)
    elif isinstance(wanted, dict | MappingProxyType):
        assert list(found) == list(wanted)
        for name in wanted:
            _alike(found[name], wanted[name])
    elif type(wanted).__eq__ is object.__eq__ and hasattr(wanted, "__dict__") and not callable(wanted):
        _alike(vars(found), vars(wanted))
    else:
        assert found == wanted
        assert repr(found) == repr(wanted)


@pytest.fixture
def together() -> Iterator[Callable[[Sequence[Callable[[], Any]]], list[Any]]]:
    """`together(calls)`: what the calls return, made by eight threads that take turns every tenth of a millisecond.

    Every twentieth round they even take turns at every line of the package, so that a shared workspace is met for sure
    and not by luck.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield _together
    sys.setswitchinterval(before)


def _together(calls: Sequence[Callable[[], Any]]) -> list[Any]:
    threads = 8
    ready = threading.Barrier(threads)

    def work(first: int) -> Mapping[int, Any]:
        ready.wait(60.0)
        made = {}
        for i in range(first, len(calls), threads):
            sys.settrace(_step if i // threads % 20 == 10 else None)
            made[i] = calls[i]()
            sys.settrace(None)
        return made

    found: dict[int, Any] = {}
    with ThreadPoolExecutor(threads) as pool:
        for part in pool.map(work, range(threads)):
            found.update(part)
    return [found[i] for i in range(len(calls))]


def _step(frame: FrameType, event: str, arg: Any) -> Any:
    """A trace function that lets the other threads go on before every line."""
    if "cutjoint" not in frame.f_code.co_filename:
        return None
    if event == "line":
        time.sleep(1e-6)
    return _step
