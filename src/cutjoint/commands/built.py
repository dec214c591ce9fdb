"""Options of the hardware between controller and joints, and the hardware that they mean."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, cast

import typer

from cutjoint.commands.options import numbers

if TYPE_CHECKING:
    from cutjoint.simulation.hardware import Hardware
    from cutjoint.simulation.hardware.values import Each

PANEL = "Hardware, with --rate or in a file"


def _option(metavar: str, about: str) -> object:
    return typer.Option(metavar=metavar, help=about, rich_help_panel=PANEL)


File = Annotated[
    Path | None, _option("FILE.toml", "All of it from a file (docs/hardware.md), in place of the options.")
]
Delay = Annotated[float | None, _option("S", "Until the controller has a measurement.")]
CommandDelay = Annotated[float | None, _option("S", "Until a command acts.")]
Jitter = Annotated[float | None, _option("S", "Most that a sample is early or late; needs --tick.")]
Tick = Annotated[float | None, _option("S", "Of the controller's clock: samples, jitter and delays are whole ticks.")]
Resolution = Annotated[str | None, _option("M", "One step of the encoders: 1e-5, or 1,2,3 (m or rad).")]
Noise = Annotated[str | None, _option("M", "Standard deviation of the encoders' noise (m or rad).")]
Filter = Annotated[
    float | None, _option("HZ", "Speeds are differences of positions, through a low pass with this cutoff.")
]
Seed = Annotated[int | None, _option("N", "Of noise and jitter; default 0.")]


class Built(NamedTuple):
    """The options as they are given."""

    file: Path | None
    delay: float | None
    command_delay: float | None
    jitter: float | None
    tick: float | None
    resolution: str | None
    noise: str | None
    filter: float | None
    seed: int | None


def hardware_of_options(given: Built, rate: float | None, limit: str | None) -> Hardware | None:
    """The hardware, or None where no option is given.

    Raises:
        InputError: options without a rate, or beside a file; values that are wrong.
        DescriptionError: the file is wrong.
    """
    from cutjoint.errors import InputError
    from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware, Tachometer, read_hardware

    named = {f"--{name.replace('_', '-')}": value for name, value in given._asdict().items() if name != "file"}
    used = [name for name, value in named.items() if value is not None]
    if given.file is not None:
        used += [name for name, value in (("--rate", rate), ("--limit", limit)) if value is not None]
        if used:
            raise InputError(f"{', '.join(used)} would stand beside {given.file}; write it into the file")
        return read_hardware(given.file)
    if not used:
        return None
    if rate is None:
        raise InputError(f"hardware ({', '.join(used)}) needs a controller with a sample rate; give --rate")
    resolution, noise, limits = (
        None if text is None else cast("Each", numbers(option, text))
        for option, text in (("--resolution", given.resolution), ("--noise", given.noise), ("--limit", limit))
    )
    return Hardware(
        Clock(rate, given.jitter or 0.0, given.tick),
        Encoder(resolution, noise=0.0 if noise is None else noise, delay=given.delay or 0.0),
        Tachometer() if given.filter is None else Differences(given.filter),
        Drive(limits, delay=given.command_delay or 0.0),
        seed=given.seed or 0,
    )
