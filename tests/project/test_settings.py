"""Settings in TOML: every value is looked at, and no key is passed over."""

from __future__ import annotations

from pathlib import Path

import pytest

from cutjoint.errors import FileError, InputError
from cutjoint.settings import Settings, read_settings


def of(**data: object) -> Settings:
    return Settings(data, "file.toml")


def test_what_is_there_is_given() -> None:
    table = of(a="x", b=["x", "y"], c=2, d=2.5, e=True, f=[1, 2.5], g={"h": 1}, i=[{"j": 2}, {"j": 3}])
    assert table.text("a") == "x"
    assert (table.texts("a"), table.texts("b")) == (("x",), ("x", "y"))
    assert (table.whole("c"), table.number("c"), table.number("d")) == (2, 2.0, 2.5)
    assert table.yes("e", False) is True
    assert table.numbers("f", size=2) == (1.0, 2.5)
    below = table.table("g")
    assert below is not None
    assert below.whole("h") == 1
    assert [one.whole("j") for one in table.tables("i")] == [2, 3]
    table.finish()


def test_defaults_stand_where_nothing_is() -> None:
    table = of()
    assert table.text("a", None) is None
    assert (table.number("a", 1.5), table.whole("a", 3), table.yes("a", True)) == (1.5, 3, True)
    assert (table.texts("a", ()), table.numbers("a", ()), table.table("a"), table.tables("a")) == ((), (), None, ())
    table.finish()


@pytest.mark.parametrize(
    ("ask", "value"),
    [
        (lambda table: table.text("a"), 1),
        (lambda table: table.text("a", choices=("x", "y")), "z"),
        (lambda table: table.texts("a"), []),
        (lambda table: table.texts("a"), ["x", 1]),
        (lambda table: table.number("a"), "1"),
        (lambda table: table.number("a"), True),
        (lambda table: table.number("a"), float("nan")),
        (lambda table: table.number("a"), float("inf")),
        (lambda table: table.number("a", least=0.0), -1.0),
        (lambda table: table.number("a", above=0.0), 0),
        (lambda table: table.whole("a"), 1.0),
        (lambda table: table.whole("a"), True),
        (lambda table: table.whole("a", least=2), 1),
        (lambda table: table.yes("a", True), 1),
        (lambda table: table.numbers("a"), 1.0),
        (lambda table: table.numbers("a"), [1.0, "2"]),
        (lambda table: table.numbers("a", size=3), [1.0, 2.0]),
        (lambda table: table.table("a"), [1]),
        (lambda table: table.tables("a"), {"b": 1}),
        (lambda table: table.tables("a"), [1]),
    ],
)
def test_another_value_is_told(ask, value) -> None:
    with pytest.raises(InputError, match=r"^file\.toml: a must be .*, found "):
        ask(of(a=value))


def test_what_must_be_there_is_asked_for() -> None:
    with pytest.raises(InputError, match=r"file\.toml: a must be a finite number \[m\] > 0, found nothing"):
        of().number("a", unit="m", above=0.0)


def test_a_key_that_nobody_asked_for_is_told_with_the_nearest() -> None:
    table = of(rate=1.0, inner={"deley": 1.0})
    table.number("rate")
    below = table.table("inner")
    assert below is not None
    below.number("delay", 0.0)
    with pytest.raises(InputError, match=r"file\.toml, \[inner\]: there is no key 'deley'; did you mean delay\?"):
        table.finish()
    with pytest.raises(InputError, match="no key 'rate'"):
        of(rate=1.0).finish()


def test_files(tmp_path: Path) -> None:
    with pytest.raises(FileError):
        read_settings(tmp_path / "none.toml")
    path = tmp_path / "file.toml"
    for content in (b"a = ", b"\xff\xfe", b"a = 1\na = 2", b"[" * 100_000):
        path.write_bytes(content)
        with pytest.raises(InputError, match="this is no TOML"):
            read_settings(path)
    path.write_text("a = 1\n")
    assert read_settings(path).whole("a") == 1
