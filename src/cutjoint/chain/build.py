"""The open tree of a description as a Pinocchio model, and how large it is, and where.

Joints are added depth first, because Pinocchio's `crba` and `constraintDynamics` assume it.  Links that a fixed joint
carries are merged into the moving body; every link keeps its frame.  A continuous joint is a plain angle (one number,
not a cosine and a sine), so that actuated coordinates are what a user types.

Singular values of a matrix that mixes lengths and angles mean nothing until it is scaled.  Lengths are divided by the
robot's characteristic length: the mean distance between neighbouring joint frames and cut frames that are apart.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.joints import JOINTS, coordinates_to_q, flies, joint_model
from cutjoint.description.model import CutJoint, Frame, Home, Inertial, Joint, Link, RobotDescription
from cutjoint.errors import CutjointError, UnknownNameError

UNBOUNDED = 1e30
MOST_JOINTS = 500
"""All is dense: with 500 joints the workspaces of Pinocchio take ten seconds to make, with 3000 a gigabyte each."""

FAR = 10.0
"""Distance of a fixed base from the world origin, in characteristic lengths, beyond which it is taken out."""


def build_model(description: RobotDescription, origin: Array | None = None) -> pin.Model:
    """The Pinocchio model of the open tree of `description`.

    Args:
        origin: point of the world that the model's origin stands for, shape (3,) [m]; default that of the world.

    Raises:
        CutjointError: the robot is too large, or Pinocchio's own consistency check refuses the model.
    """
    moving = sum(joint.type.moves for joint in description.joints)
    if moving > MOST_JOINTS:
        raise CutjointError(
            f"{description.name} has {moving} moving joints; cutjoint works with dense matrices, up to {MOST_JOINTS} "
            "joints: fix those that do not matter"
        )
    model = pin.Model()
    model.name = description.name
    model.gravity = pin.Motion(np.array(description.gravity), np.zeros(3))
    inertials = {link.name: link.inertial for link in description.links}
    children: dict[str, list[Joint]] = defaultdict(list)
    for joint in description.joints:
        children[joint.parent].append(joint)

    base = pin.SE3.Identity() if origin is None else pin.SE3(np.eye(3), -origin)
    _add_body(model, description.root, inertials[description.root], 0, base)
    stack = [(joint, 0, base) for joint in reversed(children[description.root])]
    while stack:
        joint, parent, parent_link = stack.pop()
        here = parent_link * pin.SE3(np.array(joint.placement))
        body, link = _add_joint(model, joint, parent, here) if joint.type.moves else (parent, here)
        _add_body(model, joint.child, inertials[joint.child], body, link)
        stack.extend((child, body, link) for child in reversed(children[joint.child]))

    if not model.check(model.createData()):
        raise CutjointError(f"Pinocchio refuses the model of {description.name}: joints not in depth-first order")
    return model


def _add_joint(model: pin.Model, joint: Joint, parent: int, here: pin.SE3) -> tuple[int, pin.SE3]:
    """Add a moving joint; returns its index and the child link's placement in it."""
    link = pin.SE3.Identity()
    kind = joint.type
    if JOINTS[kind].about_z:
        turn = pin.SE3(pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(joint.axis)), np.zeros(3))
        here, link = here * turn, turn.inverse()
    index = model.addJoint(parent, joint_model(joint), here, joint.name)
    rates = slice(model.idx_vs[index], model.idx_vs[index] + model.nvs[index])
    model.armature[rates] = joint.physics.armature
    model.addJointFrame(index)
    if kind.single:
        lower, upper = joint.limits.lower, joint.limits.upper
        model.lowerPositionLimit[model.idx_qs[index]] = lower if kind.limited and lower is not None else -UNBOUNDED
        model.upperPositionLimit[model.idx_qs[index]] = upper if kind.limited and upper is not None else UNBOUNDED
    return index, link


def _add_body(model: pin.Model, name: str, inertial: Inertial | None, joint: int, placement: pin.SE3) -> None:
    if inertial is not None and inertial.mass > 0.0:
        # its constructor refuses moments that are below zero by rounding, which the checks of a description let pass
        inertia = pin.Inertia(inertial.mass, np.array(inertial.com), np.zeros((3, 3)))
        inertia.inertia = np.array(inertial.inertia)
        model.appendBodyToJoint(joint, inertia, placement)
    model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.BODY))


def held_up_model(model: pin.Model, links: Iterable[Link]) -> pin.Model | None:
    """The same tree with nothing but the masses of `links` whose weight is compensated, as points; None without any."""
    links = [link for link in links if link.held_up]
    if not links:
        return None
    held = pin.Model(model)
    for joint in range(held.njoints):
        held.inertias[joint] = pin.Inertia.Zero()
    for link in links:
        assert link.inertial is not None, "see `held_up`"
        frame = model.frames[model.getFrameId(link.name, pin.FrameType.BODY)]
        point = pin.Inertia(link.held_up, np.array(link.inertial.com), np.zeros((3, 3)))
        held.inertias[frame.parentJoint] += frame.placement.act(point)
    return held


def rough_home(model: pin.Model, description: RobotDescription, name: str | None) -> tuple[Array, bool]:
    """The configuration (nq,) that a home posture describes, loops still open, and whether it prescribes the actuators.

    Args:
        name: of the home posture; default the first one, or the zero configuration where there is none.

    Raises:
        UnknownNameError: there is no such home posture.
    """
    homes = {home.name: home for home in description.homes}
    if name is not None and name not in homes:
        raise UnknownNameError("home posture", name, list(homes))
    home = homes[name] if name is not None else next(iter(homes.values()), Home("zero"))
    q = np.array(pin.neutral(model))
    joints = {joint.name: joint for joint in description.joints}
    for joint, value in {**home.passive, **home.actuated}.items():
        index = model.getJointId(joint)
        start = model.idx_qs[index]
        q[start : start + model.nqs[index]] = coordinates_to_q(joints[joint], value)
    return q, bool(home.actuated)


def bind_frame(model: pin.Model, frame: Frame) -> tuple[int, pin.SE3]:
    """Joint index and placement in that joint of a frame on a link."""
    link = model.frames[model.getFrameId(frame.link, pin.FrameType.BODY)]
    return link.parentJoint, link.placement * pin.SE3(np.array(frame.placement))


def cut_sides(model: pin.Model, cuts: Iterable[CutJoint]) -> list[tuple[int, pin.SE3]]:
    """Joint and placement in it of both frames of every cut, a and b in turn."""
    return [bind_frame(model, frame) for cut in cuts for frame in (cut.a, cut.b)]


def characteristic_length(model: pin.Model, description: RobotDescription) -> tuple[float, float]:
    """Mean distance [m] between neighbouring joint and cut frames that are apart, and the longest way along them from
    the base to a frame.

    Frames that the base carries count from their middle; what flies is where it is, so the place of its joint does not
    count.  A robot whose frames all coincide is measured by its tool or its centres of mass; 1 where those are there
    too.
    """
    middle, _ = base_of(model, description)
    way = np.zeros(model.njoints)
    distances: list[float] = []

    def step(parent: int, place: Array) -> float:
        distances.append(float(np.linalg.norm(place - middle if parent == 0 else place)))
        return float(way[parent]) + distances[-1]

    for joint in range(1, model.njoints):
        if not flies(model, joint):
            way[joint] = step(model.parents[joint], model.jointPlacements[joint].translation)
    sides = cut_sides(model, description.cuts)
    ends = [step(joint, place.translation) for joint, place in sides[::2] + sides[1::2]]
    if not max(distances, default=0.0) > 0.0:
        if description.tool is not None:
            joint, place = bind_frame(model, description.tool)
            distances.append(float(np.linalg.norm(place.translation)) if joint else 0.0)
        distances += [float(np.linalg.norm(inertia.lever)) for inertia in list(model.inertias)[1:] if inertia.mass > 0]
    longest = max(distances, default=0.0)
    apart = [distance for distance in distances if distance > 1e-9 * longest]
    length = float(np.mean(apart)) if apart else 1.0
    return length, max(float(way.max(initial=0.0)), max(ends, default=0.0), length)


def base_of(model: pin.Model, description: RobotDescription) -> tuple[Array, bool]:
    """Middle of all frames that the base carries, shape (3,) [m], and whether that is far from the world origin."""
    first = [j for j in range(1, model.njoints) if model.parents[j] == 0]
    carried = [np.array(model.jointPlacements[joint].translation) for joint in first if not flies(model, joint)]
    sides = cut_sides(model, description.cuts)
    carried += [np.array(place.translation) for joint, place in sides if joint == 0]
    if not carried:
        return np.zeros(3), False
    middle = np.mean(carried, axis=0)
    spread = max(float(np.linalg.norm(place - middle)) for place in carried)
    others = [np.linalg.norm(model.jointPlacements[j].translation) for j in range(1, model.njoints) if j not in first]
    size = max([spread, *map(float, others)])
    for inertia in list(model.inertias)[1:]:
        size = max(size, float(np.linalg.norm(inertia.lever)))
    return middle, float(np.linalg.norm(middle)) > FAR * size
