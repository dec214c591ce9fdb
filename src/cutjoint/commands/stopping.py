"""How a command ends that a signal stops: it says so, says what was kept, and has the exit status of the signal."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

import typer

from cutjoint import interrupts
from cutjoint.commands.failing import complain

P = ParamSpec("P")
R = TypeVar("R")


def told(command: Callable[P, R]) -> Callable[P, R]:
    """The command, which says so where it is interrupted and has nothing to keep."""

    @wraps(command)
    def said(*arguments: P.args, **options: P.kwargs) -> R:
        try:
            result = command(*arguments, **options)
        except KeyboardInterrupt:
            raise stopped("all was done by then" if interrupts.kept() else "nothing was written") from None
        if interrupts.waiting():
            raise stopped("all was done by then")
        return result

    return said


def stopped_name(path: Path) -> Path:
    """The name of what is kept where `path` was asked for: `run.stopped.npz`."""
    return path.with_name(f"{path.stem}.stopped{path.suffix}")


def stopped(what: str) -> typer.Exit:
    """What ends a command that was interrupted: `what` says what was kept and where.  On stderr."""
    with interrupts.held():
        interrupts.answered()
        complain(f"interrupted ({interrupts.name()}): {what}")
    return typer.Exit(interrupts.status())
