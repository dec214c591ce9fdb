"""Shapes that can be drawn.  What is wrong with one does not change the motion: lenient readers leave the shape out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.description.model import Link, RobotDescription, Shape
from cutjoint.findings import LARGEST_LENGTH, Findings

COUNTS = {"box": 3, "cylinder": 2, "capsule": 2, "sphere": 1, "mesh": 3}


def check_shapes(robot: RobotDescription, findings: Findings) -> None:
    """Note shapes that cannot be drawn and colours that are none."""
    for link in robot.links:
        for what, shapes in (("visual", link.visuals), ("collision", link.collisions)):
            for shape in shapes:
                wrong = _wrong(shape)
                if wrong is not None:
                    findings.doubt(f"{wrong[0]} in a {what} shape of link '{link.name}'", wrong[1], "", link.place)


def without_impossible_shapes(robot: RobotDescription) -> RobotDescription:
    """A copy without the shapes that `check_shapes` notes."""
    return replace(robot, links=tuple(map(_drawable, robot.links)))


def _drawable(link: Link) -> Link:
    visuals, collisions = (tuple(one for one in of if _wrong(one) is None) for of in (link.visuals, link.collisions))
    return replace(link, visuals=visuals, collisions=collisions)


def _wrong(shape: Shape) -> tuple[str, str] | None:
    """What is wrong with a shape, and what is expected."""
    size, rotation = np.array(shape.size, dtype=float), shape.placement[:3, :3]
    count = COUNTS.get(shape.kind)
    if count is None:
        return f"the kind '{shape.kind}'", f"one of {', '.join(COUNTS)}"
    if size.shape != (count,) or not np.isfinite(size).all():
        return f"{shape.kind} with the size {shape.size}", f"{count} finite numbers"
    if shape.kind == "mesh" and 0.0 in size:
        return f"mesh with the scale {shape.size}", "three numbers other than 0"
    if shape.kind != "mesh" and size.min() < 0.0:
        return f"{shape.kind} with the size {shape.size}", "no negative length [m]"
    if not np.isfinite(shape.placement).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6:
        return f"{shape.kind} whose placement is no rigid motion", "a rotation and a position"
    if max(np.abs(size).max(), np.abs(shape.placement).max()) > LARGEST_LENGTH:
        return f"{shape.kind} of the size {shape.size} at {shape.placement[:3, 3]}", f"up to {LARGEST_LENGTH:g} m"
    if shape.colour is not None and not all(0.0 <= part <= 1.0 for part in shape.colour):
        return f"the colour {shape.colour}", "four numbers from 0 to 1"
    return None
