"""How a command ends that fails: one clear message on stderr and an exit status, whoever raised the error."""

from __future__ import annotations

import os
import sys
import traceback

import typer

from cutjoint.commands.output import is_terminal, width
from cutjoint.errors import CutjointError, shown
from cutjoint.texts import harmless, wrapped

BAD_INPUT, INTERNAL = 2, 70
TRACEBACK = "CUTJOINT_TRACEBACK"
"""Variable of the environment: where it is set, an error is shown with its place in the code."""
HANG = "  "


def complain(text: str) -> None:
    """Write a message to stderr, control characters escaped: wrapped at words on a terminal, else as it is, so that it
    can be searched."""
    for line in text.split("\n"):
        whole = harmless(line.rstrip())
        lead = " " * (len(whole) - len(whole.lstrip(" ")))
        parts = wrapped(whole.lstrip(" "), width(), lead, lead + HANG) if is_terminal(sys.stderr) else [whole]
        for part in parts:
            print(part, file=sys.stderr)


def failed(error: Exception) -> int:
    """Say what is wrong; the exit status."""
    if os.environ.get(TRACEBACK):
        traceback.print_exception(error)
    status, text = _told(error)
    if text:
        complain(text)
    return status


def _told(error: Exception) -> tuple[int, str]:
    """Exit status and message of an error."""
    kind = type(error).__name__
    words = " ".join(str(error).split())
    if isinstance(error, CutjointError):
        return BAD_INPUT, f"{kind}: {error}"
    if isinstance(error, _usage_error()):
        return BAD_INPUT, _usage(error)
    if isinstance(error, OSError):
        place = "" if error.filename is None else f"{shown(os.fsdecode(error.filename))}: "
        return BAD_INPUT, f"{kind}: {place}{error.strerror or words}"
    if isinstance(error, MemoryError):
        return BAD_INPUT, f"MemoryError: this computer has not the memory for what is asked{words and f' ({words})'}"
    if isinstance(error, UnicodeDecodeError):
        return BAD_INPUT, f"{kind}: a file is no text in {error.encoding}: {words}"
    return INTERNAL, (
        f"InternalError: {kind}{words and f': {words}'}; this is a fault of cutjoint, please report it with the "
        f"command and what {TRACEBACK}=1 shows"
    )


def _usage_error() -> type[Exception]:
    """The root of the errors of arguments and options, which typer has no public name for."""
    root: type[Exception] = typer.BadParameter.__mro__[2]
    return root


def _usage(error: Exception) -> str:
    """A wrong option or argument in one line; nothing where the help was shown instead."""
    message: str = error.format_message()  # type: ignore[attr-defined]
    words = " ".join(message.split())
    context = getattr(error, "ctx", None)
    place = "cutjoint" if context is None else context.command_path
    return words and f"UsageError: {words.rstrip('.')} (see `{place} --help`)"
