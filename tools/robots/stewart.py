"""A Stewart-Gough platform: six legs universal-prismatic-spherical, six motors, six degrees of freedom.

Leg i: universal joint at the base (a cross between two hinges, first about the radius, then about the tangent),
cylinder, piston.  The platform is a free body and the six ball joints are cut.  The slide's coordinate is the length of
the leg from the centre of the universal joint to the centre of the ball.
"""

from __future__ import annotations

from math import asin, atan2, cos, radians, sin, sqrt

from cutjoint.description import CutJoint, Home, Joint, Link, RobotDescription, Shape
from robots.parts import Vector, ball, bar, box, cut, disc, frame, joint, posture, rigid, rod, slender

BASE, PLATFORM = 0.35, 0.2  # circles of the joints
BASE_ANGLES = (12.0, 108.0, 132.0, 228.0, 252.0, 348.0)
PLATFORM_ANGLES = (48.0, 72.0, 168.0, 192.0, 288.0, 312.0)
CYLINDER, PISTON = 0.34, 0.34
CYLINDER_RADIUS, PISTON_RADIUS = 0.022, 0.012
MASS_CROSS, MASS_CYLINDER, MASS_PISTON, MASS_PLATFORM = 0.2, 1.2, 0.5, 4.0
CROSS, THICKNESS = 0.035, 0.02  # half the cross's length, the platform
SHORTEST, LONGEST = 0.38, 0.66
TILT = radians(75.0)  # how far a universal joint bends
HOME: Vector = (0.0, 0.0, 0.48)
COLOUR = ("blue", "sky", "vermilion", "orange", "green", "yellow")
NOTES = ("Six legs universal-prismatic-spherical; the slides' coordinates are the leg lengths.",)


def robot() -> RobotDescription:
    """The robot with its platform level at home."""
    links = [Link("base", None, _base())]
    joints: list[Joint] = []
    cuts: list[CutJoint] = []
    for i in range(6):
        links += _leg_links(i)
        joints += _leg_joints(i)
        cuts.append(
            cut(f"ball{i + 1}", "spherical", frame("platform_link", on_platform(i)), frame(f"leg{i + 1}_piston"))
        )
    links += [Link("platform_link", disc(MASS_PLATFORM, PLATFORM, THICKNESS, "z"), _platform()), Link("tool")]
    joints += [
        joint("platform", "floating", "base", "platform_link"),
        joint("tool_mount", "fixed", "platform_link", "tool"),
    ]
    return RobotDescription(
        name="stewart",
        title="Stewart-Gough platform",
        source="Architecture of V. E. Gough and S. G. Whitehall, Universal tyre test machine, FISITA 1962, and "
        "D. Stewart, A platform with six degrees of freedom, Proc. Institution of Mechanical Engineers 180 "
        "(1965); size and masses are this project's",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        actuators=tuple(f"leg{i + 1}_slide" for i in range(6)),
        tool=frame("tool"),
        homes=(_home(),),
    )


def _on_circle(radius: float, degrees: float) -> Vector:
    return (radius * cos(radians(degrees)), radius * sin(radians(degrees)), 0.0)


def on_base(i: int) -> Vector:
    """Centre of the universal joint of leg i."""
    return _on_circle(BASE, BASE_ANGLES[i])


def on_platform(i: int) -> Vector:
    """Centre of the ball of leg i in the platform's frame."""
    return _on_circle(PLATFORM, PLATFORM_ANGLES[i])


def _home() -> Home:
    actuated: dict[str, float] = {}
    passive: dict[str, float | tuple[float, ...]] = {}
    for i in range(6):
        a, b, turn = on_base(i), on_platform(i), radians(BASE_ANGLES[i])
        dx, dy, dz = (HOME[k] + b[k] - a[k] for k in range(3))
        length = sqrt(dx * dx + dy * dy + dz * dz)
        x, y = cos(turn) * dx + sin(turn) * dy, -sin(turn) * dx + cos(turn) * dy
        # direction of the leg = Rx(swing) Ry(tilt) z = (sin tilt, -sin swing cos tilt, cos swing cos tilt)
        actuated[f"leg{i + 1}_slide"] = length
        passive |= {f"leg{i + 1}_swing": atan2(-y, dz), f"leg{i + 1}_tilt": asin(x / length)}
    passive["platform"] = (*HOME, 0.0, 0.0, 0.0)
    return posture("default", "platform level, legs near the middle of their stroke", actuated, passive)


def _leg_joints(i: int) -> list[Joint]:
    leg, turn = f"leg{i + 1}", (0.0, 0.0, radians(BASE_ANGLES[i]))
    return [
        joint(
            f"{leg}_swing",
            "revolute",
            "base",
            f"{leg}_cross",
            on_base(i),
            turn,
            axis=(1.0, 0.0, 0.0),
            lower=-TILT,
            upper=TILT,
        ),
        joint(
            f"{leg}_tilt", "revolute", f"{leg}_cross", f"{leg}_cylinder", axis=(0.0, 1.0, 0.0), lower=-TILT, upper=TILT
        ),
        joint(
            f"{leg}_slide",
            "prismatic",
            f"{leg}_cylinder",
            f"{leg}_piston",
            axis=(0.0, 0.0, 1.0),
            lower=SHORTEST,
            upper=LONGEST,
            effort=500.0,
            velocity=2.0,
        ),
    ]


def _leg_links(i: int) -> list[Link]:
    leg, colour = f"leg{i + 1}", COLOUR[i]
    # two equal rods, half the mass each, along x and y
    arm = 0.5 * MASS_CROSS * (2.0 * CROSS) ** 2 / 12.0 + 0.25 * MASS_CROSS * 0.006**2
    cross = rigid(MASS_CROSS, (0.0, 0.0, 0.0), (arm, arm, 2.0 * (arm - 0.25 * MASS_CROSS * 0.006**2)))
    cross_looks = (
        rod((-CROSS, 0.0, 0.0), (CROSS, 0.0, 0.0), 0.006, "light"),
        rod((0.0, -CROSS, 0.0), (0.0, CROSS, 0.0), 0.006, "light"),
    )
    cylinder_looks = (rod((0.0, 0.0, 0.02), (0.0, 0.0, CYLINDER), CYLINDER_RADIUS, colour), *_fork())
    piston_looks = (
        rod((0.0, 0.0, -PISTON), (0.0, 0.0, 0.0), PISTON_RADIUS, "light"),
        ball(0.018, "dark"),
    )
    return [
        Link(f"{leg}_cross", cross, cross_looks),
        Link(f"{leg}_cylinder", slender(MASS_CYLINDER, CYLINDER, CYLINDER_RADIUS, "z"), cylinder_looks),
        Link(f"{leg}_piston", slender(MASS_PISTON, PISTON, PISTON_RADIUS, "z", sign=-1), piston_looks),
    ]


def _fork() -> tuple[Shape, ...]:
    """The cylinder's end that holds the cross along y."""
    return tuple(box((0.02, 0.006, 0.045), "dark", (0.0, s * 0.03, 0.012)) for s in (-1.0, 1.0))


def _base() -> tuple[Shape, ...]:
    """A disc with a pair of ears for the cross of each leg."""
    shapes = [rod((0.0, 0.0, -0.075), (0.0, 0.0, -0.045), BASE + 0.06, "base")]
    for i in range(6):
        turn = radians(BASE_ANGLES[i])
        for s in (-0.032, 0.032):
            at = ((BASE + s) * cos(turn), (BASE + s) * sin(turn), -0.018)
            shapes.append(box((0.008, 0.02, 0.06), "dark", at, (0.0, 0.0, turn)))
    return tuple(shapes)


def _platform() -> tuple[Shape, ...]:
    """A disc with bars out to the pairs of balls."""
    half = 0.5 * THICKNESS
    shapes: list[Shape] = [rod((0.0, 0.0, -half), (0.0, 0.0, half), 0.8 * PLATFORM, "light")]
    for i in range(6):
        shapes.append(bar((0.0, 0.0, 0.0), on_platform(i), (0.016, 0.04), "light"))
    shapes.append(rod((0.0, 0.0, half), (0.0, 0.0, half + 0.02), 0.04, "dark"))
    return tuple(shapes)
