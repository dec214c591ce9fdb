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
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.parameters import Model_co, Parametrised
from cutjoint.errors import SingularError
from cutjoint.mechanism import Posture, Terms, Tool


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


class CompiledMechanism(Parametrised[Model_co]):
    """What compiled chains and compiled published models have in common; a `Mechanism`."""

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions for the branch of a posture."""
        raise NotImplementedError

    def positions(self, at: Posture) -> Array:
        """The position variables of a posture."""
        raise NotImplementedError

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `Mechanism.close`."""
        raise NotImplementedError

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `Mechanism.reach`."""
        raise NotImplementedError

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
        if v is None:
            parts["drift"] = np.zeros(3)
        return Tool(**parts)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """See `Mechanism.terms`."""
        parts = self._call("terms", at, np.zeros(self.n) if v is None else v)
        return self.plain.terms(at, v) if parts is None else Terms(**parts)

    def potential_energy(self, at: Posture) -> float:
        """See `Mechanism.potential_energy`."""
        parts = self._call("energy", at, np.zeros(self.n))
        return self.plain.potential_energy(at) if parts is None else float(parts["potential"][0])

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """See `Mechanism.inverse_dynamics`."""
        parts = self._call("inverse", at, v, a)
        return self.plain.inverse_dynamics(at, v, a) if parts is None else parts["effort"]

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """See `Mechanism.forward_dynamics`."""
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

    def _derivatives(self, what: str, at: Posture, v: npt.ArrayLike, x: npt.ArrayLike) -> Derivatives:
        parts = self._call(what, at, v, x)
        if parts is None:
            as_vector("v", v, self.n)
            as_vector(self.library()[what].row.arguments[2], x, self.n)
            self.plain.terms(at)
            raise SingularError(
                f"{self.name} is too near to a singularity for its derivatives: strain beyond {STRAIN_LIMIT:g}",
                kind="type-2",
                measure=0.0,
                limit=1.0 / STRAIN_LIMIT,
            )
        value, by_q, by_v, by_input = parts.values()
        return Derivatives(value, by_q, by_v, by_input)

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> dict[str, Array] | None:
        """Parts of the result of one evaluation, or None where the compiled function must not be trusted."""
        given = [_fitting(x, self.n) for x in arguments]
        return self.library(at)[what](self.positions(at), *given, self._values)


def _fitting(values: npt.ArrayLike, size: int) -> Array:
    """As a vector; what is not finite shows in the result."""
    if isinstance(values, np.ndarray) and values.shape == (size,):
        return values
    return as_vector("argument", values, size)
