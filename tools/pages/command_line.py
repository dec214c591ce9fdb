"""The reference of the command line: every command with its arguments and options, as `--help` tells them."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import typer

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

PROGRAM = "cutjoint"
HEAD = f"""\
# The commands

`{PROGRAM} --help` lists the commands, `{PROGRAM} COMMAND --help` explains one; this page is made of the same texts.
What holds for all of them is told in [the command line](command-line.md).
"""


def page() -> str:
    """The whole page, as Markdown."""
    from cutjoint.cli import app

    group = typer.main.get_command(app)
    context = typer.Context(group, info_name=PROGRAM)
    names = group.list_commands(context)  # type: ignore[attr-defined]
    found = {name: group.get_command(context, name) for name in names}  # type: ignore[attr-defined]
    lines = [_plain(group.epilog or ""), "", "| command | what it does |", "|---|---|"]
    for name, command in found.items():
        does = command.help.strip().split("\n\n")[0]
        lines.append(f"| [`{name}`](#{PROGRAM}-{name}) | {_plain(does)} |")
    for name, command in found.items():
        lines += _section(name, command, typer.Context(command, info_name=name, parent=context))
    return f"{HEAD}\n" + "\n".join(lines) + "\n"


def _section(name: str, command: typer.core.TyperCommand, context: typer.Context) -> Iterator[str]:
    yield from ("", f"## {PROGRAM} {name}", "", _plain(inspect.cleandoc(command.help or "")), "")
    usage = " ".join(command.collect_usage_pieces(context)).replace("{", "").replace("}", "")
    yield from ("```text", f"{PROGRAM} {name} {usage}", "```", "", "| | what it is |", "|---|---|")
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None:
            spelled = " ".join(f"`{word}`" for word in record[0].split())
            yield f"| {spelled} | {_plain(record[1])} |"


def _plain(text: str) -> str:
    """Text whose characters stand for themselves in Markdown; what it has in backticks stays code."""
    pieces = re.split(r"(`[^`]*`)", text)
    escaped = (piece if piece.startswith("`") else re.sub(r"[\[\]<>*_|]", r"\\\g<0>", piece) for piece in pieces)
    return re.sub(r"(?<!\n)\n(?!\n)", " ", "".join(escaped))
