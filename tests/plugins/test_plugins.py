"""Parts from outside: what is found, and one clear error for all that can be wrong with one."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from cutjoint import plugins
from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.plugins import installed, installed_part, is_outside, part

GOOD = """
from dataclasses import dataclass

from neighbour import VALUE

@dataclass
class Thing:
    value: int = VALUE

def make():
    return Thing()

number = 3
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    (tmp_path / "neighbour.py").write_text("VALUE = 7\n")
    (tmp_path / "things.py").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    before = list(sys.path), set(sys.modules)
    yield tmp_path
    sys.path[:] = before[0]
    for name in set(sys.modules) - before[1]:
        del sys.modules[name]


def test_a_file_is_found_from_here_and_by_its_path(folder: Path) -> None:
    for text in ("things.py:make", f"{folder}/things.py:make", "./things.py:make"):
        found = part(text)
        assert found.value().value == 7  # type: ignore[operator]
        assert found.told == text
    assert part("things.py:number").value == 3
    assert part("things.py:Thing:1,2").rest == "1,2"


def test_a_file_is_run_once_and_anew_where_it_changed(folder: Path) -> None:
    file = folder / "counted.py"
    file.write_text("import neighbour\nneighbour.VALUE += 1\ndef f(): pass\n")
    one, two = part("counted.py:f").value, part("counted.py:f").value
    assert one is two
    assert sys.modules["neighbour"].VALUE == 8
    file.write_text("def g(): pass\n")
    assert part("counted.py:g").value is not one
    assert not (folder / "__pycache__" / "counted.cpython-311.pyc").exists()


def test_a_module_that_can_be_imported_is_found() -> None:
    from cutjoint.control import PD

    assert part("cutjoint.control.pd:PD").value is PD


def test_what_is_hidden_by_a_neighbour_is_not(folder: Path) -> None:
    """The folder of a file comes behind all others, so its json.py does not become everybody's json."""
    (folder / "json.py").write_text("raise RuntimeError")
    (folder / "uses.py").write_text("import json\nvalue = json.dumps([1])\n")
    assert part("uses.py:value").value == "[1]"


@pytest.mark.parametrize(
    ("text", "outside"),
    [
        ("things.py:Thing", True),
        ("a/b c/things.py:Thing:1,2", True),
        ("package.module:Name", True),
        ("module:Name", True),
        ("things.py", True),
        ("circle:0.02", False),
        ("circle", False),
        ("line:1,2,3", False),
        ("way.csv", False),
    ],
)
def test_what_is_written_like_a_part(text: str, outside: bool) -> None:
    assert is_outside(text) is outside


@pytest.mark.parametrize(
    ("source", "about"),
    [
        ("1 / 0", r"bad.py cannot be imported: ZeroDivisionError: division by zero at .*bad.py:3: 1 / 0"),
        ("def f(:", r"bad.py cannot be imported: SyntaxError: .* at .*bad.py:3: def f\(:"),
        ("import nosuchpackage", r"bad.py cannot be imported: ModuleNotFoundError: .*nosuchpackage.* at .*bad.py:3"),
        ("raise SystemExit(3)", r"bad.py cannot be imported: SystemExit: 3 at .*bad.py:3"),
        ("raise Exception", r"bad.py cannot be imported: Exception at .*bad.py:3"),
        ("import neighbour\nneighbour.missing", r"cannot be imported: AttributeError: .*missing.* at .*bad.py:4"),
        ("x = '\\ud800'.encode()", r"cannot be imported: UnicodeEncodeError"),
        ("\0", r"bad.py cannot be imported: (ValueError|SyntaxError): "),
    ],
)
def test_a_file_that_cannot_be_imported_says_where(folder: Path, source: str, about: str) -> None:
    (folder / "bad.py").write_text(f'"""Two lines\nbefore."""\n{source}\n')
    for _ in range(2):
        with pytest.raises(InputError, match=about):
            part("bad.py:f")
    assert not any("bad" in name for name in sys.modules if name.startswith("cutjoint_outside"))


def test_a_file_that_is_no_text(folder: Path) -> None:
    (folder / "bad.py").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match=r"bad.py cannot be imported"):
        part("bad.py:f")


@pytest.mark.parametrize(
    ("text", "kind", "about"),
    [
        ("things.py", InputError, "as things.py:NAME; it has Thing, make"),
        ("thing.py:Thing", UnknownNameError, r"unknown Python file in .* 'thing.py'; did you mean 'things.py'"),
        ("none/thing.py:Thing", UnknownNameError, "unknown Python file"),
        ("things.py:Thin", UnknownNameError, "unknown name in things.py 'Thin'; did you mean 'Thing'"),
        ("things:Thing", InputError, "no module things to import; for the file here write things.py:Thing"),
        ("nosuch.things:Thing", InputError, "no module nosuch to import"),
        ("cutjoint.nosuch:Thing", InputError, "no module cutjoint.nosuch to import"),
        ("cutjoint.errors:Inputerror", UnknownNameError, "did you mean 'InputError'"),
    ],
)
def test_what_is_not_there_is_told(folder: Path, text: str, kind: type[CutjointError], about: str) -> None:
    with pytest.raises(kind, match=about):
        part(text)


def test_a_module_that_fails_inside_is_not_taken_for_a_missing_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(folder))
    (folder / "lacking.py").write_text("import nosuchpackage\n")
    (folder / "failing.py").write_text("\n1 / 0\n")
    with pytest.raises(InputError, match=r"lacking cannot be imported: .*nosuchpackage.* at .*lacking.py:1"):
        part("lacking:f")
    with pytest.raises(InputError, match=r"failing cannot be imported: ZeroDivisionError: .* at .*failing.py:2: 1 / 0"):
        part("failing:f")


@pytest.fixture
def offering(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Installed packages that offer laws."""
    offers = [
        EntryPoint("pid-of-us", "cutjoint.control.pid:PID", "group"),
        EntryPoint("twice", "cutjoint.control.pd:PD", "group"),
        EntryPoint("twice", "cutjoint.control.pid:PID", "group"),
        EntryPoint("broken", "nosuch.module:Name", "group"),
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: [one for one in offers if one.group == group])
    installed.cache_clear()
    yield
    installed.cache_clear()


@pytest.mark.usefixtures("offering")
def test_entry_points_are_found_by_name() -> None:
    from cutjoint.control import PID

    assert list(installed("group")) == ["pid-of-us", "twice", "broken"]
    assert installed_part("group", "pid-of-us").value is PID
    assert "cutjoint.control.pid:PID" in installed_part("group", "pid-of-us").told
    with pytest.raises(InputError, match=r"offered as cutjoint.control.pd:PD and as cutjoint.control.pid:PID"):
        installed_part("group", "twice")
    with pytest.raises(InputError, match="no module nosuch"):
        installed_part("group", "broken")
