from __future__ import annotations

import time
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cutjoint.chain import ClosedChain
from cutjoint.robots import PUBLISHED
from cutjoint.viewer import Bridge, play, show

pytestmark = pytest.mark.browser


@pytest.fixture
def film(chain: ClosedChain, tmp_path: Path) -> Path:
    target = tmp_path / "film.html"
    play(chain, PUBLISHED[chain.description.name].trajectory()).save(target)
    return target


@pytest.fixture
def cpm_film(cpm: ClosedChain, tmp_path: Path) -> Path:
    target = tmp_path / "film.html"
    play(cpm, PUBLISHED["cpm"].trajectory()).save(target)
    return target


def at(tab: Any, time: float) -> Any:
    tab.page.evaluate(f"() => {{ cutjoint.setPlaying(false); cutjoint.seek({time!r}); }}")
    return tab.pixels()


def test_the_file_plays_with_the_network_off(
    film: Path, open_tab: Callable[..., Any], differing: Callable[..., int]
) -> None:
    tab = open_tab(offline=True)
    tab.go(film.as_uri())
    tab.page.evaluate("cutjoint.seek(0)")  # from wherever it is by now, which may be the end
    tab.wait("cutjoint.player.time > 0.1")
    early = at(tab, 0.1)
    assert differing(early, at(tab, 1.3)) > 500
    assert differing(early, at(tab, 0.1)) < 10
    assert tab.requests == [film.as_uri()]
    assert tab.errors == []


@pytest.mark.slow
def test_it_loops_and_does_not_jump_back_at_the_end(
    cpm_film: Path, open_tab: Callable[..., Any], differing: Callable[..., int]
) -> None:
    tab = open_tab(offline=True)
    tab.go(cpm_film.as_uri())
    duration = tab.page.evaluate("Number(document.getElementById('time').max)")
    end = at(tab, duration)
    assert 3 * differing(at(tab, duration - 0.001), end) < differing(at(tab, 0.8 * duration), end)
    tab.page.evaluate(f"() => {{ cutjoint.seek({duration - 0.05}); cutjoint.setPlaying(true); }}")
    tab.wait(f"cutjoint.player.time < {duration / 2}")
    assert tab.page.evaluate("cutjoint.player.playing") is True
    tab.page.uncheck("#loop")
    tab.page.evaluate(f"() => {{ cutjoint.seek({duration - 0.05}); cutjoint.setPlaying(true); }}")
    tab.wait("!cutjoint.player.playing")
    assert tab.page.evaluate("cutjoint.player.time") == duration
    tab.page.evaluate("() => new Promise((done) => setTimeout(done, 300))")
    assert tab.changed(end) < 10


@pytest.mark.slow
def test_controls_of_the_player(cpm_film: Path, open_tab: Callable[..., Any]) -> None:
    tab = open_tab(offline=True)
    tab.go(cpm_film.as_uri())
    tab.page.click("#play")
    assert tab.page.locator("#play").inner_text() == "Play"
    tab.page.locator("#time").evaluate("(e) => { e.value = 1; e.dispatchEvent(new Event('input')); }")
    assert tab.page.locator("#clock").inner_text().startswith("1.00 / ")
    assert tab.page.evaluate("cutjoint.player.time") == 1
    tab.page.select_option("#speed", "0.1")
    tab.page.click("#play")
    tab.wait("cutjoint.player.time > 1.01")
    tab.page.click("#play")
    for name in tab.page.eval_on_selector_all("#toggles input", "(all) => all.map((e) => e.name)"):
        box = tab.page.locator(f"#toggles input[name='{name}']")
        box.set_checked(not box.is_checked())
    assert tab.page.locator("#legend li").count() == 5
    assert tab.errors == []


def test_a_served_film_plays_under_the_same_rules(cpm: ClosedChain, open_tab: Callable[..., Any]) -> None:
    document = play(cpm, PUBLISHED["cpm"].trajectory())
    with Bridge(document.files(), port=0) as bridge:
        tab = open_tab()
        tab.go(bridge.url)
        tab.wait("cutjoint.player.time > 0.1")
        assert all(url.startswith(bridge.url) for url in tab.requests)
    assert tab.errors == []


def test_a_notebooks_frame_shows_the_robot(cpm: ClosedChain, tmp_path: Path, open_tab: Callable[..., Any]) -> None:
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!DOCTYPE html><meta charset=utf-8><p>a cell</p>{show(cpm)._repr_html_()}")
    tab = open_tab(offline=True)
    tab.page.goto(notebook.as_uri())
    tab.page.frame_locator("iframe").locator("html[data-ready=yes]").wait_for(timeout=60_000)
    colours, until = 0, time.monotonic() + 60.0
    while colours <= 50 and time.monotonic() < until:
        shot = Image.open(BytesIO(tab.page.locator("iframe").screenshot())).convert("RGB")
        colours = len(np.unique(np.asarray(shot).reshape(-1, 3), axis=0))
    assert colours > 50
    assert tab.errors == []


def test_a_picture_is_taken_without_a_screen(
    cpm: ClosedChain, tmp_path: Path, browser: Any, differing: Callable[..., int]
) -> None:
    document = play(cpm, PUBLISHED["cpm"].trajectory())
    pictures = []
    for instant in (0.0, 1.0):
        target = tmp_path / f"{instant}.png"
        assert document.picture(target, time=instant, width=480, height=320) == target.stat().st_size
        pictures.append(np.asarray(Image.open(target).convert("RGB")).astype(int))
    assert pictures[0].shape == (320, 480, 3)
    assert differing(*pictures) > 200
