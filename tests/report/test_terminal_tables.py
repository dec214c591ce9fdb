"""Tables as text: no number and no word broken at any width, prose below or beside its row, bands, verdicts' marks."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutjoint.experiments.tables import Claim, Verdict, claims_table
from cutjoint.tables import INDENT, MARKS, TextTable
from cutjoint.texts import Cell, broad, harmless, wrapped

WORDS = st.text("abcdefg漢é", min_size=1, max_size=9)
TEXTS = st.lists(WORDS, min_size=1, max_size=12).map(" ".join)
NUMBER = st.floats(-1e6, 1e6, width=32).map(lambda value: f"{value:.6g}")
NUMBERS = st.one_of(NUMBER, st.tuples(NUMBER, NUMBER).map(" / ".join))


@st.composite
def tables(draw):
    """A table whose first column and some others are text, and the others numbers."""
    columns = draw(st.lists(TEXTS, min_size=2, max_size=7, unique=True))
    numbers = draw(st.lists(st.sampled_from(columns[1:]), unique=True))
    row = st.tuples(*(NUMBERS if one in numbers else TEXTS for one in columns))
    return TextTable(draw(TEXTS), columns, draw(st.lists(row, min_size=1, max_size=5)), numbers, draw(TEXTS))


@settings(max_examples=60)
@given(tables(), st.integers(40, 130))
def test_nothing_is_broken_or_lost_at_any_width(table, width):
    text = table.text(width)
    lines = text.splitlines()
    assert max(map(broad, lines)) <= width
    assert not [line for line in lines if line != line.rstrip()]
    found = text.split()
    for cells in (table.columns, *table.rows):
        for cell in cells:
            for word in cell.split():
                found.remove(word)
    for row in table.rows:
        for column, cell in zip(table.columns, row, strict=True):
            assert column not in table.right or any(cell in line for line in lines)


@settings(max_examples=20)
@given(tables())
def test_turned_twice_is_the_same(table):
    back = table.turned().turned()
    assert [list(row) for row in back.rows] == [list(row) for row in table.rows]
    assert list(back.columns) == list(table.columns)


def test_what_fits_is_as_it_is():
    table = TextTable("t", ("robot", "mass [kg]"), [("cpm", "8.7"), ("omega3", "0.58")], ["mass [kg]"], "a note")
    assert str(table).splitlines() == [
        "t",
        "robot    mass [kg]",
        "------   ---------",
        "cpm            8.7",
        "omega3        0.58",
        "a note",
    ]


def test_prose_goes_below_its_row_and_a_last_column_of_it_beside():
    rows = [("cpm", "a title of many words " * 4, "yes"), ("omega3", "short", "no")]
    lines = TextTable("t", ("robot", "title", "known"), rows).text(60).splitlines()
    assert "cpm      yes" in lines
    assert " " * INDENT + "short" in lines
    last = TextTable("t", ("robot", "title"), [row[:2] for row in rows]).text(60).splitlines()
    assert last[3].startswith("cpm      a title")
    assert last[4].startswith("         ")


def test_a_wide_table_of_numbers_is_turned_and_a_large_one_has_bands():
    columns = ["controller", *(f"{name}_column_of_the_table" for name in "abcdefgh")]
    numbers = [f"0.000{i}5678" for i in range(8)]
    few = TextTable("t", columns, [("PD", *numbers), ("PD + gravity", *numbers)], columns[1:]).text(80)
    assert f"a_column_of_the_table   {numbers[0]}   " in few
    many = TextTable("t", columns, [(f"law {i}", *numbers) for i in range(9)], columns[1:]).text(80)
    assert sum(line.startswith("law 3 ") for line in many.splitlines()) == 4
    assert [many.count(one) for one in numbers] == [9] * 8


@pytest.mark.parametrize("verdict", list(Verdict))
def test_claims_have_a_mark(verdict):
    text = "a claim that is so long that it does not fit into one line of a terminal with eighty columns [m]"
    lines = claims_table("Claims", [Claim("5.4", text, "0.25 mm", verdict)]).text(80).splitlines()
    style = {"holds": "good", "does not hold": "bad"}.get(verdict, "half")
    assert f"5.4     0.25 mm   {MARKS[style]} {verdict}" in lines
    assert text in " ".join(line.strip() for line in lines)


def test_styles_are_painted_outside_the_blanks():
    table = TextTable("t", ("a", "b"), [(Cell("x", "dim"), "1"), ("long", Cell("no", "bad"))], ["b"])
    lines = table.text(80, lambda text, style: f"<{style}:{text}>" if style else text).splitlines()
    assert lines == ["<bold:t>", "a         b", "----   ----", "<dim:x>         1", "long   <bad:✗ no>"]


def test_what_moves_a_cursor_is_escaped_and_what_nobody_reads_is_cut():
    table = TextTable("a\nb", ("x\t",), [("\x1b[31m[bold]red[/]\x1b[0m\r\n",), ("x" * 1_000_000,), ("‮evil",)])
    text = table.text(80)
    assert "\\x1b[31m[bold]red[/]\\x1b[0m\\r\\n" in text
    assert text.startswith("a\\nb\nx\\t\n")
    assert all(one.isprintable() for line in text.splitlines() for one in line)
    assert len(text) < 2000


def test_wide_characters_take_two_columns():
    lines = TextTable("t", ("name", "n"), [("漢字", "1"), ("abcd", "2")]).text().splitlines()
    assert lines[3:] == ["漢字   1", "abcd   2"]


@given(st.text(), st.integers(1, 100))
def test_harmless_text_is_one_line_and_wrapping_keeps_it(text, width):
    clean = harmless(text)
    assert clean.isprintable()
    assert " ".join(wrapped(clean, width)).split() == clean.split()


def test_a_list_is_broken_after_its_commas():
    assert wrapped("arm1 0.37 N m, arm2 0.23 N m, arm3 0.15 N m", 20) == [
        "arm1 0.37 N m,",
        "arm2 0.23 N m,",
        "arm3 0.15 N m",
    ]


def test_html_escapes_and_names_verdicts():
    html = TextTable("a < b", ("n", "v"), [("1", Cell("no", "bad"))], ["n"], "1 & 2")._repr_html_()
    for part in ("a &lt; b", '<td class="n">1</td>', '<span class="verdict bad">no</span>', "1 &amp; 2"):
        assert part in html


def test_a_row_that_does_not_fit_is_noticed():
    with pytest.raises(ValueError, match="2 cells under 1 headings"):
        TextTable("t", ("a",), [("1", "2")])
