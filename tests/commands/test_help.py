"""Helps are shown as they stand: units in brackets are no marks of a style."""

from __future__ import annotations

import re

import pytest
import typer
from rich.text import Text
from typer.core import TyperArgument, TyperOption

from cutjoint import cli

COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_no_bracket_of_a_help_is_swallowed(name: str) -> None:
    command = COMMANDS[name]
    helps = [command.help, *(one.help for one in command.params if isinstance(one, TyperOption | TyperArgument))]
    for text in filter(None, helps):
        assert Text.from_markup(text).plain == re.sub(r"\\(?=\[)", "", text)


def test_units_are_seen_in_a_help() -> None:
    from typer.testing import CliRunner

    shown = CliRunner().invoke(cli.app, ["retime", "--help"], terminal_width=80).output
    assert "[m/s2]" in shown
    assert "\\[" not in shown
