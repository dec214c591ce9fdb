"""What the Tab key offers: names of robots, their variants and homes, controllers, trajectories, formats.

Completion is asked for anew at each key: what is heavy is loaded only where it is needed, and an error offers nothing.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable

import typer

Offer = Callable[[typer.Context, str], list[str]]


def _offer(names: Callable[[typer.Context], Iterable[str]]) -> Offer:
    """What completes a word out of `names`; nothing, so that the shell offers files, where there is none."""

    def offered(ctx: typer.Context, incomplete: str) -> list[str]:
        with contextlib.suppress(Exception):
            return [name for name in names(ctx) if name.startswith(incomplete)]
        return []

    return offered


def _robots(_: typer.Context) -> Iterable[str]:
    from cutjoint.description import catalogue

    return [*catalogue.names(), *catalogue.example_names()]


def _published(_: typer.Context) -> Iterable[str]:
    from cutjoint.robots import PUBLISHED

    return [*PUBLISHED, "all"]


def _variants(ctx: typer.Context) -> Iterable[str]:
    from cutjoint.description import load_description

    return [one.name for one in load_description(_robot_of(ctx)).variants]


def _homes(ctx: typer.Context) -> Iterable[str]:
    from cutjoint.description import load_description

    return [one.name for one in load_description(_robot_of(ctx)).homes]


def _robot_of(ctx: typer.Context) -> str:
    """The robot that stands in the line already."""
    return str(ctx.params.get("robot") or ctx.params.get("source") or ctx.args[0])


def _controllers(_: typer.Context) -> Iterable[str]:
    from cutjoint.control.catalogue import LAWS

    return LAWS


def _trajectories(_: typer.Context) -> Iterable[str]:
    from cutjoint.motion.catalogue import TRAJECTORIES

    return ["paper", *TRAJECTORIES]


def _formats(_: typer.Context) -> Iterable[str]:
    from cutjoint.description.formats import WRITERS

    return WRITERS


robots, published, variants, homes = map(_offer, (_robots, _published, _variants, _homes))
controllers, trajectories, formats = map(_offer, (_controllers, _trajectories, _formats))


def words(*names: str) -> Offer:
    """What completes a word out of these."""
    return _offer(lambda _: names)
