"""Planar linkages with any number of loops: cranks on the ground, neighbours joined by couplers, one degree of freedom.

Tree: k + 1 cranks, a coupler on each of the first k.  Cuts: each coupler's end on the next crank's tip.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.description.model import (
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement

CRANK, GROUND = 0.2, 0.3
COUPLERS = (0.31, 0.29)
"""In turns a little longer and shorter than the ground, so that no loop is a parallelogram and none drifts away."""


def rod(length: float) -> Inertial:
    """A uniform rod of 1 kg a metre along x."""
    mass = length
    return Inertial(mass, np.array([length / 2, 0.0, 0.0]), mass * length**2 / 12 * np.diag([1e-3, 1.0, 1.0]))


def ladder(loops: int) -> ClosedChain:
    """The linkage with so many loops."""
    axis = readonly([0.0, 0.0, 1.0])
    links = [Link("base")]
    joints = []
    cuts = []
    for k in range(loops + 1):
        links.append(Link(f"crank{k}", rod(CRANK)))
        joints.append(
            Joint(f"turn{k}", JointType.REVOLUTE, "base", f"crank{k}", placement((k * GROUND, 0.0, 0.0)), axis=axis)
        )
        if k < loops:
            length = COUPLERS[k % 2]
            links.append(Link(f"coupler{k}", rod(length)))
            joints.append(
                Joint(f"hinge{k}", JointType.REVOLUTE, f"crank{k}", f"coupler{k}", placement((CRANK, 0, 0)), axis=axis)
            )
            a, b = Frame(f"coupler{k}", placement((length, 0, 0))), Frame(f"crank{k + 1}", placement((CRANK, 0, 0)))
            cuts.append(CutJoint(f"pin{k}", CutType.REVOLUTE, a, b))
    first = 1.2
    passive: dict[str, float | tuple[float, ...]] = {}
    angle = first
    for k in range(loops):
        angle, passive[f"hinge{k}"] = _next(angle, COUPLERS[k % 2])
        passive[f"turn{k + 1}"] = angle
    return ClosedChain(
        RobotDescription(
            name=f"ladder of {loops} loops",
            links=tuple(links),
            joints=tuple(joints),
            cuts=tuple(cuts),
            actuators=("turn0",),
            gravity=readonly([0.0, -9.81, 0.0]),
            homes=(Home("default", {"turn0": first}, passive),),
        )
    )


def _next(angle: float, coupler: float) -> tuple[float, float]:
    """Angle of the next crank, and of the coupler against this one [rad]: where two circles meet."""
    tip = CRANK * np.array([np.cos(angle), np.sin(angle)])
    away = np.array([GROUND, 0.0]) - tip
    distance = float(np.hypot(*away))
    along = (coupler**2 - CRANK**2 + distance**2) / (2.0 * distance)
    up = np.array([-away[1], away[0]]) / distance * np.sqrt(coupler**2 - along**2)
    reach = away / distance * along + up
    other = tip + reach - np.array([GROUND, 0.0])
    return float(np.arctan2(other[1], other[0])), float(np.arctan2(reach[1], reach[0]) - angle)
