"""`cutjoint workspace --certify`: a box of tool coordinates that is proven, or refused with a counter-example."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from cutjoint import interrupts
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.workspace import Certificate

PANEL = "A certified box"
CertifyBox = Annotated[
    str | None,
    typer.Option(
        "--certify",
        metavar="BOX",
        help="Prove that a box is wholly inside and free of singularities, or find a point that is not: "
        "x=-0.1..0.1,y=0..0.2 (m or rad). Status 1 where it is not proven.",
        rich_help_panel=PANEL,
    ),
]
CertificatePicture = Annotated[
    Path | None,
    typer.Option("--certificate", metavar="FILE", help="Picture of the box: .png or .svg.", rich_help_panel=PANEL),
]
MostBoxes = Annotated[
    int, typer.Option("--most", min=1, help="Sub-boxes that are looked at, at most.", rich_help_panel=PANEL)
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", metavar="S", help="Time that the proof may take.", rich_help_panel=PANEL)
]
MOST = 100_000


class AskedBox(NamedTuple):
    """What is asked of a box.

    Attributes:
        box: its edges.
        picture: where its picture is written.
        most, seconds: sub-boxes that are looked at, and time that it takes, at most.
    """

    box: dict[str, tuple[float, float]]
    picture: Path | None
    most: int
    seconds: float | None


def asked(
    box: str | None, picture: Path | None, most: int, seconds: float | None, others: Sequence[str]
) -> AskedBox | None:
    """What the options ask for; None where no box is given.

    Raises:
        InputError: options of a box without one or of a map beside one, no box, or nothing can be written where the
            picture shall be.
    """
    from cutjoint.errors import InputError
    from cutjoint.report.answers.sheet import check_picture
    from cutjoint.report.figures import plotting

    own = {"--certificate": picture is not None, "--most": most != MOST, "--seconds": seconds is not None}
    if box is None:
        if said := [name for name, given in own.items() if given]:
            raise InputError(f"{said[0]} is of a box: give it by --certify x=-0.1..0.1,...")
        return None
    if others:
        raise InputError(f"--certify goes without {others[0]}, which is of a map; --hold holds other coordinates")
    if seconds is not None and not seconds > 0.0:
        raise InputError(f"--seconds must be above 0, found {seconds:g}")
    edges = box_of(box)
    if picture is not None:
        check_picture(picture)
        plotting()
    return AskedBox(edges, picture, most, seconds)


def box_of(text: str) -> dict[str, tuple[float, float]]:
    """A box as it is written, `x=-0.1..0.1,y=0..0.2`.

    Raises:
        InputError: it is written otherwise.
    """
    from cutjoint.errors import InputError, shown

    found: dict[str, tuple[float, float]] = {}
    for part in text.split(","):
        name, equals, ends = part.partition("=")
        low, dots, high = ends.partition(".." if ".." in ends else ":")
        try:
            if not (equals and dots):
                raise ValueError
            span = float(low), float(high)
        except ValueError as error:
            raise InputError(
                f"a box is written as NAME=LEAST..MOST,..., such as x=-0.1..0.1,y=0..0.2 (m or rad); found "
                f"'{shown(part)}'"
            ) from error
        if name.strip() in found:
            raise InputError(f"the box has two edges '{shown(name.strip())}'")
        found[name.strip()] = span
    return found


def certify_box(
    chain: ClosedChain, asked: AskedBox, held: Mapping[str, float] | None = None, *, json: bool = False
) -> None:
    """Certify a box and tell; ends with status 1 where it is not proven."""
    from cutjoint.report.answers.certificate import certificate_picture
    from cutjoint.report.answers.sheet import write_sheet
    from cutjoint.workspace import certify

    with interrupts.keeping():
        with progress(f"{chain.name}: proving a box", 100.0, "%") as told:

            def go_on(part: float) -> bool:
                told(round(100.0 * part, 2))
                return not interrupts.waiting()

            found = certify(chain, asked.box, held=held, most=asked.most, seconds=asked.seconds, told=go_on)
        if asked.picture is not None:
            write_sheet(certificate_picture(found), asked.picture)
        if json:
            print_json(certificate_data(found))
        else:
            show_certificate(found, asked.picture)
        if interrupts.came():
            kept = "" if asked.picture is None else f"; drawn in {asked.picture}"
            raise stopped(f"proved {100.0 * found.part:.3g} % of the box{kept}")
    if not found.is_certified:
        raise typer.Exit(1)


def certificate_data(found: Certificate) -> dict[str, object]:
    """A certificate for JSON, in SI units."""
    wrong = found.counter_example
    return {
        "robot": found.robot,
        "status": found.status,
        "box": {name: list(ends) for name, *ends in zip(found.names, found.lower, found.upper, strict=True)},
        "held": dict(found.held),
        "part_proven": found.part,
        "sub_boxes": {"left": len(found.proven), "proven": int(found.proven.sum()), "looked_at": found.looked},
        "not_proven": {name: list(ends) for name, ends in found.doubtful.items()} or None,
        "least_margin": float(found.margins[found.proven].min()) if found.proven.any() else None,
        "counter_example": None
        if wrong is None
        else {"at": dict(wrong.at), "why": wrong.why, "joint": wrong.joint or None, "shown": wrong.shown},
    }


def show_certificate(found: Certificate, picture: Path | None = None) -> None:
    """A certificate in words."""
    rows = [
        (name, f"{low:.6g} .. {high:.6g} {unit}")
        for name, low, high, unit in zip(found.names, found.lower, found.upper, found.units, strict=True)
    ]
    rows += [
        (name, f"{round(value, 12):.6g} {'rad' if name.startswith('r') else 'm'}, held")
        for name, value in found.held.items()
    ]
    rows.append(("proven", f"{100.0 * found.part:.4g} % of the box, {int(found.proven.sum())} sub-boxes"))
    if found.proven.any():
        rows.append(("least margin", f"{float(found.margins[found.proven].min()):.3g} (of 1; 0 would be singular)"))
    show(TextTable(f"{found.robot}: a box, {found.status}", ("of the box", ""), rows))
    wrong = found.counter_example
    if wrong is not None:
        at = ", ".join(
            f"{name} = {round(value, 12):.6g} {'rad' if name.startswith('r') else 'm'}"
            for name, value in wrong.at.items()
        )
        say(f"Not so at {at}: {wrong.why}{f' of {wrong.joint}' if wrong.joint else ''}.")
        say(f"{wrong.shown}.")
    elif found.is_certified:
        say("Every point of it is reached on one branch, within joint limits, without a singularity.")
    else:
        where = ", ".join(
            f"{name} = {low:.6g} .. {high:.6g} {unit}"
            for (name, (low, high)), unit in zip(found.doubtful.items(), found.units, strict=True)
        )
        say(f"Neither proven nor refused within the budget. The smallest sub-box that is not proven: {where}.")
        say(
            "A singularity or a joint limit may be in it or close by: leave it out of the box, or allow more by --most "
            f"(it looked at {found.looked}) and --seconds."
        )
    if picture is not None:
        say(f"Picture: {picture}")
