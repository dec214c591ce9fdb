"""How everything moves and what it takes: velocities, accelerations, forces and energies of a tree, as expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cutjoint.compile.equations.inertia import BodyInertia
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions.functions import is_zero
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ZERO, Vector, add, cross, dot, scale


@dataclass(frozen=True, eq=False)
class Motion:
    """Angular and linear velocity (or acceleration) of the origin of every step, in world axes, and the rates (or their
    derivatives) that make them."""

    angular: tuple[Vector, ...]
    linear: tuple[Vector, ...]
    rates: tuple[Number, ...] = ()

    def at(self, step: int, arm: Vector) -> Vector:
        """Velocity of a point at `arm` (world axes) from the step's origin."""
        return add(self.linear[step], cross(self.angular[step], arm))


def velocities(pose: TreePose, u: Sequence[Number]) -> Motion:
    """Velocities of all steps for the rates `u`."""
    angular, linear = [ZERO], [ZERO]
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        parent = step.parent
        at = add(linear[parent], cross(angular[parent], pose.offset[k]))
        slide, spin = _parts(pose, k, u)
        linear.append(add(at, slide))
        angular.append(add(angular[parent], spin))
    return Motion(tuple(angular), tuple(linear), tuple(u))


def accelerations(
    pose: TreePose, u: Sequence[Number], motion: Motion, du: Sequence[Number], base: Vector = ZERO
) -> Motion:
    """Accelerations of all steps for the rates `u`, their velocities `motion` and the rates' derivatives `du`.

    `base` is the acceleration given to the world: minus gravity makes weights appear as inertia forces.
    """
    angular, linear = [ZERO], [base]
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        parent, offset = step.parent, pose.offset[k]
        swing = motion.angular[parent]
        slide, spin = _parts(pose, k, u)
        at = add(linear[parent], cross(angular[parent], offset))
        at = add(at, cross(swing, add(cross(swing, offset), slide)))
        # directions that the parent carries turn with it
        bends = not step.kind.in_world
        at = add(at, cross(swing, slide)) if bends else at
        faster, quicker = _parts(pose, k, du)
        linear.append(add(at, faster))
        turn = add(angular[parent], quicker)
        angular.append(add(turn, cross(swing, spin)) if bends else turn)
    return Motion(tuple(angular), tuple(linear))


def _parts(pose: TreePose, k: int, u: Sequence[Number]) -> tuple[Vector, Vector]:
    """Parts of a step's velocity and angular velocity that come from its own rates."""
    own = pose.own_rate(k, u)
    return (own, ZERO) if pose.tree.steps[k].kind.slides else (ZERO, own)


def inertia_times(pose: TreePose, body: BodyInertia, w: Vector) -> Vector:
    """Inertia of a body, about the step's origin, times `w`."""
    total = ZERO if is_zero(body.base) else scale(body.base, w)
    for weight, axis in body.axes:
        e = pose.lever(body.step, axis)
        total = add(total, scale(weight * dot(e, w), e))
    return total


def generalised_forces(
    pose: TreePose, motion: Motion, acceleration: Motion, held_up: Sequence[BodyInertia] = ()
) -> list[Number]:
    """Forces along the rates that the accelerations need (recursive Newton-Euler), less what compensates the weights of
    the bodies `held_up`, length nv."""
    tree = pose.tree
    force = [ZERO] * len(tree.steps)
    moment = [ZERO] * len(tree.steps)
    for body in pose.bodies:
        k = body.step
        w, dw, pull = motion.angular[k], acceleration.angular[k], acceleration.linear[k]
        h = pose.lever(k, body.moment)
        push = add(cross(dw, h), cross(w, cross(w, h)))
        force[k] = add(force[k], add(scale(body.mass, pull), push))
        spin = add(inertia_times(pose, body, dw), _gyroscopic(pose, body, w))
        moment[k] = add(moment[k], add(spin, cross(h, pull)))
    for point in pose.points:
        k = point.step
        w, arm = motion.angular[k], pose.lever(k, point.lever)
        pull = add(acceleration.at(k, arm), cross(w, cross(w, arm)))
        pull = scale(point.mass, pull)
        force[k] = add(force[k], pull)
        moment[k] = add(moment[k], cross(arm, pull))
    for held in held_up:
        k = held.step
        force[k] = add(force[k], scale(held.mass, pose.gravity))
        moment[k] = add(moment[k], cross(pose.lever(k, held.moment), pose.gravity))
    result: list[Number] = [0.0] * tree.nv
    for k in range(len(tree.steps) - 1, 0, -1):
        step = tree.steps[k]
        for rate, along in enumerate(pose.directions[k], start=step.u):
            result[rate] = dot(along, force[k] if step.kind.slides else moment[k])
        parent = step.parent
        force[parent] = add(force[parent], force[k])
        moment[parent] = add(moment[parent], add(moment[k], cross(pose.offset[k], force[k])))
    return result


def _gyroscopic(pose: TreePose, body: BodyInertia, w: Vector) -> Vector:
    """w x (inertia w); the part of the inertia that is the same about all axes gives nothing."""
    total = ZERO
    for weight, axis in body.axes:
        e = pose.lever(body.step, axis)
        total = add(total, scale(weight * dot(e, w), cross(w, e)))
    return total


def mass_matrix(pose: TreePose, columns: Sequence[Motion]) -> list[list[Number]]:
    """Kinetic energy of every pair of velocity columns, symmetric: the sum over bodies of
    m vi.vj + vi.(wj x h) + vj.(wi x h) + wi.(inertia wj)."""
    n = len(columns)
    result: list[list[Number]] = [[0.0] * n for _ in range(n)]
    for body in pose.bodies:
        k = body.step
        h = pose.lever(k, body.moment)
        speed = [column.linear[k] for column in columns]
        swing = [column.angular[k] for column in columns]
        push = [cross(w, h) for w in swing]
        momentum = [add(scale(body.mass, v), p) for v, p in zip(speed, push, strict=True)]
        shares = [[dot(pose.lever(k, axis), w) for w in swing] for _, axis in body.axes]
        for i in range(n):
            for j in range(i, n):
                energy = dot(speed[i], momentum[j]) + dot(push[i], speed[j])
                if not is_zero(body.base):
                    energy = energy + body.base * dot(swing[i], swing[j])
                for (weight, _), share in zip(body.axes, shares, strict=True):
                    energy = energy + weight * share[i] * share[j]
                if not is_zero(energy):
                    result[i][j] = result[i][j] + energy
    for point in pose.points:
        arm = pose.lever(point.step, point.lever)
        speed = [column.at(point.step, arm) for column in columns]
        for i in range(n):
            for j in range(i, n):
                result[i][j] = result[i][j] + point.mass * dot(speed[i], speed[j])
    for i in range(n):
        for j in range(i):
            result[i][j] = result[j][i]
    return result


def inertia_between(pose: TreePose, columns: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Mass matrix of motions, each a list of all rates (nv), the rotors included; symmetric."""
    result = mass_matrix(pose, [velocities(pose, column) for column in columns])
    for rate, weight in pose.rotors.items():
        for i, one in enumerate(columns):
            for j in range(i, len(columns)):
                result[i][j] = result[i][j] + weight * one[rate] * columns[j][rate]
                result[j][i] = result[i][j]
    return result


def potential_energy(pose: TreePose, origin: Vector = ZERO) -> Number:
    """Potential energy of gravity and what compensates it [J], zero at the world's origin; the tree stands at `origin`
    in the world."""
    total: Number = -dot(pose.gravity, pose.tree.anchored)
    for body in pose.bodies:
        first = add(scale(body.mass, pose.origin(body.step)), pose.lever(body.step, body.moment))
        total = total - dot(pose.gravity, first)
    for point in pose.points:
        place = add(pose.origin(point.step), pose.lever(point.step, point.lever))
        total = total - point.mass * dot(pose.gravity, place)
    for held in pose.held_up:
        first = add(scale(held.mass, pose.origin(held.step)), pose.lever(held.step, held.moment))
        total = total + dot(pose.gravity, first)
    if any(origin):
        weighing = pose.mass - sum((held.mass for held in pose.held_up), 0.0)
        total = total - dot(pose.gravity, origin) * weighing
    return total
