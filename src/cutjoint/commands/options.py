"""Arguments and options that several commands have, said once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Robot = Annotated[str, typer.Argument(metavar="ROBOT", help="Name of a robot (see `cutjoint list`) or a path.")]
Variant = Annotated[str | None, typer.Option(help="Named set of inertias, such as lumped.")]
Home = Annotated[str | None, typer.Option(help="Named home posture; default the first.")]
Lenient = Annotated[
    bool, typer.Option("--lenient", help="Pass flaws that do not prevent computing, such as missing meshes.")
]
Json = Annotated[bool, typer.Option("--json", help="Machine-readable output.")]

Html = Annotated[Path | None, typer.Option(metavar="FILE", help="Write one HTML file instead, which needs no network.")]
Png = Annotated[Path | None, typer.Option(metavar="FILE", help="Write a picture instead, through a headless browser.")]
Size = Annotated[str, typer.Option(metavar="WxH", help="Size of the picture in pixels.")]
Port = Annotated[int, typer.Option(min=0, max=65535, help="First port to try; 0 lets the system choose.")]
Host = Annotated[str, typer.Option(help="Address to listen on; other than loopback it is open to others.")]
OpenBrowser = Annotated[bool, typer.Option("--open/--no-open", help="Open a browser where there is a screen.")]
