"""Where the links of a URDF's tree stand at zero, for what is placed in the world or between any two links."""

from __future__ import annotations

from collections.abc import Mapping

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.model import IDENTITY


def placements(tree: OpenTree) -> Mapping[str, Array]:
    """Link -> its placement (4, 4) in its root link at zero; rings, which have no root, are left out."""
    below: dict[str, list[tuple[str, Array]]] = {}
    for joint in tree.joints:
        below.setdefault(joint.parent, []).append((joint.child, joint.placement))
    carried = {joint.child for joint in tree.joints}
    world = {link.name: IDENTITY for link in tree.links if link.name not in carried}
    pending = list(world)
    while pending:
        parent = pending.pop()
        for child, placement in below.get(parent, ()):
            if child not in world:
                world[child] = readonly(world[parent] @ placement)
                pending.append(child)
    return world
