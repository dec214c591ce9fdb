"""A planar four-bar: crank, coupler, rocker and the ground, one motor at the crank, the tool on the coupler's line."""

from __future__ import annotations

from math import cos, hypot, nan, sin, sqrt

from cutjoint.drafting.choosing import best_angle, usable_range
from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, meet, wrapped
from cutjoint.drafting.sketch import LinkSketch, Loop, Sketch, Tie, ball
from cutjoint.drafting.template import Size, Sizes, Template
from cutjoint.errors import InputError

PREFERRED = 2.0
"""Crank angle [rad] at which Hoeken's linkage is on its straight run."""


def sketch(size: Sizes) -> Sketch:
    """The linkage with its crank where the coupler pushes the rocker well.

    Raises:
        InputError: it cannot close.
    """
    linkage = _Fourbar(size)
    home = best_angle(linkage.score, PREFERRED)
    named = {one: size[one] for one in ("crank", "coupler", "rocker", "ground")}
    longest = max(named, key=lambda one: named[one])
    others = sum(named.values()) - named[longest]
    if home is None or named[longest] >= others:
        raise InputError(
            f"a four-bar of these sizes cannot close: {longest} is {named[longest]:.6g} m, the other three together "
            f"reach {others:.6g} m; make {longest} shorter or another longer"
        )
    top, pivot = linkage.tip(home), (linkage.ground, 0.0)
    knee = meet(top, pivot, linkage.coupler, linkage.rocker, 1)
    return Sketch(
        title="Planar four-bar",
        source="a template of cutjoint; Hoeken's straight-line linkage has crank : ground : coupler : rocker : tracer "
        "as 1 : 2 : 2.5 : 2.5 : 5 (R. L. Norton, Design of Machinery)",
        notes=(UPRIGHT_NOTE, "The crank turns about the origin, the rocker about the other end of the ground."),
        bodies=linkage.bodies(),
        ties=linkage.ties(usable_range(linkage.score, home)),
        loops=(
            Loop(
                "coupler_to_rocker",
                "revolute",
                "The hinge between coupler and rocker, which closes the loop.",
                ("coupler_link", (linkage.coupler, 0.0, 0.0)),
                ("rocker_link", (linkage.rocker, 0.0, 0.0)),
            ),
        ),
        tool="tool",
        home={"crank": home},
        passive={"coupler": wrapped(angle_of(top, knee) - home), "rocker": wrapped(angle_of(pivot, knee))},
        about_home="the coupler pushes the rocker well",
        mobility=1,
    )


class _Fourbar:
    """Its geometry, and its parts."""

    def __init__(self, size: Sizes) -> None:
        self.crank, self.coupler, self.rocker = size["crank"], size["coupler"], size["rocker"]
        self.ground, self.tracer = size["ground"], size["tracer"]

    def tip(self, angle: float) -> Point:
        """The end of the crank."""
        return (self.crank * cos(angle), self.crank * sin(angle))

    def score(self, angle: float) -> float:
        """Sine of the angle between coupler and rocker."""
        x, y = self.tip(angle)
        across = hypot(x - self.ground, y)
        cosine = (self.coupler**2 + self.rocker**2 - across**2) / (2.0 * self.coupler * self.rocker)
        return sqrt(1.0 - cosine * cosine) if abs(cosine) < 1.0 else nan

    def bodies(self) -> list[LinkSketch]:
        """Ground, crank, coupler, rocker and tool."""
        plane = Plane.of([self.crank, self.coupler, self.rocker])
        motor, pin = plane.motor((0.0, 0.0), -3, 0), plane.pin((self.crank, 0.0), 0, 1)
        tracer = ball(0.5 * plane.width, "vermilion", plane.at((self.tracer, 0.0), 1))
        pins = plane.pin((0.0, 0.0), -2, 0), plane.pin((self.rocker, 0.0), 0, 1)
        about = "The coupler, from the crank to the rocker and on to the tracing point."
        return [
            plane.base("The ground, which does not move.", [0.0], [self.ground]),
            plane.link("crank_link", "The crank, on the motor.", self.crank, 0, "blue", motor, pin),
            plane.link("coupler_link", about, max(self.coupler, self.tracer), 1, "orange", tracer),
            plane.link("rocker_link", "The rocker.", self.rocker, 0, "green", *pins),
            LinkSketch("tool", "The tracing point."),
        ]

    def ties(self, limits: tuple[float, float] | None) -> list[Tie]:
        """The hinges; limits [rad] of a crank that cannot go round."""
        goes = "goes all the way round" if limits is None else "stops before the linkage stretches or cannot close"
        about = f"The motor; it {goes}."
        return [
            hinge("crank", "base", "crank_link", (0.0, 0.0), about, on_base=True, limits=limits, driven=True),
            hinge("coupler", "crank_link", "coupler_link", (self.crank, 0.0)),
            hinge("rocker", "base", "rocker_link", (self.ground, 0.0), on_base=True),
            Tie("tool_mount", "fixed", "coupler_link", "tool", xyz=(self.tracer, 0.0, 0.0)),
        ]


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
