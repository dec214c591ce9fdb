"""A walking leg: Theo Jansen's linkage, one crank, seven links that move, three loops.

The lengths are Jansen's thirteen numbers in units (T. Jansen, The Great Pretender, 010 Publishers, 2007): a and l place
the hip beside the crank, m is the crank, j and k push the upper and the lower triangle b d e and g h i, c carries the
lower one, f joins the two.  The foot runs nearly straight for half a turn.
"""

from __future__ import annotations

from math import cos, hypot, sin

from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, meet, wrapped
from cutjoint.drafting.sketch import Coordinate, LinkSketch, Loop, Sketch, Solid, Tie, ball
from cutjoint.drafting.template import Size, Sizes, Template

UNITS = {
    "a": 38.0, "b": 41.5, "c": 39.3, "d": 40.1, "e": 55.8, "f": 39.4, "g": 36.7,
    "h": 65.7, "i": 49.0, "j": 50.0, "k": 61.9, "l": 7.8, "m": 15.0,
}  # fmt: skip
HOME = 2.0
"""Crank angle [rad]."""


def sketch(size: Sizes) -> Sketch:
    """The leg with its foot down."""
    leg = _Leg(size["crank"] / UNITS["m"])
    return Sketch(
        title="Walking leg (Theo Jansen's linkage)",
        source="a template of cutjoint; proportions of T. Jansen, The Great Pretender, 010 Publishers, 2007",
        notes=(UPRIGHT_NOTE, "The crank turns about the origin; the hip is to its left. Letters are Jansen's."),
        bodies=leg.bodies(),
        ties=leg.ties(),
        loops=leg.loops(),
        tool="tool",
        home={"crank": HOME},
        passive=leg.passive(),
        about_home="the foot on its way along the ground",
        mobility=1,
    )


class _Leg:
    """Where its joints are at home, its lengths by their letters [m], and its parts."""

    def __init__(self, unit: float) -> None:
        self.of = of = {letter: length * unit for letter, length in UNITS.items()}
        self.hip: Point = (-of["a"], -of["l"])
        self.pin: Point = (of["m"] * cos(HOME), of["m"] * sin(HOME))
        self.upper = meet(self.hip, self.pin, of["b"], of["j"], 1)
        self.lower = meet(self.hip, self.pin, of["c"], of["k"], -1)
        self.out = meet(self.hip, self.upper, of["d"], of["e"], 1)
        self.heel = meet(self.out, self.lower, of["f"], of["g"], -1)
        foot = meet(self.lower, self.heel, of["i"], of["h"], 1)
        self.knee, self.toe = _from(self.hip, self.upper, self.out), _from(self.lower, self.heel, foot)

    def bodies(self) -> list[LinkSketch]:
        """The base, the crank and seven links, the foot."""
        of, zero = self.of, (0.0, 0.0)
        plane = Plane.of([of[letter] for letter in "bcfgjk"])
        base = plane.base("The body of the machine, which does not move here.", [0.0], [self.hip[0]])
        motor, crank = plane.motor(zero, -3, 0), plane.pin((of["m"], 0.0), 0, 2)
        pins = {letter: (of[letter], 0.0) for letter in "cjf"}
        ends = plane.pin(zero, 0, 1), plane.pin(pins["f"], 0, 1)
        upper, lower = "The upper triangle (b, d, e), on the hip.", "The lower triangle (g, h, i) with the foot."
        return [
            base,
            plane.link("crank_link", "The crank (m), on the motor.", of["m"], 0, "vermilion", motor, crank),
            _triangle(plane, "thigh", upper, (of["b"], 0.0), self.knee, 0, "blue"),
            plane.link("strut", "The lower link on the hip (c).", of["c"], -1, "sky", plane.pin(pins["c"], -1, 2)),
            plane.link("upper_rod", "To the upper triangle (j).", of["j"], 1, "orange", plane.pin(pins["j"], 0, 1)),
            plane.link("lower_rod", "To the lower triangle (k).", of["k"], 2, "yellow"),
            plane.link("tendon", "From the upper triangle to the lower one (f).", of["f"], 1, "green", *ends),
            _triangle(plane, "shin", lower, (of["g"], 0.0), self.toe, 0, "purple"),
            LinkSketch("tool", "The foot.", (), [ball(0.7 * plane.width, "dark")]),
        ]

    def ties(self) -> list[Tie]:
        """The motor and six hinges."""
        of, x, y = self.of, self.toe[0], self.toe[1]
        about = "The motor; it goes all the way round."
        return [
            hinge("crank", "base", "crank_link", (0.0, 0.0), about, on_base=True, driven=True),
            hinge("hip", "base", "thigh", self.hip, on_base=True),
            hinge("hip_below", "base", "strut", self.hip, on_base=True),
            hinge("crank_pin", "crank_link", "upper_rod", (of["m"], 0.0)),
            hinge("crank_pin_below", "crank_link", "lower_rod", (of["m"], 0.0)),
            hinge("back", "thigh", "tendon", self.knee),
            hinge("knee", "strut", "shin", (of["c"], 0.0)),
            Tie("foot", "fixed", "shin", "tool", xyz=(x, y, 0.0)),
        ]

    def loops(self) -> list[Loop]:
        """The three hinges that close the loops."""
        ends = (
            ("upper", "Loop 1: crank, upper rod, upper triangle.", "upper_rod", "j", "thigh", "b"),
            ("lower", "Loop 2: crank, lower rod, lower link.", "lower_rod", "k", "strut", "c"),
            ("heel", "Loop 3: both triangles, with the link between them.", "tendon", "f", "shin", "g"),
        )
        return [
            Loop(name, "revolute", about, (a, (self.of[at_a], 0.0, 0.0)), (b, (self.of[at_b], 0.0, 0.0)))
            for name, about, a, at_a, b, at_b in ends
        ]

    def passive(self) -> dict[str, Coordinate]:
        """Angles of the hinges at home."""
        thigh, strut = angle_of(self.hip, self.upper), angle_of(self.hip, self.lower)
        return {
            "hip": thigh,
            "hip_below": strut,
            "crank_pin": wrapped(angle_of(self.pin, self.upper) - HOME),
            "crank_pin_below": wrapped(angle_of(self.pin, self.lower) - HOME),
            "back": wrapped(angle_of(self.out, self.heel) - thigh),
            "knee": wrapped(angle_of(self.lower, self.heel) - strut),
        }


def _from(origin: Point, ahead: Point, point: Point) -> Point:
    """A point in a frame at `origin` whose x axis leads to `ahead`."""
    r, angle = hypot(point[0] - origin[0], point[1] - origin[1]), angle_of(origin, point) - angle_of(origin, ahead)
    return (r * cos(angle), r * sin(angle))


def _triangle(plane: Plane, name: str, about: str, b: Point, c: Point, k: int, colour: str) -> LinkSketch:
    """A triangle of three bars between its joint at the origin and two more points."""
    corners: tuple[Point, ...] = ((0.0, 0.0), b, c)
    sides = [plane.bar(corners[i], corners[(i + 1) % 3], k, colour) for i in range(3)]
    looks: list[Solid] = [plane.end(one, k, colour) for one in corners]
    return LinkSketch(name, about, sides, [*looks, plane.pin((0.0, 0.0), -1, k)])


TEMPLATE = Template(
    "a walking leg, Theo Jansen's linkage: one motor, seven links, three loops",
    {"crank": Size(0.06, "the crank; the rest has Jansen's proportions")},
    sketch,
)
