"""A closed chain in minimal coordinates, compiled: the same interface and answers, from straight-line code."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array, Sealed, as_vector
from cutjoint.chain.actuation import ActuatorEfforts
from cutjoint.chain.minimal import Linearisation, MinimalCoordinates
from cutjoint.compile.closing import ChainClosing
from cutjoint.compile.functions.library import Library, Options
from cutjoint.compile.functions.minimal_sample import MinimalChecker
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.mechanism import Derivatives
from cutjoint.compile.once import once
from cutjoint.compile.sources.minimal import MinimalSource
from cutjoint.errors import InputError, SingularError
from cutjoint.mechanism import NO_LOADS, Loads, Posture, Terms, Tool
from cutjoint.reprs import clipped, one_line, quoted

NO_PARAMETERS = np.zeros(0)


# long: the public face of a robot in minimal coordinates, a line or two of code a method
class CompiledMinimal(Sealed):
    """Minimal coordinates of a chain, compiled; see `MinimalCoordinates`, whose answers these are.

    Where a compiled function must not be trusted (near singular postures) the coordinates themselves are asked.

    Args:
        minimal: the coordinates.
        options: how to compile; numbers of the description cannot stay arguments here.

    Raises:
        InputError: parameters are asked for.
    """

    def __init__(self, minimal: MinimalCoordinates, options: Options | None = None) -> None:
        self.options = Options() if options is None else options
        if self.options.parameters:
            raise InputError("in minimal coordinates no parameters stay arguments; build the robot with other numbers")
        self.plain, self.chain, self.source = minimal, minimal.chain, MinimalSource(minimal)
        self.joints, self.names, self.units, self.n = minimal.joints, minimal.names, minimal.units, minimal.n
        self.v_index, self.name = minimal.v_index, f"{minimal.name}, compiled"
        self.is_flat, self.idle_is_cyclic, self.idle = minimal.is_flat, minimal.idle_is_cyclic, minimal.idle
        self._library = Library(self.source, MinimalChecker(self.source), self.options)
        self._lock = threading.RLock()

    def __repr__(self) -> str:
        coordinates = [f"{clipped(name)} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
        return one_line("CompiledMinimal", [quoted(self.name), *coordinates])

    def __reduce__(self) -> tuple[object, ...]:
        return CompiledMinimal, (self.plain, replace(self.options, report=None))

    def kernel(self, what: str) -> Kernel:
        """The compiled function called `what`, for one state or many; efforts in it are generalised forces (n,).

        Raises:
            UnknownNameError, InputError, CompileError: there is none, or it cannot be compiled.
        """
        return self._library[what].kernel

    # ---- kinematics ------------------------------------------------------------------------------------------------

    def of(self, values_full: npt.ArrayLike) -> Array:
        """See `MinimalCoordinates.of`."""
        return self.plain.of(values_full)

    def tangent(self, at: Posture) -> Array:
        """See `MinimalCoordinates.tangent`."""
        parts = self._call("tangent", at)
        return self.plain.tangent(at) if parts is None else parts["tangent"]

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """See `MinimalCoordinates.full_velocity`."""
        return self.tangent(at) @ as_vector("v", v, self.n)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """See `MinimalCoordinates.drift`."""
        parts = self._call("drift", at, v)
        return self.plain.drift(at, v) if parts is None else parts["drift"]

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """See `MinimalCoordinates.tool`."""
        parts = self._call("tool", at, np.zeros(self.n) if v is None else v)
        return self.plain.tool(at, v) if parts is None else Tool(**parts)

    def change(self, at: Posture, to: Posture) -> Array:
        """See `MinimalCoordinates.change`."""
        return self.plain.change(at, to)

    def moved(self, at: Posture, change: npt.ArrayLike) -> Posture:
        """See `MinimalCoordinates.moved`; long ways are left to the chain's own continuation."""
        goal = as_vector("change", change, self.n)
        parts = self._call("tangent", at)
        if parts is not None:
            model = self.chain.local_model
            own = np.zeros(self.chain.nv)
            own[self.v_index] = goal
            passive = parts["tangent"] @ goal
            passive[self.v_index] = 0.0
            size = np.abs(passive / self.source.rate_scale).max(initial=0.0)
            if size < NEAR:
                start = pin.integrate(model, pin.integrate(model, at.q_full, own), passive)
                found = self._closing.to(start, np.zeros(self.n))
                if found is not None:
                    return found
        return self.plain.moved(at, goal)

    @once
    def _closing(self) -> ChainClosing:
        return ChainClosing(self.source, self._library, NO_PARAMETERS)

    # ---- dynamics --------------------------------------------------------------------------------------------------

    def effort_map(self, at: Posture) -> Array:
        """See `MinimalCoordinates.effort_map`."""
        rows: Array = self.chain.actuated_velocity(self.tangent(at))
        return rows.T

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """See `MinimalCoordinates.terms`."""
        parts = self._call("terms", at, np.zeros(self.n) if v is None else v)
        return self.plain.terms(at, v) if parts is None else Terms(**parts)

    def potential_energy(self, at: Posture) -> float:
        """See `MinimalCoordinates.potential_energy`."""
        parts = self._call("energy", at, np.zeros(self.n))
        return self.plain.potential_energy(at) if parts is None else float(parts["potential"][0])

    def kinetic_energy(self, at: Posture, v: npt.ArrayLike) -> float:
        """See `MinimalCoordinates.kinetic_energy`."""
        parts = self._call("energy", at, v)
        return self.plain.kinetic_energy(at, v) if parts is None else float(parts["kinetic"][0])

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """See `MinimalCoordinates.load_effort`."""
        return self.tangent(at).T @ self.chain.full_load_effort(at, loads)

    def pushes_idle(self, at: Posture, loads: Loads) -> bool:
        """See `MinimalCoordinates.pushes_idle`."""
        return bool(self.idle) and self.plain.pushes_idle(at, loads)

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """See `MinimalCoordinates.inverse_dynamics`."""
        parts = self._call("inverse", at, v, a)
        force = self.plain.inverse_dynamics(at, v, a) if parts is None else parts["effort"]
        return force if loads is NO_LOADS else force - self.load_effort(at, loads)

    def efforts(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> ActuatorEfforts:
        """See `MinimalCoordinates.efforts`."""
        return self.plain.efforts(at, v, a, loads)

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """See `MinimalCoordinates.forward_dynamics`."""
        force = self.effort_map(at) @ as_vector("effort", effort, self.chain.n)
        return self.accelerated(at, v, force if loads is NO_LOADS else force + self.load_effort(at, loads))

    def accelerated(self, at: Posture, v: npt.ArrayLike, force: npt.ArrayLike) -> Array:
        """See `MinimalCoordinates.accelerated`."""
        parts = self._call("forward", at, v, force)
        return self.plain.accelerated(at, v, force) if parts is None else parts["a"]

    def forward_derivatives(self, at: Posture, v: npt.ArrayLike, force: npt.ArrayLike) -> Derivatives:
        """Acceleration that generalised forces (n,) give, and its exact derivatives along the coordinates, in their
        velocities and in the forces.

        Raises:
            InputError: wrong shape or not finite.
            SingularError: too near to a singularity for derivatives of any use.
        """
        return self._derivatives("forward_derivatives", at, v, force)

    def inverse_derivatives(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Derivatives:
        """Generalised forces that give an acceleration, and their exact derivatives; see `forward_derivatives`."""
        return self._derivatives("inverse_derivatives", at, v, a)

    def linearised(self, at: Posture, effort: npt.ArrayLike | None = None, loads: Loads = NO_LOADS) -> Linearisation:
        """See `MinimalCoordinates.linearised`."""
        return self.plain.linearised(at, effort, loads)

    def _derivatives(self, what: str, at: Posture, v: npt.ArrayLike, x: npt.ArrayLike) -> Derivatives:
        parts = self._call(what, at, v, x)
        if parts is None:
            self.plain.terms(at)
            raise SingularError(
                f"{self.name} is too near to a singularity for its derivatives", kind="type-2", measure=0.0, limit=0.0
            )
        return Derivatives(*parts.values())

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> dict[str, Array] | None:
        """Parts of the result of one evaluation, or None where the compiled function must not be trusted."""
        self._closing.start(at)
        given = [as_vector("argument", x, self.n) for x in arguments]
        return self._library[what](at.q_full, *given, NO_PARAMETERS)


NEAR = 0.05
"""Longest motion of a passive joint, in radians or link lengths, that is not left to the continuation."""
