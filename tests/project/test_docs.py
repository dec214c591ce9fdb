"""The documents: links lead somewhere, what they show runs, nothing is left out of the index."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)|!\[[^\]]*\]\(([^)\s]+)\)")
# Commands that stay open until they are interrupted, unless one of these options makes them write a file.
STAYING = {"view", "play"}
WRITING = {"--html", "--png", "--help"}


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, the line of its first row.

    The language of a block that says more, as those of the guides' exercises do, is all that it says.
    """

    language: str
    text: str
    line: int


def blocks(text: str) -> list[Block]:
    found: list[Block] = []
    language: str | None = None
    fence, start, rows = "", 0, list[str]()
    for number, row in enumerate(text.splitlines(), start=1):
        mark = re.match(r"\s*(```+|~~~+)\s*(.*?)\s*$", row)
        if language is None and mark:
            fence, language, start, rows = mark[1], mark[2], number + 1, []
        elif language is not None and row.strip() == fence:
            found.append(Block(language, "\n".join(rows) + "\n", start))
            language = None
        elif language is not None:
            rows.append(row)
    assert language is None, f"a fenced block opened before line {start} is never closed"
    return found


def prose(text: str) -> str:
    """`text` without its fenced blocks."""
    return re.sub(r"^(```+|~~~+).*?^\1\s*$", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(text: str) -> set[str]:
    """The anchors that the headings of a Markdown text get on the usual hosts."""
    found: set[str] = set()
    for heading in re.findall(r"^#{1,6}\s+(.*?)\s*#*\s*$", prose(text), flags=re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        number, free = 0, slug
        while free in found:
            number += 1
            free = f"{slug}-{number}"
        found.add(free)
    return found | set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))


def broken_links(file: Path) -> list[str]:
    bad = []
    for match in LINK.finditer(re.sub(r"`[^`\n]*`", "", prose(file.read_text(encoding="utf-8")))):
        target = unquote(match[1] or match[2])
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        there = (file.parent / name).resolve() if name else file
        if not there.exists():
            bad.append(f"{target}: no such file")
        elif anchor and there.suffix == ".md" and anchor not in anchors(there.read_text(encoding="utf-8")):
            bad.append(f"{target}: no such heading")
    return bad


def missing_paths(file: Path) -> list[str]:
    """Paths of the project named in `code` that do not exist.  Placeholders (<robot>, *, ...) are left alone."""
    named = re.findall(
        r"`((?:src|docs|tests|tools|urdf)/[\w./-]+|\w+\.toml|Makefile)`", prose(file.read_text(encoding="utf-8"))
    )
    return [name for name in named if not (ROOT / name).exists() and name not in ("loops.toml",)]


def commands(text: str, language: str = "console", prompt: str = "$ ") -> list[str]:
    """The `cutjoint` commands shown after a prompt in such blocks; a line that ends in a backslash goes on."""
    lines = "".join(block.text for block in blocks(text) if block.language == language).replace("\\\n", " ")
    start = f"{prompt}cutjoint "
    return [line[len(prompt) :].split(" # ")[0].strip() for line in lines.splitlines() if line.startswith(start)]


def run_python(text: str, name: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the python blocks of a document one after the other in one new process; errors give the document's lines."""
    shown = [("\n" * (block.line - 1) + block.text) for block in blocks(text) if block.language == "python"]
    program = (
        "import json, sys\nspace = {'__name__': '__main__'}\n"
        f"for text in json.loads({json.dumps(json.dumps(shown))}):\n    exec(compile(text, {name!r}, 'exec'), space)\n"
    )
    settings = os.environ | {"MPLBACKEND": "Agg"}
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        env=settings,
        check=False,
    )


def workplace(folder: Path) -> Path:
    """A folder in which the paths that documents name exist, and whatever the commands write stays."""
    for name in ("urdf", "docs", "tests"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def run_command(line: str, folder: Path, *, ask: bool = False) -> subprocess.CompletedProcess[str]:
    """Run one `cutjoint ...` line in a shell; of one that would stay open, or to `ask`, look into its help."""
    words = shlex.split(line)
    program = Path(sys.executable).parent
    settings = os.environ | {"PATH": f"{program}{os.pathsep}{os.environ['PATH']}", "NO_COLOR": "1", "COLUMNS": "200"}
    options = [word.split("=")[0] for word in words if word.startswith("--")]
    staying = ask or (words[1] in STAYING and not WRITING & set(options))
    run = subprocess.run(
        f"cutjoint {words[1] if len(words) > 1 else ''} --help" if staying else line,
        shell=True,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=600,
        env=settings,
        check=False,
    )
    if staying:
        assert [option for option in options if option not in run.stdout] == [], line
    return run


def ids(file: Path) -> str:
    return str(file.relative_to(ROOT))


def shown(language: str) -> list[Path]:
    """Documents with such blocks; the tutorials are worked through as a whole, by test_docs_tutorials.py."""
    return [
        file
        for file in DOCUMENTS
        if file.parent.name != "tutorials" and f"```{language}" in file.read_text(encoding="utf-8")
    ]


@pytest.mark.parametrize("file", DOCUMENTS, ids=ids)
def test_links_lead_somewhere(file: Path) -> None:
    assert broken_links(file) == []


@pytest.mark.parametrize("file", DOCUMENTS, ids=ids)
def test_named_paths_exist(file: Path) -> None:
    assert missing_paths(file) == []


def test_index_names_every_document() -> None:
    index = (ROOT / "docs/README.md").read_text()
    names = {file.relative_to(ROOT / "docs").as_posix() for file in (ROOT / "docs").rglob("*.md")} - {"README.md"}
    assert [name for name in sorted(names) if f"({name})" not in index] == []


def test_named_make_targets_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    for file in DOCUMENTS:
        named = set(re.findall(r"(?:`|^\$ )make (?:[A-Z]+=\S+ )?([a-z-]+)", file.read_text(), flags=re.MULTILINE))
        assert named <= targets, file


def test_readme_shows_both_commands_on_its_first_screen() -> None:
    first = "\n".join((ROOT / "README.md").read_text().splitlines()[:40])
    assert "make demo" in first
    assert "make test" in first


LONG = (
    *("workspace", "synthesis", "tuning", "retiming", "studies", "sizing", "accuracy", "stiffness"),
    *("simulation", "plots", "formats", "motion-files"),
)
"""Pages whose Python, or whose many commands, take seconds."""


@pytest.mark.parametrize(
    "file",
    [pytest.param(one, marks=pytest.mark.slow) if one.stem in LONG else one for one in shown("python")],
    ids=ids,
)
def test_python_runs(file: Path, tmp_path: Path) -> None:
    run = run_python(file.read_text(encoding="utf-8"), file.name, workplace(tmp_path))
    assert run.returncode == 0, run.stderr[-3000:]


@pytest.mark.slow
@pytest.mark.parametrize("file", shown("console"), ids=ids)
def test_commands_run(file: Path, tmp_path: Path) -> None:
    folder = workplace(tmp_path)
    for line in commands(file.read_text(encoding="utf-8")):
        run = run_command(line, folder)
        assert run.returncode == 0, f"$ {line}\n{run.stdout[-2000:]}\n{run.stderr[-2000:]}"


@pytest.mark.parametrize(
    "file", [pytest.param(one, marks=pytest.mark.slow) if one.stem in LONG else one for one in shown("sh")], ids=ids
)
def test_commands_that_are_not_run_have_the_options(file: Path, tmp_path: Path) -> None:
    for line in commands(file.read_text(encoding="utf-8"), "sh", ""):
        assert run_command(line, tmp_path, ask=True).returncode == 0, line


# The checks above can fail: the same functions on documents that are wrong.

WRONG = """# A title, with `code` & more

[good](#a-title-with-code--more) [bad](#nothing) [gone](nowhere.md) `tools/nowhere.py` `Makefile`

```python
x = 1
```

```python
assert x == 2, "line ten"
```

```console
$ cutjoint nonsense --flag  # a remark
some output
$ ls
$ cutjoint list \\
    --json
```
"""


def test_wrong_document_is_noticed(tmp_path: Path) -> None:
    file = tmp_path / "wrong.md"
    file.write_text(WRONG)
    assert broken_links(file) == ["#nothing: no such heading", "nowhere.md: no such file"]
    assert missing_paths(file) == ["tools/nowhere.py"]
    assert [" ".join(line.split()) for line in commands(WRONG)] == ["cutjoint nonsense --flag", "cutjoint list --json"]
    run = run_python(WRONG, "wrong.md", tmp_path)
    assert run.returncode != 0
    assert 'File "wrong.md", line 10' in run.stderr
    assert run_command("cutjoint nonsense", tmp_path).returncode != 0
    with pytest.raises(AssertionError, match="--nonsense"):
        run_command("cutjoint list --nonsense", tmp_path, ask=True)


def test_unclosed_block_is_noticed() -> None:
    with pytest.raises(AssertionError, match="never closed"):
        blocks("```python\nx = 1\n")
