"""How a command shows its help: as it is written, with units in brackets, which Rich would take for markup and drop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from typer.core import TyperArgument, TyperCommand, TyperOption

if TYPE_CHECKING:
    from typer._click import Context, HelpFormatter


def _as_written(text: str) -> str:
    return text.replace("[", "\\[")


class CommandAsWritten(TyperCommand):
    """A command whose help has no markup."""

    def format_help(self, ctx: Context, formatter: HelpFormatter) -> None:
        """Write the help."""
        self.help = _as_written(self.help or "")
        for one in self.params:
            if isinstance(one, TyperOption | TyperArgument):
                one.help = _as_written(one.help or "")
        super().format_help(ctx, formatter)
