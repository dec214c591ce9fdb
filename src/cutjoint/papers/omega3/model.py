"""The Omega-3 as a `Mechanism`: the virtual-work model of Adetu, Moore, Roberts, equation (42).

The actuated coordinates are the arm angles.  A posture stores (theta_1, theta_2, theta_3, x, y, z): angles and tool
together tell the working mode (elbow of each limb) and the assembly mode (side of the elbows' plane that the tool is
on).  The checks on values are here, the equations in `cutjoint.papers.omega3.equations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import sqrt

import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.errors import ClosureError, LimbReachError, SingularError
from cutjoint.mechanism import ActuatedCoordinates, Actuator, JointLimits, Posture, in_order
from cutjoint.mechanism.interface import are_respected
from cutjoint.papers.omega3 import equations
from cutjoint.papers.omega3.equations import Arms, Omega3State
from cutjoint.papers.omega3.parameters import Omega3Parameters
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.papers.scalars import NUMBERS, Functions, Vector3, three
from cutjoint.papers.three_limbs import SMALLEST_MEASURE, Branch, MeetingRods, MeetingRodsModel, Triple, type_2

HOME_TOOL = (0.1, 0.0, 0.0)
"""Tool position of the home posture [m]: on the axis, in the plane of the paper's path (43)."""


class Omega3Model(MeetingRodsModel[Omega3Parameters], ClosedFormModel[Omega3Parameters, Branch]):
    """The reduced model of the Omega-3.

    Args:
        parameters: geometry and masses, with those that the paper leaves open.
        signs: the working mode at home: theta = atan2(a_x, a_z) + sign * acos(k / r), one sign a limb.  The default is
            elbows out.
    """

    name = "omega3 (virtual work)"
    actuators = tuple(Actuator(f"arm{i}", "rotation") for i in (1, 2, 3))
    payload = "m_payload"
    stored = ("theta_1[rad]", "theta_2[rad]", "theta_3[rad]", "x[m]", "y[m]", "z[m]")
    home_tool = HOME_TOOL
    rod = "rods"

    def __init__(self, parameters: Omega3Parameters | None = None, signs: Sequence[int] = (-1, -1, -1)) -> None:
        super().__init__(parameters if parameters is not None else Omega3Parameters(), signs)

    @property
    def length(self) -> float:
        """Characteristic length [m]: the mean of arm and rod."""
        return 0.5 * (self.parameters.L_A + self.parameters.L_B)

    @cached_property
    def _home_branch(self) -> Branch:
        return self.branch(self.home)

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """The posture with the arms at `q` [rad], in the assembly mode of `near` (forward kinematics, closed form).

        A type-1 singularity is no obstacle here: moving the arms, the robot can pass it.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: the rods are too short to meet.
            SingularError: the posture is singular of type 2.
        """
        are_respected(limits)
        angles = three("q", in_order(q, self.actuators), "rad")
        arms = equations.arms(self.parameters, angles)
        return self._meet(angles, arms, (self._home_branch if near is None else self.branch(near)).assembly)

    def reach_point(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m], in the working mode of `near` (inverse kinematics, equation 4).

        Arm angles are taken within half a turn of those of `near`.

        Raises:
            InputError: wrong shape or not finite.
            LimbReachError: a limb is too short or too long for it.
            SingularError: the posture is singular of type 1 or 2, or a type-2 singularity lies between `near` and it
                because its assembly mode is the other one.
        """
        tool = three("target", p, "m")
        near = self.home if near is None else near
        wanted = self._home_branch if near is self.home else self.branch(near)
        one, two, three_ = near.q.tolist()
        return self._place(tool, wanted.signs, (one, two, three_), wanted.assembly)

    def assembly_modes(self, q: npt.ArrayLike) -> tuple[Posture, Posture]:
        """Both postures with the arms at `q` [rad]: the tool on the sides +1 and -1 of the elbows' plane."""
        angles = three("q", q, "rad")
        arms = equations.arms(self.parameters, angles)
        return self._meet(angles, arms, 1), self._meet(angles, arms, -1)

    def jacobian_dot(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Exact dJ/dt of equation (27) for the arm rates `v` [rad/s], shape (3, 3) [m/s]."""
        return readonly(self.state(at).jacobian_dot(three("v", v, "rad/s")))

    def state(self, at: Posture) -> Omega3State:
        """Equation (42) at a posture."""
        one, two, three_, x, y, z = self.full(at)
        return Omega3State(self.parameters, equations.arms(self.parameters, (one, two, three_)), (x, y, z))

    def state_at(
        self, parameters: Omega3Parameters, q: Vector3, branch: Branch, fn: Functions = NUMBERS
    ) -> Omega3State:
        """Equation (42) with the arms at `q`, the tool on the side of the branch."""
        arms = equations.arms(parameters, q, fn)
        return Omega3State(
            parameters, arms, equations.tool_position(equations.spheres(parameters, arms), branch.assembly, fn)
        )

    def inverse_kinematics(
        self, parameters: Omega3Parameters, p: Vector3, branch: Branch, fn: Functions = NUMBERS
    ) -> Vector3:
        """Arm angles that hold the tool, equation (4)."""
        return equations.arm_angles(parameters, p, branch.signs, fn)

    def _meet(self, angles: Triple, arms: Arms, assembly: int) -> Posture:
        """Forward kinematics with its checks."""
        try:
            spheres = equations.spheres(self.parameters, arms)
        except ZeroDivisionError:
            raise type_2(f"the elbows of {self.name} stand in one line with the arms at {list(angles)} rad") from None
        if spheres.square < 0.0:
            short = sqrt(self.parameters.L_B**2 - spheres.square) - self.parameters.L_B
            raise ClosureError(
                f"the rods of {self.name} are {short:.6g} m too short to meet with the arms at {list(angles)} rad; "
                "turn the arms so that the elbows come nearer to each other",
                gap=(short, 0.0),
                cut="platform",
            )
        tool = equations.tool_position(spheres, assembly)
        return self._checked(angles, tool, self._meeting(arms, tool))

    def _rods(self, angles: Triple, tool: Triple) -> MeetingRods:
        return self._meeting(equations.arms(self.parameters, angles), tool)

    def _meeting(self, arms: Arms, tool: Triple) -> MeetingRods:
        u, ub, volume = equations.rods(arms, tool)
        return MeetingRods(u, ub, volume, self.parameters.L_B)

    def _limb_angle(self, tool: Triple, i: int, sign: int) -> float:
        check_limb(self.name, self.parameters, tool, i)
        return float(equations.arm_angle(self.parameters, tool, i, sign))


def check_limb(name: str, p: Omega3Parameters, tool: Triple, i: int) -> None:
    """Raise where limb i of the model `name` does not reach the tool [m], or only just.

    Raises:
        LimbReachError: it is too short or too long.
        SingularError: arm and rods are in line.
    """
    ax, ay, az = equations.in_limb_frame(p, tool, i)
    flat = p.L_B * p.L_B - ay * ay
    if flat >= 0.0:
        reach, rod = sqrt(ax * ax + az * az), sqrt(flat)
        bounds = (abs(p.L_A - rod), p.L_A + rod)
        plane = "in its plane"
    else:
        reach, bounds, plane = abs(ay), (0.0, p.L_B), "sideways"
    if not bounds[0] <= reach <= bounds[1]:
        raise LimbReachError(
            f"limb {i + 1} of {name} would have to span {reach:.6g} m {plane} to hold the tool at "
            f"{list(tool)} m; it spans {bounds[0]:.6g} to {bounds[1]:.6g} m",
            limb=i + 1,
            reach=reach,
            bounds=bounds,
            target=readonly(tool),
        )
    k = (reach * reach + p.L_A * p.L_A - flat) / (2.0 * p.L_A)
    sine = sqrt(max(0.0, reach * reach - k * k)) / p.L_B
    if sine < SMALLEST_MEASURE:
        raise SingularError(
            f"arm and rods of limb {i + 1} of {name} are in line with the tool at {list(tool)} m: the sine "
            f"between them is {sine:.3g}, below {SMALLEST_MEASURE:g} (type-1 singularity)",
            kind="type-1",
            measure=sine,
            limit=SMALLEST_MEASURE,
        )
