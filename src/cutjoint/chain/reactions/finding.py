"""Force and moment in every joint of a description, in every cut and coupling, in one motion.

What a link asks for (`link_needs`) comes through its joint, less what cuts, loads and its own children do to it; so
joints follow from the leaves inwards, one sum a joint, and so do those of each internal stress of the loops
(`internal`):

    reactions = R0 + R1 z,   z any

No equation of motion tells z (`choosing`).  Chosen is what all joints and cuts hold together, each at its own origin,
so that it does not matter which joint of a loop was cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.joints import rates_of
from cutjoint.chain.kinematics import Kinematics, Moving
from cutjoint.chain.reactions.choosing import HeldWrench, chosen
from cutjoint.chain.reactions.internal import CarriedLoops, LoopForces
from cutjoint.chain.reactions.link_needs import LinkNeeds
from cutjoint.chain.reactions.stiffness import Stiffness, compliances
from cutjoint.chain.reactions.values import GearForce, Reaction, Reactions
from cutjoint.description.model import Joint, RobotDescription
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism.loads import Loads, as_loads
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class _Carried:
    """What passes a joint or cut, in 1 + k columns: what it is without stresses, then what each stress adds.

    Attributes:
        wrench: about `point`, world axes, shape (6, 1 + k).
        held: the part of it against the motion that the joint forbids, shape (6, 1 + k).
        point: in the model, shape (3,).
        axes: of the child's frame, or of frame b, shape (3, 3).
    """

    wrench: Array
    held: Array
    point: Array
    axes: Array


class ReactionFinder:
    """Reactions of one robot, of which `kinematics` are."""

    __repr__ = line()

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = k = kinematics
        self._links, self._loops = LinkNeeds(k), LoopForces(k)
        self._link = {name: index for index, name in enumerate(self._links.names)}
        self._inwards = _inwards(k.description)
        closing = {cut.name: index for index, cut in enumerate(k.description.closing)}
        acting = {cut.name: index for index, cut in enumerate(k.physics.cuts)}
        self._cuts = [(cut, closing.get(cut.name), acting.get(cut.name)) for cut in k.description.cuts]

    def find(self, placed: Moving, a: Array, effort: Array, loads: Loads, stiffness: Stiffness) -> Reactions:
        """Of a motion of all joints: acceleration and effort, shape (nv,).

        Raises:
            DynamicsError: the effort does not make this motion.
            InputError: the motion opens the loops; stiffnesses or loads that are none.
            UnknownNameError: the robot does not have what they name.
        """
        k = self._k
        self._check_motion(placed, a)
        soft = compliances(stiffness, k.description, k.length)
        placements = self._links.placements(placed.q)
        outside = self._outside(placements, loads)
        loops = self._loops.carrying(placed, *self._pull(placed, a, effort, outside))
        joints, cuts = self._carried(placed, a, placements, outside, loops)
        choice = _Choice(*chosen(self._held(joints, cuts, loops), soft, loops.loose), loops.loose)
        parts = zip(k.description.joints, joints, strict=True), zip(k.description.cuts, cuts, strict=True)
        of_joints, of_cuts = ({part.name: self._reaction(part.name, one, choice) for part, one in own} for own in parts)
        gears, undecided = self._gear_forces(loops, choice), choice.left.shape[1]
        return Reactions(of_joints, of_cuts, gears, loops.stresses, undecided, effort)

    def _check_motion(self, placed: Moving, a: Array) -> None:
        """Raises InputError where a motion opens the loops."""
        k, rows = self._k, np.abs(placed.scaled)
        speed, change, drift = placed.v / k.column_scale, a / k.column_scale, k.row_scale * placed.drift
        turned, falls = np.abs(speed).max(initial=0.0) ** 2, np.linalg.norm(k.model.gravity.linear) / k.length
        opening = rows @ np.abs(change) + np.abs(drift) + turned
        for what, found, terms, usual in (
            ("velocity", placed.scaled @ speed, rows @ np.abs(speed), np.sqrt(falls)),
            ("acceleration", placed.scaled @ change + drift, opening, falls),
        ):
            left, most = (float(np.abs(one).max(initial=0.0)) for one in (found, terms))
            if left > tolerances.REACHED.value * most + tolerances.ROUNDED.value * (1.0 + usual):
                raise InputError(
                    f"this {what} of all joints opens the loops of {k.name}, by {left:.3g} (dimensionless); take one "
                    "from full_velocity, full_motion or full_forward_dynamics"
                )

    # ---- what is carried, for any stress ---------------------------------------------------------------------------

    def _outside(self, placements: Array, loads: Loads) -> Array:
        """Loads as wrenches on the links about the model's origin, shape (links, 6)."""
        tool = self._k.description.tool
        found = np.zeros((len(placements), 6))
        for load in as_loads(loads):
            if load.link is None:
                self._k.need_tool()
                assert tool is not None
                index = self._link[tool.link]
                frame = placements[index] @ tool.placement
            elif load.link in self._link:
                index = self._link[load.link]
                frame = placements[index]
            else:
                raise UnknownNameError(f"link of {self._k.name}", str(load.link), list(self._link))
            force, moment, at = load.wrench(frame[:3, :3], frame[:3, 3])
            found[index] += np.concatenate([force, moment + np.cross(at, force)])
        return found

    def _pull(self, placed: Moving, a: Array, effort: Array, outside: Array) -> tuple[Array, Array]:
        """Generalised forces that are left to the loops, and the size of the terms that make them, shape (nv,)."""
        k, q = self._k, placed.q
        terms = [k.tree.mass_matrix(q) @ a, k.tree.bias(q, placed.v), -effort]
        if k.physics.acts:
            terms += [placed.springs, placed.friction(placed.v)]
        for joint, wrench in zip(self._links.joint, outside, strict=True):
            if wrench.any():
                terms.append(-self._links.support[joint] * (placed.twists.T @ wrench))
        return sum(terms, np.zeros(k.model.nv)), sum(map(np.abs, terms), np.zeros(k.model.nv))

    def _carried(
        self, placed: Moving, a: Array, placements: Array, outside: Array, loops: CarriedLoops
    ) -> tuple[list[_Carried], list[_Carried]]:
        """What passes every joint, and every cut."""
        needs = np.zeros((len(placements), 6, 1 + loops.stresses))
        needs[:, :, 0] = self._links.needs(placed, a, placements) - outside
        elastic = placed.elastic
        own = [] if elastic is None else self._k.physics.wrenches(placed.q, placed.v, elastic)
        cuts = []
        for cut, rigid, acting in self._cuts:
            on_a, on_b, held = np.zeros((3, 6, 1 + loops.stresses))
            if rigid is not None:
                on_a, on_b, held = loops.on_a[rigid].copy(), loops.on_b[rigid].copy(), loops.on_b[rigid]
            if acting is not None:
                on_a[:, 0] += own[acting][0]
                on_b[:, 0] += own[acting][1]
            needs[self._link[cut.a.link]] -= on_a
            needs[self._link[cut.b.link]] -= on_b
            frame = placements[self._link[cut.b.link]] @ cut.b.placement
            cuts.append(_Carried(_about(on_b, frame), _about(held, frame), frame[:3, 3], frame[:3, :3]))
        joints = {}
        for joint in self._inwards:
            child = self._link[joint.child]
            free = placed.twists[:, rates_of(self._k.model, joint)]
            joints[joint.name] = _passing(needs[child], free, placements[child])
            needs[self._link[joint.parent]] += needs[child]
        return [joints[joint.name] for joint in self._k.description.joints], cuts

    # ---- which stress ----------------------------------------------------------------------------------------------

    def _held(self, joints: Sequence[_Carried], cuts: Sequence[_Carried], loops: CarriedLoops) -> list[HeldWrench]:
        """What all joints, cuts and couplings hold against each other, each along its own axes."""
        description, length = self._k.description, self._k.length
        names = [*(one.name for one in description.joints), *(one.name for one in description.cuts)]
        weights = np.array([length] * 3 + [1.0] * 3)
        found = []
        for name, one in zip(names, (*joints, *cuts), strict=True):
            own = np.concatenate([one.axes.T @ one.held[:3], one.axes.T @ one.held[3:]])
            found.append(HeldWrench(name, own, weights))
        for gear, force in zip(self._k.closure.couplings, loops.couplings, strict=True):
            found.append(HeldWrench(gear.name, force[None, :], np.array([length if gear.is_length else 1.0])))
        return found

    def _reaction(self, name: str, one: _Carried, chosen: _Choice) -> Reaction:
        k = self._k
        wrench, weights = one.wrench @ chosen.part, np.array([k.length] * 3 + [1.0] * 3)
        stresses, point = chosen.felt(weights[:, None] * one.wrench), one.point + k.origin
        return Reaction(name, wrench[:3], wrench[3:], point, np.eye(3), one.axes, stresses, k.length)

    def _gear_forces(self, loops: CarriedLoops, chosen: _Choice) -> dict[str, GearForce]:
        found = {}
        for gear, force in zip(self._k.closure.couplings, loops.couplings, strict=True):
            stress = chosen.felt(force[None, :] * (self._k.length if gear.is_length else 1.0))
            unique = float(np.abs(stress).max(initial=0.0)) < tolerances.STRESSED.value
            found[gear.name] = GearForce(float(force @ chosen.part), unique)
        return found


@dataclass(frozen=True, eq=False)
class _Choice:
    """Part of each column, shape (1 + k,), what is undecided, shape (1 + k, u), and how many of these are loose."""

    part: Array
    left: Array
    loose: int

    def felt(self, columns: Array) -> Array:
        """What undecided stresses do to something dimensionless of 1 + k columns, shape (c, u); loose ones only where
        that is more than rounding."""
        felt = columns @ self.left
        rough = felt[:, felt.shape[1] - self.loose :]
        rough[np.abs(rough) < tolerances.ROUNDED_GAP.value] = 0.0
        return np.asarray(felt)


def _passing(about_origin: Array, free: Array, frame: Array) -> _Carried:
    """What passes a joint, from its columns about the model's origin, the twists (6, dof) that it leaves free there,
    and the child's frame.  These twists are orthonormal at the child's origin."""
    wrench, point = _about(about_origin, frame), frame[:3, 3]
    own = np.concatenate([free[:3] - _crossing(point) @ free[3:], free[3:]])
    return _Carried(wrench, wrench - own @ (own.T @ wrench), point, frame[:3, :3])


def _about(wrenches: Array, frame: Array) -> Array:
    """Wrenches about the model's origin as about that of a frame, shape (6, c)."""
    return np.concatenate([wrenches[:3], wrenches[3:] - _crossing(frame[:3, 3]) @ wrenches[:3]])


def _crossing(vector: Array) -> Array:
    """The matrix (3, 3) whose product with x is the vector cross x."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _inwards(description: RobotDescription) -> tuple[Joint, ...]:
    """All joints, those of children before that of their parent."""
    below: dict[str, list[Joint]] = {joint.parent: [] for joint in description.joints}
    for joint in description.joints:
        below[joint.parent].append(joint)
    found, waiting = [], list(below.get(description.root, ()))
    while waiting:
        joint = waiting.pop()
        found.append(joint)
        waiting += below.get(joint.child, ())
    return tuple(reversed(found))
