"""A planar robot with three motors for two degrees of freedom: three limbs of two links meet at one hinge.

It lies flat, so gravity loads no motor; a third motor leaves one internal preload free.
"""

from __future__ import annotations

from math import cos, pi, sin

from cutjoint.description import Joint, Link, RobotDescription, Shape
from robots.parts import Vector, ball, bar, cut, frame, joint, rigid, rod
from robots.planar import hinge, home, layer, link, motor, pin, two_links, wrapped

CIRCLE, PROXIMAL, DISTAL = 0.3, 0.22, 0.22
MASS_PROXIMAL, MASS_DISTAL, MASS_TOOL = 0.5, 0.35, 0.2
TOOL_RADIUS = 0.016
HOME = (0.03, 0.02)  # tool, x and y
COLOURS = (("blue", "sky"), ("vermilion", "orange"), ("green", "yellow"))
ORIGIN: Vector = (0.0, 0.0, 0.0)
TIP: Vector = (DISTAL, 0.0, 0.0)
NOTES = ("It lies in the x-y plane; three motors, two degrees of freedom.",)


def robot() -> RobotDescription:
    """The robot lying in the x-y plane."""
    links: list[Link] = [Link("base", None, _base())]
    joints: list[Joint] = []
    actuated: dict[str, float] = {}
    passive: dict[str, float] = {}
    for i in (1, 2, 3):
        limb, at = f"limb{i}", corner(i)
        first, second = two_links((at[0], at[1]), HOME, PROXIMAL, DISTAL, 1)
        actuated[f"{limb}_shoulder"] = wrapped(first)
        passive[f"{limb}_elbow"] = wrapped(second - first)
        light, dark = COLOURS[i - 1][1], COLOURS[i - 1][0]
        elbow = pin((PROXIMAL, 0.0, 0.0), 0, i)
        links += [
            link(f"{limb}_proximal", MASS_PROXIMAL, PROXIMAL, 0, dark, motor(ORIGIN, -3, 0), elbow),
            link(f"{limb}_distal", MASS_DISTAL, DISTAL, i, light),
        ]
        joints += [
            hinge(f"{limb}_shoulder", "base", f"{limb}_proximal", at, effort=10.0),
            hinge(f"{limb}_elbow", f"{limb}_proximal", f"{limb}_distal", (PROXIMAL, 0.0, 0.0)),
        ]
    sphere = 0.4 * MASS_TOOL * TOOL_RADIUS**2
    body = rigid(MASS_TOOL, ORIGIN, (sphere, sphere, sphere))
    looks = (ball(TOOL_RADIUS, "dark", (0.0, 0.0, layer(4))), pin(ORIGIN, 1, 3))
    links.append(Link("tool", body, looks))
    joints.append(joint("tool_mount", "fixed", "limb1_distal", "tool", xyz=TIP))
    return RobotDescription(
        name="redundant",
        title="Redundantly actuated planar robot",
        source="Architecture of H. Cheng, Y.-K. Yiu and Z. Li, Dynamics and control of redundantly actuated parallel "
        "manipulators, IEEE/ASME Transactions on Mechatronics 8 (2003); size and masses are this project's",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(
            cut(f"tip{i}", "revolute", frame("limb1_distal", TIP), frame(f"limb{i}_distal", TIP)) for i in (2, 3)
        ),
        actuators=tuple(actuated),
        tool=frame("tool"),
        homes=(home("tool near the middle; the three motor angles agree with one another", actuated, passive),),
    )


def corner(i: int) -> Vector:
    """Motor axis of limb i."""
    angle = 0.5 * pi + 2.0 * pi * (i - 1) / 3.0
    return (CIRCLE * cos(angle), CIRCLE * sin(angle), 0.0)


def _base() -> tuple[Shape, ...]:
    """A triangle of bars under the motors."""
    low = layer(-3) - 0.008
    corners = [(p[0], p[1], low) for p in map(corner, (1, 2, 3))]
    sides = [bar(corners[k], corners[(k + 1) % 3], (0.016, 0.03), "base") for k in range(3)]
    feet = [rod((c[0], c[1], low - 0.008), (c[0], c[1], low + 0.008), 0.04, "base") for c in corners]
    return (*sides, *feet)
