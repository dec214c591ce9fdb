"""Tables on a terminal: no number and no word broken, the orientation that fits, verdicts with their marks."""

from __future__ import annotations

import re
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from cutjoint.commands import output, reproduce
from cutjoint.report import ReportTable
from cutjoint.report.page import MARKS, verdict_style

WORDS = st.text("abcdefg", min_size=1, max_size=9)
TEXTS = st.lists(WORDS, min_size=1, max_size=5).map(" ".join)


@st.composite
def tables(draw):
    columns = draw(st.lists(TEXTS, min_size=2, max_size=7, unique=True))
    row = st.lists(TEXTS, min_size=len(columns), max_size=len(columns))
    return ReportTable("title", columns, draw(st.lists(row, min_size=1, max_size=6)), right=columns[1:])


@pytest.fixture
def terminal(monkeypatch):
    """Prints to a terminal of a width and gives back what stands there."""

    def printed(table, width, show):
        console = Console(width=width, highlight=False, record=True, file=StringIO())
        monkeypatch.setattr(output, "console", lambda: console)
        monkeypatch.setattr(reproduce, "console", lambda: console)
        show(table)
        return console.export_text()

    return printed


@given(tables())
def test_turned_twice_is_the_same(table):
    back = table.turned().turned()
    assert [list(row) for row in back.rows] == [list(row) for row in table.rows]
    assert list(back.columns) == list(table.columns)


@given(tables())
def test_it_is_turned_only_where_that_helps(table):
    assert table.fitting(table.least_width) is table
    chosen = table.fitting(table.least_width - 1)
    assert chosen.least_width == min(table.least_width, table.turned().least_width)


@given(tables(), st.integers(0, 60))
def test_no_word_is_broken_where_there_is_room(table, more):
    width = table.least_width + more
    made = output.TerminalTable(table.title, table.columns, table.right)
    for row in table.rows:
        made.add_row(*row)
    made._keep_words_whole(width)
    console = Console(width=width, file=StringIO(), record=True)
    console.print(made._table)
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= width
    found = sorted(re.findall(r"[a-g]+", text))
    assert found == sorted(word for cells in (table.columns, *table.rows) for cell in cells for word in cell.split())


def test_numbers_stay_in_one_line_before_words_do():
    made = output.TerminalTable("t", ["what it is all about", "how much there is of it"], ["how much there is of it"])
    made.add_row("some long text with many words", "0.2552 / 0.0862 / 0.0862")
    made._keep_words_whole(45)
    console = Console(width=45, file=StringIO(), record=True)
    console.print(made._table)
    assert "0.2552 / 0.0862 / 0.0862" in console.export_text()


def test_a_wide_table_of_numbers_is_turned_at_80_columns(terminal):
    columns = ["controller", *(f"{name} column of the table" for name in "abcdefgh")]
    numbers = [f"0.000{i}5678" for i in range(8)]
    table = ReportTable("t", columns, [("PD", *numbers), ("PD + gravity", *numbers)], right=columns[1:])
    text = terminal(table, 80, reproduce._print)
    for number in numbers:
        assert text.count(number) == 2
    assert len(text.splitlines()) < 20
    assert max(map(len, text.splitlines())) <= 80


@pytest.mark.parametrize("verdict", ["holds", "does not hold", "holds with the inferred code only"])
def test_claims_are_paragraphs_with_a_mark(terminal, verdict):
    claim = "a claim that is so long that it does not fit into one line of a terminal with eighty columns [m]"
    table = ReportTable("Claims", ("where", "claim", "found", "verdict"), [("5.4", claim, "0.25 mm", verdict)])
    lines = [line.strip() for line in terminal(table, 80, reproduce._print).splitlines()]
    assert f"{MARKS[verdict_style(verdict)]} {verdict}" in lines
    assert "0.25 mm" in lines
    assert f"{claim} (5.4)" in " ".join(lines)
    assert max(map(len, lines)) <= 80


def test_every_verdict_has_a_style():
    from cutjoint.experiments.tables import Verdict

    assert [verdict_style(one) for one in Verdict] == ["good", "half", "half", "bad"]
    assert verdict_style("0.25 mm") is None
