"""A pose: where a frame is and how it is turned; and what may be said where a pose is wanted."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, as_vector
from cutjoint.errors import InputError
from cutjoint.mechanism.rotations import quaternion_of, rotation_from, turned
from cutjoint.reprs import line


class Homogeneous(Protocol):
    """A placement that tells its matrix, such as pin.SE3."""

    @property
    def homogeneous(self) -> Array:
        """Shape (4, 4)."""


FORMS = "a Pose, a (4, 4) matrix, seven numbers x, y, z, qx, qy, qz, qw, or a pin.SE3"


@dataclass(frozen=True, eq=False)
class Pose(Frozen):
    """Position and rotation of a frame in the world.

    Attributes:
        position: shape (3,), [m].
        rotation: axes of the frame as columns, shape (3, 3).
    """

    position: Array
    rotation: Array

    __repr__ = line("position", "quaternion", position="m")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.position.shape != (3,) or self.rotation.shape != (3, 3):
            raise InputError(
                f"a Pose is a position (3,) [m] and a rotation (3, 3), found shapes {self.position.shape} and "
                f"{self.rotation.shape}; Pose.of takes {FORMS.removeprefix('a Pose, ')}"
            )

    @classmethod
    def of(cls, given: PoseLike) -> Pose:
        """From anything that tells a pose: see `FORMS`.

        Raises:
            InputError: it is none.
        """
        if isinstance(given, Pose):
            return given
        matrix = getattr(given, "homogeneous", given)
        try:
            array = np.asarray(matrix)
            array = array.astype(np.float64, casting="same_kind" if array.dtype.kind in "cmM" else "unsafe")
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"a pose is {FORMS}; found {repr(given)[:200]}") from error
        if array.shape == (7,):
            values = as_vector("pose", array, 7)
            return cls(values[:3], rotation_from(values[3:]))
        if array.shape != (4, 4):
            raise InputError(f"a pose is {FORMS}; found shape {array.shape}")
        *_, (x, y, z, w) = array.tolist()
        if not max(abs(x), abs(y), abs(z), abs(w - 1.0)) < 1e-9 or not all(map(isfinite, array.ravel().tolist())):
            raise InputError(f"a (4, 4) pose is finite and its last row is 0, 0, 0, 1; found {array.tolist()}")
        return cls(array[:3, 3], rotation_from(array[:3, :3]))

    @property
    def matrix(self) -> Array:
        """Homogeneous, shape (4, 4)."""
        found = np.eye(4)
        found[:3, :3], found[:3, 3] = self.rotation, self.position
        return found

    @property
    def quaternion(self) -> Array:
        """x, y, z, w of the rotation, w >= 0, shape (4,)."""
        return np.array(quaternion_of(self.rotation))

    def moved(self, by: npt.ArrayLike = (0.0, 0.0, 0.0), turn: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
        """The pose `by` (3,) [m] further, turned about itself by the rotation vector `turn` (3,) [rad], both along the
        axes of the world."""
        return Pose(
            self.position + as_vector("by", by, 3, "m"), turned(as_vector("turn", turn, 3, "rad")) @ self.rotation
        )


PoseLike: TypeAlias = Pose | Homogeneous | npt.ArrayLike
"""What tells a pose: see `FORMS`."""
