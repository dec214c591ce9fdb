"""What an MJCF of cutjoint has that the chain has not: bodies that stand for cuts where MuJoCo has no equality, and
next to no mass in them and in the links that have none."""

from __future__ import annotations

import mujoco
import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.formats.mjcf.types import OWN

_NEXT_TO_NOTHING = 2e-15
"""What is left of their mass [kg] and moments [kg m2]: MuJoCo needs some."""


class Carriers:
    """The carriers in a model of MuJoCo, made next to massless.

    Attributes:
        others: the velocities of all that is not a carrier.
    """

    def __init__(self, model: mujoco.MjModel, chain: ClosedChain) -> None:
        self._model, self._chain = model, chain
        self._bodies = {}
        names = {cut.name for cut in chain.description.cuts}
        bare = {link.name for link in chain.description.links if link.inertial is None}
        for number in range(1, model.nbody):
            name = model.body(number).name
            own = name.startswith(OWN) and name.removeprefix(OWN) in names
            if own:
                self._bodies[name.removeprefix(OWN)] = number
            if (own or name in bare) and model.body_mass[number] > 0.0:
                model.body_mass[number], model.body_inertia[number] = _NEXT_TO_NOTHING, _NEXT_TO_NOTHING
        carried = np.isin(model.dof_bodyid, list(self._bodies.values()))
        self.others, self._own = np.flatnonzero(~carried), np.flatnonzero(carried)

    def has(self, joint: str) -> bool:
        """Whether a joint of MuJoCo is one of theirs."""
        return int(self._model.joint(joint).bodyid[0]) in self._bodies.values() if joint.startswith(OWN) else False

    def place(self, data: mujoco.MjData, q: Array) -> None:
        """Where frame B of each cut is, seen from frame A, as the slides and turns of its carrier."""
        for name, a, b in self._chain.cut_placements(q):
            if name not in self._bodies:
                continue
            seen, turns = np.linalg.inv(a) @ b, list[int]()
            first = int(self._model.body_jntadr[self._bodies[name]])
            for joint in range(first, first + int(self._model.body_jntnum[self._bodies[name]])):
                kind, at = int(self._model.jnt_type[joint]), int(self._model.jnt_qposadr[joint])
                if kind == int(mujoco.mjtJoint.mjJNT_SLIDE):
                    data.qpos[at] = self._model.jnt_axis[joint] @ seen[:3, 3]
                elif kind == int(mujoco.mjtJoint.mjJNT_BALL):
                    mujoco.mju_mat2Quat(data.qpos[at : at + 4], seen[:3, :3].flatten())
                else:
                    turns.append(at)
            if len(turns) == 1:
                data.qpos[turns[0]] = np.arctan2(seen[1, 0], seen[0, 0])
            elif turns:
                data.qpos[turns] = np.arctan2(seen[2, 1], seen[1, 1]), np.arctan2(seen[0, 2], seen[0, 0])

    def follow(self, turn: Array, rows: Array) -> Array:
        """The velocities (nv, n) of a model, those of the carriers such that the rows (m, nv) hold."""
        if len(self._own):
            turn[self._own] = -np.linalg.lstsq(rows[:, self._own], rows @ turn, rcond=None)[0]
        return turn
