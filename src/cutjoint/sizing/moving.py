"""A robot along a reference: what its actuators do at given instants, in batches where it is compiled.

With M the mass matrix and h all that is there without acceleration (see `mechanism.Terms`),

    effort = M a + h - J' wrench,    bare = effort - armature a,    holding = gravity + springs - J' wrench

`armature` is what the rotors of the actuated joints weigh at them (see `mechanism.physics`); a motor table brings
rotors of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, CompiledPaper
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Load, Mechanism, Posture
from cutjoint.mechanism.loads import Loads, as_loads
from cutjoint.mechanism.physics import NO_PHYSICS
from cutjoint.motion import Reference
from cutjoint.motion.reference import Desired
from cutjoint.simulation.choice import quick
from cutjoint.sizing.values import Course

SizingLoads: TypeAlias = Loads | Callable[[float], Loads]
"""Loads that stay, or a function of time [s]."""


class Mover:
    """A robot with what it carries and what pushes it.

    Attributes:
        robot: compiled where it can be.
        plain: the same, not compiled.
        armature: what the rotors of the actuators weigh at them, shape (n,), [kg] or [kg m2].
    """

    def __init__(self, robot: Mechanism, payload: float, loads: SizingLoads) -> None:
        self._given = robot
        carrying = robot.with_payload(payload) if payload else robot
        self.robot = carrying if isinstance(carrying, CompiledChain | CompiledPaper) else quick(carrying)
        self.plain: Mechanism = getattr(self.robot, "plain", self.robot)
        _check_idle(self.plain)
        self._loads = loads if callable(loads) else as_loads(loads)
        chain = self.plain if isinstance(self.plain, ClosedChain) else None
        physics = {one.name: one.physics for one in chain.description.joints} if chain else {}
        rotors = [physics.get(one.name, NO_PHYSICS) for one in robot.actuators]
        self.armature = np.array([one.armature for one in getattr(self.plain, "motors", ()) or rotors])

    def followed(self, reference: Reference) -> Reference:
        """The reference, seen through the compiled robot where it was made with the chain, which is quicker.

        Raises:
            InputError: it was made for another robot.
        """
        names, own = ([one.name for one in of.actuators] for of in (reference.mechanism, self.robot))
        if names != own:
            raise InputError(
                f"the reference along '{reference.trajectory.name}' was made for {reference.mechanism.name} with the "
                f"actuators {', '.join(names)}; {self.robot.name} has {', '.join(own)}"
            )
        if reference.mechanism is self._given is not self.robot and isinstance(self.robot, CompiledChain):
            return Reference(reference.trajectory, self.robot, reference.duration, limits=reference.limits)
        return reference

    def loads(self, t: float) -> tuple[Load, ...]:
        """What pushes at a time [s]."""
        return as_loads(self._loads(t)) if callable(self._loads) else self._loads

    @property
    def is_pushed(self) -> bool:
        """Whether there may be loads."""
        return callable(self._loads) or bool(self._loads)

    def posture(self, desired: Desired) -> Posture:
        """The desired posture as a posture of the robot that carries."""
        if desired.mechanism is self.robot or desired.mechanism is self.plain:
            return desired.posture
        if isinstance(self.plain, ClosedChain) and desired.posture.q_full.size == self.plain.nq:
            return self.plain.posture(desired.posture.q_full)
        return self.robot.close(desired.q, limits="ignore")

    def plain_posture(self, at: Posture) -> Posture:
        """A posture of the compiled robot as one of the robot that is not."""
        return self.plain.posture(at.q_full) if isinstance(self.plain, ClosedChain) else at

    def course(self, reference: Reference, times: Array) -> Course:
        """What the actuators do at m instants."""
        return self.course_of([reference.at(t) for t in times.tolist()])

    def course_of(self, wanted: Sequence[Desired]) -> Course:
        """The same where the desired motions are known."""
        q, v, a = (np.array([getattr(one, name) for one in wanted]) for name in "qva")
        mass, coriolis, gravity, springs, friction = self.terms([self.posture(one) for one in wanted], v)
        push = np.zeros_like(v)
        if self.is_pushed:
            for k, one in enumerate(wanted):
                push[k] = self.pushed(self.posture(one), self.loads(one.t))
        effort = np.einsum("kij,kj->ki", mass, a) + coriolis + gravity + springs + friction - push
        return Course(
            np.array([one.t for one in wanted]),
            q,
            v,
            a,
            effort,
            effort - self.armature * a,
            gravity + springs - push,
            np.einsum("ki,ki->k", friction, v),
            np.einsum("ki,ki->k", push, v),
            np.einsum("kii->ki", mass) - self.armature,
        )

    def pushed(self, at: Posture, loads: tuple[Load, ...]) -> Array:
        """Loads as efforts, shape (n,).

        Raises:
            ActuationError: they push an idle motion, which the actuated coordinates do not tell.
        """
        at = self.plain_posture(at)
        if isinstance(self.plain, ClosedChain) and self.plain.pushes_idle(at, loads):
            raise ActuationError(
                f"the loads push an idle motion of {self.plain.name}, such as the spin of a rod between two balls, "
                "which its actuators do not hold; let them act elsewhere",
                mobility=self.plain.n,
                actuators=self.plain.n,
                free=(),
            )
        return self.plain.load_effort(at, loads)

    def terms(self, postures: Sequence[Posture], v: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Mass matrices (m, n, n), then Coriolis vectors, weights, springs and friction, (m, n) each."""
        if isinstance(self.robot, CompiledChain):
            return tuple(self.robot.batch.terms(np.array([one.q_full for one in postures]), v))  # type: ignore[return-value]
        if isinstance(self.robot, CompiledPaper):
            return tuple(self.robot.batch.terms(np.array([one.q for one in postures]), v))  # type: ignore[return-value]
        found = [self.robot.terms(at, speed) for at, speed in zip(postures, v, strict=True)]
        names = ("mass", "coriolis", "gravity", "springs", "friction")
        return tuple(np.array([getattr(one, name) for one in found]) for name in names)  # type: ignore[return-value]


def _check_idle(robot: Mechanism) -> None:
    """Raises ActuationError where the actuators do not tell the whole motion."""
    if isinstance(robot, ClosedChain) and not robot.idle_is_cyclic:
        report = robot.mobility()
        raise ActuationError(
            f"{robot.name} has idle motions that its masses or weights notice, such as a rod that is not round "
            f"({', '.join(report.idle)}): how far they have turned depends on the past, and so do the efforts; make "
            "these links round about what they turn about",
            mobility=report.mobility,
            actuators=report.actuators,
            free=report.idle,
        )
