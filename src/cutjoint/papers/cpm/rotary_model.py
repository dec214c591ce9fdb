"""The CPM with rotary motors as a `Mechanism`: section 1.1 of Elkady et al. 2008, worked out.

The actuated coordinates are the angles of the first rods, (theta_11, theta_21, theta_31).  A posture stores them and
the tool, (theta_11, theta_21, theta_31, x, y, z): with the tool known each limb has two solutions (eight working
modes), with the motors known the tool has up to eight (assembly modes, `cutjoint.papers.cpm.forward`).  The equations
are in `cutjoint.papers.cpm.rotary`, the checks on values here.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, pi

import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.errors import ClosureError, SingularError
from cutjoint.mechanism import ActuatedCoordinates, Actuator, JointLimits, Posture, in_order
from cutjoint.mechanism.interface import are_respected
from cutjoint.papers.cpm import equations, forward, per_limb, rotary
from cutjoint.papers.cpm.model import HOME_TOOL, check_limb
from cutjoint.papers.cpm.parameters import CpmParameters
from cutjoint.papers.cpm.rotary import CpmRotaryState
from cutjoint.papers.cpm.tracking import Track, walk
from cutjoint.papers.scalars import three
from cutjoint.papers.three_limbs import SMALLEST_MEASURE, MeetingRods, MeetingRodsModel, Signs, Triple, type_2


class CpmRotaryModel(MeetingRodsModel[CpmParameters]):
    """The CPM driven by its first revolute joints, reduced to their angles.

    Args:
        parameters: geometry and masses, those of `CpmModel`.
        signs: the working mode at home; +1 where sin(theta_i1 - theta_i2) > 0, as in `CpmModel`.  The default stays far
            from singularities of type 2 at home and along the paper's circle.
    """

    name = "cpm_rotary (Lagrange)"
    actuators = tuple(Actuator(f"limb{i}_shoulder", "rotation") for i in (1, 2, 3))
    payload = "m4"
    stored = ("theta_11[rad]", "theta_21[rad]", "theta_31[rad]", "x[m]", "y[m]", "z[m]")
    home_tool = HOME_TOOL
    rod = "second rods"

    def __init__(self, parameters: CpmParameters | None = None, signs: Sequence[int] = (1, 1, 1)) -> None:
        super().__init__(parameters if parameters is not None else CpmParameters(), signs)

    @property
    def length(self) -> float:
        """Characteristic length [m]: the mean of the two links of a limb."""
        return 0.5 * (self.parameters.L1 + self.parameters.L2)

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """The posture with the motors at `q` [rad] on the branch of `near`: the motors are turned there, all at once.

        The way is walked in steps that are proved to stay on the branch (`cutjoint.papers.cpm.tracking`).  A limb that
        is stretched on the way (type 1) is no obstacle: moving the motors, the robot can pass it.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: no position of the tool at all belongs to `q`.
            SingularError: a singularity of type 2 lies on the way or at `q`.
        """
        are_respected(limits)
        target = three("q", in_order(q, self.actuators), "rad")
        start = self.home if near is None else near
        track = walk(self.parameters, SMALLEST_MEASURE, *self.split(start), target)
        if track.progress < 1.0:
            raise self._refusal(target, track)
        return self._checked(target, track.tool, self._rods(target, track.tool))

    def reach_point(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m] in the working mode of `near` (inverse kinematics, closed form).

        Motor angles are those that leading the tool there on a straight line gives, also beyond a turn.

        Raises:
            InputError: wrong shape or not finite.
            LimbReachError: a limb is too short or too long for it.
            SingularError: the posture is singular of type 1 or 2, or a type-2 singularity lies between `near` and it
                because it is on the other side of it.
        """
        tool = three("target", p, "m")
        near = self.home if near is None else near
        branch = self.branch(near)
        at = self._place(tool, branch.signs, assembly=branch.assembly)
        one, two, three_ = (
            angle + 2.0 * pi * round((wanted - angle) / (2.0 * pi))
            for angle, wanted in zip(at.q.tolist(), self._led(near, branch.signs, tool, at), strict=True)
        )
        return Posture(readonly((one, two, three_)), readonly((one, two, three_, *tool)), at.gap, self.layout)

    def assembly_modes(self, q: npt.ArrayLike) -> tuple[Posture, ...]:
        """All postures with the motors at `q` [rad]: none to eight, an even number, in the order of x, y, z.

        Raises:
            InputError: wrong shape or not finite.
            SingularError: one of them is singular of type 2, where two of them meet.
        """
        angles = three("q", q, "rad")
        found = forward.solutions(self.parameters, angles).tolist()
        return tuple(self._checked(angles, (x, y, z), self._rods(angles, (x, y, z))) for x, y, z in found)

    def singularities(self, at: Posture) -> tuple[Array, float]:
        """How far a posture is from singular.

        Returns:
            type 1, shape (3,): sin(theta_i2 - theta_i1), zero where limb i is stretched or folded.
            type 2: cos cos cos - sin sin sin of the angles of the second rods, zero where the tool can move with the
            motors held.
        """
        state = self.state(at)
        second = per_limb.second_angles(self.parameters, state.limbs)
        return readonly(rotary.type_1(self.parameters, state.rods)), float(rotary.type_2(second))

    def state(self, at: Posture) -> CpmRotaryState:
        """The equations at a posture."""
        one, two, three_, x, y, z = self.full(at)
        return CpmRotaryState(self.parameters, (one, two, three_), (x, y, z))

    def _rods(self, angles: Triple, tool: Triple) -> MeetingRods:
        limbs = rotary.limbs(self.parameters, tool, angles)
        e, (one, two, three_), volume = rotary.rods(self.parameters, limbs)
        return MeetingRods(e, (-one, -two, -three_), volume, self.parameters.L2)

    def _limb_angle(self, tool: Triple, i: int, sign: int) -> float:
        end = equations.limb_ends(self.parameters, tool)[i]
        check_limb(self.name, self.parameters, i + 1, end, tool, "type-1")
        return float(equations.limb_angle(self.parameters, *end, sign))

    def _led(self, near: Posture, signs: Signs, tool: Triple, at: Posture) -> list[float]:
        """Motor angles, to a fraction of a turn, when the tool is led on a straight line from `near`: the way from a
        slider to its limb's end turns by less than half a turn then, and the first rod stays ahead or behind."""
        p = self.parameters
        found = []
        for before, now, sign, old, new in zip(
            equations.limb_ends(p, self.split(near)[1]), equations.limb_ends(p, tool), signs, near.q, at.q, strict=True
        ):
            (u0, w0), (u1, w1) = before, now
            turn = atan2(u0 * w1 - w0 * u1, u0 * u1 + w0 * w1)
            ahead = [(sign * (angle - atan2(w, u))) % (2.0 * pi) for angle, u, w in ((old, u0, w0), (new, u1, w1))]
            found.append(float(old) + turn + sign * (ahead[1] - ahead[0]))
        return found

    def _refusal(self, target: Triple, track: Track) -> SingularError | ClosureError:
        """The error for a way that ended before its target."""
        x, y, z = track.tool
        if len(forward.solutions(self.parameters, target)):
            return type_2(
                f"{self.name} runs into a type-2 singularity after {track.progress:.1%} of the way to {list(target)} "
                f"rad, with the tool at {[round(one, 6) for one in track.tool]} m; these motor angles belong to "
                "another assembly mode",
                track.measure,
            )
        elbows = forward.elbows(self.parameters, target).tolist()
        reach = [hypot(a - u, b - w) for (a, b), (u, w) in zip(((y, z), (z, x), (x, y)), elbows, strict=True)]
        return ClosureError(
            f"the second rods of {self.name} cannot meet with the motors at {list(target)} rad, wherever the tool is; "
            f"the way there ends in a type-2 singularity after {track.progress:.1%}",
            gap=(max(abs(one - self.parameters.L2) for one in reach), 0.0),
            cut="platform",
            progress=track.progress,
        )
