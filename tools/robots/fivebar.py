"""A symmetric planar five-bar (5R): two motors on the base, the tool at the hinge of the two distal links."""

from __future__ import annotations

from cutjoint.description import Link, RobotDescription
from robots.parts import Vector, ball, box, cut, frame, joint, rigid, rod
from robots.planar import UPRIGHT, hinge, home, layer, link, motor, pin, two_links, wrapped

BASE, PROXIMAL, DISTAL = 0.2, 0.2, 0.25
MASS_PROXIMAL, MASS_DISTAL, MASS_TOOL = 0.4, 0.3, 0.15
TOOL_RADIUS = 0.018
HOME = (0.03, 0.3)  # tool, x and z
ORIGIN: Vector = (0.0, 0.0, 0.0)
LEFT, RIGHT = (-0.5 * BASE, 0.0, 0.0), (0.5 * BASE, 0.0, 0.0)
NOTES = ("It stands in the x-z plane; angles count from x towards z.",)


def robot() -> RobotDescription:
    """The five-bar in the upright plane, elbows out."""
    left, left_distal = two_links((LEFT[0], 0.0), HOME, PROXIMAL, DISTAL, 1)
    right, right_distal = two_links((RIGHT[0], 0.0), HOME, PROXIMAL, DISTAL, -1)
    base = (
        box((BASE + 0.12, 0.05, 0.02), "base", (0.0, 0.035, -0.05)),
        box((0.06, 0.03, 0.05), "base", (LEFT[0], 0.035, -0.025)),
        box((0.06, 0.03, 0.05), "base", (RIGHT[0], 0.035, -0.025)),
    )
    tip = (DISTAL, 0.0, 0.0)
    sphere = 0.4 * MASS_TOOL * TOOL_RADIUS**2
    tool = rigid(MASS_TOOL, (0.0, 0.0, 0.0), (sphere, sphere, sphere))
    return RobotDescription(
        name="fivebar",
        title="Planar five-bar",
        source="Symmetric planar 5R as in X.-J. Liu, J. Wang and G. Pritschow, Performance atlases and optimum design "
        "of planar 5R symmetrical parallel mechanisms, Mechanism and Machine Theory 41 (2006); size and masses are "
        "this project's",
        links=(
            Link("base", None, base),
            link(
                "left_proximal", MASS_PROXIMAL, PROXIMAL, 0, "blue", motor(ORIGIN, -4, 0), pin((PROXIMAL, 0, 0), 0, 1)
            ),
            link("left_distal", MASS_DISTAL, DISTAL, 1, "sky", pin(tip, 0, 1)),
            Link(
                "tool",
                tool,
                (ball(TOOL_RADIUS, "vermilion", (0, 0, layer(2))), rod(ORIGIN, (0, 0, 0.03), 0.008, "dark")),
            ),
            link("right_proximal", MASS_PROXIMAL, PROXIMAL, -1, "vermilion", motor(ORIGIN, -4, -1)),
            link("right_distal", MASS_DISTAL, DISTAL, 0, "orange", pin(ORIGIN, -1, 0)),
        ),
        joints=(
            hinge("left_shoulder", "base", "left_proximal", LEFT, UPRIGHT, effort=10.0),
            hinge("left_elbow", "left_proximal", "left_distal", (PROXIMAL, 0.0, 0.0)),
            joint("tool_mount", "fixed", "left_distal", "tool", xyz=tip),
            hinge("right_shoulder", "base", "right_proximal", RIGHT, UPRIGHT, effort=10.0),
            hinge("right_elbow", "right_proximal", "right_distal", (PROXIMAL, 0.0, 0.0)),
        ),
        cuts=(cut("tip", "revolute", frame("left_distal", tip), frame("right_distal", tip)),),
        actuators=("left_shoulder", "right_shoulder"),
        tool=frame("tool"),
        homes=(
            home(
                "elbows out, tool above the base",
                {"left_shoulder": wrapped(left), "right_shoulder": wrapped(right)},
                {"left_elbow": wrapped(left_distal - left), "right_elbow": wrapped(right_distal - right)},
            ),
        ),
    )
