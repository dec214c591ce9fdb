"""Figures and pages: units, colours, one file that needs nothing else."""

import re
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from cutjoint.errors import InputError
from cutjoint.experiments.tables import Verdict
from cutjoint.report import LIMBS, Panel, Section, ToolPath, figure, page
from cutjoint.report.figures import scaled
from cutjoint.report.page import Picture
from cutjoint.tables import TextTable

TIME = np.linspace(0.0, 2.0, 201)
WAVES = np.column_stack([np.sin(3 * TIME), np.cos(2 * TIME), 0.3 * TIME])
NAMES = ("limb 1", "limb 2", "limb 3")


@pytest.fixture(scope="module")
def drawing():
    return figure(
        ToolPath("Path & more", "yz", WAVES, WAVES + 0.01),
        Panel("Error <now>", TIME, 1e-3 * WAVES, "m", "error", NAMES, bound=5e-4, since=0.3),
        Panel("Force", TIME, WAVES, "N", "force", NAMES, zoom=(0.0, 0.3)),
    )


def test_svg_is_well_formed_and_its_identifiers_are_its_own(drawing):
    one, two = drawing.svg("a"), drawing.svg("b")
    root = ElementTree.fromstring(one)
    assert root.tag.endswith("svg")
    ids = re.findall(r'\bid="([^"]+)"', one)
    assert len(ids) == len(set(ids)) > 10
    assert not set(ids) & set(re.findall(r'\bid="([^"]+)"', two))
    for target in re.findall(r'(?:xlink:href="#|url\(#)([^")]+)', one):
        assert target in ids


def test_the_same_figure_gives_the_same_svg(drawing):
    assert drawing.svg("a") == drawing.svg("a")


def test_limbs_have_three_colours_and_dashes(drawing):
    svg = drawing.svg("a").lower()
    assert len({colour for colour, _ in LIMBS}) == len({dash for _, dash in LIMBS}) == 3
    for colour, _ in LIMBS:
        assert svg.count(colour.lower()) >= 3, "in both panels and the legend"


def test_png_is_a_picture(drawing):
    assert drawing.png().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("largest", "unit", "expected"),
    [
        (0.5, "m", (1.0, "m")),
        (0.02, "m", (1e3, "mm")),
        (3e-5, "m", (1e6, "µm")),
        (0.02, "m/s", (1e3, "mm/s")),
        (0.0, "m", (1.0, "m")),
        (0.02, "N", (1.0, "N")),
        (0.02, "rad", (1.0, "rad")),
    ],
)
def test_units_have_handy_digits(largest, unit, expected):
    assert scaled(np.array([0.1 * largest, -largest]), unit) == expected


def test_page_needs_nothing_else_and_escapes_what_it_shows(drawing):
    table = TextTable(
        "a < b", ("what", "how much [m]"), [("x & y", "1"), ("<script>", "2")], right=("how much [m]",), note="1 < 2"
    )
    html = page(
        "T & T", "lead <b>", [Section("One", ("text <i>", table, Picture(drawing, 'caption "q" & <p>')), level=2)]
    )
    assert "<script" not in html
    for text in (
        "T &amp; T",
        "a &lt; b",
        "x &amp; y",
        "&lt;script&gt;",
        "1 &lt; 2",
        "text &lt;i&gt;",
        "lead &lt;b&gt;",
    ):
        assert text in html
    body = html.replace("http://www.w3.org/", "")
    assert "http" not in body
    assert "src=" not in body
    assert "@import" not in body
    ElementTree.fromstring(html[html.index("<body>") : html.index("</body>") + 7])


def test_verdicts_are_told_by_words_and_marks_too():
    table = TextTable("v", ("verdict",), [(one.cell,) for one in Verdict])
    html = page("t", "l", [Section("s", (table,))])
    assert 'class="verdict good">holds<' in html
    assert 'class="verdict bad">does not hold<' in html
    assert 'class="verdict half">holds with the inferred code only<' in html


def test_without_matplotlib_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"cutjoint\[report\]"):
        figure(Panel("p", TIME, WAVES, "m", "q", NAMES))
