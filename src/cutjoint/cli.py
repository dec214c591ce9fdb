"""The command line: `cutjoint COMMAND ...`.  Each command is a module of `cutjoint.commands` with a function `command`,
which imports what is heavy only when it runs, so that `cutjoint --help` is quick."""

from __future__ import annotations

import contextlib
import gc
import sys
import warnings
from importlib import import_module
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands.stopping import told
from cutjoint.errors import CutjointError

COMMANDS = (
    "list",
    "info",
    "check",
    "crosscheck",
    "simulate",
    "reproduce",
    "view",
    "play",
    "export",
    "states",
    "compile",
)

RARELY = 50_000
"""New objects until Python looks for circles among them: a command makes many that stay, and ends soon."""

app = typer.Typer(no_args_is_help=True, add_completion=False, context_settings={"help_option_names": ["-h", "--help"]})
for _name in COMMANDS:
    app.command(_name)(told(import_module(f"cutjoint.commands.{_name}").command))


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
    print(f"warning: {message}", file=sys.stderr)


def main() -> None:
    """The command line.  Exit status: 0 done, 1 a check did not hold, 2 bad input, 130 and 143 interrupted (SIGINT,
    SIGTERM)."""
    interrupts.watch()
    warnings.showwarning = _say
    gc.set_threshold(RARELY, 20, 50)
    try:
        app()
    except CutjointError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(2)
    except BrokenPipeError:
        sys.exit(0)
    except KeyboardInterrupt:
        sys.exit(interrupts.status())
    finally:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
        interrupts.done()
