"""A robot to be changed into one's own: the smallest that has all parts, a slider-crank with one cut."""

from __future__ import annotations

from math import asin, cos, sin

from cutjoint.drafting.planar import UPRIGHT, UPRIGHT_NOTE, Plane, hinge
from cutjoint.drafting.sketch import LinkSketch, Loop, Sketch, Tie, box
from cutjoint.drafting.template import Sizes, Template

CRANK, ROD, HOME = 0.1, 0.3, 1.0


def sketch(_: Sizes) -> Sketch:
    """A slider-crank that says where to put what."""
    tilt = asin(CRANK * sin(HOME) / ROD)
    reach = CRANK * cos(HOME) + ROD * cos(tilt)
    plane = Plane.of([CRANK, ROD])
    w = plane.width
    rail = box((2.2 * ROD, 0.3 * w, 0.6 * w), "grey", (ROD, 0.0, -1.2 * w))
    return Sketch(
        title="Slider-crank, to be changed",
        source="where your sizes and masses are from",
        notes=(
            UPRIGHT_NOTE,
            "CHANGE: the links, each with an <inertial> if it moves, and the joints. Every link has one joint above "
            "it: leave out one joint of every loop, and say in loops.toml where it was.",
        ),
        bodies=(
            LinkSketch("base", "What does not move. CHANGE the shapes: any <visual>, or none.", (), [rail]),
            plane.link("crank_link", "The first branch of the tree: a link on the motor ...", CRANK, 0, "blue",
                       plane.motor((0.0, 0.0), -3, 0), plane.pin((CRANK, 0.0), 0, 1)),
            plane.link("rod_link", "... and the next one, whose far end has no joint: there the loop is cut.", ROD, 1,
                       "orange", plane.pin((ROD, 0.0), 0, 1)),
            LinkSketch("piston_link", "The second branch of the tree, which meets the first at the cut.",
                 [box((2.0 * w, 2.0 * w, plane.thick), "green")]),
        ),
        ties=(
            hinge("crank", "base", "crank_link", (0.0, 0.0), on_base=True, driven=True),
            hinge("rod", "crank_link", "rod_link", (CRANK, 0.0)),
            Tie("piston", "prismatic", "base", "piston_link", "CHANGE the limits: lower and upper in m or rad.",
                rpy=UPRIGHT, axis=(1.0, 0.0, 0.0),
                limits=(ROD - 1.1 * CRANK, ROD + 1.1 * CRANK)),
        ),
        loops=(
            Loop("gudgeon", "revolute",
                 "CHANGE: a table like this for every joint that was left out. Types: fixed, spherical, revolute, "
                 "universal, prismatic, distance.",
                 ("rod_link", (ROD, 0.0, 0.0)), ("piston_link", (0.0, 0.0, 0.0))),
        ),
        tool="piston_link",
        home={"crank": HOME},
        passive={"rod": -tilt - HOME, "piston": reach},
        about_home="crank up, piston to the right",
        mobility=1,
        changes=(
            "CHANGE: name, title, source; actuators (the joints with a motor); tool; the cuts; the home posture.",
        ),
    )  # fmt: skip


TEMPLATE = Template("the smallest robot with a loop, a slider-crank, with comments that say what to change", {}, sketch)
