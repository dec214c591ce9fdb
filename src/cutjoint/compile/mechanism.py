"""Compiled mechanisms: the same interface and answers as the model they were made from, from straight-line code.

Every evaluation returns its strain (`cutjoint.compile.equations.reduction`).  Where it exceeds the limit, or anything
is not a finite number, the compiled answer is thrown away and the model itself is asked, which either has the right
number or raises its own error.  So there is no wrong number in between, and errors are those of the model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, as_vector
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.parametrised import Model_co, Parametrised
from cutjoint.errors import SingularError
from cutjoint.mechanism import (
    NO_LOADS,
    ActuatedCoordinates,
    JointLimits,
    Load,
    Loads,
    Posture,
    TargetLike,
    Task,
    Terms,
    Tool,
)
from cutjoint.mechanism.loads import as_loads, tool_wrench
from cutjoint.reprs import line

WRENCH = 6
"""Numbers of a wrench: force and moment."""


@dataclass(frozen=True, eq=False)
class Derivatives(Frozen):
    """A value and its exact derivatives in actuated coordinates, the loops staying closed.

    Attributes:
        value: acceleration or effort, shape (n,).
        by_q, by_v: shape (n, n).
        by_input: with respect to the effort (forward dynamics; the inverse of the mass matrix) or the acceleration
            (inverse dynamics; the mass matrix), shape (n, n).
    """

    value: Array
    by_q: Array
    by_v: Array
    by_input: Array

    __repr__ = line()


@dataclass(frozen=True, eq=False)
class Loaded(Frozen):
    """A value under a wrench at the tool.

    Attributes:
        value: acceleration or effort, shape (n,).
        by_wrench: its derivative by force and moment, shape (n, 6).
    """

    value: Array
    by_wrench: Array

    __repr__ = line()


# long: a method a quantity of a mechanism
class CompiledMechanism(Parametrised[Model_co]):
    """What compiled chains and compiled published models have in common; a `Mechanism`."""

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions for the branch of a posture."""
        raise NotImplementedError

    def positions(self, at: Posture) -> Array:
        """The position variables of a posture."""
        raise NotImplementedError

    @property
    def task(self) -> Task:
        """See `Mechanism.task`."""
        return self.model.task

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """See `Mechanism.close`."""
        raise NotImplementedError

    def reach(
        self, target: TargetLike, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """See `Mechanism.reach`."""
        raise NotImplementedError

    def tool_by_parameters(self, at: Posture) -> Array:
        """How the tool moves with every parameter, the actuators held and the loops closed: derivatives of its position
        and the rotation vectors of its turns, in world axes, shape (6, parameters).

        Raises:
            InputError: this model does not have them.
            SingularError: too near to a singularity for derivatives of any use.
        """
        return self._parts("tool_by_parameters", at)["by_parameters"]

    def inverse_by_parameters(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """How the effort that gives an acceleration changes with every parameter, the actuated coordinates held and the
        loops closed, shape (n, parameters); errors as `tool_by_parameters`."""
        return self._parts("inverse_by_parameters", at, v, a)["by_parameters"]

    def kernel(self, what: str) -> Kernel:
        """The compiled function called `what`, on the branch of home, for use from other compiled code.

        Raises:
            UnknownNameError: there is none.
            InputError: this model does not have it.
            CompileError: it cannot be compiled.
        """
        return self.library()[what].kernel

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """See `Mechanism.tool`."""
        parts = self._call("tool", at, np.zeros(self.n) if v is None else v)
        if parts is None:
            return self.plain.tool(at, v)
        return Tool(**parts)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """See `Mechanism.terms`."""
        parts = self._call("terms", at, np.zeros(self.n) if v is None else v)
        return self.plain.terms(at, v) if parts is None else Terms(**parts)

    def potential_energy(self, at: Posture) -> float:
        """See `Mechanism.potential_energy`."""
        parts = self._call("energy", at, np.zeros(self.n))
        return self.plain.potential_energy(at) if parts is None else float(parts["potential"][0])

    @property
    def dissipates(self) -> bool:
        """See `Mechanism.dissipates`."""
        return self.model.dissipates

    def dissipation(self, at: Posture, v: npt.ArrayLike) -> float:
        """See `Mechanism.dissipation`."""
        speed = as_vector("v", v, self.n)
        return float(self.terms(at, speed).friction @ speed) if self.dissipates else self.plain.dissipation(at, speed)

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """See `Mechanism.load_effort`."""
        given = as_loads(loads)
        if any(load.link is not None for load in given):
            return self.plain.load_effort(at, given)
        tool = self.tool(at)
        return np.asarray(tool.frame_jacobian.T @ tool_wrench(given, tool, self.name))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """See `Mechanism.inverse_dynamics`."""
        if loads is not NO_LOADS:
            return self.inverse_dynamics(at, v, a) - self.load_effort(at, loads)
        parts = self._call("inverse", at, v, a)
        return self.plain.inverse_dynamics(at, v, a) if parts is None else parts["effort"]

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """See `Mechanism.forward_dynamics`."""
        if loads is not NO_LOADS:
            effort = as_vector("effort", effort, self.n) + self.load_effort(at, loads)
        parts = self._call("forward", at, v, effort)
        return self.plain.forward_dynamics(at, v, effort) if parts is None else parts["a"]

    def forward_derivatives(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Derivatives:
        """Forward dynamics with its exact derivatives.

        Raises:
            InputError: wrong shape or not finite.
            SingularError: too near to a singularity for derivatives of any use.
        """
        return self._derivatives("forward_derivatives", at, v, effort)

    def inverse_derivatives(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Derivatives:
        """Inverse dynamics with its exact derivatives; errors as `forward_derivatives`."""
        return self._derivatives("inverse_derivatives", at, v, a)

    def forward_loaded(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, wrench: npt.ArrayLike) -> Loaded:
        """Acceleration that `effort` and a wrench at the tool give, and its derivative by the wrench.

        Args:
            wrench: force [N] on the tool point, and moment [N m], along the axes of the world, shape (6,).

        Raises:
            InputError: wrong shape, not finite, or the robot has no tool.
            CompileError: friction that holds what rests.
            SingularError: as `forward_dynamics`.
        """
        parts = self._call("forward_loaded", at, v, effort, as_vector("wrench", wrench, WRENCH))
        if parts is not None:
            return Loaded(parts["a"], parts["by_wrench"])
        jacobian = self.plain.tool(at).frame_jacobian
        by_wrench = np.asarray(np.linalg.solve(self.plain.terms(at).mass, jacobian.T))
        return Loaded(self.plain.forward_dynamics(at, v, effort, _at_tool(wrench)), by_wrench)

    def inverse_loaded(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, wrench: npt.ArrayLike) -> Loaded:
        """Effort that gives the acceleration `a` against a wrench at the tool, and its derivative by the wrench; see
        `forward_loaded`."""
        parts = self._call("inverse_loaded", at, v, a, as_vector("wrench", wrench, WRENCH))
        if parts is not None:
            return Loaded(parts["effort"], parts["by_wrench"])
        jacobian = self.plain.tool(at).frame_jacobian
        return Loaded(self.plain.inverse_dynamics(at, v, a, _at_tool(wrench)), -jacobian.T)

    def _derivatives(self, what: str, at: Posture, v: npt.ArrayLike, x: npt.ArrayLike) -> Derivatives:
        value, by_q, by_v, by_input = self._parts(what, at, v, x).values()
        return Derivatives(value, by_q, by_v, by_input)

    def _parts(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> dict[str, Array]:
        """The parts of derivatives, for which the model itself cannot stand in."""
        parts = self._call(what, at, *arguments)
        if parts is None:
            for name, x in zip(self.library()[what].row.arguments[1:], arguments, strict=False):
                as_vector(name, x, self.n)
            self.plain.terms(at)
            raise SingularError(
                f"{self.name} is too near to a singularity for its derivatives: strain beyond {STRAIN_LIMIT:g}",
                kind="type-2",
                measure=0.0,
                limit=1.0 / STRAIN_LIMIT,
            )
        return parts

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> dict[str, Array] | None:
        """Parts of the result of one evaluation, or None where the compiled function must not be trusted."""
        function = self.library(at)[what]
        names = function.row.arguments[1:-1]
        given = [_fitting(x, WRENCH if name == "wrench" else self.n) for name, x in zip(names, arguments, strict=True)]
        return function(self.positions(at), *given, self._values)


def _at_tool(wrench: npt.ArrayLike) -> Load:
    force, moment = as_vector("wrench", wrench, WRENCH).reshape(2, 3)
    return Load(force, moment)


def _fitting(values: npt.ArrayLike, size: int) -> Array:
    """As a vector; what is not finite shows in the result."""
    if isinstance(values, np.ndarray) and values.shape == (size,):
        return values
    return as_vector("argument", values, size)
