"""What the joints and cuts of a robot do by themselves: dampers, friction, springs, stops, rotors and bushings.

Along the coordinates of joints, along what a cut leaves free, and along the equations of a cut that is a bushing, whose
rows are the exact gradient of their sum of squares however far its frames are apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pinocchio as pin

from cutjoint.chain.bound import BoundCut
from cutjoint.chain.build import UNBOUNDED
from cutjoint.compile.equations.acting import Acting, Coefficients, OnBall, OnCoordinate, OnRow
from cutjoint.compile.equations.cut_rows import WRITTEN, End, Relative
from cutjoint.compile.equations.joints import JOINTS, StepKind
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.equations.turning import between, from_quaternion, leaning
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import maximum
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import IDENTITY, column, dot, turn
from cutjoint.description.cuts import CutType, Equation, Kind, slide
from cutjoint.description.model import CutJoint, Joint, JointType, RobotDescription

Row = dict[int, Number]


@dataclass(frozen=True, eq=False)
class PassiveForces:
    """What acts at one pose.

    Attributes:
        acting: all of it.
        strain: how near a turn is to half a turn, where its axis has no digits.
    """

    nv: int
    acting: tuple[Acting, ...]
    strain: Number

    def springs(self) -> list[Number]:
        """Effort along the rates of the tree that holds springs, bushings and stops, length nv."""
        return self._sum([one for acting in self.acting for one in acting.springs()])

    def friction(self, u: list[Number]) -> list[Number]:
        """Effort along the rates of the tree that overcomes dampers and friction at the rates `u`, length nv."""
        return self._sum([one for acting in self.acting for one in acting.friction(u)])

    def potential(self) -> Number:
        """Energy in springs, bushings and stops [J]."""
        total: Number = 0.0
        for acting in self.acting:
            total = total + acting.potential()
        return total

    def _sum(self, forces: Sequence[tuple[int, Number]]) -> list[Number]:
        total: list[Number] = [0.0] * self.nv
        for rate, force in forces:
            total[rate] = total[rate] + force
        return total


class TreePhysics:
    """Joints, cuts and bushings of a robot, as far as they may do something by themselves.

    Args:
        tree: of the robot.
        model: Pinocchio's, that it was made from.
        description: of the robot.
    """

    def __init__(self, tree: JointTree, model: pin.Model, description: RobotDescription) -> None:
        self._tree = tree
        self._joints: list[tuple[Joint, range, list[float | None]]] = []
        for joint in range(1, model.njoints):
            one, last = description.joint(model.names[joint]), tree.mounts[joint].step
            limits: list[float | None] = [None, None]
            if one.type.single:
                at = int(model.idx_qs[joint])
                found = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
                limits = [None if abs(limit) >= UNBOUNDED else limit for limit in found]
            self._joints.append((one, range(last + 1 - len(JOINTS[one.type]), last + 1), limits))
        self._cuts = [(cut, BoundCut.of(model, cut)) for cut in description.cuts]

    def sticking(self, given: Mapping[str, Number]) -> tuple[str, ...]:
        """Names of joints and cuts whose friction jumps at rest."""
        joints = [one.name for one, *_ in self._joints if _of_joint(one, given).sticks]
        return (*joints, *(cut.name for cut, _ in self._cuts if _of_cut(cut, given).sticks))

    def rotors(self, given: Mapping[str, Number]) -> dict[int, Number]:
        """Rate -> what the rotor behind it weighs there, where there is one."""
        found: dict[int, Number] = {}
        for one, steps, _ in self._joints:
            weight = _of_joint(one, given).armature
            if not functions.is_zero(weight):
                for k in steps:
                    found.update(dict.fromkeys(self._rates(k), weight))
        return found

    def at(self, pose: TreePose) -> PassiveForces:
        """What acts at a pose of the tree."""
        acting: list[Acting] = []
        strain: Number = 0.0
        for one, steps, limits in self._joints:
            numbers = _of_joint(one, pose.given)
            if numbers.acts:
                acting += self._on_joint(pose, one, steps, limits, numbers)
        for cut, bound in self._cuts:
            numbers = _of_cut(cut, pose.given)
            if cut.bushing is None and not numbers.acts:
                continue
            at = self._relative(pose, cut.name, bound)
            found, worst = _free(at, cut.type, numbers) if cut.bushing is None else _bushed(at, cut, pose.given)
            acting += found
            strain = maximum(strain, worst)
        return PassiveForces(self._tree.nv, tuple(acting), strain)

    def _relative(self, pose: TreePose, name: str, bound: BoundCut) -> Relative:
        a = self._tree.frame(bound.joint_a, bound.placement_a)
        b = self._tree.frame(bound.joint_b, bound.placement_b)
        return Relative(pose, End(pose, pose.frame(f"cuts.{name}.a", a)), End(pose, pose.frame(f"cuts.{name}.b", b)))

    def _rates(self, k: int) -> range:
        step = self._tree.steps[k]
        return range(step.u, step.u + step.kind.rates)

    def _on_joint(
        self, pose: TreePose, joint: Joint, steps: range, limits: Sequence[float | None], numbers: Coefficients
    ) -> list[Acting]:
        if joint.type is JointType.SPHERICAL:
            (k,) = steps
            step = self._tree.steps[k]
            assert step.kind is StepKind.BALL
            x, y, z, w = pose.q[step.q : step.q + 4]
            turned = turn(pose.placed[k], from_quaternion(x, y, z, w))
            return [OnBall(dict(zip(self._rates(k), IDENTITY, strict=True)), turned, numbers)]
        if joint.type in (JointType.PLANAR, JointType.FLOATING):
            return [OnRow({rate: 1.0}, 0.0, 0.0, numbers.damping) for k in steps for rate in self._rates(k)]
        placed = [self._tree.steps[k] for k in steps]
        return [OnCoordinate({step.u: 1.0}, pose.q[step.q], numbers, *limits) for step in placed]


def _of_joint(joint: Joint, given: Mapping[str, Number]) -> Coefficients:
    return Coefficients.of(f"joints.{joint.name}", joint.physics, given)


def _of_cut(cut: CutJoint, given: Mapping[str, Number]) -> Coefficients:
    return Coefficients.of(f"cuts.{cut.name}", cut.physics, given)


def _free(at: Relative, kind: CutType, numbers: Coefficients) -> tuple[list[Acting], Number]:
    """What acts along the motion that a rigid cut leaves free, and the strain of it."""
    a, b = at.a.axes, at.b.axes
    match kind:
        case CutType.REVOLUTE:
            angle = functions.atan2(dot(column(a, 1), column(b, 0)), dot(column(a, 0), column(b, 0)))
            return [OnCoordinate(at.turning(column(a, 2)), angle, numbers)], 0.0
        case CutType.PRISMATIC:
            ((row, _, travel),) = WRITTEN[Kind.SLIDE](at, slide(2))
            return [OnCoordinate(row, travel, numbers)], 0.0
        case CutType.UNIVERSAL:
            first = functions.atan2(dot(column(a, 2), column(b, 1)), dot(column(a, 1), column(b, 1)))
            second = functions.atan2(dot(column(a, 0), column(b, 2)), dot(column(a, 0), column(b, 0)))
            on_a = OnCoordinate(at.turning(column(a, 0)), first, numbers)
            return [on_a, OnCoordinate(at.turning(column(b, 1)), second, numbers)], 0.0
        case CutType.SPHERICAL:
            turned, strain = between(a, b)
            return [OnBall(at.angular, turned, numbers)], 0.0 if functions.is_zero(numbers.stiffness) else strain
        case CutType.FIXED:
            return [], 0.0


def _bushed(at: Relative, cut: CutJoint, given: Mapping[str, Number]) -> tuple[list[Acting], Number]:
    """What a bushing does, and the strain of it."""
    acting: list[Acting] = []
    strain: Number = 0.0
    for equation in cut.type.equations:
        first = "" if equation.is_length else "turning_"
        of = [
            given.get(f"cuts.{cut.name}.bushing.{first}{what}", float(getattr(cut.bushing, first + what)))
            for what in ("stiffness", "damping")
        ]
        rows, worst = _stretched(at, equation)
        acting += [OnRow(row, left, *of) for row, left in rows]
        strain = maximum(strain, worst)
    return acting, strain


def _stretched(at: Relative, equation: Equation) -> tuple[list[tuple[Row, Number]], Number]:
    """Rows of an equation and by how much it is open, exact however far that is; and the strain of it."""
    match equation.kind:
        case Kind.LOCK:
            turned, strain = between(at.a.axes, at.b.axes)
            return [({u: one[k] for u, one in at.angular.items()}, turned[k]) for k in range(3)], strain
        case Kind.HINGE:
            lean, strain = leaning(column(at.a.axes, 2), column(at.b.axes, 2))
            x, y = column(at.a.axes, 0), column(at.a.axes, 1)
            return [(at.turning(x), dot(x, lean)), (at.turning(y), dot(y, lean))], strain
        case _:
            return [(row, left) for row, _, left in WRITTEN[equation.kind](at, equation)], 0.0
