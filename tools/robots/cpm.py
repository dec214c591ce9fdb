"""The Cartesian Parallel Manipulator of Elkady, Elkobrosy, Hanna and Sobh (2008): 3 x PRRR, three translations.

Limb i: guide rod along an axis, slider A_i, proximal rod A_i M_i, distal rod M_i B_i, platform.  Every joint axis of a
limb is parallel to its guide rod, so the platform cannot turn.  Equations (1) to (9) of the paper fix the rods'
directions at angle zero (y, z, x) and the turning senses (x, y, -z).
"""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin

import numpy as np

from cutjoint.description import Home, Inertial, Joint, Link, RobotDescription, Shape, Variant
from robots.parts import Vector, add, ball, bar, block, box, cut, dumbbell, frame, joint, posture, rod, scale, slender

# Tables 1 and 2 of the paper.
L, L1, L2, D = 0.105, 0.5, 0.373, 0.9144
M1, M2, M3, M4 = 1.892994, 0.695528, 0.2, 0.3
EFFORT = 120.0  # N, section 5.3
START: Vector = (0.6, 0.425, 0.3)  # first point of the circle, section 5.3
SIGNS = (1, -1, 1)  # elbow of each limb; the paper leaves it open

# Not in the paper: what the parts look like.
ROD_RADIUS, GUIDE_RADIUS, SLIDER, PLATE, OFFSET = 0.012, 0.012, 0.06, 0.012, 0.018
GUIDE_END = 0.98

AXIS: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TURN: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
ALONG = ("y", "z", "x")
ROD: tuple[Vector, ...] = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
GUIDE: tuple[Vector, ...] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, D, 0.0))
TO_CENTRE: tuple[Vector, ...] = ((0.0, L, 0.0), (L, 0.0, 0.0), (0.0, -L, 0.0))  # from B_i to P
COLOUR = ("blue", "orange", "green")
NOTES = (
    "World frame of the paper: z points down, so gravity is along +z.",
    "Each limb carries a third of the tool and platform mass m4, as a third of a plate around P.",
)


def robot() -> RobotDescription:
    """The robot with both inertia variants."""
    links = [Link("base", None, _base())]
    joints: list[Joint] = []
    lumped: dict[str, Inertial] = {}
    for i in range(3):
        limb = f"limb{i + 1}"
        links += _limb_links(i)
        joints += _limb_joints(i)
        lumped[f"{limb}_distal"] = dumbbell(M2, L2, ALONG[i])
    links.append(Link("tool"))
    joints.append(joint("tool_mount", "fixed", "limb1_platform", "tool", xyz=TO_CENTRE[0]))
    centre = frame("limb1_platform", TO_CENTRE[0])
    return RobotDescription(
        name="cpm",
        title="Cartesian Parallel Manipulator",
        source="A. Elkady, G. Elkobrosy, S. Hanna and T. Sobh, Cartesian Parallel Manipulator Modeling, Control and "
        "Simulation, in: H. Wu (ed.), Parallel Manipulators, Towards New Applications, I-Tech, 2008, chapter 13",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(
            cut(f"limb{i + 1}_to_platform", "fixed", centre, frame(f"limb{i + 1}_platform", TO_CENTRE[i]))
            for i in (1, 2)
        ),
        actuators=tuple(f"limb{i + 1}_slide" for i in range(3)),
        tool=frame("tool"),
        homes=(_home(),),
        gravity=np.array([0.0, 0.0, 9.81]),
        variants=(
            Variant("distributed", "uniform rods: the inertias of the URDF itself"),
            Variant("lumped", "the paper's hypothesis: half of each distal rod's mass at either end", lumped),
        ),
    )


def limb_angles(p: Vector, i: int, sign: int) -> tuple[float, float]:
    """theta_i1 and theta_i2 of equations (1) to (9) for the tool at `p`."""
    x, y, z = p
    c, s = ((y - L, z), (z, x - L), (x, D - L - y))[i]
    r = hypot(c, s)
    first = atan2(s, c) + sign * acos((r * r + L1 * L1 - L2 * L2) / (2.0 * L1 * r))
    return first, atan2(s - L1 * sin(first), c - L1 * cos(first))


def joints_at(p: Vector, signs: tuple[int, ...]) -> dict[str, float]:
    """All joint coordinates with the tool at `p` and the given elbow signs: the sliders, then limb by limb."""
    values = {f"limb{i + 1}_slide": p[i] for i in range(3)}
    for i, sign in enumerate(signs):
        first, second = limb_angles(p, i, sign)
        limb = f"limb{i + 1}"
        elbow = (second - first + pi) % (2.0 * pi) - pi
        values |= {f"{limb}_shoulder": first, f"{limb}_elbow": elbow, f"{limb}_wrist": -first - elbow}
    return values


def _home() -> Home:
    values = joints_at(START, SIGNS)
    sliders = {name: value for name, value in values.items() if name.endswith("_slide")}
    passive: dict[str, float | tuple[float, ...]] = {k: value for k, value in values.items() if k not in sliders}
    return posture("default", "start of the paper's circle, elbow signs (+, -, +)", sliders, passive)


def _limb_joints(i: int) -> list[Joint]:
    limb = f"limb{i + 1}"
    return [
        joint(
            f"{limb}_slide",
            "prismatic",
            "base",
            f"{limb}_slider",
            xyz=GUIDE[i],
            axis=AXIS[i],
            lower=0.0,
            upper=0.9,
            effort=EFFORT,
            velocity=5.0,
        ),
        joint(f"{limb}_shoulder", "revolute", f"{limb}_slider", f"{limb}_proximal", axis=TURN[i]),
        joint(f"{limb}_elbow", "revolute", f"{limb}_proximal", f"{limb}_distal", xyz=scale(L1, ROD[i]), axis=TURN[i]),
        joint(f"{limb}_wrist", "revolute", f"{limb}_distal", f"{limb}_platform", xyz=scale(L2, ROD[i]), axis=TURN[i]),
    ]


def _limb_links(i: int) -> list[Link]:
    limb, axis, colour = f"limb{i + 1}", AXIS[i], COLOUR[i]
    near, far = scale(OFFSET, axis), scale(-OFFSET, axis)
    elbow, wrist = scale(L1, ROD[i]), scale(L2, ROD[i])
    slider = (
        box((SLIDER, SLIDER, SLIDER), "dark"),
        rod(scale(-0.3 * SLIDER, axis), scale(2.2 * OFFSET, axis), 0.016, "light"),
    )
    proximal = (
        bar(near, add(elbow, near), (0.032, 0.032), colour),
        rod(add(elbow, scale(0.1, near)), add(elbow, scale(1.9, near)), 0.025, colour),
        rod(add(elbow, scale(-1.8, near)), add(elbow, scale(2.2, near)), 0.013, "light"),
    )
    distal = (
        rod(far, add(wrist, far), ROD_RADIUS, colour),
        rod(scale(0.4, far), scale(1.6, far), 0.02, colour),
        rod(add(wrist, scale(0.4, far)), add(wrist, scale(1.6, far)), 0.02, colour),
    )
    third = block(M4 / 3.0, (2.0 * L, 2.0 * L, PLATE), TO_CENTRE[i])
    return [
        Link(f"{limb}_slider", block(M3, (SLIDER, SLIDER, SLIDER)), slider),
        Link(f"{limb}_proximal", slender(M1, L1, ROD_RADIUS, ALONG[i]), proximal),
        Link(f"{limb}_distal", slender(M2, L2, ROD_RADIUS, ALONG[i]), distal),
        Link(f"{limb}_platform", third, _platform(i)),
    ]


def _platform(i: int) -> tuple[Shape, ...]:
    """Limb 1 shows the square plate and the tool, every limb its hinge."""
    hinge = rod(scale(-0.045, AXIS[i]), scale(0.045, AXIS[i]), 0.013, "dark")
    if i > 0:
        return (hinge,)
    centre = TO_CENTRE[0]
    return (
        box((2.0 * L, 2.0 * L, PLATE), "light", centre),
        rod(centre, add(centre, (0.0, 0.0, 0.09)), 0.012, "dark"),
        ball(0.012, "vermilion", add(centre, (0.0, 0.0, 0.09))),
        hinge,
    )


def _base() -> tuple[Shape, ...]:
    """Three guide rods on a frame of corner blocks."""
    shapes: list[Shape] = []
    for i in range(3):
        end = add(GUIDE[i], scale(GUIDE_END if i != 1 else D, AXIS[i]))
        shapes.append(rod(GUIDE[i], end, GUIDE_RADIUS, "base"))
        shapes.append(box((0.07, 0.07, 0.07), "base", end))
    shapes.append(box((0.07, 0.07, 0.07), "base"))
    return tuple(shapes)
