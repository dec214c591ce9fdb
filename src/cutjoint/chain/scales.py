"""How large a robot is, and where: what makes metres and radians comparable.

Singular values of a matrix that mixes lengths and angles mean nothing until it is scaled.  Lengths are divided by the
robot's characteristic length: the mean distance between neighbouring joint frames and cut frames that are apart.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import bind_frame
from cutjoint.chain.closure import Closure
from cutjoint.chain.joints import flies
from cutjoint.description.model import RobotDescription

FAR = 10.0
"""Distance of a fixed base from the world origin, in characteristic lengths, beyond which it is taken out."""


def characteristic_length(model: pin.Model, closure: Closure, description: RobotDescription) -> tuple[float, float]:
    """Mean distance [m] between neighbouring joint and cut frames that are apart, and the longest way along them from
    the base to a frame.

    Frames that the base carries count from their middle; what flies is where it is, so the place of its joint does not
    count.  A robot whose frames all coincide is measured by its tool or its centres of mass; 1 where those are there
    too.
    """
    middle, _ = base_of(model, closure)
    way = np.zeros(model.njoints)
    distances: list[float] = []

    def step(parent: int, place: Array) -> float:
        distances.append(float(np.linalg.norm(place - middle if parent == 0 else place)))
        return float(way[parent]) + distances[-1]

    for joint in range(1, model.njoints):
        if not flies(model, joint):
            way[joint] = step(model.parents[joint], model.jointPlacements[joint].translation)
    ends = [step(cut.joint_a, cut.placement_a.translation) for cut in closure.cuts]
    ends += [step(cut.joint_b, cut.placement_b.translation) for cut in closure.cuts]
    if not max(distances, default=0.0) > 0.0:
        if description.tool is not None:
            joint, place = bind_frame(model, description.tool)
            distances.append(float(np.linalg.norm(place.translation)) if joint else 0.0)
        distances += [float(np.linalg.norm(inertia.lever)) for inertia in list(model.inertias)[1:] if inertia.mass > 0]
    longest = max(distances, default=0.0)
    apart = [distance for distance in distances if distance > 1e-9 * longest]
    length = float(np.mean(apart)) if apart else 1.0
    return length, max(float(way.max(initial=0.0)), max(ends, default=0.0), length)


def base_of(model: pin.Model, closure: Closure) -> tuple[Array, bool]:
    """Middle of all frames that the base carries, shape (3,) [m], and whether that is far from the world origin."""
    first = [j for j in range(1, model.njoints) if model.parents[j] == 0]
    carried = [np.array(model.jointPlacements[joint].translation) for joint in first if not flies(model, joint)]
    sides = [side for cut in closure.cuts for side in cut.sides]
    carried += [np.array(place.translation) for joint, place in sides if joint == 0]
    if not carried:
        return np.zeros(3), False
    middle = np.mean(carried, axis=0)
    spread = max(float(np.linalg.norm(place - middle)) for place in carried)
    others = [np.linalg.norm(model.jointPlacements[j].translation) for j in range(1, model.njoints) if j not in first]
    size = max([spread, *map(float, others)])
    for inertia in list(model.inertias)[1:]:
        size = max(size, float(np.linalg.norm(inertia.lever)))
    return middle, float(np.linalg.norm(middle)) > FAR * size
