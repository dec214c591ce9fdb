"""Every page at four sizes, light and dark: nothing off screen, nothing over text, all within reach and to be read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from kit.looks import SIZES, assert_laid_out, faults_of

from cutjoint.chain import ClosedChain
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation import run
from cutjoint.viewer import Document, LiveView, play, show

pytestmark = pytest.mark.browser

QUICK = ((1280, 800), (390, 844))
IDLE = "!cutjoint.state.inFlight && !cutjoint.state.wanted && cutjoint.state.last"


def exact(name: str) -> Document:
    return play(load(name), PUBLISHED[name].trajectory())


def simulated(name: str) -> Document:
    return play(load(name), run(load(name), duration=0.2, every=0.01, joint_limits="ignore"))


def long_names() -> ClosedChain:
    """A robot whose title and actuators have names as long as a sentence, without a space."""
    robot = load("fivebar").description
    words = {name: name + "_of_the_robot_with_the_longest_name_that_anyone_has_given" for name in robot.actuators}
    joints = tuple(replace(joint, name=words.get(joint.name, joint.name)) for joint in robot.joints)
    homes = tuple(replace(home, actuated={words[name]: q for name, q in home.actuated.items()}) for home in robot.homes)
    title = "A-robot-" * 12
    return ClosedChain(replace(robot, joints=joints, homes=homes, actuators=tuple(words.values()), title=title))


PAGES: dict[str, Callable[[], Document]] = {
    "cpm followed exactly": lambda: exact("cpm"),
    "omega3 followed exactly": lambda: exact("omega3"),
    "stewart simulated": lambda: simulated("stewart"),
    "fourbar simulated": lambda: simulated("fourbar"),
    "fivebar still": lambda: show(load("fivebar")),
    "talos still": lambda: show(load("talos")),
}


@pytest.fixture
def written(open_tab: Callable[..., Any], tmp_path: Path) -> Callable[[Document], Any]:
    """A page written to a file and opened, standing still."""

    def open_page(document: Document) -> Any:
        document.save(tmp_path / "page.html")
        tab = open_tab(offline=True)
        tab.go((tmp_path / "page.html").as_uri())
        tab.page.evaluate(
            "() => { cutjoint.setPlaying(false); cutjoint.seek(0.7 * document.getElementById('time').max); }"
        )
        return tab

    return open_page


@pytest.fixture
def live(open_tab: Callable[..., Any]) -> Iterator[Callable[[ClosedChain], Any]]:
    """The live page of a robot, in a tab."""
    running: list[LiveView] = []

    def open_page(chain: ClosedChain) -> Any:
        running.append(LiveView(chain, port=0))
        tab = open_tab()
        tab.go(running[-1].url)
        tab.wait(IDLE)
        return tab

    yield open_page
    for view in running:
        view.stop()


BAD = {
    "beside the screen": "<button style='position: absolute; left: 1270px'>far to the right</button>",
    "the page is": "<div style='width: 3000px'>wide</div>",
    "cut off": "<div style='height: 30px; overflow: hidden'><p style='margin: 40px'>below</p></div>",
    "lies over another": "<p style='position: absolute; top: 0'>one</p><p style='position: absolute; top: 4px'>two</p>",
    "hard to read": "<p style='color: #888'>grey</p>",
    "has no name": "<button aria-hidden=true>✕</button>",
    "too small to touch": "<button style='min-height: 0; height: 20px'>small</button>",
}


def test_faults_are_found(browser: Any) -> None:
    page = browser.new_page()
    style = "body { margin: 8px } button { min-height: 44px } .x { overflow-x: auto; width: 100px }"
    good = "<h1>A page</h1><button>one</button><div class=x><pre>a line that is longer than its box</pre></div>"
    start = f"<!DOCTYPE html><html><head><style>{style}</style></head><body>{good}"
    page.set_content(start)
    assert faults_of(page, QUICK, ["light"]) == []
    for fault, made in BAD.items():
        page.set_content(f"{start}<div style='position: relative'>{made}</div>")
        assert any(fault in one for one in faults_of(page, QUICK, ["light"])), fault
    page.close()


def test_a_written_page_is_laid_out(written: Callable[[Document], Any]) -> None:
    tab = written(simulated("fourbar"))
    assert_laid_out(tab.page, QUICK[:1], ["dark"])
    assert_laid_out(tab.page, QUICK[1:], ["light"])
    assert tab.errors == []


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_written_pages_are_laid_out(name: str, written: Callable[[Document], Any]) -> None:
    tab = written(PAGES[name]())
    assert_laid_out(tab.page)
    boxes = tab.page.locator("#choose input, #toggles input")
    for box in boxes.all():
        box.set_checked(True)
    assert_laid_out(tab.page)
    assert tab.errors == []


@pytest.mark.slow
def test_names_as_long_as_a_sentence_hang_over_nothing(
    written: Callable[[Document], Any], live: Callable[[ClosedChain], Any]
) -> None:
    chain = long_names()
    assert_laid_out(written(play(chain, run(chain, duration=0.1, every=0.01))).page)
    assert_laid_out(live(chain).page)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cpm", "stewart", "omega3", "talos"])
def test_the_live_page_is_laid_out(name: str, live: Callable[[ClosedChain], Any]) -> None:
    tab = live(load(name))
    assert_laid_out(tab.page)
    tab.page.evaluate("() => { for (const one of document.querySelectorAll('#toggles input')) one.click(); }")
    tab.page.locator("#passive-section").evaluate("(section) => { section.open = true; }")
    tab.page.click("#toml")
    tab.wait("document.getElementById('text').value !== ''")
    tab.wait(IDLE)
    tab.page.evaluate("say('trouble', 'A message of the program that takes two lines, because it tells what to do.')")
    assert_laid_out(tab.page)
    assert tab.errors == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cpm", "stewart", "talos"])
def test_what_to_show_is_on_screen_without_scrolling(name: str, live: Callable[[ClosedChain], Any]) -> None:
    tab = live(load(name))
    tab.page.set_viewport_size({"width": 1280, "height": 800})
    for box in tab.page.locator("#toggles label").all():
        place = box.bounding_box()
        assert place["y"] >= 0
        assert place["y"] + place["height"] <= 800


@pytest.mark.slow
def test_the_legend_is_beside_the_robot_where_there_is_little_room(written: Callable[[Document], Any]) -> None:
    tab = written(exact("cpm"))
    for width, height in SIZES:
        tab.page.set_viewport_size({"width": width, "height": height})
        tab.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        legend, scene = (tab.page.locator(one).bounding_box() for one in ("#legend", "#scene"))
        across = legend["x"] < scene["x"] + scene["width"] and scene["x"] < legend["x"] + legend["width"]
        down = legend["y"] < scene["y"] + scene["height"] and scene["y"] < legend["y"] + legend["height"]
        assert (across and down) == (width > 760 and height > 500)
        assert tab.page.locator("#legend li").count() == 5


@pytest.mark.slow
def test_the_panel_folds_away_and_the_colours_change_on_demand(written: Callable[[Document], Any]) -> None:
    tab = written(show(load("fivebar")))
    wide, light = tab.page.locator("#scene").bounding_box()["width"], tab.pixels()
    assert light[:40, -200:].mean() > 200
    tab.page.get_by_role("button", name="Dark colours").click()
    dark = tab.pixels()
    assert dark[:40, -200:].mean() < 90
    tab.page.get_by_role("button", name="Light colours").click()
    assert tab.changed(light) < 10
    tab.page.get_by_role("button", name="Hide the panel").click()
    assert not tab.page.locator("#panel").is_visible()
    assert tab.page.locator("#scene").bounding_box()["width"] == 780 > wide
    tab.page.get_by_role("button", name="Show the panel").click()
    assert tab.page.locator("#scene").bounding_box()["width"] == wide
    assert tab.errors == []


@pytest.mark.slow
def test_the_colours_follow_the_system_and_a_picture_is_light(
    written: Callable[[Document], Any], open_tab: Callable[..., Any], tmp_path: Path
) -> None:
    tab = written(exact("cpm"))
    for scheme in ("dark", "light", "dark"):
        tab.page.emulate_media(color_scheme=scheme)
        tab.wait(f"document.documentElement.dataset.theme === '{scheme}'")
        assert (tab.pixels()[:, :10].mean() < 100) == (scheme == "dark")
    other = open_tab(offline=True)
    other.page.emulate_media(color_scheme="dark")
    other.go((tmp_path / "page.html").as_uri() + "#picture")
    assert other.pixels()[:, :10].mean() > 200


CURVE = "#curves canvas"


@pytest.mark.slow
def test_a_curve_seeks_the_film_and_shows_where_it_is(written: Callable[[Document], Any]) -> None:
    tab = written(exact("cpm"))
    tab.page.set_viewport_size({"width": 1280, "height": 800})
    duration = tab.page.evaluate("Number(document.getElementById('time').max)")
    box = tab.page.locator(CURVE).first.bounding_box()
    times = []
    tab.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 60)
    tab.page.mouse.down()
    times.append(tab.page.evaluate("cutjoint.player.time"))
    tab.page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 60, steps=4)
    times.append(tab.page.evaluate("cutjoint.player.time"))
    tab.page.mouse.up()
    assert 0.0 < times[0] < 0.4 * duration < 0.6 * duration < times[1] < duration
    values = tab.page.locator(".curve-legend output")
    before = values.first.inner_text()
    tab.page.evaluate(f"cutjoint.seek({0.5 * duration})")
    assert values.first.inner_text() != before
    shown = tab.page.locator(CURVE).count()
    tab.page.locator("#curve-tool").check()
    assert tab.page.locator(CURVE).count() == shown + 1
    for box in tab.page.locator("#choose input").all():
        box.uncheck()
    assert tab.page.locator(CURVE).count() == 0
    assert tab.errors == []


LISTENERS = "DOMDebugger.getEventListeners"


def heard(tab: Any, on: str) -> int:
    """How many listeners an object of the page has."""
    session = tab.page.context.new_cdp_session(tab.page)
    found = session.send("Runtime.evaluate", {"expression": on})["result"]["objectId"]
    return len(session.send(LISTENERS, {"objectId": found})["listeners"])


@pytest.mark.slow
def test_curves_that_are_gone_listen_to_nothing(written: Callable[[Document], Any]) -> None:
    tab = written(simulated("fourbar"))
    box = tab.page.locator("#choose input").first
    before = heard(tab, "window")
    for _ in range(4):
        box.click()
    assert heard(tab, "window") == before
    for box in tab.page.locator("#choose input").all():
        box.uncheck()
    assert heard(tab, "window") == before - 2, "curves listen to the printing"
    assert tab.errors == []


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["reduce", "no-preference"])
def test_nothing_moves_unasked_where_motion_is_not_wanted(
    motion: str, open_tab: Callable[..., Any], tmp_path: Path
) -> None:
    simulated("fourbar").save(tmp_path / "page.html")
    tab = open_tab(offline=True)
    tab.page.emulate_media(reduced_motion=motion)
    tab.go((tmp_path / "page.html").as_uri())
    assert tab.page.evaluate("cutjoint.player.playing") == (motion == "no-preference")
    tab.page.get_by_role("button", name="Play" if motion == "reduce" else "Pause").click()
    assert tab.page.evaluate("cutjoint.player.playing") == (motion == "reduce")


FOCUS = """
() => {
  const { activeElement: at } = document, look = getComputedStyle(at), box = at.getBoundingClientRect();
  const again = "reached" in at.dataset, seen = box.width > 0 && box.bottom > 0 && box.top < innerHeight;
  at.dataset.reached = "";
  return [again, seen && look.outlineStyle !== "none" && parseFloat(look.outlineWidth) > 0, at.outerHTML.slice(0, 80)];
}
"""
REACHED = "button, input, select, canvas[tabindex], summary"


@pytest.mark.slow
@pytest.mark.parametrize("page", ["written", "live"])
def test_the_tab_key_reaches_every_control_and_shows_where_it_is(
    page: str, written: Callable[[Document], Any], live: Callable[[ClosedChain], Any]
) -> None:
    tab = written(exact("omega3")) if page == "written" else live(load("omega3"))
    tab.page.set_viewport_size({"width": 1280, "height": 800})
    hidden = []
    for _ in range(100):
        tab.page.keyboard.press("Tab")
        again, seen, what = tab.page.evaluate(FOCUS)
        if again:
            break
        if not seen and not what.startswith("<body"):  # after the last one the page itself is
            hidden.append(what)
    assert hidden == []
    controls = [one for one in tab.page.locator(REACHED).all() if one.is_visible()]
    assert len(controls) > 15
    missed = [one for one in controls if one.get_attribute("data-reached") is None]
    assert [one.evaluate("(one) => one.outerHTML") for one in missed] == []
