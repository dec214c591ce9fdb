"""The experiments of Adetu, Moore and Roberts: the figure of eight (43) with two controllers, and what they rest on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.control import Law, law
from cutjoint.errors import UnknownNameError
from cutjoint.motion import Reference
from cutjoint.papers.omega3 import Omega3Model, Parameters
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation import ConstrainedPlant, ReducedPlant, Result, RungeKutta4, run
from cutjoint.tuning.known import GAINS

ROBOT = "omega3"
LAWS = ("computed-torque", "feedforward")
RATE = 1000.0
TOO_HEAVY = 0.2


@dataclass(frozen=True)
class Setup:
    """A plant and a start; the controller always believes equation (42).

    Attributes:
        about: for tables and captions.
        variant: rods of the closed chain; None for the plant of equation (42) itself.
        sampled: controlled at `RATE` with zero-order hold instead of continuously.
        from_home: starts at rest in the home posture, 60 mm off the path, instead of at rest on it.
        payload: mass that the plant carries and the controller does not know [kg].
    """

    about: str
    variant: str | None = None
    sampled: bool = False
    from_home: bool = False
    payload: float = 0.0


SETUPS: Mapping[str, Setup] = {
    "paper": Setup("equation (42), continuous control"),
    "home": Setup("equation (42), started 60 mm off the path", from_home=True),
    "lumped": Setup("Pinocchio, lumped rods, 1 kHz", "lumped", sampled=True),
    "distributed": Setup("Pinocchio, distributed rods, 1 kHz", "distributed", sampled=True),
    "heavy": Setup(
        "Pinocchio, distributed rods, 1 kHz, payload 20 % too heavy",
        "distributed",
        sampled=True,
        payload=TOO_HEAVY * Parameters().m_payload,
    ),
}


@lru_cache(maxsize=1)
def model() -> Omega3Model:
    """What the controller believes: equation (42) with the documented defaults."""
    return Omega3Model()


@lru_cache(maxsize=4)
def chain(variant: str, payload: float = 0.0) -> ClosedChain:
    """The closed chain with lumped or distributed rods, with a payload [kg] on top of the paper's."""
    robot = load(ROBOT, variant, dynamics="ideal")
    return robot.with_payload(payload) if payload else robot


@lru_cache(maxsize=1)
def reference() -> Reference:
    """The curve (43), through the controller's model."""
    return Reference(PUBLISHED[ROBOT].trajectory(), model())


def controller(name: str) -> Law:
    """A law with the gains of this project; the paper prints none."""
    return law(name, model(), GAINS[ROBOT][name])


def curve_run(name: str, setup: str) -> Result:
    """One turn of the curve from rest; RK4 and a sample every millisecond."""
    if setup not in SETUPS:
        raise UnknownNameError("set-up", setup, list(SETUPS))
    chosen = SETUPS[setup]
    plant = ReducedPlant(model()) if chosen.variant is None else ConstrainedPlant(chain(chosen.variant, chosen.payload))
    return run(
        plant,
        controller(name),
        reference(),
        integrator=RungeKutta4(1e-3),
        every=1e-3,
        rate=RATE if chosen.sampled else None,
        start=plant.mechanism.home if chosen.from_home else None,
    )


@dataclass(frozen=True, eq=False)
class ArmAssumption:
    """A shape that the semi-circular arm may have, and what it does to the torque along the path.

    Attributes:
        about: the shape.
        com: centre of mass from the motor axis towards the elbow [m].
        inertia: about the motor axis, without the rods' share [kg m2].
        peak: largest torque of the arms along the path, shape (3,), [N m].
        change: largest change against the default, shape (3,), [N m].
    """

    about: str
    com: float
    inertia: float
    peak: Array
    change: Array


def arm_shapes() -> dict[str, tuple[float, float]]:
    """Shapes of equal mass and length: centre of mass [m] and inertia about it [kg m2]."""
    p = Parameters()
    length, mass = p.L_A, p.m_SC
    ring = 2.0 * length / pi
    return {
        "uniform half-disc of radius L_A (default)": (p.arm_com, p.arm_inertia),
        "half-ring of radius L_A": (ring, mass * (length**2 - ring**2)),
        "uniform rod of length L_A": (length / 2.0, mass * length**2 / 12.0),
        "all its mass at the motor axis": (0.0, 0.0),
        "all its mass at the elbow": (length, 0.0),
    }


def arm_assumptions(samples: int = 401) -> list[ArmAssumption]:
    """The torque along the path under each shape of the arm."""
    way = reference()
    desired = [way.at(float(t)) for t in np.linspace(0.0, way.duration, samples)]

    def torque(com: float, inertia: float) -> Array:
        robot = Omega3Model(replace(Parameters(), arm_com=com, arm_inertia=inertia))
        return np.array([robot.inverse_dynamics(robot.close(d.q), d.v, d.a) for d in desired])

    default = torque(Parameters().arm_com, Parameters().arm_inertia)
    found = []
    for about, (com, inertia) in arm_shapes().items():
        there = torque(com, inertia)
        about_axis = inertia + Parameters().m_SC * com**2
        found.append(
            ArmAssumption(about, com, about_axis, np.abs(there).max(axis=0), np.abs(there - default).max(axis=0))
        )
    return found
