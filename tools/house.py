"""Checks the house: sizes, names and loose types of the source; `--page` writes docs/house.md, the map of it.

    python tools/house.py [SOURCE]         exit status 1 and a line per offence
    python tools/house.py --page           writes the map

What is larger than the limits says why, in a comment `# long: ...` right above the class or function (above its
decorators), or for a module in its first lines.  Rules about who may import whom are in tools/layers.py.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import layers

MODULE_LINES = 350
CLASS_METHODS = 15
FUNCTION_LINES = 60
ANY_USES = 10
CODE_LINES = 61_400
"""Of the whole source, without blank lines, comments and docstrings, on which nobody should save.  A ratchet: lower it
when the source gets shorter; raise it for what the source can do, not for how it does it."""
REASON = re.compile(r"\s*# long: \S")
HEAD = 40
"""Lines of a module among which its reason may stand."""

FILE = Path(__file__).resolve().parents[1] / "docs" / "house.md"
BEGIN = "<!-- rooms: written by `tools/house.py --page` -->"
END = "<!-- end of the rooms -->"

Function = ast.FunctionDef | ast.AsyncFunctionDef


def offences(source: Path) -> list[str]:
    """Every broken rule of the package at `source`, a line each."""
    lines: list[str] = []
    classes: dict[str, list[str]] = defaultdict(list)
    uses: dict[str, int] = {}
    total = 0
    for file in sorted(source.rglob("*.py")):
        where = str(file.relative_to(source.parent))
        text = file.read_text(encoding="utf-8")
        rows, tree = text.splitlines(), ast.parse(text)
        total += code_lines(rows, tree)
        if len(rows) > MODULE_LINES and not any(REASON.match(row) for row in rows[:HEAD]):
            lines.append(f"{where}: {len(rows)} lines, more than {MODULE_LINES}")
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                classes[node.name].append(f"{where}:{node.lineno}")
            if isinstance(node, ast.ClassDef | Function) and not _explained(node, rows):
                lines += [f"{where}:{node.lineno}: {what}" for what in _too_long(node)]
        if count := sum(_is_any(node) for node in ast.walk(tree)):
            uses[where] = count
    lines += [f"class {name} stands {len(at)} times: {', '.join(at)}" for name, at in classes.items() if len(at) > 1]
    if sum(uses.values()) > ANY_USES:
        most = sorted(uses, key=lambda where: -uses[where])
        told = ", ".join(f"{where} {uses[where]}" for where in most[:12])
        lines.append(f"`Any` is used {sum(uses.values())} times, more than {ANY_USES}: {told}, ...")
    if total > CODE_LINES:
        lines.append(f"the source has {total} lines of code, more than {CODE_LINES}: what can go?")
    return lines


def code_lines(rows: Sequence[str], tree: ast.AST) -> int:
    """How many lines of a module are neither blank nor comment nor docstring."""
    told = set[int]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | Function) and ast.get_docstring(node, clean=False) is not None:
            first = node.body[0]
            assert first.end_lineno is not None
            told |= set(range(first.lineno, first.end_lineno + 1))
    kept = (row.strip() for number, row in enumerate(rows, start=1) if number not in told)
    return sum(bool(row) and not row.startswith("#") for row in kept)


def _too_long(node: ast.ClassDef | Function) -> Iterator[str]:
    """What is too long about a class or function."""
    if isinstance(node, ast.ClassDef):
        methods = sum(isinstance(one, Function) for one in node.body)
        if methods > CLASS_METHODS:
            yield f"class {node.name} has {methods} methods, more than {CLASS_METHODS}"
    else:
        assert node.end_lineno is not None
        length = node.end_lineno - node.lineno + 1
        if length > FUNCTION_LINES:
            yield f"{node.name}() has {length} lines, more than {FUNCTION_LINES}"


def _explained(node: ast.ClassDef | Function, rows: Sequence[str]) -> bool:
    """Whether the reason stands above a class or function, in a comment of any number of lines."""
    above = min([node.lineno, *(one.lineno for one in node.decorator_list)]) - 2
    while above >= 0 and rows[above].lstrip().startswith("#"):
        if REASON.match(rows[above]):
            return True
        above -= 1
    return False


def _is_any(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Name | ast.Attribute) and (node.id if isinstance(node, ast.Name) else node.attr) == "Any"
    )


def page(text: str) -> str:
    """The map with its table of rooms as the source is now."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{FILE} lacks the line '{BEGIN}' or '{END}'")
    return f"{before}{BEGIN}\n\n{rooms(layers.SOURCE)}\n{END}{after}"


def rooms(source: Path) -> str:
    """A table of all rooms and the folders in them: what each is for, and which rooms it may import."""
    lines = ["| room | holds | imports |", "|---|---|---|"]
    for room, allowed in layers.ALLOWED.items():
        file, folder = source / f"{room}.py", source / room
        if room in (layers.PACKAGE, "__main__"):
            continue
        shown = file if file.is_file() else folder / "__init__.py"
        others = [f"{one}" for one in sorted(allowed - layers.BASE) if one != room]
        base = "the base" if layers.BASE & allowed else ""
        told = ", ".join([base, *others] if base else others)
        lines.append(f"| `{room}{'' if file.is_file() else '/'}` | {_first_sentence(shown)} | {told} |")
        for inner in sorted(folder.rglob("__init__.py")) if folder.is_dir() else ():
            if inner != shown:
                name = inner.parent.relative_to(source).as_posix()
                lines.append(f"| \u2003`{name}/` | {_first_sentence(inner)} | |")
    base = ", ".join(f"`{one}`" for one in sorted(layers.BASE))
    return "\n".join([*lines, "", f"The base is {base}.", ""])


def _first_sentence(file: Path) -> str:
    """What a module says of itself first."""
    said = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return re.split(r"(?<=[.;])\s", " ".join(said.split("\n\n")[0].split()))[0].rstrip(";.").replace("|", "\\|")


def main(arguments: Sequence[str]) -> int:
    """Check the package at the path given, or cutjoint's own source, or write the map; the exit status."""
    if list(arguments) == ["--page"]:
        fresh = FILE.with_suffix(".new")
        fresh.write_text(page(FILE.read_text(encoding="utf-8")), encoding="utf-8")
        fresh.replace(FILE)
        return 0
    lines = offences(Path(arguments[0]) if arguments else layers.SOURCE)
    for line in lines:
        print(line)
    print(f"house: {len(lines)} offence{'' if len(lines) == 1 else 's'}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
