"""Settings in TOML: every value is looked at, no key is passed over, and all that is wrong is told at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from cutjoint.errors import DescriptionError, InputError, SettingsError
from cutjoint.findings import Findings
from cutjoint.toml.reading import read_settings, settings_of
from cutjoint.toml.table import TomlTable
from cutjoint.toml.taking import each, one_of, positive, several, texts, truth, whole


def of(**data: object) -> TomlTable:
    return TomlTable(data, (), {}, Findings("file.toml"))


def test_what_is_there_is_given() -> None:
    table = of(a="x", b=["x", "y"], c=2, d=2.0, e=True, g={"h": 1}, i=[{"j": 2}, {"j": 3}])
    assert (texts(table, "a"), texts(table, "b"), texts(table, "none")) == (("x",), ("x", "y"), ())
    assert (whole(table, "c", 0, 9), whole(table, "d", 0, 9), whole(table, "none", 0, 9)) == (2, 2, None)
    assert (positive(table, "d"), positive(table, "none")) == (2.0, None)
    assert (truth(table, "e"), truth(table, "none")) == (True, False)
    assert (one_of(table, "a", ("x", "y"), "y"), one_of(table, "none", ("x", "y"), "y")) == ("x", "y")
    assert [whole(one, "h", 0, 9) for one in several(table, "g")] == [1]
    assert [whole(one, "j", 0, 9) for one in several(table, "i")] == [2, 3]
    assert each(table.table("g"), lambda key, value: (key, value)) == {"h": ("h", 1)}
    assert each(table.table("none"), lambda key, value: value) == {}
    table.finish()
    assert not table.findings.problems


@pytest.mark.parametrize(
    ("take", "value"),
    [
        (lambda table: one_of(table, "a", ("x", "y"), "x"), "z"),
        (lambda table: one_of(table, "a", ("x", "y"), "x"), 1),
        (lambda table: texts(table, "a"), []),
        (lambda table: texts(table, "a"), ["x", 1]),
        (lambda table: texts(table, "a"), 1),
        (lambda table: positive(table, "a"), "1"),
        (lambda table: positive(table, "a"), True),
        (lambda table: positive(table, "a"), float("nan")),
        (lambda table: positive(table, "a"), float("inf")),
        (lambda table: positive(table, "a"), 0),
        (lambda table: positive(table, "a", zero=True), -1.0),
        (lambda table: whole(table, "a", 0, 9), 1.5),
        (lambda table: whole(table, "a", 0, 9), True),
        (lambda table: whole(table, "a", 2, 9), 1),
        (lambda table: whole(table, "a", 2, 9), 10),
        (lambda table: truth(table, "a"), 1),
        (lambda table: several(table, "a"), [1]),
        (lambda table: several(table, "a"), 1),
    ],
)
def test_another_value_is_told(take, value) -> None:
    table = of(a=value)
    take(table)
    assert len(table.findings.problems) == 1
    (problem,) = table.findings.problems
    assert problem.file == "file.toml"
    assert problem.found.startswith("a of the file is ")
    assert problem.expected


def _taken(top: TomlTable) -> dict[str, float]:
    def number(key: str, value: object) -> float:
        if not isinstance(value, float):
            raise InputError(f"{key} is no number")
        return value

    top.string("robot", required=True)
    found = each(top.table("springs"), number)
    top.finish()
    return found


def test_all_that_is_wrong_in_a_file_is_told_at_once_with_lines(tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_text('robto = "x"\n\n[springs]\na = 1.0\nb = "2"\nc = true\n')
    with pytest.raises(SettingsError) as found:
        read_settings(path, _taken)
    told = {one.line: f"{one.found}; {one.mend}" for one in found.value.problems}
    assert told == {
        None: "the file without 'robot'; add robot = ...",
        1: "unknown key 'robto' in the file; did you mean 'robot'?",
        5: "b is no number; ",
        6: "c is no number; ",
    }
    assert isinstance(found.value, InputError)
    assert isinstance(found.value, DescriptionError)
    assert str(found.value).startswith("4 problems in the settings:")
    path.write_text('robot = "x"\nsprings.a = 1.0\n')
    assert read_settings(path, _taken) == {"a": 1.0}


def test_an_error_of_what_is_made_is_told_with_the_file() -> None:
    def made(top: TomlTable) -> int:
        raise InputError("that does not fit together")

    with pytest.raises(SettingsError, match=r"file\.toml: that does not fit together"):
        settings_of(of(), made)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="file not found"):
        read_settings(tmp_path / "none.toml", _taken)
    path = tmp_path / "file.toml"
    for content in (b"a = ", b"\xff\xfe\x00", b"a = 1\na = 2", b"[" * 100_000):
        path.write_bytes(content)
        with pytest.raises(SettingsError, match=r"does not parse|not UTF-8"):
            read_settings(path, _taken)
