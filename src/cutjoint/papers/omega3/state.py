"""The Omega-3 at one posture: equation (42) on floats, arrays or symbols alike."""

from __future__ import annotations

from cutjoint.papers.omega3 import equations
from cutjoint.papers.omega3.equations import Arms
from cutjoint.papers.omega3.parameters import Omega3Parameters
from cutjoint.papers.scalars import Matrix3, Scalar, Vector3, Vector6, inverse
from cutjoint.papers.three_limbs import ThreeLimbState


class Omega3State(ThreeLimbState):
    """The arms with the tool at a position [m].

    Attributes:
        rods: from the elbows to the tool.
        jacobian: J of equation (23) [m].
    """

    __slots__ = ("_arms", "_inverse", "_k", "_p", "_tool", "jacobian", "rods")

    def __init__(self, p: Omega3Parameters, arms: Arms, tool: Vector3) -> None:
        self._p, self._k, self._arms, self._tool = p, p.coefficients, arms, tool
        self.rods = equations.rods(arms, tool)
        self._inverse = inverse(self.rods.u)
        self.jacobian = equations.jacobian(self.rods, self._inverse)

    def jacobian_dot(self, v: Vector3) -> Matrix3:
        """Exact dJ/dt of equation (27) [m/s] for the rates `v` of the arms [rad/s]."""
        return equations.jacobian_dot(self._arms, self.rods, self._inverse, self.jacobian, v)

    def _drift(self, v: Vector3) -> Vector3:
        return equations.drift(self._arms, self.rods, self._inverse, self.jacobian, v)

    def entries(self) -> Vector6:
        """M of equation (42) [kg m2]."""
        return equations.mass(self._k, self.jacobian)

    def coriolis(self, v: Vector3) -> Vector3:
        """V of equation (42) [N m]."""
        return equations.coriolis(self._k, self.jacobian, self._drift(v))

    def gravity(self) -> Vector3:
        """G of equation (42) [N m]."""
        return equations.gravity(self._k, self._arms, self.jacobian)

    def potential_energy(self) -> Scalar:
        """Potential energy of gravity [J]."""
        return equations.potential_energy(self._p, self._k, self._arms, self._tool)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """Position, J of equation (23) and dJ/dt v of equation (25)."""
        return self._tool, self.jacobian, (0.0, 0.0, 0.0) if v is None else self._drift(v)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the volume that the directions of the rods span."""
        length = self._p.L_B
        return (length * length * length / self.rods.volume,)
