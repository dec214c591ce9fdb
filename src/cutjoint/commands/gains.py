"""The gains of the control laws as options of the command line, made from `control.LAWS`, and what is written there."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from inspect import Parameter, signature
from typing import Annotated, TypeVar, cast

import numpy.typing as npt
import typer

from cutjoint.control.catalogue import LAWS, law_row
from cutjoint.control.law import GainHelp
from cutjoint.errors import InputError

Command = TypeVar("Command", bound=Callable[..., None])
FORMS = "one number, one an actuator as 1,2,3, or a matrix as [[..],[..]]"
CONTROLLERS = "; ".join(f"{name} ({row.about})" for name, row in LAWS.items()) + "."


def option(gain: str) -> str:
    """How the option of a gain is written."""
    return f"--{gain.replace('_', '-')}"


def with_gains(command: Command) -> Command:
    """`command`, whose `**gains` become an option for every gain of every law, with a help that says whose it is."""
    whole = signature(command, eval_str=True)
    named = [one for one in whole.parameters.values() if one.kind is not Parameter.VAR_KEYWORD]
    # Typer reads a command's options off its signature.
    command.__signature__ = whole.replace(parameters=[*named, *_options()])  # type: ignore[attr-defined]
    return command


def _options() -> list[Parameter]:
    takers: dict[str, dict[GainHelp, list[str]]] = {}
    for name, row in LAWS.items():
        for gain, about in row.gains.items():
            takers.setdefault(gain, {}).setdefault(about, []).append(name)
    made = []
    for gain, laws in takers.items():
        what = "; ".join(f"{', '.join(names)}: {about.about}, {about.unit}" for about, names in laws.items())
        shown = typer.Option(metavar="K", help=f"{what}.", rich_help_panel=f"Gains: {FORMS}; default the paper's")
        made.append(
            Parameter(gain, Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=Annotated[str | None, shown])
        )
    return made


def gains_of(robot: str, controller: str, given: Mapping[str, str | None]) -> Mapping[str, npt.ArrayLike]:
    """The gains as `given` on the command line, or those known for the robot where none is given.

    Raises:
        UnknownNameError: no such controller.
        InputError: a gain is missing, not used or no number, or none is known.
    """
    from cutjoint.experiments.gains import default_gains

    wanted = law_row(controller).gains
    gains = {name: numbers(option(name), text) for name, text in given.items() if text is not None}
    if not gains:
        return default_gains(robot, controller)
    missing = [option(name) for name in wanted if name not in gains]
    unused = [option(name) for name in gains if name not in wanted]
    if missing or unused:
        wrong = [f"{what} {', '.join(them)}" for what, them in (("missing", missing), ("not used", unused)) if them]
        takes = ", ".join(map(option, wanted)) or "no gains"
        raise InputError(f"controller '{controller}' takes {takes}; {'; '.join(wrong)}")
    return gains


def numbers(option: str, text: str) -> npt.ArrayLike:
    """One number, several with commas, or a matrix in JSON.

    Raises:
        InputError: it is none of them.
    """
    try:
        if text.lstrip().startswith("["):
            return cast(npt.ArrayLike, json.loads(text))
        found = [float(one) for one in text.split(",")]
    except ValueError as error:
        raise InputError(f"{option} must be a number, numbers with commas, or [[..],[..]]; found '{text}'") from error
    return found[0] if len(found) == 1 else found
