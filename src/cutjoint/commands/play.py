"""`cutjoint play`: a simulation, or a trajectory followed exactly, in the browser or in one file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import completing, options
from cutjoint.commands.options import HELP, trajectory_of
from cutjoint.commands.run_robot import robot_of_run
from cutjoint.commands.view import announce, served, write_files

if TYPE_CHECKING:
    from cutjoint.viewer import Document

RESULT_SUFFIX = ".npz"


def command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="RESULT|ROBOT",
            help="A result that `cutjoint simulate --save` wrote, or a robot.",
            autocompletion=completing.robots,
        ),
    ],
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC",
            help=f"With a robot, what it follows exactly: {HELP}",
            autocompletion=completing.trajectories,
        ),
    ] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="ROBOT", help="With a result: the robot, where its file does not tell.")
    ] = None,
    variant: options.Variant = None,
    lenient: options.Lenient = False,
    html: options.Html = None,
    png: options.Png = None,
    time: Annotated[float, typer.Option(min=0.0, help="Time of the picture, in seconds.")] = 0.0,
    size: options.Size = "1280x800",
    port: options.Port = 7000,
    host: options.Host = "127.0.0.1",
    open_browser: options.OpenBrowser = True,
) -> None:
    """Play a simulation with its desired and actual path and the efforts of the actuators.

    A robot with `--trajectory` follows it exactly, with the efforts of inverse dynamics.  `--html` writes the same
    page as one file that makes no network request.
    """
    from cutjoint.viewer import Bridge

    document = _document(source, trajectory, robot, variant, lenient)
    if html is not None or png is not None:
        write_files(document, html, png, time, size)
        return
    with Bridge(document.files(), host=host, port=port) as bridge, served():
        announce(bridge.url, bridge.open_to_others, host, open_browser)
        bridge.wait()


def _document(source: str, trajectory: str | None, robot: str | None, variant: str | None, lenient: bool) -> Document:
    from cutjoint.errors import InputError
    from cutjoint.robots import load
    from cutjoint.viewer import play

    if source.endswith(RESULT_SUFFIX):
        from cutjoint.simulation import load as load_result

        if trajectory is not None:
            raise InputError("a result has its trajectory in it; --trajectory goes with a robot")
        result = load_result(source)
        return play(robot_of_run(result, robot, variant, lenient), result)
    if trajectory is None:
        raise InputError(f"say what {source} should do with --trajectory SPEC, or give a result file ({RESULT_SUFFIX})")
    if robot is not None:
        raise InputError("--robot goes with a result file; here the robot is the first argument")
    chain = load(source, variant, lenient=lenient)
    return play(chain, trajectory_of(chain, trajectory))
