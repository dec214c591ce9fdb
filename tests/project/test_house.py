"""The house's rules hold, each can be broken, and the map of the rooms is up to date."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

LONG = "def f(x):\n" + "    x += 1\n" * 61
MANY = "class C:\n" + "".join(f"    def f{i}(self): ...\n" for i in range(16))


def write(folder: Path, files: dict[str, str]) -> Path:
    source = folder / "cutjoint"
    for name, text in files.items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
    return source


def test_cutjoint_keeps_the_rules(house: ModuleType) -> None:
    assert house.offences(house.layers.SOURCE) == []


def test_map_of_the_rooms_is_up_to_date(house: ModuleType) -> None:
    text = house.FILE.read_text(encoding="utf-8")
    assert text == house.page(text), "run tools/house.py --page"
    assert text.count("\n| `") >= 20


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"a.py": "x = 1\n" * 351}, "cutjoint/a.py: 351 lines, more than 350"),
        ({"a.py": LONG}, "cutjoint/a.py:1: f() has 62 lines, more than 60"),
        ({"a.py": MANY}, "cutjoint/a.py:1: class C has 16 methods, more than 15"),
        (
            {"a.py": "class C: ...\n", "b.py": "\nclass C: ...\n"},
            "class C stands 2 times: cutjoint/a.py:1, cutjoint/b.py:2",
        ),
        ({"a.py": "x: Any = 1\n" * 60}, "`Any` is used 60 times, more than 10: cutjoint/a.py 60, ..."),
        ({"a.py": "x: typing.Any = 1\n" * 60}, "`Any` is used 60 times"),
        ({f"{i}.py": "# long: numbers\n" + "x = 1\n" * 4000 for i in range(16)}, "the source has 64000 lines of code"),
    ],
)
def test_broken_rule_is_named(house: ModuleType, tmp_path: Path, files: dict[str, str], said: str) -> None:
    (line,) = house.offences(write(tmp_path, files))
    assert line.startswith(said)
    assert house.main([str(tmp_path / "cutjoint")]) == 1


@pytest.mark.parametrize(
    "text",
    [
        '"""A table."""\n\n# long: one row a state of the union\n' + "x = 1\n" * 351,
        "# long: one step after the other\n@decorated\n" + LONG,
        "# The public face.\n# long: it has what users call\n" + MANY,
        "x = 1\n" * 350,
    ],
)
def test_a_reason_is_heard(house: ModuleType, tmp_path: Path, text: str) -> None:
    assert house.offences(write(tmp_path, {"a.py": text})) == []


def test_a_reason_elsewhere_is_none(house: ModuleType, tmp_path: Path) -> None:
    assert house.offences(write(tmp_path, {"a.py": "# long: not of f\nx = 1\n" + LONG}))
    assert house.offences(write(tmp_path, {"a.py": "# long:\n" + LONG}))
    assert house.offences(write(tmp_path, {"a.py": "x = 1\n" * 351 + "# long: too late\n"}))


def test_only_code_counts_as_code(house: ModuleType) -> None:
    text = '"""Two\nlines."""\n\n# a remark\nx = """kept\nboth"""\n\n\ndef f():\n    "Said."\n    return x  # here\n'
    assert house.code_lines(text.splitlines(), house.ast.parse(text)) == 4
