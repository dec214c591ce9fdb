"""Arguments and options that several commands have, said once: robots, pages, trajectories, and the gains of the
control laws, made from `control.LAWS`."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar, cast

import numpy.typing as npt
import typer

from cutjoint.commands import completing
from cutjoint.control.catalogue import LAWS, law_row
from cutjoint.control.law import GainHelp
from cutjoint.control.outside import GROUP as LAW_GROUP
from cutjoint.errors import InputError, shown
from cutjoint.motion.catalogue import TRAJECTORIES, describe
from cutjoint.motion.outside import GROUP as PATH_GROUP
from cutjoint.plugins import installed

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Trajectory


Robot = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="Name of a robot (see `cutjoint list`) or a path.",
        autocompletion=completing.robots,
    ),
]
Variant = Annotated[
    str | None,
    typer.Option(help="Named set of inertias, such as lumped.", autocompletion=completing.variants),
]
Ideal = Annotated[
    bool, typer.Option("--ideal", help="Joints move freely: no damping, friction, springs, rotors, stops or bushings.")
]
Home = Annotated[
    str | None, typer.Option(help="Named home posture; default the first.", autocompletion=completing.homes)
]
Lenient = Annotated[
    bool,
    typer.Option(
        "--lenient", help="Pass, with a warning, flaws that do not change the motion, such as missing meshes."
    ),
]
Payload = Annotated[float, typer.Option(metavar="KG", help="Mass at the tool.")]
SampleRate = Annotated[
    float | None, typer.Option(metavar="HZ", help="Sample rate of the controller; default continuous control.")
]
Believed = Annotated[
    str | None,
    typer.Option(
        metavar="chain|paper",
        help="What the controller believes; default the published model of an ideal robot that has one.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Machine-readable output.")]

Html = Annotated[Path | None, typer.Option(metavar="FILE", help="Write one HTML file instead, which needs no network.")]
Png = Annotated[Path | None, typer.Option(metavar="FILE", help="Write a picture instead, through a headless browser.")]
Size = Annotated[str, typer.Option(metavar="WxH", help="Size of the picture in pixels.")]
Port = Annotated[int, typer.Option(min=0, max=65535, help="First port to try; 0 lets the system choose.")]
Host = Annotated[str, typer.Option(help="Address to listen on; other than loopback it is open to others.")]
OpenBrowser = Annotated[bool, typer.Option("--open/--no-open", help="Open a browser where there is a screen.")]


def _entries(group: str) -> list[str]:
    """What installed packages offer, which takes a while to find out: only where a help is asked for."""
    if {"-h", "--help"}.isdisjoint(sys.argv):
        return []
    return [
        f"{name} (of {offers[0].dist.name if offers[0].dist else 'a package'})"
        for name, offers in installed(group).items()
    ]


Command = TypeVar("Command", bound=Callable[..., None])
FORMS = "one number, one an actuator as 1,2,3, or a matrix as [[..],[..]]"
OUTSIDE = "FILE.py:NAME or PACKAGE.MODULE:NAME (one's own)"
CONTROLLERS = "; ".join([*(f"{name} ({row.about})" for name, row in LAWS.items()), *_entries(LAW_GROUP), OUTSIDE]) + "."


def option(gain: str) -> str:
    """How the option of a gain is written."""
    own = any(gain in row.gains for row in LAWS.values())
    return f"--{gain.replace('_', '-')}" if own else f"--gain {gain}=K"


def with_gains(command: Command) -> Command:
    """`command`, whose `**gains` become an option for every gain of every law, with a help that says whose it is."""
    return with_options(command, _gain_helps(), "K", f"Gains: {FORMS}; default the paper's, or for 20 rad/s")


def with_options(command: Command, helps: Mapping[str, str], metavar: str, panel: str) -> Command:
    """`command`, whose `**others` become an option of text for every name, with its help, under one heading.

    Raises:
        ValueError: the command has an option of such a name already.
    """
    whole = signature(command, eval_str=True)
    if taken := [name for name in helps if name in whole.parameters]:
        raise ValueError(f"under '{panel}' there are names of other options: {', '.join(taken)}; rename them")
    named = [one for one in whole.parameters.values() if one.kind is not Parameter.VAR_KEYWORD]
    for name, about in helps.items():
        kind = Annotated[str | None, typer.Option(metavar=metavar, help=about, rich_help_panel=panel)]
        named.append(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=kind))
    # Typer reads a command's options off its signature.
    command.__signature__ = whole.replace(parameters=named)  # type: ignore[attr-defined]
    return command


def _gain_helps() -> dict[str, str]:
    """Gain -> which laws take it, what it is there, and its unit."""
    takers: dict[str, dict[GainHelp, list[str]]] = {}
    for name, row in LAWS.items():
        for gain, about in row.gains.items():
            takers.setdefault(gain, {}).setdefault(about, []).append(name)
    return {
        gain: "; ".join(f"{', '.join(names)}: {about.about}, {about.unit}" for about, names in laws.items()) + "."
        for gain, laws in takers.items()
    }


def assigned(what: str, form: str, texts: Sequence[str]) -> dict[str, str]:
    """Texts such as NAME=K, of an option that may be repeated, by name.

    Raises:
        InputError: one has not the `form`, or a name is given twice; the message says `what` is wrong.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (sign and name and value):
            raise InputError(f"{what} is given as {form}, found '{shown(text)}'")
        if name in found:
            raise InputError(f"{what} is given twice for '{shown(name)}'")
        found[name] = value
    return found


def as_argument(path: Path) -> str:
    """A path as it is typed in a shell after a command that takes names of robots too."""
    from cutjoint.description import catalogue

    text = str(path)
    return shlex.quote(f"./{text}" if text in catalogue.names() or text.startswith("-") else text)


def made_with(variant: str | None, ideal: bool, lenient: bool, payload: float) -> dict[str, object]:
    """What a result keeps of the options of its robot, so that other commands find the same one."""
    given = {"variant": variant, "ideal": ideal, "lenient": lenient, "payload": payload}
    return {name: one for name, one in given.items() if one}


def named_gains(options: Mapping[str, str | None], named: Sequence[str]) -> dict[str, str]:
    """The gains that are given, by options of their own or as NAME=K.

    Raises:
        InputError: something else is named, or a gain is given twice.
    """
    found = {name: text for name, text in options.items() if text is not None}
    for name, text in assigned("a gain", "--gain NAME=K", named).items():
        gain = name.replace("-", "_")
        if gain in found:
            raise InputError(f"gain {shown(gain)} is given twice")
        found[gain] = text
    return found


def gains_of(robot: str, controller: str, given: Mapping[str, str]) -> Mapping[str, npt.ArrayLike]:
    """The gains as `given` on the command line, or those known for the robot where none is given.

    Raises:
        UnknownNameError: no such controller.
        InputError: a gain is missing, not used or no number, or none is known.
    """
    from cutjoint.tuning.known import default_gains

    row = law_row(controller)
    gains = {name: numbers(option(name), text) for name, text in given.items()}
    if not gains and not row.told:
        return default_gains(robot, controller)
    missing = [option(name) for name in row.needed if name not in gains]
    unused = [option(name) for name in gains if name not in row.gains]
    if missing or unused:
        wrong = [f"{what} {', '.join(them)}" for what, them in (("missing", missing), ("not used", unused)) if them]
        takes = ", ".join(map(option, row.gains)) or "no gains"
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
    except (ValueError, RecursionError) as error:
        told = f"{option} must be a number, numbers with commas, or [[..],[..]]; found '{shown(text)}'"
        raise InputError(told) from error
    return found[0] if len(found) == 1 else found


FILE = (
    "a file, such as way.csv, with columns t and some of x, y, z, an orientation, or actuators (docs/motion-files.md)"
)
HELP = "; ".join(["paper (the robot's own)", *map(describe, TRAJECTORIES), FILE, *_entries(PATH_GROUP), OUTSIDE]) + "."


def trajectory_of(chain: ClosedChain, spec: str, mechanism: Mechanism | None = None) -> Trajectory:
    """The trajectory that `spec` names, for a robot that starts in the home posture of `mechanism` (default: `chain`).

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong, or the robot has no published trajectory.
    """
    from cutjoint.robots import named_trajectory

    return named_trajectory(spec, chain, mechanism)
