"""A planar four-bar: Hoeken's straight-line linkage, one motor at the crank.

Proportions 1 : 2 : 2.5 : 2.5 of crank, ground, coupler and rocker; the coupler goes on for another 2.5 to the tracing
point, which runs almost straight while the crank is on the far side of the rocker.
"""

from __future__ import annotations

from math import cos, pi, sin

from cutjoint.description import Link, RobotDescription
from robots.parts import ball, box, cut, frame, joint
from robots.planar import UPRIGHT, hinge, home, layer, link, motor, pin, two_links, wrapped

CRANK = 0.1
GROUND, COUPLER, ROCKER, TRACER = 2.0 * CRANK, 2.5 * CRANK, 2.5 * CRANK, 5.0 * CRANK
MASS_CRANK, MASS_COUPLER, MASS_ROCKER = 0.25, 0.8, 0.45
HOME = 2.0  # rad
NOTES = ("It stands in the x-z plane; angles count from x towards z.",)


def robot() -> RobotDescription:
    """The linkage in the upright plane."""
    tip = (CRANK * cos(HOME), CRANK * sin(HOME))
    coupler, back = two_links(tip, (GROUND, 0.0), COUPLER, ROCKER, 1)
    base = (
        box((GROUND + 0.1, 0.05, 0.02), "base", (0.5 * GROUND, 0.03, -0.05)),
        box((0.03, 0.02, 0.06), "base", (0.0, 0.03, -0.015)),
        box((0.03, 0.02, 0.06), "base", (GROUND, 0.03, -0.015)),
    )
    return RobotDescription(
        name="fourbar",
        title="Planar four-bar",
        source="Hoeken's straight-line linkage, proportions as in R. L. Norton, Design of Machinery; size and masses "
        "are this project's",
        links=(
            Link("base", None, base),
            link("crank_link", MASS_CRANK, CRANK, 0, "blue", motor((0.0, 0.0, 0.0), -3, 0), pin((CRANK, 0, 0), 0, 1)),
            link("coupler_link", MASS_COUPLER, TRACER, 1, "orange", ball(0.012, "vermilion", (TRACER, 0, layer(1)))),
            link("rocker_link", MASS_ROCKER, ROCKER, 0, "green", pin((0, 0, 0), -2, 0), pin((ROCKER, 0, 0), 0, 1)),
            Link("tool"),
        ),
        joints=(
            hinge("crank", "base", "crank_link", (0.0, 0.0, 0.0), UPRIGHT, effort=10.0),
            hinge("coupler", "crank_link", "coupler_link", (CRANK, 0.0, 0.0)),
            hinge("rocker", "base", "rocker_link", (GROUND, 0.0, 0.0), UPRIGHT),
            joint("tool_mount", "fixed", "coupler_link", "tool", xyz=(TRACER, 0.0, 0.0)),
        ),
        cuts=(
            cut(
                "coupler_to_rocker",
                "revolute",
                frame("coupler_link", (COUPLER, 0.0, 0.0)),
                frame("rocker_link", (ROCKER, 0.0, 0.0)),
            ),
        ),
        actuators=("crank",),
        tool=frame("tool"),
        homes=(
            home(
                "tracing point on its straight run",
                {"crank": HOME},
                {"coupler": wrapped(coupler - HOME), "rocker": wrapped(back + pi)},
            ),
        ),
    )
