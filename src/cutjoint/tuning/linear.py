"""A robot and a law near rest at a posture, as linear equations.

    plant    a = by_q dq + by_v v + by_effort du            exact derivatives of the compiled forward dynamics
    law      du = by_q dq + by_v v + by_memory m,  m' = rate_q dq + rate_v v + rate_memory m

The law's are central differences of its own answer, so that any law has them, one from outside too.  Dry friction is
left out of the plant: within its friction speed it is a damper far stiffer than it is on average, and beyond it none;
the loop without it is the one with less damping.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.compile import Compiled, compiled
from cutjoint.control import Law
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.motion import Desired, JointMotion, Reference
from cutjoint.reprs import line

STEP = 1e-5
"""Half of a central difference, in [rad], in the robot's lengths, or of them a second."""


@dataclass(frozen=True, eq=False)
class JointRest(Frozen):
    """The actuators rest at `q`, shape (n,) [m] or [rad], for `duration` [s]."""

    q: Array
    duration: float = 1.0
    name: str = "rest"

    __repr__ = line("q", "duration", q="m or rad", duration="s")

    def at(self, t: float) -> JointMotion:
        """The same at every time."""
        still = np.zeros(len(self.q))
        return JointMotion(self.q, still, still)


@dataclass(frozen=True, eq=False)
class LinearPlant(Frozen):
    """A robot near rest at a posture.

    Attributes:
        q: where, shape (n,) [m] or [rad].
        effort: that holds it there, shape (n,) [N] or [N m].
        mass: mass matrix there, shape (n, n).
        by_q, by_v, by_effort: derivatives of the acceleration, shape (n, n).
    """

    q: Array
    effort: Array
    mass: Array
    by_q: Array
    by_v: Array
    by_effort: Array

    __repr__ = line("q", "effort", q="m or rad", effort="N or N m")

    @property
    def state(self) -> Array:
        """A of x' = A x + B du with x = (dq, v), shape (2 n, 2 n)."""
        n = len(self.q)
        return np.block([[np.zeros((n, n)), np.eye(n)], [self.by_q, self.by_v]])

    @property
    def input(self) -> Array:
        """B of it, shape (2 n, n)."""
        return np.vstack([np.zeros_like(self.by_effort), self.by_effort])


@dataclass(frozen=True, eq=False)
class LinearLaw(Frozen):
    """A law of m own states near rest.

    Attributes:
        by_q, by_v, by_memory: derivatives of its effort, shape (n, n), (n, n) and (n, m).
        rate_q, rate_v, rate_memory: of the rate of its memory, shape (m, n), (m, n) and (m, m).
    """

    by_q: Array
    by_v: Array
    by_memory: Array
    rate_q: Array
    rate_v: Array
    rate_memory: Array

    __repr__ = line()


def without_dry_friction(robot: Compiled) -> Compiled:
    """The robot as its linear equations see it: joints and cuts have no dry friction."""
    plain = getattr(robot, "plain", robot)
    if not isinstance(plain, ClosedChain) or not _rubs(plain):
        return robot
    told = plain.description
    joints = tuple(replace(one, physics=replace(one.physics, friction=0.0)) for one in told.joints)
    cuts = tuple(replace(one, physics=replace(one.physics, friction=0.0)) for one in told.cuts)
    smooth = ClosedChain(replace(told, joints=joints, cuts=cuts))
    return compiled(smooth, parameters=robot.options.parameters, quick=True)


def _rubs(chain: ClosedChain) -> bool:
    return any(one.physics.friction for one in chain.description.joints) or any(
        one.physics.friction for one in chain.description.cuts
    )


def linear_plant(robot: Compiled, at: Posture | None = None) -> LinearPlant:
    """A compiled robot at rest at a posture (default home).

    Raises:
        ActuationError: the actuators do not determine the motion.
        SingularError: type-2 singularity.
    """
    at = robot.home if at is None else at
    still = np.zeros(robot.n)
    effort = robot.inverse_dynamics(at, still, still)
    found = robot.forward_derivatives(at, still, effort)
    return LinearPlant(at.q, effort, robot.terms(at).mass, found.by_q, found.by_v, found.by_input)


def at_rest(model: Mechanism, q: Array) -> Desired:
    """The desired motion of a robot that is to rest at actuated coordinates `q`, shape (n,)."""
    return Reference(JointRest(q), model, limits="ignore").at(0.0)


def linear_law(law: Law, desired: Desired) -> LinearLaw:
    """A law near where it is to rest."""
    n = len(desired.q)
    m = law.memory(n)
    sizes = steps_of(desired.mechanism)
    held = np.zeros(m)
    asked = law.effort(desired, desired.q, np.zeros(n), held)

    def effort(q: Array, v: Array, memory: Array) -> Array:
        return np.asarray(law.effort(desired, desired.q + q, v, memory))

    def rate(q: Array, v: Array, memory: Array) -> Array:
        return np.asarray(law.memory_rate(desired, desired.q + q, v, asked, asked))

    parts = []
    for of in (effort, rate):
        for which, widths in enumerate((sizes, sizes, np.ones(m))):
            columns = []
            for k, width in enumerate(widths):
                x = [np.zeros(n), np.zeros(n), np.zeros(m)]
                x[which][k] = STEP * width
                there = of(*x)
                x[which][k] = -STEP * width
                columns.append((there - of(*x)) / (2.0 * STEP * width))
            parts.append(np.array(columns).T.reshape(n if of is effort else m, len(widths)))
    return LinearLaw(*parts)


def steps_of(robot: Mechanism) -> Array:
    """What is small of each actuator: 1 rad, or the robot's characteristic length [m]; shape (n,)."""
    length = float(getattr(robot, "length", 1.0))
    return np.array([length if one.kind == "translation" else 1.0 for one in robot.actuators])


def discretised(state: npt.ArrayLike, inputs: npt.ArrayLike, time: float) -> tuple[Array, Array]:
    """exp(A t) and the integral of exp(A s) B over s from 0 to t: what a held input has done after `time` [s]."""
    from scipy.linalg import expm

    a, b = np.asarray(state), np.asarray(inputs)
    n, m = b.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a * time, b * time
    whole = expm(block)
    return whole[:n, :n], whole[:n, n:]
