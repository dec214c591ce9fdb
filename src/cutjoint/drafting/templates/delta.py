"""A Delta robot: three motors on the base, arms, pairs of parallel rods, and a platform that stays level.

The base is on top and z points up.  Limb i stands at phi_i = 120 degrees (i - 1) about z; in its plane x points
outwards, and its arm is level and points outwards at 0 and down at 90 degrees.  The rods hang on a cross bar at the
elbow, on two hinges each; their six balls at the platform are cut.  After R. Clavel, Delta, a fast robot with parallel
geometry, 18th International Symposium on Industrial Robots, 1988.
"""

from __future__ import annotations

from math import asin, atan2, cos, nan, pi, radians, sin, sqrt

from cutjoint.drafting.choosing import best_angle
from cutjoint.drafting.planar import wrapped
from cutjoint.drafting.sketch import Coordinate, LinkSketch, Loop, Sketch, Tie, Vector, ball, bar, box, rod
from cutjoint.drafting.template import Size, Sizes, Template
from cutjoint.errors import InputError

COLOURS = ("blue", "orange", "green")
PREFERRED = 0.25
ARM_RANGE = (radians(-85.0), radians(105.0))
SWING = radians(80.0)
"""How far a rod swings to its side [rad]."""


def sketch(size: Sizes) -> Sketch:
    """The robot with its platform below the middle of the base, elbows out.

    Raises:
        InputError: it cannot close.
    """
    limb = _Limb(size)
    home = best_angle(limb.score, PREFERRED, *ARM_RANGE)
    if home is None:
        raise InputError(
            f"a Delta of these sizes cannot close with its elbows out: from the elbow to the platform it is at least "
            f"{min(map(limb.out, ARM_RANGE)):.6g} m sideways, the rod is {limb.rod:.6g} m long; the rod must be longer "
            "than that, and an elbow can be outside the platform: base larger than platform, or arm longer"
        )
    height = -limb.arm * sin(home) - limb.down(home)
    bodies, ties, loops = [_base(size)], [], []
    passive: dict[str, Coordinate] = {}
    for i in range(3):
        bodies += limb.bodies(i)
        ties += limb.ties(i)
        loops += limb.loops(i)
        ways = limb.angles((0.0, 0.0, height), i)
        passive |= {f"elbow{i + 1}": ways[1], f"rod{i + 1}a": ways[2], f"rod{i + 1}b": ways[2]}
    bodies += [_platform(size), LinkSketch("tool", "The tool, in the middle of the platform.")]
    ties += [
        Tie("platform", "floating", "base", "platform_link", "The platform is free; the rods hold it."),
        Tie("tool_mount", "fixed", "platform_link", "tool"),
    ]
    return Sketch(
        title="Delta robot",
        source="a template of cutjoint; after R. Clavel, Delta, a fast robot with parallel geometry, 18th "
        "International Symposium on Industrial Robots, 1988",
        notes=(
            "The base is on top, z points up. Arms are level and point outwards at 0, down at pi/2.",
            "Limb 1 points along x, limbs 2 and 3 are turned by 120 and 240 degrees.",
        ),
        bodies=bodies,
        ties=ties,
        loops=loops,
        tool="tool",
        home={f"arm{i}": home for i in (1, 2, 3)},
        passive=passive | {"platform": (0.0, 0.0, height, 0.0, 0.0, 0.0)},
        about_home="platform below the middle of the base, elbows out",
        mobility=3,
    )


def turned(i: int, v: Vector) -> Vector:
    """A vector of limb i in the base."""
    phi = 2.0 * pi * i / 3.0
    return (cos(phi) * v[0] - sin(phi) * v[1], sin(phi) * v[0] + cos(phi) * v[1], v[2])


class _Limb:
    """The geometry of a limb, and its parts."""

    def __init__(self, size: Sizes) -> None:
        self.base, self.platform, self.arm = size["base"], size["platform"], size["arm"]
        self.rod, self.half = size["rod"], 0.5 * size["spacing"]
        self.thin = min(0.012 * (self.arm + self.rod), 0.3 * self.half, 0.25 * self.arm)

    def out(self, angle: float) -> float:
        """How far an elbow is outside the balls of a platform in the middle."""
        return self.base + self.arm * cos(angle) - self.platform

    def down(self, angle: float) -> float:
        """How far a platform in the middle is below the elbows."""
        return sqrt(self.rod**2 - self.out(angle) ** 2)

    def score(self, angle: float) -> float:
        """How well arms move rods (type 1), and rods hold the platform sideways and up (type 2)."""
        if not 0.0 < self.out(angle) < self.rod:
            return nan
        sideways, deep = self.out(angle) / self.rod, self.down(angle) / self.rod
        return min(abs(sin(angle) * sideways + cos(angle) * deep), 1.5 * sideways, deep)

    def angles(self, tool: Vector, i: int) -> tuple[float, float, float]:
        """Arm, elbow and swing of the rods of limb i with the tool at a point, elbow out."""
        x, y, z = turned(-i, tool)
        x += self.platform - self.base
        reach = sqrt(x * x + z * z)
        cosine = (x * x + y * y + z * z + self.arm**2 - self.rod**2) / (2.0 * self.arm * reach)
        arm = atan2(-z, x) - atan2(sqrt(max(1.0 - cosine**2, 0.0)), cosine)
        ux, uz = x - self.arm * cos(arm), z + self.arm * sin(arm)
        return arm, wrapped(atan2(-uz, ux) - arm), asin(y / self.rod)

    def bodies(self, i: int) -> list[LinkSketch]:
        """Arm, cross bar and two rods."""
        thin, colour, end = self.thin, COLOURS[i], (self.arm, 0.0, 0.0)
        across: tuple[Vector, Vector] = ((0.0, -self.half, 0.0), (0.0, self.half, 0.0))
        far = (self.rod, 0.0, 0.0)
        rods = [
            LinkSketch(
                f"rod{i + 1}{side}_link",
                "",
                [rod((0.0, 0.0, 0.0), far, 0.55 * thin, colour)],
                [ball(1.1 * thin, "light", far)],
            )
            for side in "ab"
        ]
        return [
            LinkSketch(
                f"arm{i + 1}_link",
                f"Limb {i + 1}: the arm on its motor, the cross bar at the elbow, two parallel rods.",
                [bar((0.0, 0.0, 0.0), end, (2.6 * thin, 1.6 * thin), colour)],
                [rod((0.0, -2.2 * thin, 0.0), (0.0, 2.2 * thin, 0.0), 2.4 * thin, "dark")],
            ),
            LinkSketch(
                f"elbow{i + 1}_link",
                "",
                [rod(*across, 0.7 * thin, "light")],
                [ball(1.2 * thin, "light", one) for one in across],
            ),
            *rods,
        ]

    def ties(self, i: int) -> list[Tie]:
        """The motor, the elbow, and the hinges of the rods on the cross bar."""
        n, phi = i + 1, 2.0 * pi * i / 3.0
        made = [
            Tie(f"arm{n}", "revolute", "base", f"arm{n}_link", f"The motor of limb {n}.", turned(i, (self.base, 0, 0)),
                (0.0, 0.0, phi), (0.0, 1.0, 0.0), ARM_RANGE, driven=True),
            Tie(f"elbow{n}", "continuous", f"arm{n}_link", f"elbow{n}_link", xyz=(self.arm, 0.0, 0.0),
                axis=(0.0, 1.0, 0.0)),
        ]  # fmt: skip
        for side, y in (("a", self.half), ("b", -self.half)):
            made.append(
                Tie(f"rod{n}{side}", "revolute", f"elbow{n}_link", f"rod{n}{side}_link", xyz=(0.0, y, 0.0),
                    limits=(-SWING, SWING))
            )  # fmt: skip
        return made

    def loops(self, i: int) -> list[Loop]:
        """The balls between the rods and the platform."""
        made = []
        for side, y in (("a", self.half), ("b", -self.half)):
            about = f"Limb {i + 1}: the balls between its rods and the platform." if side == "a" else ""
            at = turned(i, (self.platform, y, 0.0))
            rods = (f"rod{i + 1}{side}_link", (self.rod, 0.0, 0.0))
            made.append(Loop(f"ball{i + 1}{side}", "spherical", about, ("platform_link", at), rods))
        return made


def _base(size: Sizes) -> LinkSketch:
    """A disc above the arms, with a block down to each motor."""
    limb = _Limb(size)
    thin, r = limb.thin, size["base"]
    disc = rod((0.0, 0.0, 3.2 * thin), (0.0, 0.0, 4.8 * thin), r + 3.0 * thin, "grey")
    looks = [disc]
    for i in range(3):
        for side in (-1.0, 1.0):
            at = turned(i, (r, 3.0 * side * thin, 1.2 * thin))
            looks.append(box((3.0 * thin, 1.4 * thin, 4.4 * thin), "grey", at, (0.0, 0.0, 2.0 * pi * i / 3.0)))
    return LinkSketch("base", "The base, which does not move.", (), looks)


def _platform(size: Sizes) -> LinkSketch:
    """A disc with a bar for the two balls of each limb."""
    limb = _Limb(size)
    thin, r, half = limb.thin, size["platform"], limb.half
    disc = rod((0.0, 0.0, -0.8 * thin), (0.0, 0.0, 0.8 * thin), max(0.8 * r, 2.0 * thin), "light")
    bars = [rod(turned(i, (r, -half, 0.0)), turned(i, (r, half, 0.0)), 0.6 * thin, "dark") for i in range(3)]
    spokes = [bar((0.0, 0.0, 0.0), turned(i, (r, 0.0, 0.0)), (1.2 * thin, 2.4 * thin), "light") for i in range(3)]
    tip = rod((0.0, 0.0, -3.5 * thin), (0.0, 0.0, 0.0), 0.9 * thin, "dark")
    return LinkSketch("platform_link", "The platform, which stays level.", [disc], [*bars, *spokes, tip])


TEMPLATE = Template(
    "a Delta robot: three motors move a platform that stays level",
    {
        "base": Size(0.12, "from the middle of the base to the motors' axes"),
        "platform": Size(0.05, "from the middle of the platform to the middle of each pair of balls"),
        "arm": Size(0.2, "an arm, from motor to elbow"),
        "rod": Size(0.4, "a rod, from elbow to platform"),
        "spacing": Size(0.08, "between the two rods of a pair"),
    },
    sketch,
)
