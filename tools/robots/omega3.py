"""The Omega-3 of Adetu, Moore and Roberts: a DELTA with 3 x RRPaR, three translations.

A free platform (floating joint); per chain a half-disc arm on the motor, a cross bar at the elbow and two parallel
rods; six ball joints between the rods' lower ends and the platform are cut.  World frame of the paper: x is the normal
of the base, gravity is along -z.  Chain i is turned by phi_i = 2 pi (i - 1) / 3 about x, equation (9); its arm points
along the local z at theta = 0 and turns about the local y, equation (7).
"""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, radians, sin

from cutjoint.description import CutJoint, Home, Inertial, Joint, Link, RobotDescription, Shape, Variant
from robots.parts import Vector, ball, box, cut, disc, dumbbell, frame, joint, posture, rigid, rod, scale, slender

# Tables I and II of the paper; the row that it prints as R is R_B.
LA, LB, RA, RB = 0.070, 0.146, 0.075, 0.03525
M_PAYLOAD, M_P, M_R, M_SC = 0.070, 0.110, 0.03493, 0.100

# Left open by the paper.
SPACING = 0.040  # between the two rods of a chain
START: Vector = (0.1, 0.0, 0.0)  # middle of the trajectory (43)
EFFORT = 2.0  # N m

# Not in the paper: what the parts look like.
ROD_RADIUS, ARM, PLATE, BACK = 0.003, 0.008, 0.006, -0.085
COLOUR = ("blue", "orange", "green")
NOTES = (
    "World frame of the paper: x is the normal of the base, gravity is along -z.",
    "The cross bars have no mass of their own; each rod has half the mass of its pair.",
)


def robot() -> RobotDescription:
    """The robot with both inertia variants."""
    links = [Link("base", None, _base())]
    joints: list[Joint] = []
    cuts: list[CutJoint] = []
    lumped: dict[str, Inertial] = {}
    for i in (1, 2, 3):
        links += _chain_links(i)
        joints += _chain_joints(i)
        for side, y in (("a", 0.5 * SPACING), ("b", -0.5 * SPACING)):
            lumped[f"rod{i}{side}_link"] = dumbbell(0.5 * M_R, LB, "z")
            ends = frame("platform_link", turned(i, (0.0, y, RB))), frame(f"rod{i}{side}_link", (0.0, 0.0, LB))
            cuts.append(cut(f"ball{i}{side}", "spherical", *ends))
    links += [
        Link("platform_link", disc(M_P, RB, PLATE, "x"), _platform()),
        Link(
            "payload", disc(M_PAYLOAD, 0.015, 0.03, "x"), (rod((-0.015, 0.0, 0.0), (0.015, 0.0, 0.0), 0.015, "dark"),)
        ),
        Link("tool"),
    ]
    joints += [
        joint("platform", "floating", "base", "platform_link"),
        joint("payload_mount", "fixed", "platform_link", "payload"),
        joint("tool_mount", "fixed", "platform_link", "tool"),
    ]
    return RobotDescription(
        name="omega3",
        title="Omega-3",
        source="C. F. Adetu, C. A. Moore and R. G. Roberts, Dynamic Modeling and Control of the OMEGA-3 Parallel "
        "Manipulator",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        actuators=("arm1", "arm2", "arm3"),
        tool=frame("tool"),
        homes=(_home(),),
        variants=(
            Variant("distributed", "uniform rods: the inertias of the URDF itself"),
            Variant("lumped", "the paper's hypothesis: half of each rod's mass at either end", lumped),
        ),
    )


def half_disc() -> Inertial:
    """The arm: a uniform half-disc of radius L_A about the motor axis y, its arc towards the elbow.

    The paper gives mass and radius only.  Inertia about the motor axis m L_A^2 / 2, centre of mass 4 L_A / (3 pi) out.
    """
    d = 4.0 * LA / (3.0 * pi)
    quarter, thick = M_SC * LA**2 / 4.0, M_SC * ARM**2 / 12.0
    inertia = (quarter - M_SC * d**2 + thick, 2.0 * quarter - M_SC * d**2, quarter + thick)
    return rigid(M_SC, (0.0, 0.0, d), inertia)


def turned(i: int, v: Vector) -> Vector:
    """`v` of chain i in the base frame, equation (9)."""
    phi = 2.0 * pi * (i - 1) / 3.0
    return (v[0], cos(phi) * v[1] - sin(phi) * v[2], sin(phi) * v[1] + cos(phi) * v[2])


def chain_angles(p: Vector, i: int) -> tuple[float, float, float]:
    """Arm, bar and rod angle of chain i with the tool at `p`, elbow out; equations (3) to (8)."""
    phi = 2.0 * pi * (i - 1) / 3.0
    x, y, z = p[0], cos(phi) * p[1] + sin(phi) * p[2], -sin(phi) * p[1] + cos(phi) * p[2] - (RA - RB)
    r = hypot(x, z)
    arm = atan2(x, z) - acos((r * r + LA * LA + y * y - LB * LB) / (2.0 * LA * r))
    ux, uz = x - LA * sin(arm), z - LA * cos(arm)
    return arm, (atan2(ux, uz) - arm + pi) % (2.0 * pi) - pi, -atan2(y, hypot(ux, uz))


def _home() -> Home:
    actuated: dict[str, float] = {}
    passive: dict[str, float | tuple[float, ...]] = {}
    for i in (1, 2, 3):
        arm, elbow, tilt = chain_angles(START, i)
        actuated[f"arm{i}"] = arm
        passive |= {f"bar{i}": elbow, f"rod{i}a": tilt, f"rod{i}b": tilt}
    passive["platform"] = (*START, 0.0, 0.0, 0.0)
    return posture(
        "default", "tool on the base's axis in the plane of the paper's trajectory, elbows out", actuated, passive
    )


ROD_SWING = radians(85.0)
"""How far a rod swings on its hinge [rad]; it would have to pass through the cross bar to swing further."""


def _chain_joints(i: int) -> list[Joint]:
    phi = 2.0 * pi * (i - 1) / 3.0
    turn: Vector = (0.0, 1.0, 0.0)
    side: Vector = (1.0, 0.0, 0.0)
    half = 0.5 * SPACING
    return [
        joint(
            f"arm{i}",
            "revolute",
            "base",
            f"arm{i}_link",
            xyz=turned(i, (0.0, 0.0, RA)),
            rpy=(phi, 0.0, 0.0),
            axis=turn,
            lower=-pi,
            upper=pi,
            effort=EFFORT,
            velocity=50.0,
        ),
        joint(f"bar{i}", "revolute", f"arm{i}_link", f"bar{i}_link", xyz=(0.0, 0.0, LA), axis=turn),
        joint(
            f"rod{i}a",
            "revolute",
            f"bar{i}_link",
            f"rod{i}a_link",
            xyz=(0.0, half, 0.0),
            axis=side,
            lower=-ROD_SWING,
            upper=ROD_SWING,
        ),
        joint(
            f"rod{i}b",
            "revolute",
            f"bar{i}_link",
            f"rod{i}b_link",
            xyz=(0.0, -half, 0.0),
            axis=side,
            lower=-ROD_SWING,
            upper=ROD_SWING,
        ),
    ]


def _chain_links(i: int) -> list[Link]:
    half, colour = 0.5 * SPACING, COLOUR[i - 1]
    ends: tuple[Vector, Vector] = ((0.0, -half, 0.0), (0.0, half, 0.0))
    bar_looks = (rod(*ends, 0.0035, "light"), ball(0.006, "light", ends[0]), ball(0.006, "light", ends[1]))
    rod_looks = (rod((0.0, 0.0, 0.0), (0.0, 0.0, LB), ROD_RADIUS, colour), ball(0.0055, "light", (0.0, 0.0, LB)))
    body = slender(0.5 * M_R, LB, ROD_RADIUS, "z")
    return [
        Link(f"arm{i}_link", half_disc(), _arm(colour)),
        Link(f"bar{i}_link", None, bar_looks),
        Link(f"rod{i}a_link", body, rod_looks),
        Link(f"rod{i}b_link", body, rod_looks),
    ]


def _arm(colour: str) -> tuple[Shape, ...]:
    """A half-disc as a polygon: a spoke per segment of the arc, wide enough to touch the next, and a thicker rim."""
    segments, rim = 14, LA - 0.004
    half = 0.5 * pi / segments
    shapes: list[Shape] = []
    for k in range(segments):
        angle = -0.5 * pi + (2 * k + 1) * half
        reach, width = rim * cos(half), 2.0 * rim * sin(half)
        turn: Vector = (0.0, angle, 0.0)
        middle = (sin(angle), 0.0, cos(angle))
        shapes.append(box((width, ARM, reach), colour, scale(0.5 * reach, middle), turn))
        shapes.append(box((width, 1.6 * ARM, 0.005), colour, scale(reach - 0.0025, middle), turn))
    shapes.append(rod((0.0, -0.011, 0.0), (0.0, 0.011, 0.0), 0.011, "dark"))
    return tuple(shapes)


def _base() -> tuple[Shape, ...]:
    """A round plate behind the arms; per chain a post beside the arm that carries the motor."""
    shapes = [rod((BACK - 0.012, 0.0, 0.0), (BACK, 0.0, 0.0), RA + 0.025, "base")]
    for i in (1, 2, 3):
        motor = turned(i, (0.0, 0.011, RA)), turned(i, (0.0, 0.055, RA))
        post = turned(i, (BACK, 0.033, RA)), turned(i, (0.0, 0.033, RA))
        shapes += [rod(*motor, 0.014, "dark"), rod(*post, 0.009, "base")]
    return tuple(shapes)


def _platform() -> tuple[Shape, ...]:
    """A triangular plate with a bar per chain for its two balls."""
    half = 0.5 * PLATE
    shapes: list[Shape] = [rod((-half, 0.0, 0.0), (half, 0.0, 0.0), 0.024, "light")]
    for i in (1, 2, 3):
        ends = turned(i, (0.0, 0.5 * SPACING, RB)), turned(i, (0.0, -0.5 * SPACING, RB))
        follow = turned(i % 3 + 1, (0.0, -0.5 * SPACING, RB))
        shapes += [
            rod(*ends, 0.004, "light"),
            rod(ends[0], follow, 0.003, "light"),
            box((PLATE, 0.026, RB), "light", turned(i, (0.0, 0.0, 0.5 * RB)), (2.0 * pi * (i - 1) / 3.0, 0.0, 0.0)),
        ]
    return tuple(shapes)
