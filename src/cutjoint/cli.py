"""The command line: `cutjoint COMMAND ...`.  Each command lives in `cutjoint.commands`, a file each."""

import typer

app = typer.Typer(no_args_is_help=True, add_completion=False)


def main() -> None:
    """Entry point of the `cutjoint` command."""
    app()
