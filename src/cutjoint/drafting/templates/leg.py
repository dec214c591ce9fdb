"""A walking leg: Theo Jansen's linkage, one crank, seven links that move, three loops.

The lengths are Jansen's thirteen numbers in units (T. Jansen, The Great Pretender, 010 Publishers, 2007): a and l place
the hip beside the crank, m is the crank, j and k push the upper and the lower triangle b d e and g h i, c carries the
lower one, f joins the two.  The foot runs nearly straight for half a turn.
"""

from __future__ import annotations

from math import cos, hypot, sin

from cutjoint.drafting.planar import UPRIGHT_NOTE, Plane, Point, angle_of, hinge, meet, wrapped
from cutjoint.drafting.sketch import Body, Loop, Sketch, Solid, Tie, ball
from cutjoint.drafting.template import Size, Sizes, Template

A, B, C, D, E, F, G = 38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7
H, I, J, K, L, M = 65.7, 49.0, 50.0, 61.9, 7.8, 15.0
HOME = 2.0
"""Crank angle [rad]."""


def sketch(size: Sizes) -> Sketch:
    """The leg with its foot down."""
    u = size["unit"]
    hip: Point = (-A * u, -L * u)
    pin: Point = (M * u * cos(HOME), M * u * sin(HOME))
    upper = meet(hip, pin, B * u, J * u, 1)
    lower = meet(hip, pin, C * u, K * u, -1)
    out = meet(hip, upper, D * u, E * u, 1)
    heel = meet(out, lower, F * u, G * u, -1)
    foot = meet(lower, heel, I * u, H * u, 1)
    plane = Plane.of([one * u for one in (B, C, F, G, J, K)])
    knee, toe = _from(hip, upper, out), _from(lower, heel, foot)
    return Sketch(
        title="Walking leg (Theo Jansen's linkage)",
        source="a template of cutjoint; proportions of T. Jansen, The Great Pretender, 010 Publishers, 2007",
        notes=(UPRIGHT_NOTE, "The crank turns about the origin; the hip is to its left. Letters are Jansen's."),
        bodies=(
            plane.base("The body of the machine, which does not move here.", [0.0], [hip[0]]),
            plane.link(
                "crank_link", "The crank (m), on the motor.", M * u, 0, "vermilion",
                plane.motor((0.0, 0.0), -3, 0), plane.pin((M * u, 0.0), 0, 2),
            ),
            _triangle(plane, "thigh", "The upper triangle (b, d, e), on the hip.", (B * u, 0.0), knee, 0, "blue"),
            plane.link("strut", "The lower link on the hip (c).", C * u, -1, "sky", plane.pin((C * u, 0.0), -1, 2)),
            plane.link("upper_rod", "From the crank to the upper triangle (j).", J * u, 1, "orange",
                       plane.pin((J * u, 0.0), 0, 1)),
            plane.link("lower_rod", "From the crank to the lower triangle (k).", K * u, 2, "yellow"),
            plane.link("tendon", "From the upper triangle to the lower one (f).", F * u, 1, "green",
                       plane.pin((0.0, 0.0), 0, 1), plane.pin((F * u, 0.0), 0, 1)),
            _triangle(plane, "shin", "The lower triangle (g, h, i) with the foot.", (G * u, 0.0), toe, 0, "purple"),
            Body("tool", "The foot.", (), [ball(0.7 * plane.width, "dark")]),
        ),
        ties=(
            hinge("crank", "base", "crank_link", (0.0, 0.0), "The motor; it goes all the way round.", on_base=True,
                  driven=True),
            hinge("hip", "base", "thigh", hip, on_base=True),
            hinge("hip_below", "base", "strut", hip, on_base=True),
            hinge("crank_pin", "crank_link", "upper_rod", (M * u, 0.0)),
            hinge("crank_pin_below", "crank_link", "lower_rod", (M * u, 0.0)),
            hinge("back", "thigh", "tendon", knee),
            hinge("knee", "strut", "shin", (C * u, 0.0)),
            Tie("foot", "fixed", "shin", "tool", xyz=(toe[0], toe[1], 0.0)),
        ),
        loops=(
            Loop("upper", "revolute", "Loop 1: crank, upper rod, upper triangle.", ("upper_rod", (J * u, 0.0, 0.0)),
                 ("thigh", (B * u, 0.0, 0.0))),
            Loop("lower", "revolute", "Loop 2: crank, lower rod, lower link.", ("lower_rod", (K * u, 0.0, 0.0)),
                 ("strut", (C * u, 0.0, 0.0))),
            Loop("heel", "revolute", "Loop 3: both triangles, with the link between them.",
                 ("tendon", (F * u, 0.0, 0.0)), ("shin", (G * u, 0.0, 0.0))),
        ),
        tool="tool",
        home={"crank": HOME},
        passive={
            "hip": angle_of(hip, upper),
            "hip_below": angle_of(hip, lower),
            "crank_pin": wrapped(angle_of(pin, upper) - HOME),
            "crank_pin_below": wrapped(angle_of(pin, lower) - HOME),
            "back": wrapped(angle_of(out, heel) - angle_of(hip, upper)),
            "knee": wrapped(angle_of(lower, heel) - angle_of(hip, lower)),
        },
        about_home="the foot on its way along the ground",
        mobility=1,
    )  # fmt: skip


def _from(origin: Point, ahead: Point, point: Point) -> Point:
    """A point in a frame at `origin` whose x axis leads to `ahead`."""
    r, angle = hypot(point[0] - origin[0], point[1] - origin[1]), angle_of(origin, point) - angle_of(origin, ahead)
    return (r * cos(angle), r * sin(angle))


def _triangle(plane: Plane, name: str, about: str, b: Point, c: Point, k: int, colour: str) -> Body:
    """A triangle of three bars between its joint at the origin and two more points."""
    corners: tuple[Point, ...] = ((0.0, 0.0), b, c)
    sides = [plane.bar(corners[i], corners[(i + 1) % 3], k, colour) for i in range(3)]
    looks: list[Solid] = [plane.end(one, k, colour) for one in corners]
    return Body(name, about, sides, [*looks, plane.pin((0.0, 0.0), -1, k)])


TEMPLATE = Template(
    "a walking leg, Theo Jansen's linkage: one motor, seven links, three loops",
    {"unit": Size(0.004, "one of Jansen's units: the crank has 15, the leg reaches about 100")},
    sketch,
)
