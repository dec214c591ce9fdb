"""Hostile names of robots, joints, cuts, homes and files through every command, and into every file that is written."""

from __future__ import annotations

import io
import json
import shutil
import sqlite3
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import numpy as np

from attacks.arguments import outcome, outcome_and_output
from attacks.judging import Attack, Wrong
from cutjoint.description import catalogue

PARTS = (
    *(
        "</script>",
        "<script>alert(1)</script>",
        "<!--",
        "-->",
        "--!>",
        "]]>",
        "&amp;",
        "&lt",
        "<b>",
        '"',
        "'",
        "`",
        "\\",
    ),
    *("</title>", "</style>", "</svg>", "\" onload='x'", "${x}", "{0}", "%s", "$x^2$", "$\\frac{", "_", "[red]", "[/]"),
    *("\n", "\t", "\r", "\x1b[31m", "\x1b]0;x\x07", "\x7f", "\x85", "\u2028", "\u202e", "\u2066", "\u200b", "\ufeff"),
    *(
        "漢字",
        "é\u0301",
        "🦾",
        "عربي",
        "\ud7ff\ue000",
        "../",
        "/",
        ".",
        "#",
        ";",
        ",",
        "=",
        " ",
        "  ",
        "a",
        "crank",
        "nan",
    ),
)
"""What names are put together of."""
WHERE = ("robot", "title", "joint", "link", "cut", "home", "source")
"""What of a robot may have such a name."""
IN_XML = ("joint", "link")
NOT_IN_XML = dict.fromkeys([*range(9), 11, 12, *range(14, 32), 0xFFFE, 0xFFFF])
"""Characters that no XML can hold."""
RUN = ["simulate", "{robot}", "--plant", "chain", "--duration", "0.02", "--save", "{stem}.npz"]
COMMANDS: Mapping[str, list[str]] = {
    "info": ["{robot}", "--no-modes"],
    "info-json": ["{robot}", "--no-modes", "--json"],
    "check": ["{robot}"],
    "check-json": ["{robot}", "--json"],
    "cut": ["{robot}", "-o", "{stem}-cut"],
    "cut-json": ["{robot}", "--json"],
    "new": ["{stem}"],
    "new-json": ["leg1", "-o", "{stem}-new", "--json"],
    "simulate": ["{robot}", "--plant", "chain", "--duration", "0.01", "--reactions", "{stem}.csv"],
    "simulate-json": ["{robot}", "--free", "--plant", "chain", "--duration", "0.01", "--json", "--save", "{stem}.csv"],
    "plot": ["{stem}.npz", "--robot", "{robot}"],
    "plot-html": ["{stem}.npz", "-o", "{stem}.html", "--robot", "{robot}", "--what", "joints,reactions"],
    "plot-two": ["{stem}.npz", "b.npz", "-o", "{stem}.svg"],
    "report": ["{stem}.npz", "--robot", "{robot}"],
    "report-two": ["{stem}.npz", "b.npz"],
    "states": ["{stem}.npz", "-o", "{stem}.jsonl", "--robot", "{robot}"],
    "states-bag": ["{stem}.npz", "-o", "{stem}-bag", "--robot", "{robot}"],
    "view": ["{robot}", "--html", "{stem}.html"],
    "play": ["{stem}.npz", "--html", "{stem}.html"],
    "play-trajectory": ["{robot}", "--trajectory", "hold:0.1", "--html", "{stem}.html"],
    **{f"export-{kind}": ["{robot}", "--to", kind, "-o", "{stem}-" + kind] for kind in ("loops", "gepetto")},
    **{
        f"export-{kind}": ["{robot}", "--to", kind, "-o", f"{{stem}}.{ending}"]
        for kind, ending in (("urdf", "urdf"), ("mjcf", "xml"), ("sdf", "sdf"))
    },
}
"""Name of what is tried, the command before the `-` -> its arguments."""


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` names, each in one of the places of a robot and in the name of a file, through one command."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        name, where = _name(rng), WHERE[int(rng.integers(len(WHERE)))]
        what = [*COMMANDS][number % len(COMMANDS)]
        place = folder / f"{seed}-{number}"
        yield Attack(
            f"names {seed}:{number} ({what}, {where} {name[:60]!a})", partial(_tried, rng, what, where, name, place)
        )


def _name(rng: np.random.Generator) -> str:
    if not rng.integers(25):
        return str(rng.choice(["x", "漢", "<", "&"])) * 100_000
    return "".join(PARTS[int(rng.integers(len(PARTS)))] for _ in range(int(rng.integers(1, 5))))


def _tried(rng: np.random.Generator, what: str, where: str, name: str, folder: Path) -> str:
    folder.mkdir()
    try:
        robot, stem = _robot(folder, where, name), "run"
        if rng.integers(2):
            stem = _file_name(rng, name)
        words = [one.format(robot=robot, stem=stem) for one in COMMANDS[what]]
        if "{stem}.npz" in COMMANDS[what]:
            made = outcome([one.format(robot=robot, stem="run") for one in RUN], folder)
            if made != "done":
                return made
            shutil.copy(folder / "run.npz", folder / "b.npz")
            (folder / "run.npz").rename(folder / f"{stem}.npz")
        before = {file for file in folder.rglob("*") if file.is_file()}
        came, out = outcome_and_output([what.partition("-")[0], *words], folder)
        if came == "done" and what.endswith("-json"):
            json.loads(out)
        for file in sorted({one for one in folder.rglob("*") if one.is_file()} - before):
            _judge_file(file)
        left = [file.name for file in folder.rglob(".*")]
        if left and not stem.startswith("."):
            raise Wrong(f"left over: {left}")
        return came
    finally:
        shutil.rmtree(folder)


def _file_name(rng: np.random.Generator, name: str) -> str:
    """A name that a file may have."""
    if not rng.integers(8):
        return "a\udcff"  # a byte that is no UTF-8
    made = name.replace("/", "-").replace("\0", "")[:40]
    return made.lstrip("-. ") or "run"


def _robot(folder: Path, where: str, name: str) -> str:
    """A four-bar in `folder` in which one thing is called `name`."""
    source, place = catalogue.path("fourbar").parent, folder / "robot"
    place.mkdir()
    if where in IN_XML:
        name = name.translate(NOT_IN_XML)
    tree, loops = ((source / one).read_text(encoding="utf-8") for one in ("robot.urdf", "loops.toml"))
    told = _toml(name)
    old = {"robot": "fourbar", "joint": "crank", "link": "crank_link", "cut": "coupler_to_rocker"}.get(where, "")
    if old:
        loops = loops.replace(f'"{old}"', told)
    if where == "joint":
        loops = loops.replace("{ crank =", f"{{ {told} =")
    if where == "home":
        loops = loops.replace("home.default", f"home.{told}")
    if where in ("title", "source"):
        loops = "\n".join(f"{where} = {told}" if one.startswith(f"{where} =") else one for one in loops.split("\n"))
    if where in IN_XML:
        tree = tree.replace(f'"{old}"', _attribute(name))
    (place / "robot.urdf").write_text(tree, encoding="utf-8")
    (place / "loops.toml").write_text(loops, encoding="utf-8")
    return "robot"


def _toml(text: str) -> str:
    """A string of TOML, all that is not plain escaped."""
    return '"' + "".join(one if one.isalnum() and one.isascii() else f"\\U{ord(one):08x}" for one in text) + '"'


def _attribute(text: str) -> str:
    """An attribute of XML, all that is not plain escaped."""
    return '"' + "".join(one if one.isalnum() and one.isascii() else f"&#{ord(one)};" for one in text) + '"'


class _Page(HTMLParser):
    """Counts what could act on a page, and sees what is in its frames."""

    def __init__(self) -> None:
        super().__init__()
        self.bad: list[str] = []
        self.frames: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name.startswith("on"):
                self.bad.append(f"{tag} {name}")
            if name == "srcdoc":
                self.frames.append(value or "")
        if tag == "script" and any(name == "src" for name, _ in attrs):
            self.bad.append("script src")

    def handle_data(self, data: str) -> None:
        if self.lasttag == "script" and data.startswith("alert"):
            self.bad.append("script alert")


def _judge_file(file: Path) -> None:
    """Whether a file that was written is what its name says, and nothing in it acts that only is a name."""
    data = file.read_bytes()
    if not data:
        raise Wrong(f"{file.name!a} is empty")
    kind = file.suffix
    if kind in (".html", ".svg", ".urdf", ".xml", ".sdf", ".toml", ".json", ".jsonl", ".csv", ".md", ".yaml"):
        text = data.decode()  # UTF-8
        if kind in (".svg", ".urdf", ".xml", ".sdf"):
            tree = ET.fromstring(text)
            if kind == ".svg" and any(one.tag.endswith("script") for one in tree.iter()):
                raise Wrong(f"{file.name!a}: a script in a picture")
        elif kind == ".html":
            _judge_page(text)
        elif kind == ".toml":
            tomllib.loads(text)
        elif kind == ".json":
            json.loads(text)
        elif kind == ".jsonl":
            for line in text.split("\n")[:-1]:
                json.loads(line)
        elif kind == ".csv":
            import csv

            if len({len(row) for row in csv.reader(io.StringIO(text, newline=""))}) != 1:
                raise Wrong(f"{file.name!a}: rows of different lengths")
    elif kind == ".db3":
        with sqlite3.connect(file) as store:
            store.execute("select count(*) from messages")


def _judge_page(text: str) -> None:
    page = _Page()
    page.feed(text)
    if page.bad:
        raise Wrong(f"a page in which a name acts: {page.bad}")
    for one in page.frames:
        _judge_page(one)
