"""What holds for every test: the same inputs in every run, no clock in any verdict, no cache of the user touched."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path

import pytest
from hypothesis import settings

# Reproducible, and not failed by a busy machine: hypothesis would count an example of 0.2 s as a failure.
settings.register_profile("cutjoint", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("cutjoint")

sys.path.insert(0, str(Path(__file__).resolve().parent))  # what rooms share is in tests/kit and tests/oracles

os.environ.setdefault("MPLBACKEND", "Agg")


SLOW_CASES = 8
"""So many slow cases of one test run in CI, spread over its family; the others are marked `thorough`."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all but a few of the slow cases of every test."""
    families: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker("slow") is not None:
            families.setdefault(item.nodeid.split("[")[0], []).append(item)
    for family in families.values():
        count = len(family)
        kept = {round(k * (count - 1) / (SLOW_CASES - 1)) for k in range(SLOW_CASES)}
        for number, item in enumerate(family):
            if count > SLOW_CASES and number not in kept:
                item.add_marker(pytest.mark.thorough)


@pytest.fixture(autouse=True)
def signals_left_alone() -> Iterator[None]:
    """A test that leaves a program's handling of Ctrl-C behind would end the whole process at a later one's."""
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    yield
    after = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    if after != before:
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True):
            signal.signal(number, handler)
        pytest.fail("the test leaves other handlers of signals behind")


@pytest.fixture(scope="session", autouse=True)
def own_caches(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compiled robots and matplotlib's fonts go to a folder of this run, in this process and those that it starts."""
    folder: Path = tmp_path_factory.mktemp("cache")
    before = {name: os.environ.get(name) for name in ("XDG_CACHE_HOME", "MPLCONFIGDIR")}
    os.environ["XDG_CACHE_HOME"] = str(folder)
    os.environ["MPLCONFIGDIR"] = str(folder / "matplotlib")
    yield
    for name, value in before.items():
        if value is None:
            del os.environ[name]
        else:
            os.environ[name] = value


@pytest.fixture
def add_row(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Adds a member to a table of types (`CutType`, `JointType`) for the time of a test: (table, name, *row)."""

    def add(table: type[StrEnum], name: str, *row: object) -> None:
        member = table.__new_member__(table, name, *row)  # type: ignore[attr-defined]
        member._name_ = name.upper()
        monkeypatch.setitem(table._value2member_map_, name, member)
        monkeypatch.setitem(table._member_map_, name.upper(), member)
        monkeypatch.setattr(table, "_member_names_", [*table._member_names_, name.upper()])

    return add
