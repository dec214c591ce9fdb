"""The live page's controls of a tool and of a posture, and the named views of all pages, in a real browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.led import with_limits
from kit.led_robots import somewhere
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description, write
from cutjoint.robots import load
from cutjoint.viewer import LiveView, show

pytestmark = pytest.mark.browser

IDLE = "!cutjoint.state.inFlight && !cutjoint.state.wanted && cutjoint.state.last"
SET = """
([id, value]) => {
  const slider = document.getElementById(id);
  slider.value = value;
  slider.dispatchEvent(new Event("input"));
}
"""
BALL = """
() => {
  const { stage, handle } = cutjoint, box = stage.pane.getBoundingClientRect();
  const at = handle.ball.getWorldPosition(new MeshCat.THREE.Vector3()).project(stage.viewer.camera);
  return [box.left + (at.x + 1) / 2 * box.width, box.top + (1 - at.y) / 2 * box.height];
}
"""
WORLD = "const { camera, scene } = cutjoint.stage.viewer, back = scene.quaternion.clone().invert();"
"""meshcat turns the whole scene, because for three.js y is up."""
EYE = f"""
() => {{
  {WORLD}
  return camera.getWorldPosition(new MeshCat.THREE.Vector3()).applyQuaternion(back).toArray();
}}
"""
RIGHT_AND_UP = f"""
() => {{
  {WORLD}
  const column = (i) => new MeshCat.THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i);
  return [0, 1].map((i) => column(i).applyQuaternion(back).toArray());
}}
"""
AGAINST_GRAVITY = f"""
(up) => {{
  {WORLD}
  const turned = new MeshCat.THREE.Vector3(...up).transformDirection(cutjoint.stage.node("robot").matrixWorld);
  return turned.applyQuaternion(back).toArray();
}}
"""


@pytest.fixture
def views() -> Iterator[Callable[[ClosedChain], LiveView]]:
    running: list[LiveView] = []

    def start(chain: ClosedChain) -> LiveView:
        running.append(LiveView(chain, port=0))
        return running[-1]

    yield start
    for view in running:
        view.stop()


@pytest.fixture
def opened(
    views: Callable[[ClosedChain], LiveView], open_tab: Callable[..., Any]
) -> Callable[[ClosedChain], tuple[LiveView, Any]]:
    """The live page of a robot, in a tab."""

    def make(chain: ClosedChain) -> tuple[LiveView, Any]:
        view, tab = views(chain), open_tab()
        tab.go(view.url)
        tab.wait(IDLE)
        return view, tab

    return make


def settle(tab: Any) -> dict[str, Any]:
    state: dict[str, Any] = tab.wait(IDLE)
    return state


def rendered(tab: Any) -> None:
    tab.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def planar(folder: Path) -> ClosedChain:
    return somewhere("planar_3rrr", 0, folder, np.random.default_rng(0)).chain


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stewart", "planar_3rrr"])
def test_a_rotation_is_led_in_degrees(name: str, opened: Callable[..., Any], tmp_path: Path) -> None:
    chain = planar(tmp_path) if name == "planar_3rrr" else load(name)
    _, tab = opened(chain)
    first, before = settle(tab), tab.pixels()
    tab.page.evaluate(SET, ["tool-5", 8.0])
    state = settle(tab)
    assert state["stop"] is None
    assert state["coordinates"]["5"] == pytest.approx(np.radians(8.0), abs=1e-9)
    for row in first["coordinates"]:
        if row != "5":
            assert state["coordinates"][row] == pytest.approx(first["coordinates"][row], abs=1e-9)
    number = tab.page.get_by_label("rz [°]")
    assert number.input_value() == "8.00"
    assert tab.changed(before) > 50
    number.fill("-5.5")
    number.press("Enter")
    tab.wait("Math.abs(cutjoint.state.last.coordinates[5] + 5.5 * Math.PI / 180) < 1e-9")
    assert float(tab.page.locator("#tool-5").input_value()) == pytest.approx(-5.5, abs=1e-6)
    assert tab.errors == []


@pytest.mark.slow
def test_actuators_that_turn_are_in_degrees_too(opened: Callable[..., Any]) -> None:
    view, tab = opened(load("fivebar"))
    home = np.degrees(view.puppet.chain.home.q)
    number = tab.page.get_by_label("left_shoulder [°]")
    assert float(number.input_value()) == pytest.approx(home[0], abs=0.006)
    number.fill(f"{home[0] + 10.0:.9f}")
    number.press("Enter")
    tab.wait(f"Math.abs(cutjoint.state.last.q[0] - {float(np.radians(home[0] + 10.0))!r}) < 1e-9")


@pytest.mark.slow
def test_passive_joints_follow_and_those_at_a_limit_are_marked(opened: Callable[..., Any]) -> None:
    chain = load("fivebar")
    index = chain.model.idx_qs[chain.model.getJointId("left_elbow")]
    elbow = float(chain.home.q_full[index])
    tight = ClosedChain(with_limits(chain.description, {"left_elbow": (elbow - 0.1, elbow + 0.1)}))
    _, tab = opened(tight)
    assert tab.page.locator("#passive tr").count() == 2
    for target in (0.05, 0.6):
        tab.page.evaluate(SET, ["actuated-0", float(np.degrees(chain.home.q[0] + target))])
        state = settle(tab)
        rows = [row.inner_text().split("\t") for row in tab.page.locator("#passive tr").all()]
        for (name, shown), value in zip(rows, state["passive"], strict=True):
            assert float(shown.removesuffix("°")) == pytest.approx(np.degrees(value), abs=0.006)
            assert ("left_elbow" in state["at_limit"]) == (target == 0.6)
            assert name in ("left_elbow", "right_elbow")
        marked = tab.page.locator("#passive .at-limit")
        assert marked.count() == (1 if target == 0.6 else 0)
    assert "left_elbow is at its limit" in tab.page.locator("#message").inner_text()
    assert marked.inner_text() == "left_elbow"


@pytest.mark.slow
def test_many_passive_joints_are_folded_up(opened: Callable[..., Any]) -> None:
    _, tab = opened(load("stewart"))
    assert not tab.page.locator("#passive").is_visible()
    tab.page.click("#passive-section summary")
    assert tab.page.locator("#passive tr").count() == 18
    box, scroll = (tab.page.locator(one).bounding_box() for one in ("#passive", ".scroll"))
    assert scroll["height"] < box["height"]


@pytest.mark.parametrize("name", few(["omega3", "stewart", "fivebar", "fourbar"], "stewart"))
def test_the_tool_is_dragged_and_the_camera_stays(name: str, opened: Callable[..., Any]) -> None:
    view, tab = opened(load(name))
    chain, first = view.puppet.chain, settle(tab)
    rendered(tab)
    eye, (x, y) = tab.page.evaluate(EYE), tab.page.evaluate(BALL)
    tab.page.mouse.move(x, y)
    assert tab.page.locator("#pane").evaluate("(pane) => pane.style.cursor") == "grab"
    tab.page.mouse.down()
    for step in range(1, 5):
        tab.page.mouse.move(x + 3 * step, y - 2 * step)
    tab.page.mouse.up()
    state = settle(tab)
    rendered(tab)
    moved = np.subtract(state["tool"], first["tool"])
    assert np.linalg.norm(moved) > 5e-3 * view.puppet.radius
    assert max(state["gap"]) <= 1e-9
    for row in ("3", "4", "5"):
        if row in first["coordinates"]:
            assert state["coordinates"][row] == pytest.approx(first["coordinates"][row], abs=1e-9)
    if chain.n == len(chain.task.names) == 3 or name == "stewart":  # where the hand is, to a pixel
        np.testing.assert_allclose(tab.page.evaluate(BALL), [x + 12, y - 8], atol=1.5)
    np.testing.assert_allclose(tab.page.evaluate(EYE), eye, atol=1e-9)
    tab.page.mouse.move(40, 200)
    tab.page.mouse.down()
    tab.page.mouse.move(80, 220, steps=3)
    tab.page.mouse.up()
    rendered(tab)
    assert np.linalg.norm(np.subtract(tab.page.evaluate(EYE), eye)) > 0.05
    assert settle(tab)["tool"] == state["tool"]
    assert tab.errors == []


def test_a_robot_without_a_tool_has_no_ball_and_no_sliders_for_it(opened: Callable[..., Any]) -> None:
    _, tab = opened(ClosedChain(replace(load("fivebar").description, tool=None)))
    assert not tab.page.locator("#tool-section").is_visible()
    assert tab.page.evaluate("cutjoint.handle.ball.parent") is None
    assert tab.page.locator("#actuated .slider").count() == 2
    assert tab.errors == []


VIEWS = {"f": ((0, -1, 0), (1, 0, 0)), "s": ((1, 0, 0), (0, 1, 0)), "t": ((0, 0, 1), (1, 0, 0))}
"""Key: where the camera is, and what is to the right."""


def check_views(tab: Any, press: Callable[[str], None]) -> None:
    rendered(tab)
    home = np.array(tab.page.evaluate(EYE))
    for key, (where, right) in VIEWS.items():
        press(key)
        rendered(tab)
        eye, (across, up) = np.array(tab.page.evaluate(EYE)), tab.page.evaluate(RIGHT_AND_UP)
        np.testing.assert_allclose(eye / np.linalg.norm(eye), where, atol=1e-5)
        assert np.linalg.norm(eye) == pytest.approx(np.linalg.norm(home), rel=1e-6)
        np.testing.assert_allclose(across, right, atol=1e-5)
        np.testing.assert_allclose(up, (0, 1, 0) if key == "t" else (0, 0, 1), atol=1e-5)
    press("h")
    rendered(tab)
    np.testing.assert_allclose(tab.page.evaluate(EYE), home, atol=1e-9)


@pytest.mark.slow
def test_named_views_by_key_and_by_button(opened: Callable[..., Any]) -> None:
    _, tab = opened(load("omega3"))
    check_views(tab, tab.page.keyboard.press)
    names = {"f": "Front", "s": "Side", "t": "Top", "h": "Home"}
    check_views(tab, lambda key: tab.page.get_by_role("button", name=names[key], exact=True).click())
    tab.page.mouse.move(40, 200)
    tab.page.mouse.down()
    tab.page.mouse.move(90, 150, steps=3)
    tab.page.mouse.up()
    tab.page.keyboard.press("h")
    check_views(tab, tab.page.keyboard.press)
    eye = tab.page.evaluate(EYE)
    number = tab.page.locator("#actuated input[type=number]").first
    number.focus()
    for key in "fst":
        tab.page.keyboard.press(key)
    tab.page.keyboard.press("Control+f")
    rendered(tab)
    np.testing.assert_allclose(tab.page.evaluate(EYE), eye, atol=1e-9)
    assert tab.errors == []


@pytest.mark.slow
def test_a_written_page_has_the_named_views(open_tab: Callable[..., Any], tmp_path: Path) -> None:
    show(load("fivebar")).save(tmp_path / "robot.html")
    tab = open_tab(offline=True)
    tab.go(f"file://{tmp_path}/robot.html")
    check_views(tab, tab.page.keyboard.press)
    assert tab.errors == []


def test_up_is_against_gravity_whatever_the_axes(opened: Callable[..., Any]) -> None:
    robot = replace(load("fivebar").description, gravity=np.array([0.0, -9.81, 0.0]))
    _, tab = opened(ClosedChain(robot))
    tab.page.keyboard.press("f")
    rendered(tab)
    along = tab.page.evaluate(AGAINST_GRAVITY, [0, 1, 0])
    np.testing.assert_allclose(along, tab.page.evaluate(RIGHT_AND_UP)[1], atol=1e-5)


@pytest.mark.slow
def test_the_posture_is_copied_as_text_that_gives_it_back(opened: Callable[..., Any], tmp_path: Path) -> None:
    chain = load("fivebar")
    view, tab = opened(chain)
    tab.page.evaluate(SET, ["tool-0", settle(tab)["coordinates"]["0"] + 0.03])
    settle(tab)
    tab.page.get_by_role("button", name="As TOML").click()
    tab.wait("document.getElementById('text').value.startsWith('[home.')")
    settle(tab)
    files = write(chain.description, tmp_path)
    text = tab.page.locator("#text").input_value()
    files[0].write_text(files[0].read_text(encoding="utf-8") + "\n" + text, encoding="utf-8")
    again = ClosedChain(load_description(tmp_path / "loops.toml"), "posture")
    np.testing.assert_allclose(again.home.q_full, view.puppet.at.q_full, atol=1e-9)
    assert np.abs(again.home.q_full - chain.home.q_full).max() > 0.01
    tab.page.get_by_role("button", name="As Python").click()
    tab.wait("document.getElementById('text').value.startsWith('at = ')")
    lines = tab.page.locator("#text").input_value().splitlines()
    assert [line.split("(")[0] for line in lines] == ["at = robot.close", "at = robot.reach"]
    for line in lines:
        names: dict[str, Any] = {"robot": chain}
        exec(line, names)
        np.testing.assert_allclose(names["at"].q_full, view.puppet.at.q_full, atol=1e-7)
    assert tab.page.evaluate("document.getElementById('copied').textContent") != ""
    tab.page.click("#home")
    settle(tab)
    assert not tab.page.locator("#text").is_visible()
    assert tab.errors == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 420])
def test_nothing_hangs_over_at_any_width(width: int, opened: Callable[..., Any]) -> None:
    _, tab = opened(load("stewart"))
    tab.page.set_viewport_size({"width": width, "height": 800})
    tab.page.click("#passive-section summary")
    tab.page.get_by_role("button", name="As TOML").click()
    tab.wait("document.getElementById('text').value !== ''")
    settle(tab)
    for box in ("panel", "scene", "views"):
        assert tab.page.evaluate(f"(() => {{ const e = document.getElementById('{box}'); "
                                 "return e.scrollWidth <= e.clientWidth + 1; })()"), box  # fmt: skip
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
