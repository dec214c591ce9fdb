"""`cutjoint reproduce`: bad input is found before anything runs; the whole report stands alone."""

import re
from xml.etree import ElementTree

import pytest
import typer
from typer.testing import CliRunner

from cutjoint.commands.reproduce import command
from cutjoint.errors import CutjointError
from cutjoint.pool import run_all

app = typer.Typer()
app.command()(command)


@pytest.mark.parametrize("arguments", [["delta"], ["cpm", "--output", "none/report.html"], ["cpm", "--output", "."]])
def test_bad_input_is_found_before_anything_runs(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, arguments)
    assert isinstance(done.exception, CutjointError)
    assert list(tmp_path.iterdir()) == []


def test_pool_keeps_the_order_and_raises_the_first_error():
    told = []
    found = run_all({i: (pow, (2, i)) for i in range(5)}, told.append)
    assert found == {i: 2**i for i in range(5)}
    assert list(found) == [0, 1, 2, 3, 4]
    assert told == [1, 2, 3, 4, 5]
    with pytest.raises(ZeroDivisionError):
        run_all({"bad": (divmod, (1, 0)), "good": (divmod, (1, 1))})


@pytest.mark.slow
def test_the_whole_report(tmp_path):
    file = tmp_path / "report.html"
    done = CliRunner().invoke(app, ["all", "--output", str(file)])
    assert done.exit_code == 0, done.output
    html = file.read_text()
    # Every figure of the two papers that shows a result, and all four columns of table 3.
    for number in [*range(9, 23), "4a", "4b", "4c", "5", "5c"]:
        assert f"(figure {number})" in html or f"igures {number}" in html, number
    for text in ("inferred code", "equation (39)", "Pinocchio, lumped", "Pinocchio, distributed", "12691", "8507"):
        assert text in html
    assert html.count("<figure>") == 10
    assert html.count(">holds with the inferred code only<") == 6
    assert html.count(">holds with equation (39) only<") == 1
    assert html.count(">(39), solver steps<") == 2
    # Every claim about the control laws has its verdict: eleven hold, five do not.
    laws = html[html.index("What the paper says of the control laws") :]
    laws = laws[: laws.index("</table>")]
    assert (laws.count(">holds<"), laws.count(">does not hold<")) == (11, 5)
    # It stands alone: no script, no link out, identifiers unique, and it is well formed.
    assert not re.search(r"<script|<link|<img|src=|@import|https?://(?!www\.w3\.org/)", html)
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))
    ElementTree.fromstring(html[html.index("<body>") : html.index("</body>") + 7])
    # The tables are printed as well.
    for text in ("Table 3, root mean square position error [m]", "12691", "one turn of the curve (43)"):
        assert text in done.output
