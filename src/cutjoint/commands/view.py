"""`cutjoint view`: a robot in the browser, with sliders; or one posture as a page or a picture."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.failing import complain
from cutjoint.commands.output import say
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped
from cutjoint.errors import InputError
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from collections.abc import Iterator

    from cutjoint.chain import ClosedChain
    from cutjoint.viewer import Document, Places

HOST_WARNING = (
    "warning: the viewer is open to every machine that can reach {host}: anyone there can see the "
    "robot and move its picture. Nothing is encrypted and no password is asked."
)


def command(
    robot: options.Robot,
    variant: options.Variant = None,
    home: options.Home = None,
    lenient: options.Lenient = False,
    html: options.Html = None,
    png: options.Png = None,
    size: options.Size = "1280x800",
    port: options.Port = 7000,
    host: options.Host = "127.0.0.1",
    open_browser: options.OpenBrowser = True,
    workspace: Annotated[
        Path | None,
        typer.Option(metavar="FILE.npz", help="Show beside it the workspace that `cutjoint workspace --save` wrote."),
    ] = None,
    coloured: Annotated[
        str, typer.Option("--map", metavar="NAME", help="Map of the workspace that colours its points.")
    ] = "",
) -> None:
    """Show a robot in the browser: sliders for its actuators and its tool, loops closed all the time.

    The page shows the loop gap, mobility, distance to singularities and the effort that holds the robot against
    gravity, and says why a slider stops.  The server listens on this machine only and ends with the program (Ctrl-C).
    """
    from cutjoint.robots import load
    from cutjoint.viewer import LiveView, show

    if coloured and workspace is None:
        raise InputError("--map colours the points of a workspace; give its file with --workspace")
    chain = load(robot, variant, home, lenient=lenient)
    places = None if workspace is None else places_of(chain, workspace, coloured)
    if html is not None or png is not None:
        write_files(show(chain, places=places), html, png, 0.0, size)
        return
    with LiveView(chain, host=host, port=port, places=places) as view, served():
        announce(view.url, view.bridge.open_to_others, host, open_browser)
        view.wait()


def places_of(chain: ClosedChain, file: Path, coloured: str) -> Places:
    """The workspace in a file of this robot, as it is shown beside it.

    Raises:
        InputError: it is of another robot, or has no place in the world.
        ResultFileError: the file holds no workspace.
        UnknownNameError: it has no such map.
    """
    from cutjoint.viewer import Places
    from cutjoint.workspace import in_world, load

    space = load(file)
    if space.robot.partition(" (")[0] != chain.name.partition(" (")[0]:
        raise InputError(
            f"{file} holds the workspace of {space.robot}, not of {chain.name}; give the robot that it is of"
        )
    task = chain.task
    if task is None:
        raise InputError(f"the tool of {chain.name} has no task, so that no workspace of it can be placed")
    with progress(f"workspace {file}"):
        shape = in_world(space, task, coloured)
    quantity, low_is_good = "", False
    points, values = shape.points, shape.values
    if coloured:
        field = space.maps[coloured]
        quantity, low_is_good = f"{field.title} [{field.unit or '-'}]", field.best == "low"
        told = np.isfinite(values)
        points, values = points[told], values[told]
    return Places("Workspace", points, values, quantity, low_is_good, shape.vertices, shape.faces)


def write_files(document: Document, html: Path | None, png: Path | None, time: float, size: str) -> None:
    """Write a page, a picture or both, and say how large they are."""
    width, height = pixels(size)
    done = []
    try:
        with interrupts.asking():
            if html is not None:
                with interrupts.keeping():
                    say(f"wrote {html}: {document.save(html) / 1e6:.2f} MB, one file, no network needed")
                    done.append(str(html))
            if png is not None:
                with progress(f"picture {png}"):
                    written = document.picture(png, time=time, width=width, height=height)
                say(f"wrote {png}: {width} x {height} pixels, {written / 1e6:.2f} MB")
                done.append(str(png))
    except KeyboardInterrupt:
        only = "only " if len(done) == 1 and html is not None and png is not None else ""
        raise stopped(f"{only}{' and '.join(done)} was written" if done else "nothing was written") from None


@contextmanager
def served() -> Iterator[None]:
    """From before the address is told on: Ctrl-C is how a viewer ends.

    Raises:
        typer.Exit: it was SIGTERM.
    """
    try:
        with interrupts.asking():
            yield
    except KeyboardInterrupt:
        say("closed")
        if interrupts.name() == "SIGTERM":
            raise typer.Exit(interrupts.status()) from None


def pixels(size: str) -> tuple[int, int]:
    """Width and height of `WxH`.

    Raises:
        InputError: it does not read like that.
    """
    width, cross, height = size.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise InputError(f"the size of a picture is given like 1280x800, found {size!r}")
    return int(width), int(height)


def announce(url: str, open_to_others: bool, host: str, open_browser: bool) -> None:
    """Print the address, warn where others can reach it, and open a browser where there is a screen."""
    import os
    import sys

    if open_to_others:
        complain(HOST_WARNING.format(host=host))
    say("viewer at ", Cell(url, "bold"), " (Ctrl-C ends it)")
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if open_browser and screen:
        import webbrowser

        webbrowser.open(url)
