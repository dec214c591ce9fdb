"""The command line: `cutjoint COMMAND ...`.  Each command is a module of `cutjoint.commands` with a function `command`,
which imports what is heavy only when it runs, so that `cutjoint --help` is quick."""

from __future__ import annotations

import gc
import sys
import warnings
from importlib import import_module
from inspect import cleandoc
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands.failing import complain, failed
from cutjoint.commands.helping import CommandAsWritten
from cutjoint.commands.stopping import told

HEADINGS = {
    "Begin": ("new", "cut", "list"),
    "Look at a robot": ("info", "check", "view"),
    "Run it and look at the run": ("simulate", "plot", "report", "play"),
    "Engineer it": ("workspace", "size", "retime", "stiffness", "accuracy", "tune", "study", "synthesise"),
    "Hand it to other programs": ("export", "states", "compile"),
    "Compare with papers and engines": ("crosscheck", "reproduce"),
}
"""Headings of `cutjoint --help` -> the commands below them."""
COMMANDS = tuple(name for names in HEADINGS.values() for name in names)

RARELY = 50_000
"""New objects until Python looks for circles among them: a command makes many that stay, and ends soon."""

STATUS = (
    "Exit status: 0 done, 1 a check did not hold, 2 bad input, 70 a fault of cutjoint itself, 130 and 143 interrupted "
    "(SIGINT, SIGTERM). Messages go to stderr; CUTJOINT_TRACEBACK=1 shows where in the code an error came from."
)


def _flowing(text: str) -> str:
    """A docstring whose paragraphs are a line each, to be wrapped for the width there is."""
    return "\n\n".join(" ".join(part.split()) for part in cleandoc(text).split("\n\n"))


app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=STATUS,
)
for _heading, _names in HEADINGS.items():
    for _name in _names:
        _command = import_module(f"cutjoint.commands.{_name}").command
        _about = _flowing(_command.__doc__ or "")
        app.command(_name, cls=CommandAsWritten, help=_about, rich_help_panel=_heading)(told(_command))


def _version(wanted: bool) -> None:
    if wanted:
        from cutjoint import __version__

        typer.echo(f"cutjoint {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Robots whose links form closed loops: a URDF of the open tree plus the cut joints, closed with Pinocchio."""


def _say(message: Warning | str, *_: object, **__: object) -> None:
    """A warning as a line on its own, without the place in the code."""
    complain(f"warning: {message}")


def main() -> None:
    """The command line; it ends the program with the status that `STATUS` explains."""
    interrupts.watch()
    warnings.showwarning = _say
    gc.set_threshold(RARELY, 20, 50)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a mark or a name that the encoding has no sign for
    try:
        status = app(prog_name="cutjoint", standalone_mode=False) or 0
    except KeyboardInterrupt:
        status = interrupts.status()
    except Exception as error:
        status = failed(error)
    finally:
        interrupts.done()
    sys.exit(interrupts.status() if status == 128 + interrupts.SIGNALS[0] else status)
