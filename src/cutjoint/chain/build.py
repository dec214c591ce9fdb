"""The open tree of a description as a Pinocchio model.

Joints are added depth first, because Pinocchio's `crba` and `constraintDynamics` assume it.  Links that a fixed joint
carries are merged into the moving body; every link keeps its frame.  A continuous joint is a plain angle (one number,
not a cosine and a sine), so that actuated coordinates are what a user types.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.joints import JOINTS, coordinates_to_q, joint_model
from cutjoint.description.model import Frame, Home, Inertial, Joint, RobotDescription
from cutjoint.errors import CutjointError, UnknownNameError

UNBOUNDED = 1e30
MOST_JOINTS = 500
"""All is dense: with 500 joints the workspaces of Pinocchio take ten seconds to make, with 3000 a gigabyte each."""


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
        if not joint.type.moves:
            body, link = parent, here
        else:
            body, link = _add_joint(model, joint, parent, here)
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
    model.addJointFrame(index)
    if kind.single:
        lower, upper = joint.limits.lower, joint.limits.upper
        model.lowerPositionLimit[model.idx_qs[index]] = lower if kind.limited and lower is not None else -UNBOUNDED
        model.upperPositionLimit[model.idx_qs[index]] = upper if kind.limited and upper is not None else UNBOUNDED
    return index, link


def _add_body(model: pin.Model, name: str, inertial: Inertial | None, joint: int, placement: pin.SE3) -> None:
    if inertial is not None and inertial.mass > 0.0:
        inertia = pin.Inertia(inertial.mass, np.array(inertial.com), np.array(inertial.inertia))
        model.appendBodyToJoint(joint, inertia, placement)
    model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.BODY))


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
