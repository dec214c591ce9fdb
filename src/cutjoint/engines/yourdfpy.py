"""yourdfpy's opinion of a robot's tree: where an independent URDF reader puts every link.

The robot is written as a URDF and read back by yourdfpy, which shares no code with Pinocchio.  A joint with several
coordinates is no joint to yourdfpy, so the links that it carries are compared in the frame of the link that it moves.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint import tolerances
from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import Comparison, ComparisonRow, Reacher, SampledState
from cutjoint.description.formats import write
from cutjoint.mechanism import Posture

if TYPE_CHECKING:
    import yourdfpy


def compare_with_yourdfpy(
    chain: ClosedChain, states: Iterable[SampledState], progress: Callable[[int], None] | None = None
) -> Comparison:
    """Placements of all links of `chain` at `states` against yourdfpy's: worst difference in lengths of the robot (or a
    thousandth of the distance from the origin, where rounding decides) and of rotations.
    """
    tree = _read(chain)
    parts = _parts(chain)
    reacher = Reacher(chain)
    worst = {"link positions": (0.0, 0), "link orientations": (0.0, 0)}
    count = 0
    for count, state in enumerate(states, start=1):
        at = reacher.take_up(state)
        tree.update_cfg(_values(chain, at, tree.actuated_joint_names))
        placed = chain.link_placements(at)
        for root, links in parts.items():
            back = np.linalg.inv(placed[root])
            for link in links:
                apart = np.abs(back @ placed[link] - tree.get_transform(link, root))
                size = max(chain.length, 1e-3 * float(np.abs(placed[link][:3, 3]).max()))
                for name, error in zip(worst, (apart[:3, 3].max() / size, apart[:3, :3].max()), strict=True):
                    if not error <= worst[name][0]:
                        worst[name] = (float(error), count - 1)
        if progress is not None:
            progress(count)
    rows = tuple(
        ComparisonRow(name, error, tolerances.PLACEMENT.value, sample) for name, (error, sample) in worst.items()
    )
    return Comparison(chain.name, "yourdfpy", count, rows)


def _read(chain: ClosedChain) -> yourdfpy.URDF:
    import yourdfpy

    with tempfile.TemporaryDirectory() as folder:
        files = write(chain.description, Path(folder) / chain.description.name)
        urdf = next(file for file in files if file.suffix == ".urdf")
        return yourdfpy.URDF.load(str(urdf), load_meshes=False, build_scene_graph=True)


def _parts(chain: ClosedChain) -> dict[str, list[str]]:
    """Links by the link they hang on: the root of the tree, or one whose joint has several coordinates."""
    robot = chain.description
    above = {joint.child: joint for joint in robot.joints}
    parts: dict[str, list[str]] = {}
    for link in robot.links:
        top = link.name
        while top in above and above[top].type.dof <= 1:
            top = above[top].parent
        parts.setdefault(top, []).append(link.name)
    return parts


def _values(chain: ClosedChain, at: Posture, names: Iterable[str]) -> dict[str, float]:
    types = {joint.name: joint.type for joint in chain.description.joints}
    return {name: float(at[name]) for name in names if types[name].single}
