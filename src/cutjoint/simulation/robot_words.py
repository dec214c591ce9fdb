"""What a result says of its robot: which actuators and joints it has, its file, and how to tell it from another."""

from __future__ import annotations

from pathlib import Path

from cutjoint.chain import ClosedChain
from cutjoint.chain.massless import undetermined_motions
from cutjoint.description.catalogue import folder, is_example
from cutjoint.description.fingerprint import fingerprint
from cutjoint.errors import DynamicsError
from cutjoint.mechanism import Mechanism
from cutjoint.simulation.coordinates import joints_of
from cutjoint.simulation.plant import State
from cutjoint.simulation.result import About


def chain_of(mechanism: Mechanism) -> ClosedChain | None:
    """The chain that a robot is, or that it was compiled from; None of a published model."""
    robot = getattr(mechanism, "plain", mechanism)
    return robot if isinstance(robot, ClosedChain) else None


def robot_words(mechanism: Mechanism) -> About:
    """What a result says of its robot besides its name."""
    said: About = {"actuators": [[one.name, one.kind] for one in mechanism.actuators]}
    joints = joints_of(mechanism)
    if joints is not None:
        said["joints"] = joints
    chain = chain_of(mechanism)
    if chain is not None:
        said["fingerprint"] = fingerprint(chain.description)
        path = chain.description.path
        if path is not None and not _is_known_by_name(path):
            said["file"] = str(path.absolute())
    return said


def check_moves(mechanism: Mechanism, start: State) -> None:
    """That a motion of the robot can be told.

    Raises:
        DynamicsError: something acts on a motion that moves no mass.
    """
    chain = chain_of(mechanism)
    if chain is None:
        return
    q = start.q if start.posture is None else start.posture.q_full
    if joints := undetermined_motions(chain, q):
        raise DynamicsError(
            f"{chain.name} cannot be simulated: a motion of {', '.join(joints)} moves no mass, so nothing tells how it "
            "accelerates under actuators, dampers, friction or springs; give the links that these joints carry moments "
            "of inertia (<inertial>)",
            residual=float("inf"),
        )


def _is_known_by_name(path: Path) -> bool:
    return path.is_relative_to(folder()) or is_example(path)
