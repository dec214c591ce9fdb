"""Pages of curves and of runs in a real browser: laid out on every screen, read off, enlarged, and fetching nothing."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.looks import assert_laid_out
from kit.runs import made

from cutjoint.report import Panel, Section, ToolPath, figure, page, plot, run_report
from cutjoint.report.page import Picture
from cutjoint.robots import load
from cutjoint.simulation import run
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

pytestmark = pytest.mark.browser
TIME = np.linspace(0.0, 2.0, 60)


@pytest.fixture
def opened(open_tab: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """A page that can `save` itself, in a tab without a network."""

    def open_page(page: Any) -> Any:
        tab = open_tab(offline=True)
        tab.go(page.save(tmp_path / "page.html").as_uri())
        return tab

    return open_page


def values(tab: Any, chart: int = 0) -> list[float]:
    """What the legend of a chart reads off."""
    read = tab.page.locator(".curve").nth(chart).locator("output").all_text_contents()
    return [float(one.replace("−", "-")) for one in read]


def test_curves_are_read_off_enlarged_and_switched_off(opened: Callable[..., Any]) -> None:
    result = made(kinds="r", tool=np.column_stack([np.cos(TIME), np.sin(TIME), TIME]))
    tab = opened(plot(result, "tool,effort"))
    drawn = "document.querySelector('.charts').drawn"
    box = tab.page.locator("canvas").first.bounding_box()
    tab.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    at = tab.page.evaluate(f"{drawn}.view.at")
    assert 1.0 < at < 1.4
    np.testing.assert_allclose(values(tab), [np.cos(at), np.sin(at), at], atol=2e-3)  # 3 digits of a range of 2
    assert tab.page.locator(".curve").nth(1).locator("output").first.text_content(), "all charts have the same cursor"

    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.5 * box["height"])
    tab.page.mouse.up()
    start, end = tab.page.evaluate(f"[{drawn}.view.from, {drawn}.view.to]")
    assert start == pytest.approx(at, abs=1e-9)
    assert end == pytest.approx(at + 0.4, abs=0.05)
    tab.page.get_by_role("button", name="Whole run").click()
    assert tab.page.evaluate(f"[{drawn}.view.from, {drawn}.view.to]") == [0.0, 2.0]

    key = tab.page.locator(".curve-legend button").first
    key.click()
    assert key.get_attribute("aria-pressed") == "false"
    assert tab.errors == []
    assert [one for one in tab.requests if not one.startswith("file:")] == []


def test_keys_move_the_cursor(opened: Callable[..., Any]) -> None:
    tab = opened(plot(made(), "tool"))
    tab.page.locator("canvas").first.focus()
    for key, expected in (("End", 2.0), ("ArrowLeft", 1.99), ("Home", 0.0), ("Shift+ArrowRight", 0.1)):
        tab.page.keyboard.press(key)
        assert tab.page.evaluate("document.querySelector('.charts').drawn.view.at") == pytest.approx(expected)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 6, 30])
def test_pages_of_curves_are_laid_out(n: int, opened: Callable[..., Any]) -> None:
    assert_laid_out(opened(plot(made(n=n, about={"limits": 11.0}))).page)


@pytest.mark.slow
def test_pages_of_several_runs_are_laid_out(opened: Callable[..., Any]) -> None:
    drifting = made(kinetic=TIME, about={"robot": "made", "law": "a law with a name that is long " * 3})
    tab = opened(run_report({"first": made(), "second_with_a_long_name_of_a_file": drifting, "third": made(1)}))
    assert_laid_out(tab.page)
    assert tab.errors == []


@pytest.mark.slow
def test_a_page_of_a_run_moves_its_robot(opened: Callable[..., Any]) -> None:
    chain = load("fourbar")
    tab = opened(run_report(run(chain, duration=0.2, every=0.01)))
    tab.page.locator("iframe").scroll_into_view_if_needed()
    frame = next(one for one in tab.page.frames if one != tab.page.main_frame)
    for _ in range(600):
        tab.page.wait_for_timeout(50)
        if frame.evaluate("document.documentElement.dataset.ready") == "yes":
            break
    assert frame.evaluate("cutjoint.player.playing")
    assert_laid_out(tab.page)
    assert tab.errors == []
    assert [one for one in tab.requests if one.startswith("http")] == []


def of_papers() -> str:
    """A page as `cutjoint reproduce` writes it, with one of everything."""
    round_ = np.column_stack([np.cos(3 * TIME), np.sin(3 * TIME), TIME])
    over_time = Panel("Over time", TIME, round_, "m", "place", ["limb 1", "limb 2", "limb 3"])
    drawn = figure(over_time, ToolPath("In a plane", "xy", round_, 0.98 * round_))
    grades = [(grade, "a claim of a paper, in words", Cell(grade, grade)) for grade in ("good", "half", "bad")]
    wide = TextTable(
        "Numbers", ("name", *(f"column {i}" for i in range(12))), [("a", *["1.2345e-06"] * 12)], ("column 1",)
    )
    return page(
        "Of the papers",
        "What this page shows.",
        [
            Section("First", ["A paragraph.", TextTable("Claims", ("no", "claim", "verdict"), grades), wide], 2),
            Section("Second, of the first", [Picture(drawn, "Figure 1: what was drawn.")]),
        ],
    )


def test_a_page_about_papers_is_laid_out_and_its_figures_suit_the_dark(
    open_tab: Callable[..., Any], tmp_path: Path
) -> None:
    tab = open_tab(offline=True)
    (tmp_path / "page.html").write_text(of_papers(), encoding="utf-8")
    tab.page.goto((tmp_path / "page.html").as_uri())
    assert_laid_out(tab.page)
    for theme, plate, ink in (("light", "#ffffff", "#222222"), ("dark", "#16191d", "#e8eaed")):
        tab.page.emulate_media(color_scheme=theme)
        fills = tab.page.evaluate(
            "[...document.querySelectorAll('figure svg *')].map((one) => getComputedStyle(one).fill)"
        )
        numbers = [[int(one) for one in re.findall(r"\d+", fill)[:3]] for fill in fills if fill.startswith("rgb")]
        used = {f"#{bytes(one).hex()}" for one in numbers}
        assert plate in used
        assert ink in used
        assert theme == "light" or not used & {"#ffffff", "#222222"}, "colours of a light page"
    assert tab.errors == []
