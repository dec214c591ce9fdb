"""A symmetric planar five-bar (5R): two motors on the base, the tool at the hinge of the two distal links."""

from __future__ import annotations

from math import cos, nan, pi, sin, sqrt

from cutjoint.drafting.choosing import best_angle
from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, wrapped
from cutjoint.drafting.sketch import Body, Loop, Sketch, Tie, ball, rod
from cutjoint.drafting.template import Size, Sizes, Template
from cutjoint.errors import InputError

PREFERRED = 1.1
"""Angle of the right proximal link [rad] that looks well: elbows out and up."""
RANGE = (-0.5 * pi, 1.5 * pi)


def sketch(size: Sizes) -> Sketch:
    """The five-bar in the upright plane, elbows out, the tool above the middle of the base.

    Raises:
        InputError: it cannot close.
    """
    base, proximal, distal = size["base"], size["proximal"], size["distal"]

    def elbow(angle: float) -> Point:
        """The right one."""
        return (0.5 * base + proximal * cos(angle), proximal * sin(angle))

    def tip(angle: float) -> Point:
        x, y = elbow(angle)
        return (0.0, y + sqrt(distal * distal - x * x))

    def score(angle: float) -> float:
        """The lesser sine: between proximal and distal link (type 1), or between the distal links (type 2)."""
        x, _ = elbow(angle)
        if not 0.0 < x < distal:
            return nan
        way = angle_of(elbow(angle), tip(angle))
        return min(abs(sin(way - angle)), abs(sin(2.0 * (way - 0.5 * pi))))

    right = best_angle(score, PREFERRED, -0.5 * pi, pi)
    if right is None:
        raise InputError(
            f"a five-bar of these sizes cannot close with its elbows out: half the base less the proximal link is "
            f"{0.5 * base - proximal:.6g} m, which the distal link of {distal:.6g} m must be able to span; "
            "make proximal or distal longer, or base shorter"
        )
    turn = angle_of(elbow(right), tip(right)) - right
    plane, end = Plane.of([proximal, distal]), (distal, 0.0)
    w = plane.width
    return Sketch(
        title="Planar five-bar",
        source="a template of cutjoint; a symmetric planar 5R as in X.-J. Liu, J. Wang and G. Pritschow, Mechanism and "
        "Machine Theory 41 (2006)",
        notes=(UPRIGHT_NOTE, "The motors stand to the left and right of the origin; the tool joins the distal links."),
        bodies=(
            plane.base("The base, which does not move.", [-0.5 * base, 0.5 * base]),
            plane.link(
                "left_proximal", "The left limb: a link on the motor ...", proximal, 0, "blue",
                plane.motor((0.0, 0.0), -3, 0), plane.pin((proximal, 0.0), 0, 1),
            ),
            plane.link("left_distal", "... and one to the tool.", distal, 1, "sky", plane.pin(end, 0, 1)),
            Body(
                "tool", "The tool, on the hinge of the distal links.",
                [ball(0.7 * w, "vermilion", (0.0, 0.0, plane.layer(2)))],
                [rod((0.0, 0.0, 0.0), (0.0, 0.0, 1.2 * w), 0.3 * w, "dark")],
            ),
            plane.link(
                "right_proximal", "The right limb.", proximal, -1, "vermilion", plane.motor((0.0, 0.0), -3, -1)
            ),
            plane.link("right_distal", "", distal, 0, "orange", plane.pin((0.0, 0.0), -1, 0)),
        ),
        ties=(
            hinge(
                "left_shoulder", "base", "left_proximal", (-0.5 * base, 0.0), "The left motor.", on_base=True,
                limits=RANGE, driven=True,
            ),
            hinge("left_elbow", "left_proximal", "left_distal", (proximal, 0.0)),
            Tie("tool_mount", "fixed", "left_distal", "tool", xyz=(distal, 0.0, 0.0)),
            hinge(
                "right_shoulder", "base", "right_proximal", (0.5 * base, 0.0), "The right motor.", on_base=True,
                limits=RANGE, driven=True,
            ),
            hinge("right_elbow", "right_proximal", "right_distal", (proximal, 0.0)),
        ),
        loops=(
            Loop(
                "tip", "revolute", "The hinge between the two distal links, which closes the loop.",
                ("left_distal", (distal, 0.0, 0.0)), ("right_distal", (distal, 0.0, 0.0)),
            ),
        ),
        tool="tool",
        home={"left_shoulder": pi - right, "right_shoulder": right},
        passive={"left_elbow": wrapped(-turn), "right_elbow": wrapped(turn)},
        about_home="elbows out, tool above the middle of the base",
        mobility=2,
    )  # fmt: skip


TEMPLATE = Template(
    "a planar five-bar: two motors on the base lead a point in the plane",
    {
        "base": Size(0.2, "between the two motors"),
        "proximal": Size(0.2, "a link on a motor"),
        "distal": Size(0.25, "a link to the tool"),
    },
    sketch,
)
