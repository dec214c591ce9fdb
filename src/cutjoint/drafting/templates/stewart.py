"""A Stewart-Gough platform: six legs universal-prismatic-spherical, six motors, six degrees of freedom.

Leg i: a cross between two hinges at the base, first about the radius, then about the tangent; cylinder, piston, ball.
The platform is a free body and the six balls are cut.  The slide's coordinate is the length of the leg.
"""

from __future__ import annotations

from math import asin, atan2, cos, radians, sin, sqrt

from cutjoint.drafting.sketch import Coordinate, LinkSketch, Loop, Sketch, Solid, Tie, Vector, ball, bar, box, rod
from cutjoint.drafting.template import Size, Sizes, Template
from cutjoint.errors import InputError

BASE_ANGLES = (12.0, 108.0, 132.0, 228.0, 252.0, 348.0)
PLATFORM_ANGLES = (48.0, 72.0, 168.0, 192.0, 288.0, 312.0)
TILT = radians(80.0)
"""How far a universal joint bends [rad]."""
ROOM = 1.15
"""How much longer than its stroke the shortest leg is at least: the piston goes into the cylinder."""
COLOURS = ("blue", "sky", "vermilion", "orange", "green", "yellow")


def sketch(size: Sizes) -> Sketch:
    """The robot with its platform level above the base, the legs in the middle of their stroke.

    Raises:
        InputError: the legs cannot be built, or stand too flat.
    """
    legs = _Legs(size)
    ways = [legs.ways(i) for i in range(6)]
    length, stroke = ways[0][2], size["stroke"]
    if length - 0.5 * stroke < ROOM * stroke:
        raise InputError(
            f"legs of these sizes cannot be built: they are {length:.6g} m long at home, so with a stroke of "
            f"{stroke:.6g} m the shortest is {length - 0.5 * stroke:.6g} m, and the piston needs {ROOM * stroke:.6g} m "
            "to go into its cylinder; take a smaller stroke or a greater height"
        )
    if max(abs(one) for way in ways for one in way[:2]) > TILT:
        raise InputError(
            f"legs of these sizes stand too flat: a height of {size['height']:.6g} m for a base of "
            f"{size['base']:.6g} m and a platform of {size['platform']:.6g} m (radii); take a greater height"
        )
    passive: dict[str, Coordinate] = {"platform": (0.0, 0.0, size["height"], 0.0, 0.0, 0.0)}
    for i, way in enumerate(ways):
        passive |= {f"leg{i + 1}_swing": way[0], f"leg{i + 1}_tilt": way[1]}
    return Sketch(
        title="Stewart-Gough platform",
        source="a template of cutjoint; V. E. Gough and S. G. Whitehall, FISITA 1962, and D. Stewart, Proc. "
        "Institution of Mechanical Engineers 180 (1965)",
        notes=("z points up. Each slide's coordinate is the length of its leg from cross to ball.",),
        bodies=[
            legs.base(),
            *(body for i in range(6) for body in legs.bodies(i)),
            legs.plate(),
            LinkSketch("tool", "The tool, in the middle of the platform."),
        ],
        ties=[
            *(tie for i in range(6) for tie in legs.ties(i)),
            Tie("platform", "floating", "base", "platform_link", "The platform is free; the legs hold it."),
            Tie("tool_mount", "fixed", "platform_link", "tool"),
        ],
        loops=[
            Loop(
                f"ball{i + 1}", "spherical", "The balls between the legs and the platform." if i == 0 else "",
                ("platform_link", legs.top[i]), (f"leg{i + 1}_piston", (0.0, 0.0, 0.0)),
            )
            for i in range(6)
        ],
        tool="tool",
        home={f"leg{i + 1}_slide": way[2] for i, way in enumerate(ways)},
        passive=passive,
        about_home="platform level, legs in the middle of their stroke",
        mobility=6,
    )  # fmt: skip


class _Legs:
    """Where the legs stand, and their parts."""

    def __init__(self, size: Sizes) -> None:
        self.size = size
        self.foot = [_on_circle(size["base"], one) for one in BASE_ANGLES]
        self.top = [_on_circle(size["platform"], one) for one in PLATFORM_ANGLES]
        self.length = self.ways(0)[2]
        self.shortest = self.length - 0.5 * size["stroke"]
        self.thick = min(0.045 * self.length, 0.09 * size["platform"], 0.09 * size["base"])

    def ways(self, i: int) -> tuple[float, float, float]:
        """Swing, tilt and length of leg i with the platform at home.

        Its direction is Rx(swing) Ry(tilt) z = (sin tilt, -sin swing cos tilt, cos swing cos tilt).
        """
        (ax, ay, _), (bx, by, _) = self.foot[i], self.top[i]
        dx, dy, dz = bx - ax, by - ay, self.size["height"]
        length, turn = sqrt(dx * dx + dy * dy + dz * dz), radians(BASE_ANGLES[i])
        x, y = cos(turn) * dx + sin(turn) * dy, -sin(turn) * dx + cos(turn) * dy
        return atan2(-y, dz), asin(x / length), length

    def bodies(self, i: int) -> list[LinkSketch]:
        """Cross, cylinder and piston."""
        n, t, colour = i + 1, self.thick, COLOURS[i]
        arms = [rod((-1.4 * t, 0.0, 0.0), (1.4 * t, 0.0, 0.0), 0.25 * t, "light")]
        arms.append(rod((0.0, -1.4 * t, 0.0), (0.0, 1.4 * t, 0.0), 0.25 * t, "light"))
        fork = [box((0.8 * t, 0.25 * t, 2.0 * t), "dark", (0.0, side * 1.2 * t, 0.5 * t)) for side in (-1.0, 1.0)]
        tube = 0.92 * self.shortest
        return [
            LinkSketch(f"leg{n}_cross", f"Leg {n}: a cross on the base, the cylinder, the piston with its ball.", arms),
            LinkSketch(f"leg{n}_cylinder", "", [rod((0.0, 0.0, t), (0.0, 0.0, tube), t, colour)], fork),
            LinkSketch(
                f"leg{n}_piston", "",
                [rod((0.0, 0.0, -0.9 * tube), (0.0, 0.0, 0.0), 0.5 * t, "light")], [ball(0.8 * t, "dark")],
            ),
        ]  # fmt: skip

    def ties(self, i: int) -> list[Tie]:
        """Two hinges and the slide."""
        leg, half = f"leg{i + 1}", 0.5 * self.size["stroke"]
        turn = (0.0, 0.0, radians(BASE_ANGLES[i]))
        return [
            Tie(f"{leg}_swing", "revolute", "base", f"{leg}_cross", "", self.foot[i], turn, (1.0, 0.0, 0.0),
                (-TILT, TILT)),
            Tie(f"{leg}_tilt", "revolute", f"{leg}_cross", f"{leg}_cylinder", axis=(0.0, 1.0, 0.0),
                limits=(-TILT, TILT)),
            Tie(f"{leg}_slide", "prismatic", f"{leg}_cylinder", f"{leg}_piston", "The motor.",
                limits=(self.length - half, self.length + half), driven=True),
        ]  # fmt: skip

    def base(self) -> LinkSketch:
        """A disc with a pair of ears for the cross of each leg."""
        t, r = self.thick, self.size["base"]
        looks: list[Solid] = [rod((0.0, 0.0, -3.4 * t), (0.0, 0.0, -2.2 * t), r + 3.0 * t, "grey")]
        for angle in BASE_ANGLES:
            for side in (-1.3, 1.3):
                x, y, _ = _on_circle(r + side * t, angle)
                looks.append(box((0.35 * t, t, 2.8 * t), "dark", (x, y, -0.9 * t), (0.0, 0.0, radians(angle))))
        return LinkSketch("base", "The base, which does not move.", (), looks)

    def plate(self) -> LinkSketch:
        """A disc with bars out to the balls."""
        t, r = self.thick, self.size["platform"]
        disc = rod((0.0, 0.0, -0.5 * t), (0.0, 0.0, 0.5 * t), 0.8 * r, "light")
        bars = [bar((0.0, 0.0, 0.0), one, (0.8 * t, 1.8 * t), "light") for one in self.top]
        hub = rod((0.0, 0.0, 0.5 * t), (0.0, 0.0, 1.4 * t), 0.2 * r, "dark")
        return LinkSketch("platform_link", "The platform.", [disc], [*bars, hub])


def _on_circle(radius: float, degrees: float) -> Vector:
    return (radius * cos(radians(degrees)), radius * sin(radians(degrees)), 0.0)


TEMPLATE = Template(
    "a Stewart-Gough platform: six legs that change their length move a platform in all six ways",
    {
        "base": Size(0.35, "radius of the circle of the legs on the base"),
        "platform": Size(0.2, "radius of the circle of the balls on the platform"),
        "height": Size(0.45, "the platform above the base at home"),
        "stroke": Size(0.2, "by how much a leg can change its length"),
    },
    sketch,
)
