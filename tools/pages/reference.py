"""The reference of Python: a page of Markdown for every public room, which mkdocstrings fills from the docstrings."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import griffe

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src"
PACKAGE = "cutjoint"

MODULES = ("errors", "tables", "tolerances")
"""Rooms that are one module, without `__all__`, and whose classes people meet all the same."""


@dataclass(frozen=True)
class Part:
    """A package or module that offers names.

    Attributes:
        path: as it is imported, such as cutjoint.chain.minimal.
        names: what it offers.
    """

    path: str
    names: tuple[str, ...]

    @property
    def room(self) -> str:
        """The page it is on."""
        return [*self.path.split("."), PACKAGE][1]


def parts() -> list[Part]:
    """All that offer names, the package itself first, then by name."""
    found = [_part(file) for file in sorted(SOURCE.rglob("__init__.py"))]
    found += [_module(f"{PACKAGE}.{name}", SOURCE / PACKAGE / f"{name}.py") for name in MODULES]
    return sorted((part for part in found if part.names), key=lambda part: part.path)


def _part(file: Path) -> Part:
    path = ".".join(file.parent.relative_to(SOURCE).parts)
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return Part(path, tuple(name for name in ast.literal_eval(node.value) if not name.startswith("__")))
    return Part(path, ())


def _module(path: str, file: Path) -> Part:
    body = ast.parse(file.read_text(encoding="utf-8")).body
    names = (node.name for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef))
    return Part(path, tuple(name for name in names if not name.startswith("_")))


def pages() -> dict[str, str]:
    """Room -> its page, as Markdown; `index` says what is where.

    An object that several rooms offer is described in the one it is defined in, else in the first; the others name it.
    """
    package = griffe.load(PACKAGE, search_paths=[str(SOURCE)])
    everything = parts()
    homes: dict[str, tuple[str, str]] = {}
    for part in sorted(everything, key=lambda part: part.path == PACKAGE):
        for name in part.names:
            there = _canonical(package, part, name)
            if there not in homes or (there.startswith(f"{part.path}.") and not there.startswith(homes[there][0])):
                homes[there] = (part.path, name)
    made: dict[str, list[str]] = {}
    for part in everything:
        made.setdefault(part.room, []).extend(_section(package, part, homes))
    index = [
        "# Python",
        "",
        "Every public name, by room, from its docstring.",
        "",
        "| room | what it has |",
        "|---|---|",
    ]
    index += [f"| [{part.path}]({part.room}.md) | {_opening(package, part)} |" for part in everything if _heads(part)]
    return {"index": "\n".join(index) + "\n", **{room: "\n".join(lines) for room, lines in made.items()}}


def _heads(part: Part) -> bool:
    return part.path.count(".") < 2


def _canonical(package: griffe.Object | griffe.Alias, part: Part, name: str) -> str:
    """Where a name is defined; where that is no single place in this package, the name itself."""
    inside = part.path.removeprefix(PACKAGE).strip(".")
    holder = package[inside] if inside else package
    try:
        return str(holder[name].canonical_path)
    except (KeyError, griffe.AliasResolutionError):
        raise SystemExit(f"{part.path} offers {name} in __all__, but where it is from cannot be told") from None


def _opening(package: griffe.Object | griffe.Alias, part: Part) -> str:
    """The first sentence of a part's docstring."""
    inside = part.path.removeprefix(PACKAGE).strip(".")
    said = (package[inside] if inside else package).docstring
    first = said.value.split("\n\n")[0] if said else ""
    return " ".join(first.split())


def _section(package: griffe.Object | griffe.Alias, part: Part, homes: dict[str, tuple[str, str]]) -> Iterator[str]:
    head, below = ("#", "##") if _heads(part) else ("##", "###")
    yield from (f"{head} {part.path}", "", _opening(package, part), "")
    elsewhere = []
    for name in part.names:
        home = homes[_canonical(package, part, name)]
        if home == (part.path, name):
            yield from (f"::: {part.path}.{name}", "    options:", f"      heading_level: {len(below)}", "")
        else:
            elsewhere.append(f'- <span id="{part.path}.{name}"></span>[`{name}`][{home[0]}.{home[1]}], of `{home[0]}`')
    if elsewhere:
        yield from ("Also here:" if len(elsewhere) < len(part.names) else "Here are:", "", *elsewhere, "")
