"""The open tree of a Pinocchio model as expressions: placements, velocities, accelerations, forces.

Everything is in world axes, so a planar limb leaves zeros instead of rotated zeros.  Two choices keep the expressions
short.  A joint with a slanted axis gets a frame of its own whose z axis is that axis (constants only).  And the rates
of joints with several coordinates (`u` below) are vectors in world axes, where they enter as they stand; Pinocchio's
own velocities `v` are in the moving body's axes and are converted at the border.

All joint types are broken down into turns about one axis, slides along one axis, free translations and free rotations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile.equations.inertia import Body, Kind, Moments, Step, make_body, regrouped
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Functions, Number, is_zero
from cutjoint.compile.expressions.vectors import IDENTITY, ZERO, Matrix, Vector
from cutjoint.errors import InputError


@dataclass(frozen=True, eq=False)
class PointMass:
    """A mass that is an argument of the compiled function (a payload), at `lever` in the frame of a step."""

    step: int
    mass: Number
    lever: Vector


@dataclass(frozen=True, eq=False)
class Mount:
    """Where a joint of the model sits: step and constant rotation from the joint's frame to the step's."""

    step: int
    rotation: Array


RATES = {Kind.TURN: 1, Kind.SLIDE: 1, Kind.SHIFT: 3, Kind.FLAT: 2, Kind.BALL: 3, Kind.SPIN: 1}


class Tree:
    """Constant data of the tree.

    Attributes:
        steps: elementary joints, parents first; index 0 is the world.
        bodies: what has mass, regrouped.
        mass: of all moving bodies [kg].
        anchored: first moment that rests on the world [kg m].
        mounts: for every joint of the model, the step that carries its body.
        nq, nv: sizes of configuration and velocity.
        gravity: acceleration of gravity [m/s2].
    """

    def __init__(self, model: pin.Model) -> None:
        self.nq, self.nv = int(model.nq), int(model.nv)
        self.gravity = vectors.constant_vector(np.asarray(model.gravity.linear))
        self.steps: list[Step] = [Step(-1, IDENTITY, ZERO, Kind.TURN, 0, -1, -1)]
        self.mounts: list[Mount] = [Mount(0, np.eye(3))]
        if np.any(np.asarray(getattr(model, "armature", np.zeros(1)))):
            raise InputError("rotor inertias (armature) cannot be compiled; add them to the links")
        for joint in range(1, model.njoints):
            self._add(model, joint)
        self.mass = sum(float(model.inertias[joint].mass) for joint in range(1, model.njoints))
        self.bodies, self.anchored = regrouped(self.steps, self._inertias(model))

    def _add(self, model: pin.Model, joint: int) -> None:
        parent = self.mounts[model.parents[joint]]
        placement = model.jointPlacements[joint]
        rotation = parent.rotation @ np.asarray(placement.rotation)
        translation = parent.rotation @ np.asarray(placement.translation)
        name = str(model.joints[joint].shortname())
        iq, iv = int(model.idx_qs[joint]), int(model.idx_vs[joint])
        columns = motion_subspace(model, joint)
        match int(model.nqs[joint]), int(model.nvs[joint]):
            case 1, 1:
                linear, angular = columns[:3, 0], columns[3:, 0]
                turns = bool(np.linalg.norm(angular) > 0.5)
                kind, axis = (Kind.TURN, angular) if turns else (Kind.SLIDE, linear)
                if turns and np.linalg.norm(linear) > 1e-12:
                    raise InputError(f"joint '{model.names[joint]}' ({name}) cannot be compiled: a screw")
                self._turn(parent.step, rotation, translation, kind, axis, iq, iv)
            case 2, 2 if "Universal" in name:
                self._turn(parent.step, rotation, translation, Kind.TURN, columns[3:, 0], iq, iv)
                middle = self.mounts.pop()
                self._turn(middle.step, middle.rotation, np.zeros(3), Kind.TURN, columns[3:, 1], iq + 1, iv + 1)
            case 4, 3 if "Spherical" in name:
                self._step(parent.step, rotation, translation, Kind.BALL, iq, iv)
                self.mounts.append(Mount(len(self.steps) - 1, np.eye(3)))
            case 4, 3 if "Planar" in name:
                self._step(parent.step, rotation, translation, Kind.FLAT, iq, iv)
                self._step(len(self.steps) - 1, np.eye(3), np.zeros(3), Kind.SPIN, iq + 2, iv + 2, axis=2)
                self.mounts.append(Mount(len(self.steps) - 1, np.eye(3)))
            case 7, 6:
                self._step(parent.step, rotation, translation, Kind.SHIFT, iq, iv)
                self._step(len(self.steps) - 1, np.eye(3), np.zeros(3), Kind.BALL, iq + 3, iv + 3)
                self.mounts.append(Mount(len(self.steps) - 1, np.eye(3)))
            case _:
                raise InputError(f"joint '{model.names[joint]}' of type {name} cannot be compiled")

    def _turn(self, parent: int, rotation: Array, translation: Array, kind: Kind, axis: Array, q: int, u: int) -> None:
        """A turn or slide about any axis: a frame whose coordinate axis it is, and the rotation back from it."""
        axis = axis / np.linalg.norm(axis)
        nearest = int(np.argmax(np.abs(axis)))
        if abs(axis[nearest] - 1.0) < vectors.ROUNDING:
            own = np.eye(3)
        else:
            own, nearest = vectors.rotation_onto(axis), 2
        self._step(parent, rotation @ own, translation, kind, q, u, axis=nearest)
        self.mounts.append(Mount(len(self.steps) - 1, own.T))

    def _step(
        self, parent: int, rotation: Array, translation: Array, kind: Kind, q: int, u: int, *, axis: int = 0
    ) -> None:
        where = vectors.constant_rotation(rotation), vectors.constant_vector(translation)
        self.steps.append(Step(parent, *where, kind, axis, q, u))

    def _inertias(self, model: pin.Model) -> dict[int, Moments]:
        """Mass, first and second moments of the body on each step, about the step's origin in its frame."""
        found: dict[int, Moments] = {}
        for joint in range(1, model.njoints):
            inertia, mount = model.inertias[joint], self.mounts[joint]
            mass, turn = float(inertia.mass), mount.rotation
            centre = turn @ np.asarray(inertia.lever)
            second = turn @ np.asarray(inertia.inertia) @ turn.T
            second = second + mass * (float(centre @ centre) * np.eye(3) - np.outer(centre, centre))
            found[mount.step] = Moments(mass, mass * centre, second)
        return found

    def scaled_body(self, joint: int, mass: Number, centre: Array, inertia: Array) -> Body:
        """A body on a joint whose mass is an expression; `centre` [m] and `inertia` per mass [m2] about the joint's
        origin, in the joint's frame."""
        mount = self.mounts[joint]
        unit = Moments(1.0, mount.rotation @ centre, mount.rotation @ inertia @ mount.rotation.T)
        body = make_body(mount.step, unit)
        assert body is not None
        moment = vectors.scale(mass, body.moment)
        return Body(body.step, mass, moment, mass * body.base, tuple((mass * w, axis) for w, axis in body.axes))

    def point(self, joint: int, position: Array) -> tuple[int, Vector]:
        """Step and lever of a point given in a joint's frame."""
        mount = self.mounts[joint]
        return mount.step, vectors.constant_vector(mount.rotation @ np.asarray(position))

    def frame(self, joint: int, placement: pin.SE3) -> tuple[int, Matrix, Vector]:
        """Step, rotation and lever of a frame given in a joint's frame."""
        step, lever = self.point(joint, np.asarray(placement.translation))
        return step, vectors.constant_rotation(self.mounts[joint].rotation @ np.asarray(placement.rotation)), lever


def motion_subspace(model: pin.Model, joint: int) -> Array:
    """Twists (linear, angular) of a joint's rates at its zero, in its own frame, shape (6, rates of the joint)."""
    one = model.joints[joint]
    data = one.createData()
    one.calc(data, pin.neutral(model))
    return np.asarray(data.S).reshape(6, -1)


class Pose:
    """Placements of all steps for a configuration `q` (expressions, Pinocchio's layout).

    Attributes:
        bodies, points: those of the tree, and further ones whose masses are expressions.
        rotation: of every step, in world axes.
        placed: rotation before the step's own motion.
        offset: from the parent's origin to the step's, in world axes.
    """

    def __init__(
        self, tree: Tree, q: Sequence[Number], bodies: Sequence[Body] = (), points: Sequence[PointMass] = ()
    ) -> None:
        self.tree, self.q = tree, tuple(q)
        self.bodies, self.points = (*tree.bodies, *bodies), tuple(points)
        self.rotation: list[Matrix] = [IDENTITY]
        self.placed: list[Matrix] = [IDENTITY]
        self.offset: list[Vector] = [ZERO]
        self.axis: list[Vector] = [ZERO]
        fn = Functions
        for step in tree.steps[1:]:
            carrier = self.rotation[step.parent]
            placed = vectors.product(carrier, step.rotation)
            offset = vectors.turn(carrier, step.translation)
            rotation, k = placed, step.q
            match step.kind:
                case Kind.TURN:
                    sine, cosine = fn.sin(q[k]), fn.cos(q[k])
                    rotation = vectors.product(placed, vectors.about(step.axis, sine, cosine))
                case Kind.SPIN:
                    rotation = vectors.product(placed, vectors.about(step.axis, q[k + 1], q[k]))
                case Kind.SLIDE:
                    offset = vectors.add(offset, vectors.scale(q[k], vectors.column(placed, step.axis)))
                case Kind.SHIFT:
                    offset = vectors.add(offset, vectors.turn(placed, (q[k], q[k + 1], q[k + 2])))
                case Kind.FLAT:
                    offset = vectors.add(offset, vectors.turn(placed, (q[k], q[k + 1], 0.0)))
                case Kind.BALL:
                    rotation = vectors.product(placed, vectors.from_quaternion(q[k], q[k + 1], q[k + 2], q[k + 3]))
            self.placed.append(placed)
            self.rotation.append(rotation)
            self.offset.append(offset)
            self.axis.append(vectors.column(placed, step.axis))

    @property
    def mass(self) -> Number:
        """Mass of everything that moves [kg]."""
        total: Number = self.tree.mass
        for body in self.bodies[len(self.tree.bodies) :]:
            total = total + body.mass
        for point in self.points:
            total = total + point.mass
        return total

    def origin(self, step: int) -> Vector:
        """Origin of a step in the world."""
        total = ZERO
        while step > 0:
            total = vectors.add(self.offset[step], total)
            step = self.tree.steps[step].parent
        return total

    def lever(self, step: int, lever: Vector) -> Vector:
        """A vector of a step's frame in world axes."""
        return vectors.turn(self.rotation[step], lever)

    def columns(self, step: int, lever: Vector) -> list[tuple[int, Vector, Vector]]:
        """(rate, velocity of a point, angular velocity) for every rate that moves the point `lever` [m] of `step`."""
        arm = self.lever(step, lever)
        found: list[tuple[int, Vector, Vector]] = []
        while step > 0:
            here = self.tree.steps[step]
            match here.kind:
                case Kind.TURN | Kind.SPIN:
                    found.append((here.u, vectors.cross(self.axis[step], arm), self.axis[step]))
                case Kind.SLIDE:
                    found.append((here.u, self.axis[step], ZERO))
                case Kind.SHIFT:
                    found.extend((here.u + k, IDENTITY[k], ZERO) for k in range(3))
                case Kind.FLAT:
                    found.extend((here.u + k, vectors.column(self.placed[step], k), ZERO) for k in range(2))
                case Kind.BALL:
                    found.extend((here.u + k, vectors.cross(IDENTITY[k], arm), IDENTITY[k]) for k in range(3))
            arm = vectors.add(arm, self.offset[step])
            step = here.parent
        return found


@dataclass(frozen=True, eq=False)
class Motion:
    """Angular and linear velocity (or acceleration) of the origin of every step, in world axes."""

    angular: tuple[Vector, ...]
    linear: tuple[Vector, ...]

    def at(self, step: int, arm: Vector) -> Vector:
        """Velocity of a point at `arm` (world axes) from the step's origin."""
        return vectors.add(self.linear[step], vectors.cross(self.angular[step], arm))


def sliding(pose: Pose, k: int, u: Sequence[Number]) -> Vector:
    """Part of a step's linear velocity that comes from its own translation."""
    step = pose.tree.steps[k]
    match step.kind:
        case Kind.SLIDE:
            return vectors.scale(u[step.u], pose.axis[k])
        case Kind.SHIFT:
            return (u[step.u], u[step.u + 1], u[step.u + 2])
        case Kind.FLAT:
            return vectors.turn(pose.placed[k], (u[step.u], u[step.u + 1], 0.0))
    return ZERO


def turning(pose: Pose, k: int, u: Sequence[Number]) -> Vector:
    """Part of a step's angular velocity that comes from its own rotation."""
    step = pose.tree.steps[k]
    match step.kind:
        case Kind.TURN | Kind.SPIN:
            return vectors.scale(u[step.u], pose.axis[k])
        case Kind.BALL:
            return (u[step.u], u[step.u + 1], u[step.u + 2])
    return ZERO


def velocities(pose: Pose, u: Sequence[Number]) -> Motion:
    """Velocities of all steps for the rates `u`."""
    angular, linear = [ZERO], [ZERO]
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        parent = step.parent
        at = vectors.add(linear[parent], vectors.cross(angular[parent], pose.offset[k]))
        linear.append(vectors.add(at, sliding(pose, k, u)))
        angular.append(vectors.add(angular[parent], turning(pose, k, u)))
    return Motion(tuple(angular), tuple(linear))


def accelerations(pose: Pose, u: Sequence[Number], motion: Motion, du: Sequence[Number], base: Vector = ZERO) -> Motion:
    """Accelerations of all steps for the rates `u`, their velocities `motion` and the rates' derivatives `du`.

    `base` is the acceleration given to the world: minus gravity makes weights appear as inertia forces.
    """
    angular, linear = [ZERO], [base]
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        parent, offset = step.parent, pose.offset[k]
        spin = motion.angular[parent]
        slide = sliding(pose, k, u)
        at = vectors.add(linear[parent], vectors.cross(angular[parent], offset))
        at = vectors.add(at, vectors.cross(spin, vectors.add(vectors.cross(spin, offset), slide)))
        # the direction of a slide turns with its carrier; shifts are rates in world axes and turn with nothing
        if step.kind in (Kind.SLIDE, Kind.FLAT):
            at = vectors.add(at, vectors.cross(spin, slide))
        linear.append(vectors.add(at, sliding(pose, k, du)))
        turn = vectors.add(angular[parent], turning(pose, k, du))
        if step.kind in (Kind.TURN, Kind.SPIN):
            turn = vectors.add(turn, vectors.cross(spin, turning(pose, k, u)))
        angular.append(turn)
    return Motion(tuple(angular), tuple(linear))


def inertia_times(pose: Pose, body: Body, w: Vector) -> Vector:
    """Inertia of a body, about the step's origin, times `w`."""
    total = ZERO if is_zero(body.base) else vectors.scale(body.base, w)
    for weight, axis in body.axes:
        e = pose.lever(body.step, axis)
        total = vectors.add(total, vectors.scale(weight * vectors.dot(e, w), e))
    return total


def generalised_forces(pose: Pose, motion: Motion, acceleration: Motion) -> list[Number]:
    """Forces along the rates that the accelerations need (recursive Newton-Euler), length nv."""
    tree = pose.tree
    force = [ZERO] * len(tree.steps)
    moment = [ZERO] * len(tree.steps)
    for body in pose.bodies:
        k = body.step
        w, dw, pull = motion.angular[k], acceleration.angular[k], acceleration.linear[k]
        h = pose.lever(k, body.moment)
        push = vectors.add(vectors.cross(dw, h), vectors.cross(w, vectors.cross(w, h)))
        force[k] = vectors.add(force[k], vectors.add(vectors.scale(body.mass, pull), push))
        spin = vectors.add(inertia_times(pose, body, dw), _gyroscopic(pose, body, w))
        moment[k] = vectors.add(moment[k], vectors.add(spin, vectors.cross(h, pull)))
    for point in pose.points:
        k = point.step
        w, arm = motion.angular[k], pose.lever(k, point.lever)
        pull = vectors.add(acceleration.at(k, arm), vectors.cross(w, vectors.cross(w, arm)))
        pull = vectors.scale(point.mass, pull)
        force[k] = vectors.add(force[k], pull)
        moment[k] = vectors.add(moment[k], vectors.cross(arm, pull))
    result: list[Number] = [0.0] * tree.nv
    for k in range(len(tree.steps) - 1, 0, -1):
        step = tree.steps[k]
        match step.kind:
            case Kind.TURN | Kind.SPIN:
                result[step.u] = vectors.dot(pose.axis[k], moment[k])
            case Kind.SLIDE:
                result[step.u] = vectors.dot(pose.axis[k], force[k])
            case Kind.SHIFT:
                result[step.u : step.u + 3] = force[k]
            case Kind.FLAT:
                for i in range(2):
                    result[step.u + i] = vectors.dot(vectors.column(pose.placed[k], i), force[k])
            case Kind.BALL:
                result[step.u : step.u + 3] = moment[k]
        parent = step.parent
        force[parent] = vectors.add(force[parent], force[k])
        moment[parent] = vectors.add(moment[parent], vectors.add(moment[k], vectors.cross(pose.offset[k], force[k])))
    return result


def _gyroscopic(pose: Pose, body: Body, w: Vector) -> Vector:
    """w x (inertia w); the part of the inertia that is the same about all axes gives nothing."""
    total = ZERO
    for weight, axis in body.axes:
        e = pose.lever(body.step, axis)
        total = vectors.add(total, vectors.scale(weight * vectors.dot(e, w), vectors.cross(w, e)))
    return total


def mass_matrix(pose: Pose, columns: Sequence[Motion]) -> list[list[Number]]:
    """Kinetic energy of every pair of velocity columns, symmetric: the sum over bodies of
    m vi.vj + vi.(wj x h) + vj.(wi x h) + wi.(inertia wj)."""
    n = len(columns)
    result: list[list[Number]] = [[0.0] * n for _ in range(n)]
    for body in pose.bodies:
        k = body.step
        h = pose.lever(k, body.moment)
        speed = [column.linear[k] for column in columns]
        swing = [column.angular[k] for column in columns]
        push = [vectors.cross(w, h) for w in swing]
        momentum = [vectors.add(vectors.scale(body.mass, v), p) for v, p in zip(speed, push, strict=True)]
        shares = [[vectors.dot(pose.lever(k, axis), w) for w in swing] for _, axis in body.axes]
        for i in range(n):
            for j in range(i, n):
                energy = vectors.dot(speed[i], momentum[j]) + vectors.dot(push[i], speed[j])
                if not is_zero(body.base):
                    energy = energy + body.base * vectors.dot(swing[i], swing[j])
                for (weight, _), share in zip(body.axes, shares, strict=True):
                    energy = energy + weight * share[i] * share[j]
                if not is_zero(energy):
                    result[i][j] = result[i][j] + energy
    for point in pose.points:
        arm = pose.lever(point.step, point.lever)
        speed = [column.at(point.step, arm) for column in columns]
        for i in range(n):
            for j in range(i, n):
                result[i][j] = result[i][j] + point.mass * vectors.dot(speed[i], speed[j])
    for i in range(n):
        for j in range(i):
            result[i][j] = result[j][i]
    return result


def potential_energy(pose: Pose, origin: Vector = ZERO) -> Number:
    """Potential energy of gravity [J], zero at the world's origin; the tree stands at `origin` in the world."""
    total: Number = -vectors.dot(pose.tree.gravity, pose.tree.anchored)
    for body in pose.bodies:
        first = vectors.add(vectors.scale(body.mass, pose.origin(body.step)), pose.lever(body.step, body.moment))
        total = total - vectors.dot(pose.tree.gravity, first)
    for point in pose.points:
        place = vectors.add(pose.origin(point.step), pose.lever(point.step, point.lever))
        total = total - point.mass * vectors.dot(pose.tree.gravity, place)
    if any(origin):
        total = total - vectors.dot(pose.tree.gravity, origin) * pose.mass
    return total


def to_rates(pose: Pose, v: Sequence[Number]) -> list[Number]:
    """Pinocchio's velocities (or, dually, forces) as rates `u`."""
    u = list(v)
    for k, first in _turned(pose):
        u[first : first + 3] = vectors.turn(pose.rotation[k], (v[first], v[first + 1], v[first + 2]))
    for k, first in _flat(pose):
        cosine, sine = pose.q[pose.tree.steps[k].q : pose.tree.steps[k].q + 2]
        x, y = v[first], v[first + 1]
        u[first : first + 2] = (cosine * x - sine * y, sine * x + cosine * y)
    return u


def from_rates(pose: Pose, u: Sequence[Number]) -> list[Number]:
    """Rates `u` as Pinocchio's velocities."""
    v = list(u)
    for k, first in _turned(pose):
        back = vectors.transposed(pose.rotation[k])
        v[first : first + 3] = vectors.turn(back, (u[first], u[first + 1], u[first + 2]))
    for k, first in _flat(pose):
        cosine, sine = pose.q[pose.tree.steps[k].q : pose.tree.steps[k].q + 2]
        x, y = u[first], u[first + 1]
        v[first : first + 2] = (cosine * x + sine * y, cosine * y - sine * x)
    return v


def from_rate_derivatives(pose: Pose, u: Sequence[Number], motion: Motion, du: Sequence[Number]) -> list[Number]:
    """Derivatives of the rates as Pinocchio's accelerations (time derivative of its velocities)."""
    turned = turning_axes(pose, u, motion)
    return from_rates(pose, [x if is_zero(y) else x + y for x, y in zip(du, turned, strict=True)])


def turning_axes(pose: Pose, u: Sequence[Number], motion: Motion) -> list[Number]:
    """What Pinocchio's accelerations are beside the derivatives of the rates, because its axes turn, length nv."""
    changed: list[Number] = [0.0] * pose.tree.nv
    for k, first in _turned(pose):
        rate: Vector = (u[first], u[first + 1], u[first + 2])
        changed[first : first + 3] = vectors.cross(rate, motion.angular[k])
    for k, first in _flat(pose):
        w = u[pose.tree.steps[k].u]
        changed[first] = w * u[first + 1]
        changed[first + 1] = -(w * u[first])
    return changed


def _turned(pose: Pose) -> list[tuple[int, int]]:
    """(step whose rotation counts, first rate) of every triple that Pinocchio has in body axes."""
    found = []
    for k, step in enumerate(pose.tree.steps):
        if step.kind is Kind.BALL:
            found.append((k, step.u))
        elif step.kind is Kind.SHIFT:
            found.append((k + 1, step.u))
    return found


def _flat(pose: Pose) -> list[tuple[int, int]]:
    """(spin step, first rate) of every planar joint."""
    return [(k + 1, step.u) for k, step in enumerate(pose.tree.steps) if step.kind is Kind.FLAT]


def configuration_rate(pose: Pose, u: Sequence[Number]) -> list[Number]:
    """Time derivative of the configuration (quaternions and cosines included), length nq."""
    q = pose.q
    rate: list[Number] = [0.0] * pose.tree.nq
    for k, step in enumerate(pose.tree.steps[1:], start=1):
        i = step.q
        match step.kind:
            case Kind.TURN | Kind.SLIDE:
                rate[i] = u[step.u]
            case Kind.SPIN:
                rate[i], rate[i + 1] = -u[step.u] * q[i + 1], u[step.u] * q[i]
            case Kind.FLAT:
                rate[i : i + 2] = u[step.u : step.u + 2]
            case Kind.SHIFT | Kind.BALL:
                back = vectors.transposed(pose.placed[k])
                local = vectors.turn(back, (u[step.u], u[step.u + 1], u[step.u + 2]))
                if step.kind is Kind.SHIFT:
                    rate[i : i + 3] = local
                else:
                    half = vectors.scale(0.5, local)
                    vector: Vector = (q[i], q[i + 1], q[i + 2])
                    rate[i : i + 3] = vectors.add(vectors.scale(q[i + 3], half), vectors.cross(half, vector))
                    rate[i + 3] = -vectors.dot(half, vector)
    return rate


def moved(pose: Pose, u: Sequence[Number]) -> list[Number]:
    """The configuration after a small step `u`: exact for angles and lengths, to first order for the others, whose
    quaternions and cosines are brought back to unit length."""
    q: list[Number] = [x + dx for x, dx in zip(pose.q, configuration_rate(pose, u), strict=True)]
    for step in pose.tree.steps:
        if step.kind in (Kind.BALL, Kind.SPIN):
            span = slice(step.q, step.q + (4 if step.kind is Kind.BALL else 2))
            factor = 1.0 / Functions.sqrt(vectors.dot(q[span], q[span]))
            q[span] = [factor * x for x in q[span]]
    return q
