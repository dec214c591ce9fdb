"""The documents as pages: nothing is left out of them, and they can be looked at anywhere, without a network."""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from cutjoint.cli import COMMANDS
from cutjoint.viewer.browser.camera import find_browser, flags
from cutjoint.viewer.browser.keeper import make_folder

ROOT = Path(__file__).resolve().parents[2]
for needed in ("mkdocs", "mkdocstrings", "latex2mathml"):
    pytest.importorskip(needed, reason=f"{needed} is not installed (extra docs)")

SIZES = {"desk": (1280, 800), "phone": (390, 844)}
LOOKED_AT = (
    "index.html",
    "overview.html",
    "leading.html",
    "corpus.html",
    "commands.html",
    "gallery.html",
    "tutorials/from-pinocchio.html",
    "api/chain.html",
    "api/simulation.html",
)


def module(name: str) -> ModuleType:
    """A module of tools/pages."""
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        return importlib.import_module(f"pages.{name}")
    finally:
        sys.path.remove(str(ROOT / "tools"))


def test_every_document_is_in_the_navigation() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    there = sorted(file.relative_to(ROOT / "docs").as_posix() for file in (ROOT / "docs").rglob("*.md"))
    assert [name for name in there if f": {name}\n" not in navigation] == []


@pytest.mark.slow
def test_every_public_name_is_in_the_reference() -> None:
    reference = module("reference")
    text = "\n".join(reference.pages().values())
    rooms = {"cutjoint": importlib.import_module("cutjoint")}
    for file in (ROOT / "src/cutjoint").rglob("__init__.py"):
        name = ".".join(file.relative_to(ROOT / "src").parent.parts)
        rooms[name] = importlib.import_module(name)
    offered = [
        f"{room}.{name}"
        for room, module in rooms.items()
        for name in getattr(module, "__all__", ())
        if not name.startswith("_")
    ]
    assert len(offered) > 150
    missing = [name for name in offered if f"::: {name}\n" not in text and f'id="{name}"' not in text]
    assert missing == []
    described = re.findall(r"^::: (\S+)", text, flags=re.MULTILINE)
    assert len(described) == len(set(described))


def test_every_command_and_option_is_in_the_reference() -> None:
    import typer

    from cutjoint.cli import app

    page = module("command_line").page()
    group = typer.main.get_command(app)
    for name in COMMANDS:
        section = page.partition(f"\n## cutjoint {name}\n")[2].partition("\n## ")[0]
        options = [word for one in group.commands[name].params for word in one.opts if word.startswith("--")]  # type: ignore[attr-defined]
        assert [word for word in options if word not in section] == [], name


@pytest.mark.parametrize(
    ("source", "link", "becomes"),
    [
        ("docs/chain.md", "[a](motion.md#laws)", "[a](motion.md#laws)"),
        ("docs/README.md", "[a](../README.md)", "[a](overview.md)"),
        ("docs/tutorials/x.md", "[a](../../README.md#b)", "[a](../overview.md#b)"),
        ("docs/tutorials/x.md", "[a](../chain.md)", "[a](../chain.md)"),
        ("README.md", "![a](docs/pictures/a.png) [d](docs/chain.md)", "![a](pictures/a.png) [d](chain.md)"),
        ("README.md", "[a](LICENSE)", "a"),
        ("CONTRIBUTING.md", "[a](docs/) [b](README.md)", "[a](README.md) [b](overview.md)"),
        ("docs/chain.md", "[a](../src/cutjoint/mechanism/task.py)", "[a](api/mechanism.md)"),
        ("docs/chain.md", "[a](../src/cutjoint/files.py)", "a"),
        ("docs/chain.md", "[`a/b`](../examples/x.py) and [`c`](motion.md)", "`a/b` and [`c`](motion.md)"),
        ("docs/chain.md", "```py\n[a](b.c)\n```\n`x`[y](z.md)", "```py\n[a](b.c)\n```\n`x`[y](z.md)"),
        ("docs/chain.md", "[a](https://a.b/c) `[b](c)`", "[a](https://a.b/c) `[b](c)`"),
    ],
)
def test_links_lead_from_page_to_page(source: str, link: str, becomes: str) -> None:
    assert module("markdown").links_within(link, source, {"mechanism"}) == becomes


def test_exercises_say_where_their_code_goes() -> None:
    text = (
        "```python new=control/lead.py\nx\n```\n\n```python row=a.py table=B\nx\n```\n\n```console exercise\n$ x\n```\n"
    )
    shown = module("markdown").titled_fences(text)
    assert '```python title="src/cutjoint/control/lead.py (new)"\n' in shown
    assert '```python title="src/cutjoint/a.py, in B"\n' in shown
    assert "```console\n" in shown


def test_formulas_are_drawn_by_the_browser_itself() -> None:
    within = r'<p><span class="arithmatex">\(a &lt; b\)</span></p>'
    page = within + r'<div class="arithmatex">\[\begin{bmatrix} 1 \end{bmatrix}\]</div>'
    drawn = module("markdown").formulas(page)
    assert drawn.count("<math") == 2
    assert 'class="matrix"' in drawn
    assert "arithmatex" not in drawn


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, made anew."""
    folder = tmp_path_factory.mktemp("site")
    made = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert made.returncode == 0, made.stderr[-3000:]
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    chromium = find_browser()
    if chromium is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    folder = make_folder(tempfile.gettempdir())
    with api.sync_playwright() as play:
        running = play.chromium.launch(executable_path=chromium, args=flags(), env={**os.environ, "TMPDIR": folder})
        yield running
        running.close()
    shutil.rmtree(folder, ignore_errors=True)


def opened(browser: Any, page: Path, size: str = "desk", scheme: str = "light") -> tuple[Any, list[str]]:
    """A tab with a page opened as a file, and all that it asks for elsewhere or complains of."""
    width, height = SIZES[size]
    tab = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme).new_page()
    wrong: list[str] = []
    tab.on(
        "request",
        lambda request: None if request.url.startswith(("file:", "data:", "about:")) else wrong.append(request.url),
    )
    tab.on("requestfailed", lambda request: wrong.append(f"{request.url} failed"))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.goto(page.as_uri())
    return tab, wrong


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_pages_fit_their_screen_and_ask_nobody(browser: Any, site: Path, size: str, scheme: str) -> None:
    for name in LOOKED_AT:
        tab, wrong = opened(browser, site / name, size, scheme)
        tab.wait_for_timeout(200)
        wide, there = tab.evaluate("[document.documentElement.scrollWidth, innerWidth]")
        assert wide <= there, name
        # What is wider than the page scrolls by itself: nothing that is seen reaches beyond the screen but inside that.
        beyond = tab.evaluate(
            """() => [...document.querySelectorAll('.md-content article *')].filter(one => {
                const box = one.getBoundingClientRect()
                if (!box.width || box.right <= innerWidth + 1) return false
                for (let up = one.parentElement; up; up = up.parentElement)
                    if (['auto', 'scroll', 'hidden'].includes(getComputedStyle(up).overflowX) && up !== document.body) {
                        if (up.getBoundingClientRect().right <= innerWidth + 1) return false
                    }
                return true
            }).map(one => one.outerHTML.slice(0, 80))"""
        )
        assert beyond == [], name
        bright = tab.evaluate(
            "getComputedStyle(document.body).backgroundColor.match(/[0-9.]+/g).slice(0, 3).reduce((a, b) => a + +b, 0)"
        )
        assert (bright > 600) is (scheme == "light"), name
        assert wrong == [], name
        tab.context.close()


@pytest.mark.slow
@pytest.mark.browser
def test_search_finds_a_robot_in_pages_opened_as_files(browser: Any, site: Path) -> None:
    tab, wrong = opened(browser, site / "tutorials/from-pinocchio.html")
    tab.keyboard.press("/")
    tab.keyboard.type("stewart")
    tab.wait_for_selector(".md-search-result__link")
    found = tab.locator(".md-search-result__link").evaluate_all("links => links.map(link => link.href)")
    assert len(found) >= 5
    assert all((site / link.split("/", 3)[-1].partition("?")[0].partition("#")[0]).name for link in found)
    tab.locator(".md-search-result__link").first.click()
    tab.wait_for_load_state()
    assert "tewart" in tab.locator("article").inner_text()
    assert wrong == []


@pytest.mark.slow
def test_every_public_name_has_its_place_on_a_page(site: Path) -> None:
    """Links into the reference stay: each name has the anchor that it is imported by."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in (site / "api").glob("*.html"))
    anchors = set(re.findall(r'id="([^"]+)"', text))
    missing = [
        f"{part.path}.{name}"
        for part in module("reference").parts()
        for name in part.names
        if f"{part.path}.{name}" not in anchors
    ]
    assert missing == []


@pytest.mark.slow
def test_gallery_shows_what_was_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = subprocess.run(
        [sys.executable, "tools/gallery.py", "--output", str(tmp_path), "--only", "fivebar", "new-delta"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert made.returncode == 0, made.stderr[-3000:]
    robots = json.loads((tmp_path / "gallery.json").read_text())
    assert [robot["mobility"] for robot in robots] == ["mobility 2, 2 motors, 1 cut joint", robots[1]["mobility"]]
    assert robots[1]["mobility"].startswith("mobility 3, 3 motors")
    gallery = module("gallery")
    monkeypatch.setattr(gallery, "FOLDER", tmp_path)
    monkeypatch.setattr(gallery, "LIST", tmp_path / "gallery.json")
    page = gallery.page()
    for robot in robots:
        assert (tmp_path / robot["page"]).stat().st_size > 100_000
        assert f'href="gallery/{robot["page"]}"' in page
        if robot["picture"]:
            assert (tmp_path / robot["picture"]).read_bytes().startswith(b"\x89PNG")
            assert f'src="gallery/{robot["picture"]}"' in page
