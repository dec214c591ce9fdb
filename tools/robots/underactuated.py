"""A crane: a driven cart carries a load on two rods, which swing freely.

Cart, two rods and load are a four-bar on a slider: two degrees of freedom, one motor.
"""

from __future__ import annotations

from math import atan2, pi, sqrt

from cutjoint.description import Inertial, Link, RobotDescription, Shape
from robots.parts import Vector, ball, block, box, cut, frame, joint, rod
from robots.planar import UPRIGHT, hinge, home, layer, link, pin, wrapped

CART, ROD, WIDTH, DROP = 0.3, 0.5, 0.2, 0.06  # hinges on the cart, rods, hinges on the load, hinges to its centre
MASS_CART, MASS_ROD, MASS_LOAD = 3.0, 0.4, 2.0
CART_SIZE: Vector = (0.4, 0.08, 0.08)
LOAD_SIZE: Vector = (0.24, 0.12, 0.06)  # in the plane's axes: along, up, across
LEFT: Vector = (-0.5 * CART, 0.0, 0.0)
RIGHT: Vector = (0.5 * CART, 0.0, 0.0)
END: Vector = (ROD, 0.0, 0.0)
HOLE: Vector = (WIDTH, 0.0, 0.0)
CENTRE: Vector = (0.5 * WIDTH, -DROP, 0.0)
NOTES = ("It moves in the x-z plane; one motor, two degrees of freedom.",)


def robot() -> RobotDescription:
    """The crane in the upright plane, its load hanging at rest."""
    inward = 0.5 * (CART - WIDTH)
    left = atan2(-sqrt(ROD**2 - inward**2), inward)
    right = -pi - left
    return RobotDescription(
        name="underactuated",
        title="Underactuated crane",
        source="A gantry crane with a load on two rods, a textbook underactuated system; size and masses are this "
        "project's",
        links=(
            Link("base", None, _rail()),
            Link("cart_link", block(MASS_CART, CART_SIZE), _cart()),
            link("left_rod", MASS_ROD, ROD, 0, "blue", pin((0, 0, 0), -1, 0)),
            Link("load_link", _load(), _load_looks()),
            Link("tool"),
            link("right_rod", MASS_ROD, ROD, 0, "orange", pin((0, 0, 0), -1, 0)),
        ),
        joints=(
            joint(
                "cart",
                "prismatic",
                "base",
                "cart_link",
                axis=(1.0, 0.0, 0.0),
                lower=-0.5,
                upper=0.5,
                effort=200.0,
                velocity=5.0,
            ),
            hinge("left", "cart_link", "left_rod", LEFT, UPRIGHT),
            hinge("load", "left_rod", "load_link", END),
            joint("tool_mount", "fixed", "load_link", "tool", xyz=CENTRE),
            hinge("right", "cart_link", "right_rod", RIGHT, UPRIGHT),
        ),
        cuts=(cut("right_to_load", "revolute", frame("right_rod", END), frame("load_link", HOLE)),),
        actuators=("cart",),
        tool=frame("tool"),
        homes=(
            home(
                "cart in the middle, load hanging at rest",
                {"cart": 0.0},
                {"left": left, "load": wrapped(-left), "right": right},
            ),
        ),
    )


def _load() -> Inertial:
    return block(MASS_LOAD, LOAD_SIZE, CENTRE)


def _load_looks() -> tuple[Shape, ...]:
    middle = (CENTRE[0], CENTRE[1], layer(1))
    return (box(LOAD_SIZE, "light", middle), pin((0, 0, 0), 0, 2), pin(HOLE, 0, 2), ball(0.015, "vermilion", CENTRE))


def _cart() -> tuple[Shape, ...]:
    return (box(CART_SIZE, "dark", (0.0, 0.04, 0.03)),)


def _rail() -> tuple[Shape, ...]:
    return (rod((-0.75, 0.04, 0.03), (0.75, 0.04, 0.03), 0.02, "base"),)
