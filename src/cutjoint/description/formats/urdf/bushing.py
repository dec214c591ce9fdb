"""Drake's LinearBushingRollPitchYaw as a bushing of a cut.

Drake's has three numbers of each kind, along x, y, z and for roll, pitch, yaw
(https://drake.mit.edu, class LinearBushingRollPitchYaw).  Those here are the same in every direction that the cut's
type holds, so that Drake's can be read where the forces are the same along all axes, and the torques the same about all
of them (a fixed cut), about all but one, which turns freely (revolute), or zero (spherical).  Where something turns,
Drake's torques are those of its angles, these those of the rotation vector or of the tilt of the axis: the same as long
as the bushing is turned little, which is what it is made for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.description.model import Bushing, CutJoint, CutType, Frame, Place
from cutjoint.description.transforms import frame_along, turned
from cutjoint.findings import Findings


def read_bushing(
    name: str, ends: tuple[Frame, Frame], values: Sequence[tuple[float, ...]], place: Place, findings: Findings
) -> CutJoint | None:
    """The cut of a bushing whose `values` are the stiffness and damping of forces, then those of torques, each along
    x, y, z; None where ours cannot be so."""
    stiffness, damping, turning, turning_damping = values
    if len({*stiffness}) > 1 or len({*damping}) > 1 or stiffness[0] == 0.0:
        return None
    free = [axis for axis in range(3) if turning[axis] == 0.0 and turning_damping[axis] == 0.0]
    held = [axis for axis in range(3) if axis not in free]
    if len(free) == 2 or any(len({each[axis] for axis in held}) > 1 for each in (turning, turning_damping)):
        return None
    kind = {0: CutType.FIXED, 1: CutType.REVOLUTE, 3: CutType.SPHERICAL}[len(free)]
    if held and turning[held[0]] == 0.0:
        return None
    a, b = ends
    if kind is CutType.REVOLUTE:
        align = frame_along(np.eye(3)[free[0]])
        a, b = (Frame(end.link, turned(end.placement, align)) for end in ends)
    if held:
        found = f"the torques of bushing '{name}' are taken as those of small turns"
        findings.warn(found, "turns that stay small", "", place)
    own = (turning[held[0]], turning_damping[held[0]]) if held else (0.0, 0.0)
    return CutJoint(name, kind, a, b, place, bushing=Bushing(stiffness[0], damping[0], *own))
