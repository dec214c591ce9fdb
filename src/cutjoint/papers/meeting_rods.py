"""Robots with three rotary limbs whose rods, all of one length, meet in the tool.

With the tool known each limb has two solutions (working modes), with the motors known the tool has several (assembly
modes); between those lie the postures where the rods are parallel to one plane, singular of type 2.
"""

from __future__ import annotations

from abc import abstractmethod
from math import pi, sqrt
from typing import ClassVar, NamedTuple

from cutjoint.arrays import readonly
from cutjoint.errors import SingularError
from cutjoint.mechanism import Posture
from cutjoint.papers.reduced_model import P
from cutjoint.papers.scalars import Matrix3, Scalar, Vector3
from cutjoint.papers.three_limbs import Branch, Signs, ThreeLimbModel, Triple

SMALLEST_MEASURE = 1e-4
"""Smallest distance from a singularity that is accepted: near type 2 the volume of the directions of the three rods,
near type 1 the sine between arm and rod.  Both vanish like a root, so answers lose as many digits as the measure's
square: eight are left here."""


class MeetingRods(NamedTuple):
    """The rods at a posture.

    Attributes:
        rows: each rod in space [m].
        modes: positive where a limb is in working mode +1.
        volume: of the three rods [m3]; its sign is the assembly mode.
        length: of a rod [m].
    """

    rows: Matrix3
    modes: Vector3
    volume: Scalar
    length: float


class MeetingRodsModel(ThreeLimbModel[P]):
    """A reduced model of such a robot; a posture stores the angles of the motors and the tool."""

    rod: ClassVar[str]
    """What messages call the rods."""

    @abstractmethod
    def _rods(self, angles: Triple, tool: Triple) -> MeetingRods:
        """The rods with the motors at `angles` [rad] and the tool at a position [m]."""

    @abstractmethod
    def _limb_angle(self, tool: Triple, i: int, sign: int) -> float:
        """Angle of limb i (0, 1, 2) in a working mode [rad]; raises where it does not reach the tool, or only just."""

    def split(self, at: Posture) -> tuple[Triple, Triple]:
        """Angles [rad] and tool [m] of a posture."""
        one, two, three, x, y, z = self.full(at)
        return (one, two, three), (x, y, z)

    def branch(self, at: Posture) -> Branch:
        """Working mode, and side of the type-2 singularities, of a posture."""
        _, (one, two, three), volume, _ = self._rods(*self.split(at))
        return Branch((1 if one > 0 else -1, 1 if two > 0 else -1, 1 if three > 0 else -1), 1 if volume > 0 else -1)

    def _place(
        self, tool: Triple, signs: Signs, around: Triple = (0.0, 0.0, 0.0), assembly: int | None = None
    ) -> Posture:
        """Inverse kinematics with its checks; angles are taken within half a turn of `around`."""
        one, two, three = (
            angle + 2.0 * pi * round((middle - angle) / (2.0 * pi))
            for angle, middle in zip((self._limb_angle(tool, i, signs[i]) for i in range(3)), around, strict=True)
        )
        angles = (one, two, three)
        return self._checked(angles, tool, self._rods(angles, tool), assembly)

    def _checked(self, angles: Triple, tool: Triple, rods: MeetingRods, assembly: int | None = None) -> Posture:
        """The posture with its residual, unless it is singular of type 2 or on the wrong side of a singularity."""
        rows, _, volume, length = rods
        measure = volume / length**3
        if abs(measure) < SMALLEST_MEASURE:
            raise SingularError(
                f"the {self.rod} of {self.name} lie parallel to one plane with the tool at {list(tool)} m: the volume "
                f"of their directions is {abs(measure):.3g}, below {SMALLEST_MEASURE:g} (type-2 singularity)",
                kind="type-2",
                measure=abs(measure),
                limit=SMALLEST_MEASURE,
            )
        if assembly is not None and measure * assembly < 0.0:
            raise SingularError(
                f"{self.name} comes to {list(tool)} m in this working mode only through a type-2 singularity (volume "
                f"of the {self.rod}' directions {measure:+.3g}, of the other sign before)",
                kind="type-2",
                measure=0.0,
                limit=SMALLEST_MEASURE,
            )
        gap = max(abs(sqrt(x * x + y * y + z * z) - length) for x, y, z in rows)
        return Posture(readonly(angles), readonly((*angles, *tool)), (gap, 0.0))
