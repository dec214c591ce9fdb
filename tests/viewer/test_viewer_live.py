from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cutjoint.chain import ClosedChain
from cutjoint.viewer import LiveView

pytestmark = pytest.mark.browser

IDLE = "!cutjoint.state.inFlight && !cutjoint.state.wanted && cutjoint.state.last"
SWEEP = """
async ([id, values]) => {
  const slider = document.getElementById(id), found = [];
  for (const value of values) {
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    const until = performance.now() + 20000;
    while ((cutjoint.state.inFlight || cutjoint.state.wanted) && performance.now() < until)
      await new Promise((done) => setTimeout(done, 5));
    found.push(cutjoint.state.last);
  }
  return found;
}
"""


@pytest.fixture
def view(chain: ClosedChain) -> Iterator[LiveView]:
    with LiveView(chain, port=0) as running:
        yield running


@pytest.fixture
def cpm_view(cpm: ClosedChain) -> Iterator[LiveView]:
    with LiveView(cpm, port=0) as running:
        yield running


def settle(tab: Any) -> dict[str, Any]:
    state: dict[str, Any] = tab.wait(IDLE)
    return state


def sweep(tab: Any, slider: str, values: Any) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = tab.page.evaluate(SWEEP, [slider, [float(v) for v in values]])
    return found


def test_the_page_loads_and_a_slider_moves_the_robot(view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(view.url)
    before = tab.pixels()
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 50
    first = settle(tab)
    box = tab.page.locator("#actuated-0").bounding_box()
    tab.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + box["height"] / 2)
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + box["height"] / 2, steps=4)
    tab.page.mouse.up()
    state = settle(tab)
    assert abs(state["q"][0] - first["q"][0]) > 0.01
    assert np.linalg.norm(np.subtract(state["tool"], first["tool"])) > 0.001
    assert max(state["gap"]) <= 1e-9
    assert tab.changed(before) > 300
    shown = [float(tab.page.locator(f"#tool-{axis}").input_value()) for axis in range(3)]
    np.testing.assert_allclose(shown, state["tool"], atol=1e-4)
    assert tab.errors == []
    assert all(url.startswith(view.url) for url in tab.requests)


@pytest.mark.slow
def test_a_sweep_of_the_whole_range_keeps_loops_closed_and_the_branch(
    view: LiveView, open_tab: Callable[..., Any]
) -> None:
    tab = open_tab()
    tab.go(view.url)
    home = settle(tab)
    model = view.puppet.chain.model
    name = {"cpm": "limb{}_elbow", "omega3": "bar{}"}[view.puppet.chain.description.name]
    elbows = [model.idx_qs[model.getJointId(name.format(i))] for i in (1, 2, 3)]
    signs = [math.copysign(1.0, math.sin(view.puppet.at.q_full[i])) for i in elbows]
    stopped = False
    for slider in ("actuated-1", "tool-2"):
        low, high = (float(tab.page.locator(f"#{slider}").get_attribute(end)) for end in ("min", "max"))
        for value in [*np.linspace(low, high, 3), low]:
            (state,) = sweep(tab, slider, [value])
            assert max(state["gap"]) <= 1e-9
            assert state["mode"] == 0
            assert [math.copysign(1.0, math.sin(view.puppet.at.q_full[i])) for i in elbows] == signs
            stopped = stopped or state["stop"] is not None
        tab.page.click("#home")
        settle(tab)
    assert stopped
    np.testing.assert_allclose(settle(tab)["q"], home["q"], atol=1e-12)
    assert tab.errors == []


@pytest.mark.slow
def test_at_an_end_the_slider_stops_and_the_page_says_why(cpm_view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(cpm_view.url)
    settle(tab)
    (state,) = sweep(tab, "tool-0", [0.9])
    assert state["stop"]["kind"] in ("limit", "singularity", "workspace")
    message = tab.page.locator("#message")
    assert message.inner_text() == state["stop"]["text"]
    assert "Stopped at tool x" in message.inner_text()
    assert float(tab.page.locator("#tool-0").input_value()) == pytest.approx(state["tool"][0], abs=1e-3)
    assert state["tool"][0] < 0.9
    sweep(tab, "tool-0", [0.6])
    assert message.inner_text() == ""


@pytest.mark.slow
def test_modes_home_and_typed_numbers(cpm_view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(cpm_view.url)
    home = settle(tab)
    before = tab.pixels()
    tab.page.click("#modes")
    tab.wait("document.querySelectorAll('#mode option').length === 8")
    settle(tab)
    tab.page.select_option("#mode", "3")
    state = settle(tab)
    assert state["mode"] == 3
    np.testing.assert_allclose(state["tool"], home["tool"], atol=1e-9)
    assert tab.changed(before) > 300
    tab.page.click("#home")
    assert settle(tab)["mode"] == 0
    assert tab.changed(before) < 50
    number = tab.page.get_by_label("limb2_slide [m]")
    number.fill("0.4")
    number.press("Enter")
    tab.wait("Math.abs(cutjoint.state.last.q[1] - 0.4) < 1e-12")
    assert tab.errors == []


@pytest.mark.slow
def test_every_toggle_shows_something_and_hides_it_again(cpm_view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(cpm_view.url)
    tab.wait("document.querySelector(\"#toggles input[name='Workspace box']\")")
    before = tab.pixels()
    for box in tab.page.locator("#toggles input").all():
        name = box.get_attribute("name")
        box.check()
        if name == "Tool trail":
            sweep(tab, "tool-1", [settle(tab)["tool"][1] + 0.02])
        if name == "Names":
            assert tab.page.locator(".label").count() == 4
        else:
            assert tab.changed(before) > 20, name
        if name == "Tool trail":
            tab.page.click("#home")
            settle(tab)
        box.uncheck()
        assert tab.changed(before) < 10, name
    assert tab.errors == []


@pytest.mark.slow
def test_two_tabs_show_the_same_posture(cpm_view: LiveView, open_tab: Callable[..., Any]) -> None:
    one, two = open_tab(), open_tab()
    one.go(cpm_view.url)
    two.go(cpm_view.url)
    before = two.pixels()
    sweep(one, "actuated-2", [0.35])
    two.wait("Math.abs(cutjoint.state.last.q[2] - 0.35) < 1e-9")
    assert two.changed(before) > 200
    late = open_tab()
    late.go(cpm_view.url)
    assert late.changed(two.pixels()) < 20
    assert cpm_view.bridge.tabs == 3


def test_text_that_reaches_the_page_is_never_run(
    cpm_view: LiveView, open_tab: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    import umsgpack

    tab = open_tab()
    tab.go(cpm_view.url)
    settle(tab)
    attack = {"type": "set_control", "name": "x", "callback": "window.hacked = 1", "path": ""}
    cpm_view.bridge._send_scene([umsgpack.packb(attack)])
    # whoever tells of the controls tells this: the workspace's sampler does as well, whenever it gets there
    controls = {**cpm_view.panel.controls(), "title": "<img src=x onerror=hacked=1>"}
    monkeypatch.setattr(cpm_view.panel, "controls", lambda: controls)
    cpm_view.bridge.broadcast(controls)
    tab.wait("document.getElementById('title').textContent.includes('onerror')")
    assert tab.page.evaluate("Object.keys(cutjoint.stage.viewer.gui_controllers)") == []
    assert tab.errors == []
    later = "(done) => setTimeout(() => { try { done(eval('1')); } catch (error) { done(error.name); } })"
    assert tab.page.evaluate(f"() => new Promise({later})") == "EvalError"
    assert tab.page.evaluate("typeof window.hacked") == "undefined"


@pytest.mark.slow
def test_a_lost_connection_is_told_and_found_again(cpm: ClosedChain, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    with LiveView(cpm, port=0) as view:
        tab.go(view.url)
        settle(tab)
        port = view.bridge.port
    tab.wait("document.getElementById('message').textContent.includes('lost')")
    with LiveView(cpm, port=port) as again:
        assert again.bridge.port == port
        tab.wait("document.getElementById('message').textContent === '' && window.cutjoint?.state.last")
        assert settle(tab)["mobility"] == 3


@pytest.mark.slow
def test_the_limbs_are_told_apart_by_colour(view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(view.url)
    pixels = tab.pixels().reshape(-1, 1, 3).astype(np.uint8)
    hue, saturation, _ = np.moveaxis(np.asarray(Image.fromarray(pixels).convert("HSV")).reshape(-1, 3), 1, 0)
    bright = hue[saturation > 140]
    for colour in ("#0072b2", "#e69f00", "#009e73"):
        one = np.array([[[int(colour[i : i + 2], 16) for i in (1, 3, 5)]]], dtype=np.uint8)
        wanted = int(np.asarray(Image.fromarray(one).convert("HSV"))[0, 0, 0])
        assert (np.abs(bright.astype(int) - wanted) < 8).sum() > 150, colour


def test_nothing_covers_text(cpm_view: LiveView, open_tab: Callable[..., Any]) -> None:
    tab = open_tab()
    tab.go(cpm_view.url)
    settle(tab)
    script = """() => {
      const seen = [...document.querySelectorAll("#panel h1, #panel h2, #panel label, #panel td, #panel button")]
        .filter((e) => e.offsetParent && e.textContent.trim()).map((e) => [e.textContent, e.getBoundingClientRect()]);
      const bad = [];
      seen.forEach(([a, p], i) => seen.slice(i + 1).forEach(([b, q]) => {
        const across = p.left < q.right - 1 && q.left < p.right - 1;
        if (across && p.top < q.bottom - 1 && q.top < p.bottom - 1) bad.push([a, b]);
      }));
      const panel = document.getElementById("panel");
      return { bad, wide: panel.scrollWidth > panel.clientWidth };
    }"""
    assert tab.page.evaluate(script) == {"bad": [], "wide": False}


def test_stopping_leaves_no_thread(cpm: ClosedChain) -> None:
    before = set(threading.enumerate())
    with LiveView(cpm, port=0):
        assert len(set(threading.enumerate()) - before) == 2
    assert set(threading.enumerate()) == before
