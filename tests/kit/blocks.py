"""Blocks on level rails, one an actuator: bodies whose motion under any sampled effort is known in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.model import NO_PHYSICS, JointPhysics, Limits
from cutjoint.mechanism import Loads, Posture
from cutjoint.simulation import Observation, State


def blocks(masses: Sequence[float], physics: JointPhysics = NO_PHYSICS, way: float = np.inf) -> ClosedChain:
    """A robot of blocks [kg] on rails along x that are `way` [m] long in both directions."""
    names = [f"rail{i}" for i in range(len(masses))]
    links = [Link("base"), *(Link(f"block{i}", Inertial(mass, inertia=np.eye(3))) for i, mass in enumerate(masses))]
    limits = Limits(-way, way)
    rails = [
        Joint(name, JointType.PRISMATIC, "base", f"block{i}", axis=[1.0, 0.0, 0.0], limits=limits, physics=physics)
        for i, name in enumerate(names)
    ]
    return ClosedChain(
        RobotDescription("blocks", tuple(links), tuple(rails), (), actuators=tuple(names), tool=Frame("block0"))
    )


class Rails:
    """The same robot as a plant of two lines, so that long runs are quick; with springs to 0 and dampers."""

    name = "rails"

    def __init__(self, masses: Sequence[float], stiffness: float = 0.0, damping: float = 0.0) -> None:
        self.mechanism, self.actuated = blocks(masses), np.arange(len(masses))
        self.masses, self.stiffness, self.damping = np.array(masses, dtype=float), stiffness, damping

    def start(self, posture: Posture, v: Array) -> State:
        return State(posture.q, v)

    def chart(self, state: State) -> Array:
        return state.q

    def moved(self, origin: State, u: Array, v: Array) -> State:
        return State(u, v)

    def chart_rate(self, origin: State, state: State) -> Array:
        return state.v

    def measured(self, state: State) -> tuple[Array, Array]:
        return state.q, state.v

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        given = effort if push is None else effort + push
        return (given - self.stiffness * state.q - self.damping * state.v) / self.masses

    def pushed(self, state: State, loads: Loads) -> Array:
        raise NotImplementedError("rails are not pushed")

    @property
    def sticking(self) -> Mapping[int, float]:
        return {}

    def joint_rows(self, state: State, joints: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        raise NotImplementedError("rails have no stiction")

    @property
    def dissipates(self) -> bool:
        return self.damping > 0.0

    def dissipation(self, state: State) -> float:
        return self.damping * float(state.v @ state.v)

    def settled(self, state: State) -> tuple[State, float]:
        return state, 0.0

    def observe(self, state: State) -> Observation:
        kinetic = 0.5 * float(self.masses @ state.v**2)
        potential = 0.5 * self.stiffness * float(state.q @ state.q)
        return Observation(state.q, state.v, np.zeros(3), np.zeros(3), kinetic, potential, (0.0, 0.0), state.q)
