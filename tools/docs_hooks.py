"""What MkDocs calls while it makes the site (mkdocs.yml): pages that are no documents, and documents as pages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pages import command_line, gallery, markdown, reference

ROOT = Path(__file__).resolve().parents[1]
Config = Any
"""MkDocs' own, whose attributes are made at run time."""


def on_config(config: Config) -> Config:
    """The pages of the rooms, at the place that mkdocs.yml keeps for them."""
    rooms = sorted({part.room for part in reference.parts()}, key=lambda room: (room != reference.PACKAGE, room))
    pages = [{"Overview": "api/index.md"}, *({room: f"api/{room}.md"} for room in rooms)]
    for tab in config.nav:
        for items in tab.values():
            for item in items:
                if "Python" in item:
                    item["Python"] = pages
    return config


def on_files(files: Files, config: Config) -> Files:
    """Adds the pages that are no files of docs/, and the gallery's pictures."""
    made = {f"api/{room}.md": text for room, text in reference.pages().items()}
    made |= {"commands.md": command_line.page(), "gallery.md": gallery.page()}
    made |= {page: (ROOT / name).read_text(encoding="utf-8") for name, page in markdown.ROOT_PAGES.items()}
    for name, text in made.items():
        files.append(File.generated(config, name, content=text))
    for file in gallery.files():
        files.append(File.generated(config, f"gallery/{file.name}", abs_src_path=str(file)))
    return files


def on_page_markdown(text: str, page: Page, config: Config, files: Files) -> str:
    """A document as MkDocs takes it."""
    name = page.file.src_uri
    sources = {there: source for source, there in markdown.ROOT_PAGES.items()}
    rooms = {part.room for part in reference.parts()}
    if name.startswith("api/"):
        return text
    return markdown.links_within(markdown.titled_fences(text), sources.get(name, f"docs/{name}"), rooms)


def on_page_content(html: str, page: Page, config: Config, files: Files) -> str:
    """Its formulas as MathML."""
    return markdown.formulas(html)
