"""What the joints and cuts of a robot do by themselves: dampers, friction, springs, stops, rotors and bushings.

Along the coordinates of joints here, between the frames of cuts in `cutjoint.compile.equations.cut_physics`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pinocchio as pin

from cutjoint.chain.bound import BoundCut
from cutjoint.chain.build import UNBOUNDED
from cutjoint.compile.equations.acting import Acting, Coefficients, OnBall, OnCoordinate, OnRow
from cutjoint.compile.equations.cut_physics import bushed, free
from cutjoint.compile.equations.cut_rows import CutEnd, Relative
from cutjoint.compile.equations.joints import JOINTS, StepKind
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.equations.turning import from_quaternion
from cutjoint.compile.expressions.functions import is_zero, maximum
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import IDENTITY, column, turn
from cutjoint.description.model import CutJoint, Joint, RobotDescription


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
            if not is_zero(weight):
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
                acting += self._on_joint(pose, steps, limits, numbers)
        for cut, bound in self._cuts:
            numbers = _of_cut(cut, pose.given)
            if cut.bushing is None and not numbers.acts:
                continue
            at = self._relative(pose, cut.name, bound)
            found, worst = free(at, cut, numbers) if cut.bushing is None else bushed(at, cut, pose.given)
            acting += found
            strain = maximum(strain, worst)
        return PassiveForces(self._tree.nv, tuple(acting), strain)

    def _relative(self, pose: TreePose, name: str, bound: BoundCut) -> Relative:
        a = self._tree.frame(bound.joint_a, bound.placement_a)
        b = self._tree.frame(bound.joint_b, bound.placement_b)
        ends = CutEnd(pose, pose.frame(f"cuts.{name}.a", a)), CutEnd(pose, pose.frame(f"cuts.{name}.b", b))
        return Relative(pose, *ends, length=pose.given.get(f"cuts.{name}.length", bound.length))

    def _rates(self, k: int) -> range:
        step = self._tree.steps[k]
        return range(step.u, step.u + step.kind.rates)

    def _on_joint(
        self, pose: TreePose, steps: range, limits: Sequence[float | None], numbers: Coefficients
    ) -> list[Acting]:
        """What acts along a ball, along every coordinate, or, where coordinates are no such numbers, dampers alone."""
        kinds = [self._tree.steps[k].kind for k in steps]
        if kinds == [StepKind.BALL]:
            (k,) = steps
            first = self._tree.steps[k].q
            x, y, z, w = pose.q[first : first + 4]
            turned = turn(pose.placed[k], from_quaternion(x, y, z, w))
            return [OnBall(dict(zip(self._rates(k), IDENTITY, strict=True)), turned, numbers)]
        if any(kind.coordinates != kind.rates for kind in kinds):
            return [OnRow({rate: 1.0}, 0.0, 0.0, numbers.damping) for k in steps for rate in self._rates(k)]
        return [
            OnCoordinate(row, pose.q[self._tree.steps[k].q + index], numbers, *limits)
            for k in steps
            for index, row in enumerate(self._rows(pose, k))
        ]

    def _rows(self, pose: TreePose, k: int) -> list[dict[int, Number]]:
        """Of every coordinate of a step, its speed by the rates."""
        rates = self._rates(k)
        if not self._tree.steps[k].kind.in_world:
            return [{rate: 1.0} for rate in rates]
        return [dict(zip(rates, column(pose.placed[k], index), strict=True)) for index in range(len(rates))]


def _of_joint(joint: Joint, given: Mapping[str, Number]) -> Coefficients:
    return Coefficients.of(f"joints.{joint.name}", joint.physics, given)


def _of_cut(cut: CutJoint, given: Mapping[str, Number]) -> Coefficients:
    return Coefficients.of(f"cuts.{cut.name}", cut.physics, given)
