"""A symmetric planar five-bar (5R): two motors on the base, the tool at the hinge of the two distal links."""

from __future__ import annotations

from math import cos, nan, pi, sin, sqrt

from cutjoint.drafting.choosing import best_angle
from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, wrapped
from cutjoint.drafting.sketch import LinkSketch, Loop, Sketch, Tie, ball, rod
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
    linkage = _Fivebar(size)
    right = best_angle(linkage.score, PREFERRED, -0.5 * pi, pi)
    if right is None:
        raise InputError(
            "a five-bar of these sizes cannot close with its elbows out: half the base less the proximal link is "
            f"{0.5 * linkage.base - linkage.proximal:.6g} m, which the distal link of {linkage.distal:.6g} m must be "
            "able to span; make proximal or distal longer, or base shorter"
        )
    turn = angle_of(linkage.elbow(right), linkage.tip(right)) - right
    end = (linkage.distal, 0.0, 0.0)
    return Sketch(
        title="Planar five-bar",
        source="a template of cutjoint; a symmetric planar 5R as in X.-J. Liu, J. Wang and G. Pritschow, Mechanism and "
        "Machine Theory 41 (2006)",
        notes=(UPRIGHT_NOTE, "The motors stand to the left and right of the origin; the tool joins the distal links."),
        bodies=linkage.bodies(),
        ties=linkage.ties(),
        loops=(
            Loop(
                "tip",
                "revolute",
                "The hinge between the two distal links, which closes the loop.",
                ("left_distal", end),
                ("right_distal", end),
            ),
        ),
        tool="tool",
        home={"left_shoulder": pi - right, "right_shoulder": right},
        passive={"left_elbow": wrapped(-turn), "right_elbow": wrapped(turn)},
        about_home="elbows out, tool above the middle of the base",
        mobility=2,
    )


class _Fivebar:
    """Its geometry, and its parts."""

    def __init__(self, size: Sizes) -> None:
        self.base, self.proximal, self.distal = size["base"], size["proximal"], size["distal"]

    def elbow(self, angle: float) -> Point:
        """The right one."""
        return (0.5 * self.base + self.proximal * cos(angle), self.proximal * sin(angle))

    def tip(self, angle: float) -> Point:
        """The tool, in the middle."""
        x, y = self.elbow(angle)
        return (0.0, y + sqrt(self.distal**2 - x * x))

    def score(self, angle: float) -> float:
        """The lesser sine: between proximal and distal link (type 1), or between the distal links (type 2)."""
        x, _ = self.elbow(angle)
        if not 0.0 < x < self.distal:
            return nan
        way = angle_of(self.elbow(angle), self.tip(angle))
        return min(abs(sin(way - angle)), abs(sin(2.0 * (way - 0.5 * pi))))

    def bodies(self) -> list[LinkSketch]:
        """The base, two limbs and the tool."""
        plane = Plane.of([self.proximal, self.distal])
        zero, elbow, end, w = (0.0, 0.0), (self.proximal, 0.0), (self.distal, 0.0), plane.width
        motor, low, pin = plane.motor(zero, -3, 0), plane.motor(zero, -3, -1), plane.pin(elbow, 0, 1)
        left = "The left limb: a link on the motor ..."
        tip = ball(0.7 * w, "vermilion", (0.0, 0.0, plane.layer(2)))
        return [
            plane.base("The base, which does not move.", [-0.5 * self.base, 0.5 * self.base]),
            plane.link("left_proximal", left, self.proximal, 0, "blue", motor, pin),
            plane.link("left_distal", "... and one to the tool.", self.distal, 1, "sky", plane.pin(end, 0, 1)),
            LinkSketch(
                "tool",
                "The tool, on the hinge of the distal links.",
                [tip],
                [rod((0.0, 0.0, 0.0), (0.0, 0.0, 1.2 * w), 0.3 * w, "dark")],
            ),
            plane.link("right_proximal", "The right limb.", self.proximal, -1, "vermilion", low),
            plane.link("right_distal", "", self.distal, 0, "orange", plane.pin(zero, -1, 0)),
        ]

    def ties(self) -> list[Tie]:
        """Two motors, two elbows, and the tool."""
        made = []
        for side, sign in (("left", -0.5), ("right", 0.5)):
            at, about = (sign * self.base, 0.0), f"The {side} motor."
            names = f"{side}_shoulder", "base", f"{side}_proximal"
            made.append(hinge(*names, at, about, on_base=True, limits=RANGE, driven=True))
            made.append(hinge(f"{side}_elbow", f"{side}_proximal", f"{side}_distal", (self.proximal, 0.0)))
        return [*made, Tie("tool_mount", "fixed", "left_distal", "tool", xyz=(self.distal, 0.0, 0.0))]


TEMPLATE = Template(
    "a planar five-bar: two motors on the base lead a point in the plane",
    {
        "base": Size(0.2, "between the two motors"),
        "proximal": Size(0.2, "a link on a motor"),
        "distal": Size(0.25, "a link to the tool"),
    },
    sketch,
)
