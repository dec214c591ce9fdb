"""Tracks of meshcat's animations in the compact form that three.js takes too: float32 arrays of all frames.

meshcat's own Python writes a table of keys per number, five times the size.
"""

from __future__ import annotations

import numpy as np
import umsgpack
from meshcat.transformations import quaternion_from_matrix

from cutjoint.arrays import Array


class FilmTrack:
    """Values of one property of a path at the frames."""

    def __init__(self, name: str, kind: str, frames: Array, values: Array) -> None:
        self._name, self._kind, self._frames, self._values = name, kind, frames, values

    def lower(self) -> dict[str, object]:
        """As meshcat sends it."""
        return {
            "name": f".{self._name}",
            "type": self._kind,
            "times": umsgpack.Ext(0x17, self._frames.astype("<f4").tobytes()),
            "values": umsgpack.Ext(0x17, self._values.astype("<f4").tobytes()),
        }


def pose_tracks(frames: Array, matrices: Array) -> list[FilmTrack]:
    """Tracks of position and quaternion of placements, shape (k, 4, 4); none where the path does not move."""
    if np.abs(matrices - matrices[0]).max() == 0.0:
        return []
    turns = np.array([quaternion_from_matrix(matrix)[[1, 2, 3, 0]] for matrix in matrices])
    signs = np.cumprod(np.where(np.einsum("ij,ij->i", turns[1:], turns[:-1]) < 0, -1.0, 1.0))
    turns[1:] *= signs[:, None]  # neighbouring frames on the same side, so that what lies between is short
    return [
        FilmTrack("position", "vector3", frames, matrices[:, :3, 3]),
        FilmTrack("quaternion", "quaternion", frames, turns),
    ]
