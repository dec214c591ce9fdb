"""The Cartesian Parallel Manipulator as a `Mechanism`: Lagrange's equations of Elkady et al. 2008, equation (39).

The actuated coordinates are the slider positions, which are the tool position (equation 10), so `close` and `reach` are
the same.  A posture stores (x, y, z, theta_11, theta_21, theta_31); the angles tell the branch.  The checks on values
are here, the equations in `cutjoint.papers.cpm.equations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin, sqrt

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import readonly
from cutjoint.errors import LimbReachError, SingularError
from cutjoint.mechanism import Actuator, Posture, Tool
from cutjoint.papers.cpm import equations
from cutjoint.papers.cpm.parameters import CpmParameters
from cutjoint.papers.cpm.quantities import CpmQuantities
from cutjoint.papers.cpm.state import CpmState
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.papers.scalars import NUMBERS, Functions, Vector3, three
from cutjoint.papers.three_limbs import Signs, Triple

HOME_TOOL = (0.6, 0.425, 0.3)
"""Tool position of the home posture [m]: where the paper's circle starts (section 5.3)."""

SMALLEST_SINE = 1e-4
"""Smallest |sin(elbow)| that is accepted.  Gamma loses as many digits as the sine's square: eight are left here, and
only the last nanometre of a limb's reach is given up."""

_IDENTITY = np.eye(3)
_STILL = np.zeros(3)


class CpmModel(CpmQuantities, ClosedFormModel[CpmParameters, Signs]):
    """The reduced model of the CPM.

    Args:
        parameters: geometry and masses.
        signs: the elbow branch of each limb at home.  +1 where sin(theta_i1 - theta_i2) > 0, so that the first link
            stands ahead of the line from slider to platform, -1 otherwise.  The default is the branch that the paper's
            own figures need (see docs/errata.md).
    """

    name = "cpm (Lagrange)"
    actuators = tuple(Actuator(f"limb{i}_slide", "translation") for i in (1, 2, 3))
    payload = "m4"
    home_tool = HOME_TOOL

    def __init__(self, parameters: CpmParameters | None = None, signs: Sequence[int] = (1, -1, 1)) -> None:
        super().__init__(parameters if parameters is not None else CpmParameters(), signs)

    @property
    def length(self) -> float:
        """Characteristic length [m]: the mean of the two links of a limb."""
        return 0.5 * (self.parameters.L1 + self.parameters.L2)

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the sliders at `q` = (x, y, z) [m], on the elbow branch of `near`.

        Raises:
            InputError: wrong shape or not finite.
            LimbReachError: a limb is too short or too long for it.
            SingularError: a limb is stretched or folded (kind `limb`).
        """
        return self._place(three("q", q, "m"), self.signs if near is None else self.branch(near))

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m]; the same as `close` (equation 10), with the same errors."""
        return self._place(three("p", p, "m"), self.signs if near is None else self.branch(near))

    def branch(self, at: Posture) -> Signs:
        """The elbow signs of a posture."""
        x, y, z, *angles = self.full(at)
        one, two, three_ = equations.limbs(self.parameters, (x, y, z), (angles[0], angles[1], angles[2]))
        return (
            1 if one.denominator > 0 else -1,
            1 if two.denominator > 0 else -1,
            1 if three_.denominator > 0 else -1,
        )

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """The tool follows the sliders: the Jacobian is the identity, the drift zero (equation 10)."""
        if v is not None:
            three("v", v, "m/s")
        return Tool(np.array(self.full(at)[:3]), _IDENTITY, _STILL)

    def state_at(self, parameters: CpmParameters, q: Vector3, branch: Signs, fn: Functions = NUMBERS) -> CpmState:
        """Equation (39) with the sliders at `q`."""
        angles = equations.limb_angles(parameters, q, branch, fn)
        return CpmState(parameters, self.coefficients(parameters), q, angles, fn)

    def inverse_kinematics(
        self, parameters: CpmParameters, p: Vector3, branch: Signs, fn: Functions = NUMBERS
    ) -> Vector3:
        """The sliders stand where the tool does (equation 10)."""
        return p

    def _place(self, tool: Triple, signs: Signs) -> Posture:
        p = self.parameters
        angles, gap = [], 0.0
        for number, ((u, w), sign) in enumerate(zip(equations.limb_ends(p, tool), signs, strict=True), start=1):
            check_limb(self.name, p, number, (u, w), tool, "limb")
            angle = equations.limb_angle(p, u, w, sign)
            gap = max(gap, abs(hypot(u - p.L1 * cos(angle), w - p.L1 * sin(angle)) - p.L2))
            angles.append(angle)
        return Posture(readonly(tool), readonly((*tool, *angles)), (gap, 0.0))


def check_limb(
    name: str,
    p: CpmParameters,
    number: int,
    end: tuple[float, float],
    tool: Triple,
    kind: str,
) -> None:
    """Raise where limb `number` of the model `name` does not reach the tool [m], or only just.

    Args:
        end: (u, w) of the limb in its own plane [m].
        kind: of the singularity, for the error: `limb`, or `type-1` where the first rod is driven.

    Raises:
        LimbReachError: it is too short or too long.
        SingularError: it is stretched or folded.
    """
    bounds = p.reach
    square = end[0] * end[0] + end[1] * end[1]
    reach = sqrt(square)
    if not bounds[0] <= reach <= bounds[1]:
        raise LimbReachError(
            f"limb {number} of {name} would have to span {reach:.6g} m to hold the tool at "
            f"{list(tool)} m; it spans {bounds[0]:.6g} to {bounds[1]:.6g} m",
            limb=number,
            reach=reach,
            bounds=bounds,
            target=readonly(tool),
        )
    cosine = (square - p.L1 * p.L1 - p.L2 * p.L2) / (2.0 * p.L1 * p.L2)
    sine = sqrt(max(0.0, 1.0 - cosine * cosine))
    if sine < SMALLEST_SINE:
        raise SingularError(
            f"limb {number} of {name} is {'stretched' if cosine > 0 else 'folded'} with the tool at "
            f"{list(tool)} m: |sin(elbow)| = {sine:.3g} is below {SMALLEST_SINE:g}; stay away from limb "
            f"reaches of {bounds[0]:.6g} and {bounds[1]:.6g} m",
            kind=kind,
            measure=sine,
            limit=SMALLEST_SINE,
        )
