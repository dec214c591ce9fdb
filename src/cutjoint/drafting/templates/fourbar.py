"""A planar four-bar: crank, coupler, rocker and the ground, one motor at the crank, the tool on the coupler's line."""

from __future__ import annotations

from math import cos, hypot, nan, sin, sqrt

from cutjoint.drafting.choosing import best_angle, usable_range
from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, meet, wrapped
from cutjoint.drafting.sketch import Body, Loop, Sketch, Tie, ball
from cutjoint.drafting.template import Size, Sizes, Template
from cutjoint.errors import InputError

PREFERRED = 2.0
"""Crank angle [rad] at which Hoeken's linkage is on its straight run."""


def sketch(size: Sizes) -> Sketch:
    """The linkage with its crank where the coupler pushes the rocker well.

    Raises:
        InputError: it cannot close.
    """
    crank, coupler, rocker, ground, tracer = (
        size[one] for one in ("crank", "coupler", "rocker", "ground", "tracer")
    )
    named = {"crank": crank, "coupler": coupler, "rocker": rocker, "ground": ground}
    longest = max(named, key=lambda one: named[one])
    others = sum(named.values()) - named[longest]

    def tip(angle: float) -> Point:
        return (crank * cos(angle), crank * sin(angle))

    def score(angle: float) -> float:
        """Sine of the angle between coupler and rocker."""
        across = hypot(tip(angle)[0] - ground, tip(angle)[1])
        cosine = (coupler**2 + rocker**2 - across**2) / (2.0 * coupler * rocker)
        return sqrt(1.0 - cosine * cosine) if abs(cosine) < 1.0 else nan

    home = best_angle(score, PREFERRED)
    if home is None or named[longest] >= others:
        raise InputError(
            f"a four-bar of these sizes cannot close: {longest} is {named[longest]:.6g} m, the other three together "
            f"reach {others:.6g} m; make {longest} shorter or another longer"
        )
    limits = usable_range(score, home)
    top, pivot = tip(home), (ground, 0.0)
    knee = meet(top, pivot, coupler, rocker, 1)
    along = angle_of(top, knee)
    plane = Plane.of([crank, coupler, rocker])
    goes = "goes all the way round" if limits is None else "is limited: beyond, the linkage stretches or cannot close"
    end = max(coupler, tracer)
    return Sketch(
        title="Planar four-bar",
        source="a template of cutjoint; Hoeken's straight-line linkage has crank : ground : coupler : rocker : tracer "
        "as 1 : 2 : 2.5 : 2.5 : 5 (R. L. Norton, Design of Machinery)",
        notes=(UPRIGHT_NOTE, "The crank turns about the origin, the rocker about the other end of the ground."),
        bodies=(
            plane.base("The ground, which does not move.", [0.0], [ground]),
            plane.link(
                "crank_link", "The crank, on the motor.", crank, 0, "blue",
                plane.motor((0.0, 0.0), -3, 0), plane.pin((crank, 0.0), 0, 1),
            ),
            plane.link(
                "coupler_link", "The coupler, from the crank to the rocker and on to the tracing point.", end, 1,
                "orange", ball(0.5 * plane.width, "vermilion", plane.at((tracer, 0.0), 1)),
            ),
            plane.link(
                "rocker_link", "The rocker.", rocker, 0, "green",
                plane.pin((0.0, 0.0), -2, 0), plane.pin((rocker, 0.0), 0, 1),
            ),
            Body("tool", "The tracing point."),
        ),
        ties=(
            hinge(
                "crank", "base", "crank_link", (0.0, 0.0), f"The motor; it {goes}.", on_base=True, limits=limits,
                driven=True,
            ),
            hinge("coupler", "crank_link", "coupler_link", (crank, 0.0)),
            hinge("rocker", "base", "rocker_link", pivot, on_base=True),
            Tie("tool_mount", "fixed", "coupler_link", "tool", xyz=(tracer, 0.0, 0.0)),
        ),
        loops=(
            Loop(
                "coupler_to_rocker", "revolute", "The hinge between coupler and rocker, which closes the loop.",
                ("coupler_link", (coupler, 0.0, 0.0)), ("rocker_link", (rocker, 0.0, 0.0)),
            ),
        ),
        tool="tool",
        home={"crank": home},
        passive={"coupler": wrapped(along - home), "rocker": wrapped(angle_of(pivot, knee))},
        about_home="the coupler pushes the rocker well",
        mobility=1,
    )  # fmt: skip


TEMPLATE = Template(
    "a planar four-bar: one motor turns the crank, the tool is a point of the coupler",
    {
        "crank": Size(0.1, "the crank"),
        "coupler": Size(0.25, "the coupler, from crank to rocker"),
        "rocker": Size(0.25, "the rocker"),
        "ground": Size(0.2, "from the crank's pivot to the rocker's"),
        "tracer": Size(0.5, "from the crank's end along the coupler to the tool"),
    },
    sketch,
)
