"""The law as a run asks it: shown what is desired and what is measured, and held to shapes, numbers and limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.control import Law, efforts_of
from cutjoint.errors import InputError
from cutjoint.motion import Desired, Reference
from cutjoint.plugins import guarded
from cutjoint.simulation.hardware.electronics import Electronics
from cutjoint.simulation.undesired import Undesired


class Answer(NamedTuple):
    """What a law asks for, shape (n,); the same within limits; and the rate of its memory, shape (memory,)."""

    asked: Array
    given: Array
    memory_rate: Array


class Asking:
    """A law under a reference.

    Args:
        law: the law.
        reference: what it is to follow, if anything.
        control: the hardware of sampled control, whose drives have limits, or the limits of efforts under continuous
            control, or None.

    Attributes:
        electronics: the hardware, or None under continuous control.
    """

    def __init__(self, law: Law, reference: Reference | None, control: Array | Electronics | None) -> None:
        self.law, self.reference = law, reference
        self.electronics = control if isinstance(control, Electronics) else None
        self._limits = None if isinstance(control, Electronics) else control

    def desired(self, t: float) -> Desired:
        """The reference at `t` [s], or what stands for it where there is none."""
        return Undesired(t, self.law.name) if self.reference is None else self.reference.at(t)

    def ask(self, desired: Desired, q: Array, v: Array, memory: Array) -> Answer:
        """What the law, shown `q` and `v`, shape (n,) each, answers.

        Raises:
            InputError: shapes do not fit, or efforts are not finite.
        """
        told = f"controller '{self.law.name}'"
        asked = efforts_of(self.law.name, guarded(told, self.law.effort, desired, q, v, memory))
        if asked.shape != q.shape:
            raise InputError(
                f"{told} asks for efforts of shape {asked.shape}; the robot has {q.size} "
                f"actuators, so they must have shape {q.shape}"
            )
        if not np.isfinite(asked).all():
            raise InputError(f"{told} asks for an effort that is not finite: {asked.tolist()}")
        if self.electronics is not None:
            given = self.electronics.equations.saturated(asked)
        else:
            given = asked if self._limits is None else np.clip(asked, -self._limits, self._limits)
        rate = np.asarray(guarded(told, self.law.memory_rate, desired, q, v, asked, given))
        if rate.shape != memory.shape:
            raise InputError(f"{told} has a memory of shape {memory.shape} and its rate is of shape {rate.shape}")
        return Answer(asked, given, rate)
