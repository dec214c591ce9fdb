"""The full configurations of a run by name: which joint's coordinates the columns of `q_full` are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import JOINTS
from cutjoint.description.joints import JointType
from cutjoint.errors import InputError


class JointColumn(NamedTuple):
    """One coordinate of a joint over a run: name of the joint, name of the coordinate (such as "roll"; empty where the
    joint has but one), unit (`m` or `rad`), and values of shape (m,)."""

    joint: str
    part: str
    unit: str
    values: Array

    @property
    def name(self) -> str:
        """As a legend has it."""
        return f"{self.joint} {self.part}".rstrip()


def joints_of(mechanism: object) -> list[list[str]] | None:
    """Name and type of the moving joints of a chain, or of one that is compiled, in the order of `q_full`; None of
    another mechanism, whose configurations are its own."""
    chain = getattr(mechanism, "plain", mechanism)
    chain = getattr(chain, "chain", chain)
    if not isinstance(chain, ClosedChain):
        return None
    kinds = {joint.name: joint.type for joint in chain.description.joints}
    return [[name, str(kinds[name])] for name in chain.model.names[1:]]


def coordinates(q_full: Array, joints: Sequence[Sequence[str]]) -> list[JointColumn]:
    """Coordinates of all `joints` (names and types) over a run; angles that come of a
    rotation go on beyond a turn.

    Args:
        q_full: configurations, shape (m, nq).
        joints: in the order of `q_full`.

    Raises:
        InputError: they have other coordinates than `q_full`, or a type is unknown.
    """
    found: list[JointColumn] = []
    start = 0
    for name, kind in joints:
        if kind not in set(JointType):
            raise InputError(f"joint '{name}' is said to be '{kind}', which is no type of joint")
        row, parts = JOINTS[JointType(kind)], JointType(kind).coordinates
        end = start + row.models[0]().nq
        own = q_full[:, start:end]
        if own.shape[1] == end - start:
            values = own if row.from_q is None else np.array([row.from_q(one) for one in own])
            for i, part in enumerate(parts):
                stored = part.is_length or row.from_q is None
                column = values[:, i] if stored else np.unwrap(values[:, i])
                found.append(JointColumn(name, part.name if len(parts) > 1 else "", part.unit, column))
        start = end
    if start != q_full.shape[1]:
        raise InputError(
            f"the joints ({', '.join(name for name, _ in joints)}) have {start} coordinates in a configuration, this "
            f"run has {q_full.shape[1]}; give the robot that it was made with"
        )
    return found
