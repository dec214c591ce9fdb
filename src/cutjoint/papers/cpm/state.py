"""The CPM at one posture, with linear or rotary motors, on floats, arrays or symbols alike."""

from __future__ import annotations

from cutjoint.papers.cpm import equations, rotary
from cutjoint.papers.cpm.parameters import CpmCoefficients, CpmParameters
from cutjoint.papers.scalars import NUMBERS, Functions, Matrix3, Scalar, Vector3, Vector6, times
from cutjoint.papers.three_limbs import ThreeLimbState


class CpmState(ThreeLimbState):
    """Equation (39): tool and sliders at a position [m] (10), the first links at their angles [rad].

    Attributes:
        limbs: in their own planes.
        gamma: equation (30).
    """

    __slots__ = ("_k", "_p", "_tool", "gamma", "limbs")

    def __init__(
        self, p: CpmParameters, k: CpmCoefficients, tool: Vector3, angles: Vector3, fn: Functions = NUMBERS
    ) -> None:
        self._p, self._k, self._tool = p, k, tool
        self.limbs = equations.limbs(p, tool, angles, fn)
        self.gamma = equations.gamma(self.limbs)

    def entries(self) -> Vector6:
        """M of equation (39) [kg]."""
        return equations.mass(self._k, self.gamma)

    def gamma_dot(self, v: Vector3) -> Matrix3:
        """Exact time derivative of Gamma for the tool velocity `v` [m/s]."""
        return equations.gamma_dot(self._p, self.limbs, v)

    def coriolis(self, v: Vector3) -> Vector3:
        """G v of equation (39) [N]."""
        return equations.coriolis(self._k, self.gamma, equations.gamma_dot(self._p, self.limbs, v), v)

    def gravity(self) -> Vector3:
        """K of equation (39) [N]."""
        return equations.gravity(self._k, self.limbs, self.gamma)

    def potential_energy(self) -> Scalar:
        """Equation (19) [J]."""
        return equations.potential_energy(self._k, self.limbs)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """The tool follows the sliders: the Jacobian is the identity, the drift zero (10)."""
        return self._tool, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the sine of each elbow."""
        size = self._p.L1 * self._p.L2
        return tuple(size / limb.denominator for limb in self.limbs)


class CpmRotaryState(ThreeLimbState):
    """The motors at their angles [rad] with the tool at a position [m].

    Attributes:
        limbs: in their own planes.
        rods: the second rods in space.
        jacobian: of the tool [m].
    """

    __slots__ = ("_k", "_p", "_tool", "jacobian", "limbs", "rods")

    def __init__(self, p: CpmParameters, angles: Vector3, tool: Vector3, fn: Functions = NUMBERS) -> None:
        self._p, self._k, self._tool = p, p.coefficients, tool
        self.limbs = rotary.limbs(p, tool, angles, fn)
        self.rods = rotary.rods(p, self.limbs)
        self.jacobian = rotary.jacobian(self.rods)

    def _drift(self, v: Vector3) -> Vector3:
        return rotary.drift(self._p, self.limbs, self.rods, times(self.jacobian, v), v)

    def entries(self) -> Vector6:
        """Mass matrix [kg m2]."""
        return rotary.mass(self._k, self.jacobian)

    def coriolis(self, v: Vector3) -> Vector3:
        """Coriolis vector [N m] for the rates `v` of the motors [rad/s]."""
        return rotary.coriolis(self._k, self.jacobian, self._drift(v))

    def gravity(self) -> Vector3:
        """Torques that hold the robot [N m]."""
        return rotary.gravity(self._k, self.limbs, self.jacobian)

    def potential_energy(self) -> Scalar:
        """Equation (19) [J]."""
        return equations.potential_energy(self._k, self.limbs)

    def tool(self, v: Vector3 | None = None) -> tuple[Vector3, Matrix3, Vector3]:
        """Position, Jacobian and drift."""
        return self._tool, self.jacobian, (0.0, 0.0, 0.0) if v is None else self._drift(v)

    def strains(self) -> tuple[Scalar, ...]:
        """One over the type-2 measure."""
        return (self._p.L2 * self._p.L2 * self._p.L2 / self.rods.volume,)
