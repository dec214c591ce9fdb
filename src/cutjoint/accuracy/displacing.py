"""What a small change of one number does to the loops and to the tool while no joint moves.

A number of a placement moves all frames behind it as one body: along or about an axis of the link that it is given in.
So its columns are a twist on some of the frames of the cuts, and on the tool: with G of `cutjoint.chain.closure`, which
holds the rows of the loops over the twists of these frames, the loops open by G (twist on those frames).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.kinematics import Kinematics
from cutjoint.description.model import Frame, RobotDescription
from cutjoint.description.paths import PLACE, Path
from cutjoint.description.transforms import rotation_from_rpy, rpy_from_rotation
from cutjoint.description.values import number, placement_at, with_values
from cutjoint.mechanism import Posture


class Displacements:
    """Columns of the numbers of one robot in one posture.

    Attributes:
        kinematics: of the robot, with all rows.
        placed: it in the posture.
        rows: how many rows its loops have.

    Raises:
        InputError: the robot has no tool, or it is no posture of it.
    """

    def __init__(self, chain: ClosedChain, at: Posture | None) -> None:
        robot = chain.description
        self.robot, self.kinematics = robot, Kinematics(robot)
        self.kinematics.need_tool()
        where = chain.home if at is None else chain.posture(at)
        self.placed = self.kinematics.at(where.q_full)
        self.rows = self.kinematics.closure.rows
        self._links = {name: np.array(place) for name, place in chain.link_placements(where).items()}
        for place in self._links.values():
            place[:3, 3] -= self.kinematics.origin
        self._below = _below(robot)
        self._cuts = {cut.name: index for index, cut in enumerate(robot.closing)}

    def of(self, path: Path) -> tuple[Array, Array]:
        """By how much the loops open, shape (rows,), and how the tool moves, shape (6,), per unit of a number."""
        if path.part == "actuators":
            index = int(self.kinematics.model.idx_vs[self.kinematics.model.getJointId(path.name)])
            return self.placed.jacobian[:, index], self.placed.tool_jacobian[:, index]
        if path.part == "couplings" or path.field == "length":
            return self._by_difference(path), np.zeros(6)
        if path.part == "joints":
            joint = self.robot.joint(path.name)
            return self._moved(self._twist(path, joint.parent), self._behind(joint.child))
        if path.part == "tool":
            assert self.robot.tool is not None
            return self._moved(self._twist(path, self.robot.tool.link), lambda index, side: side == "tool")
        cut, side = self._cuts[path.name], path.field[0]
        frame = getattr(self.robot.closing[cut], side)
        return self._moved(self._twist(path, frame.link), lambda index, of: index == cut and of == side)

    def gives(self) -> list[tuple[str, Array, Array]]:
        """Of every joint and cut its name and the columns of a small play along and about the axes of its child or
        frame b, shapes (rows, 6) and (6, 6)."""
        found = []
        for joint in self.robot.joints:
            moved = self._behind(joint.child)
            pairs = [self._moved(twist, moved) for twist in _axes(self._links[joint.child])]
            opened, tool = np.array([one for one, _ in pairs]).T, np.array([one for _, one in pairs]).T
            if joint.name in self.robot.actuators:  # what it drives is held
                kept = np.eye(6)
                few = slice(0, 3) if joint.type.slides else slice(3, 6)
                kept[few, few] -= np.outer(joint.axis, joint.axis)
                opened, tool = opened @ kept, tool @ kept
            found.append((joint.name, opened, tool))
        for index, cut in enumerate(self.robot.closing):
            place = self._links[cut.b.link] @ cut.b.placement
            pairs = [self._moved(twist, _just(index)) for twist in _axes(place)]
            found.append((cut.name, np.array([one for one, _ in pairs]).T, np.array([one for _, one in pairs]).T))
        return found

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _twist(self, path: Path, link: str) -> Array:
        """Twist about the model's origin of what is behind a placement in a link, per unit of one of its numbers."""
        axes, origin = self._links[link][:3, :3], self._links[link][:3, 3]
        which = PLACE.index(path.last)
        if which < 3:
            return np.concatenate([axes[:, which], np.zeros(3)])
        placement = placement_at(self.robot, path)
        _, pitch, yaw = rpy_from_rotation(placement[:3, :3])
        about = {
            "roll": rotation_from_rpy((0.0, pitch, yaw))[:, 0],
            "pitch": rotation_from_rpy((0.0, 0.0, yaw))[:, 1],
            "yaw": np.eye(3)[2],
        }[path.last]
        turning = axes @ about
        return np.concatenate([np.cross(origin + axes @ placement[:3, 3], turning), turning])

    def _behind(self, link: str) -> Callable[[int, str], bool]:
        """Whether a frame goes with a link."""
        links = self._below[link]

        def moves(index: int, side: str) -> bool:
            frame: Frame | None = self.robot.tool if side == "tool" else getattr(self.robot.closing[index], side)
            return frame is not None and frame.link in links

        return moves

    def _moved(self, twist: Array, moves: Callable[[int, str], bool]) -> tuple[Array, Array]:
        closure, count = self.kinematics.closure, len(self._cuts)
        twists = np.zeros((2, count, 6))
        for index in range(count):
            for row, side in enumerate("ab"):
                if moves(index, side):
                    twists[row, index] = twist
        opened = np.zeros(closure.all_rows)
        gather = self.placed.gather
        opened[: len(gather)] = gather @ twists.ravel()
        tool = np.zeros(6)
        if moves(-1, "tool"):
            tool = np.concatenate([twist[:3] + np.cross(twist[3:], self.placed.tool_position), twist[3:]])
        return closure.kept(opened), tool

    def _by_difference(self, path: Path) -> Array:
        """Of numbers in which the loops are linear."""
        now = number(self.robot, path)
        step = 0.25 * (abs(now) or 1.0)
        sides = [
            Kinematics(with_values(self.robot, {str(path): now + sign * step})).at(self.placed.q).residual
            for sign in (1.0, -1.0)
        ]
        return np.asarray((sides[0] - sides[1]) / (2.0 * step))


def _just(cut: int) -> Callable[[int, str], bool]:
    return lambda index, side: index == cut and side == "b"


def _axes(place: Array) -> list[Array]:
    """Twists about the model's origin along and about the axes of a frame (4, 4)."""
    slides = [np.concatenate([axis, np.zeros(3)]) for axis in place[:3, :3].T]
    return slides + [np.concatenate([np.cross(place[:3, 3], axis), axis]) for axis in place[:3, :3].T]


def _below(robot: RobotDescription) -> dict[str, set[str]]:
    """Link -> itself and all links that it carries."""
    children: dict[str, list[str]] = {link.name: [] for link in robot.links}
    for joint in robot.joints:
        children[joint.parent].append(joint.child)
    found: dict[str, set[str]] = {}
    for link in children:
        found[link], waiting = {link}, [link]
        while waiting:
            more = children[waiting.pop()]
            found[link].update(more)
            waiting += more
    return found
