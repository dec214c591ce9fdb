"""Links made longer or shorter, as a designer makes them: the same section, another length.

A link is stretched by a ratio r along a direction u of its own frame: what was at x is at S x with S = 1 + (r-1) u u',
and every slice across u keeps its mass.  So mass grows by r, the centre of mass goes to S c, and the second moments of
mass about it, which are P = tr(I) 1 / 2 - I, become r S P S.  All that sits on the link goes along: the joints of its
children, frames of cuts, the tool, shapes.  Directions stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, positive
from cutjoint.description.model import Frame, Inertial, Link, RobotDescription, Shape, Variant
from cutjoint.doors import door
from cutjoint.errors import InputError

ALONG = 1e-9
"""Part of a direction that may be across an axis of a shape that is stretched along it."""


@door
def stretched(
    robot: RobotDescription, links: str | Sequence[str], along: npt.ArrayLike, ratio: float
) -> RobotDescription:
    """A copy with other lengths of some links.

    Args:
        robot: the description.
        links: one name, or several: each is stretched in its own frame.
        along: direction in the frame of each link, shape (3,).
        ratio: new length by old length, > 0.

    Raises:
        UnknownNameError: there is no such link.
        InputError: no direction, no ratio above 0, or a link is named twice.
    """
    names = (links,) if isinstance(links, str) else tuple(links)
    if len(set(names)) < len(names):
        raise InputError(f"a link is named twice: {', '.join(names)}")
    for name in names:
        robot.link(name)
    u = as_vector("along", along, 3)
    size = float(np.linalg.norm(u))
    if size == 0.0:
        raise InputError("along must be a direction, found zeros")
    u = u / size
    ratio = positive("ratio", ratio)
    stretch = np.eye(3) + (ratio - 1.0) * np.outer(u, u)

    links_now = [_link(one, stretch, u, ratio) if one.name in names else one for one in robot.links]
    joints = [
        replace(one, placement=_moved(one.placement, stretch)) if one.parent in names else one for one in robot.joints
    ]

    def frame(one: Frame) -> Frame:
        return replace(one, placement=_moved(one.placement, stretch)) if one.link in names else one

    return replace(
        robot,
        links=tuple(links_now),
        joints=tuple(joints),
        cuts=tuple(replace(one, a=frame(one.a), b=frame(one.b)) for one in robot.cuts),
        tool=robot.tool and frame(robot.tool),
        variants=tuple(_variant(one, names, stretch, ratio) for one in robot.variants),
    )


def _moved(placement: Array, stretch: Array) -> Array:
    there = np.array(placement)
    there[:3, 3] = stretch @ there[:3, 3]
    return there


def _link(one: Link, stretch: Array, u: Array, ratio: float) -> Link:
    visuals, collisions = (
        tuple(_shape(shape, _moved(shape.placement, stretch), u, ratio) for shape in shapes)
        for shapes in (one.visuals, one.collisions)
    )
    inertial = one.inertial and _inertial(one.inertial, stretch, ratio)
    return replace(one, inertial=inertial, visuals=visuals, collisions=collisions)


def _variant(one: Variant, names: Sequence[str], stretch: Array, ratio: float) -> Variant:
    inertials = {
        name: _inertial(inertial, stretch, ratio) if name in names else inertial
        for name, inertial in one.inertials.items()
    }
    return replace(one, inertials=inertials)


def _inertial(one: Inertial, stretch: Array, ratio: float) -> Inertial:
    moments = 0.5 * np.trace(one.inertia) * np.eye(3) - one.inertia
    moments = ratio * stretch @ moments @ stretch
    return Inertial(ratio * one.mass, stretch @ one.com, np.trace(moments) * np.eye(3) - moments)


def _shape(one: Shape, placement: Array, u: Array, ratio: float) -> Shape:
    """A shape that went along; its own length too where it has one along the direction."""
    size = list(one.size)
    own = np.abs(placement[:3, :3].T @ u)
    axis = int(np.argmax(own))
    if math.isclose(own[axis], 1.0, abs_tol=ALONG):
        if one.kind in ("box", "mesh"):
            size[axis] *= ratio
        elif one.kind in ("cylinder", "capsule") and axis == 2:
            size[1] *= ratio
    return replace(one, placement=placement, size=tuple(size))


@door
def mounted(robot: RobotDescription, roll: float = 0.0, pitch: float = 0.0) -> RobotDescription:
    """A copy whose base is turned in the field of gravity: by `roll` about its x axis, then by `pitch` about the y axis
    of the ground [rad].  The robot's own axes stay the world's, so it is the gravity that turns, the other way round.

    Raises:
        InputError: an angle is not a finite number.
    """
    roll, pitch = (float(as_vector(name, [x], 1, "rad")[0]) for name, x in (("roll", roll), ("pitch", pitch)))
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    turn = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return replace(robot, gravity=turn.T @ robot.gravity)
