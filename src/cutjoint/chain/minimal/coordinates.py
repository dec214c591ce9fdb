"""A closed robot in minimal coordinates: as many velocities as it has freedoms, whatever drives it.

With v the independent velocities, T and d of `cutjoint.chain.reduced` and the rows T_a of T that belong to the
actuators,

    mass a + coriolis + gravity + springs + friction = B effort + T' J' wrench,   B = T_a'

Where the actuators determine the motion, they are the coordinates and B is the unit matrix.  Otherwise the coordinates
are those of what flies from the base, of the motors as far as they are independent, and of joints that are named
(`cutjoint.chain.minimal.choosing`).  Velocities of a ball, and of what flies, are those of the body in its own axes;
they are no derivatives of coordinates, so a change of posture is told as a motion with constant velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, Sealed, as_vector
from cutjoint.chain.actuation import ActuatorEfforts
from cutjoint.chain.closed_chain import ClosedChain
from cutjoint.chain.closing.continuation import Stopped, follow
from cutjoint.chain.closing.short_steps import short_way
from cutjoint.chain.minimal.choosing import chosen
from cutjoint.chain.minimal.independent import Independent
from cutjoint.chain.minimal.linearisation import Linearisation, linearised
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.reduced import ReducedDynamics
from cutjoint.errors import ClosureError, SingularError
from cutjoint.mechanism import NO_LOADS, Loads, Posture, Terms, Tool
from cutjoint.reprs import clipped, one_line, quoted


# long: the public face of a robot in minimal coordinates, a line or two of code a method
class MinimalCoordinates(Sealed):
    """A closed chain in minimal coordinates.  `ClosedChain.minimal` makes one.

    Args:
        chain: the robot.
        mobility: of it, by its actuators.
        joints: names of passive joints that are coordinates too.

    Attributes:
        chain: the robot, which makes and takes the postures.
        joints: names of all joints whose velocities are independent, in the order of the coordinates.
        names, units: of every coordinate, the unit `m` or `rad`.
        n: number of coordinates.
        v_index: where they are in a velocity of all joints, shape (n,).

    Raises:
        UnknownNameError, InputError, ActuationError: as `cutjoint.chain.minimal.choosing.chosen`.
    """

    def __init__(self, chain: ClosedChain, mobility: Mobility, joints: Sequence[str] = ()) -> None:
        self.chain, self._named = chain, tuple(joints)
        self._mobility = chosen(mobility, self._named)
        assert isinstance(self._mobility.chosen, Independent)
        self._own, self._postures = self._mobility.chosen, mobility.postures
        self._k, self._reduced = self._postures.k, ReducedDynamics(self._mobility)
        self.joints, self.names, self.units, self.n = self._own.joints, self._own.names, self._own.units, self._own.n
        self.v_index = self._own.v_index

    def __reduce__(self) -> tuple[Callable[[], MinimalCoordinates], tuple[()]]:
        """Chosen anew for the same robot, in another process too."""
        return partial(_of, self.chain, self._named), ()

    def __repr__(self) -> str:
        coordinates = [f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
        return one_line("MinimalCoordinates", [f"of {quoted(self.chain.name)}", *map(clipped, coordinates)])

    @property
    def name(self) -> str:
        """Of the robot."""
        return self.chain.name

    @property
    def is_flat(self) -> bool:
        """Whether the coordinates are numbers of the configuration, `q_full`: no body turns freely."""
        return self._own.flat

    @property
    def idle_is_cyclic(self) -> bool:
        """See `ClosedChain.idle_is_cyclic`: whether the coordinates tell the whole motion."""
        return self._mobility.idle_is_cyclic

    @property
    def idle(self) -> int:
        """Number of idle motions, which are no coordinates, such as the spin of a rod between two balls."""
        return self._mobility.structure.idle

    # ---- kinematics ------------------------------------------------------------------------------------------------

    def of(self, values_full: npt.ArrayLike) -> Array:
        """The independent part of a velocity or acceleration of all joints (nv,), shape (n,)."""
        return np.asarray(as_vector("values_full", values_full, self.chain.nv)[self.v_index])

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n).

        Raises:
            SingularError: with the independent velocities held, the robot still moves here.
        """
        return self._reduced.at(at).map

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self._reduced.velocity(at, v)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,)."""
        return self._reduced.drift(at, v)

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Pose, frame Jacobian (6, n), its drift and twist of the tool in world axes.

        Raises:
            InputError: the robot has no tool, or `at` is another robot's posture.
            SingularError: as `tangent`.
        """
        return self._reduced.tool(at, v)

    def change(self, at: Posture, to: Posture) -> Array:
        """The motion of the independent joints from one posture to another, shape (n,) [m] or [rad]."""
        here, there = self._postures.placed(at), self._postures.placed(to)
        return np.asarray(self._k.tree.difference(here.q, there.q)[self.v_index])

    def moved(self, at: Posture, change: npt.ArrayLike) -> Posture:
        """The posture after a motion of the independent joints, shape (n,) [m] or [rad], on the branch of `at`.

        Joint limits are not asked.

        Raises:
            InputError: wrong shape or not finite, or `at` is no posture of this robot.
            ClosureError: the loops cannot be kept closed all the way.
            SingularError: the way leads through a singularity, where branches meet.
        """
        goal, start = as_vector("change", change, self.n), self._postures.placed(at)
        driver = self._own.lead(start.q, np.zeros(self.n), goal)
        quick = self._mobility.quick
        found = short_way(quick, start, driver) if quick is not None else None
        placed = found or follow(self._k, start, driver, self._mobility.structure.idle)
        if isinstance(placed, Stopped):
            raise self._stopped(placed)
        return self._postures.make(placed)

    def _stopped(self, stopped: Stopped) -> ClosureError | SingularError:
        here = self._own.show(self._own.of(stopped.placed.q))
        told = f"{self.name} came {stopped.fraction:.1%} of the way, to {here}, where {stopped.why}"
        if stopped.singular:
            limit = tolerances.SINGULAR.value
            return SingularError(told, kind="type-2", measure=stopped.measure, limit=limit)
        distance, angle, cut = stopped.placed.gap
        return ClosureError(told, gap=(distance, angle), cut=cut, progress=stopped.fraction)

    # ---- dynamics --------------------------------------------------------------------------------------------------

    def effort_map(self, at: Posture) -> Array:
        """B, by which efforts of the actuators act on the coordinates, shape (n, actuators)."""
        rows = self.chain.actuated_velocity(self._reduced.at(at).map)
        return rows.T

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix (n, n), Coriolis vector, gravity, springs and friction (n,).

        Raises:
            SingularError: as `tangent`.
        """
        return self._reduced.terms(at, v)

    def potential_energy(self, at: Posture) -> float:
        """See `ClosedChain.potential_energy` [J]."""
        return self.chain.potential_energy(at)

    def kinetic_energy(self, at: Posture, v: npt.ArrayLike) -> float:
        """v' M v / 2 [J]."""
        speed = as_vector("v", v, self.n)
        return 0.5 * float(speed @ self.terms(at).mass @ speed)

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """Generalised forces of loads from outside: T' J' wrench, shape (n,), [N] or [N m].

        Raises:
            InputError: they are no loads, or one acts at a tool that the robot does not have.
            UnknownNameError: there is no such link.
            SingularError: as `tangent`.
        """
        return self._reduced.at(at).transposed @ self.chain.full_load_effort(at, loads)

    def pushes_idle(self, at: Posture, loads: Loads) -> bool:
        """Whether loads push an idle motion, which the coordinates do not tell."""
        return self._reduced.at(at).pushes_idle(self.chain.full_load_effort(at, loads))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Generalised forces that give the acceleration `a` against `loads`, shape (n,); `efforts` are those of the
        actuators.

        Raises:
            InputError, UnknownNameError, SingularError: as `load_effort`.
        """
        force = self._reduced.inverse(at, v, a)
        return force if loads is NO_LOADS else force - self.load_effort(at, loads)

    def efforts(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> ActuatorEfforts:
        """Least efforts of the actuators that give the acceleration `a` against `loads`, and their internal preload.

        Raises:
            ActuationError: the actuators cannot do that; it names the joints that would need a motor.
            InputError, UnknownNameError, SingularError: as `load_effort`.
        """
        here = self._reduced.at(at)
        full = here.map @ as_vector("a", a, self.n) + self.drift(at, v)
        if here.idle.size and loads is not NO_LOADS:  # idle motions are pushed by loads alone
            full = full + here.idle @ (here.idle.T @ self.chain.full_load_effort(at, loads))
        return self.chain.full_inverse_dynamics(at, self.full_velocity(at, v), full, loads)

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Acceleration that efforts of the actuators and `loads` give, shape (n,).

        Args:
            at: where.
            v: independent velocities, shape (n,).
            effort: of the actuators, in the order of `chain.actuators`.
            loads: from outside.

        Raises:
            InputError, UnknownNameError, SingularError: as `load_effort`.
            DynamicsError: a motion moves no mass.
        """
        force = self.effort_map(at) @ as_vector("effort", effort, self.chain.n)
        return self.accelerated(at, v, force if loads is NO_LOADS else force + self.load_effort(at, loads))

    def accelerated(self, at: Posture, v: npt.ArrayLike, force: npt.ArrayLike) -> Array:
        """Acceleration that generalised forces (n,) give, shape (n,)."""
        return self._reduced.forward(at, v, force)

    def linearised(self, at: Posture, effort: npt.ArrayLike | None = None, loads: Loads = NO_LOADS) -> Linearisation:
        """How small motions around an equilibrium go on.

        Args:
            at: where the robot stands.
            effort: of the actuators; default the least that holds it there.
            loads: from outside, the same wherever it moves.

        Raises:
            ActuationError: the actuators cannot hold it.
            InputError: it is no equilibrium, or some friction sticks.
            SingularError: as `tangent`.
        """
        given = None if effort is None else as_vector("effort", effort, self.chain.n)
        return linearised(self, self._k, at, given, loads)


def _of(chain: ClosedChain, joints: Sequence[str]) -> MinimalCoordinates:
    """For unpickling."""
    return chain.minimal(joints)
