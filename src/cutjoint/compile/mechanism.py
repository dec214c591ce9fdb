"""Compiled mechanisms: the same interface and answers as the model they were made from, from straight-line code.

Every evaluation returns its strain (`cutjoint.compile.equations.reduction`).  Where it exceeds the limit, or anything
is not a finite number, the compiled answer is thrown away and the model itself is asked, which either has the right
number or raises its own error.  So there is no wrong number in between, and errors are those of the model.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.compile.batch import Batch
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library, Made
from cutjoint.compile.machine.llvm.native import Kernel
from cutjoint.compile.once import once
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Actuator, Mechanism, Posture, Terms, Tool

NOTHING: Array = readonly(np.zeros(0))
NEWTON_STEPS = 8


@dataclass(frozen=True, eq=False)
class Derivatives:
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

    def __post_init__(self) -> None:
        for name in ("value", "by_q", "by_v", "by_input"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __reduce__(self) -> Any:
        return Derivatives, (self.value, self.by_q, self.by_v, self.by_input)


@dataclass(frozen=True)
class Options:
    """How to compile.

    Attributes:
        parameters: inertial parameters that stay arguments (see `ChainSource`, `PaperSource`).
        fast: let the compiler reassociate sums (fast-math): a little quicker, other digits in the last places.
        cached: use the cache folder.
        report: called with every function that was made.
    """

    parameters: tuple[str, ...] = ()
    fast: bool = False
    cached: bool = True
    report: Callable[[Made], None] | None = None


class CompiledMechanism:
    """What compiled chains and compiled published models have in common; a `Mechanism`."""

    def __init__(self, model: Mechanism, options: Options, values: Array, nominal: Array) -> None:
        self.model, self.options = model, options
        self._values, self._nominal = readonly(values), readonly(nominal)
        self._lock = threading.RLock()

    def __reduce__(self) -> Any:
        # machine code stays behind, and so does whoever is told of functions that are made
        return _restored, (type(self), self.model, replace(self.options, report=None), self._values)

    @property
    def name(self) -> str:
        """Name of the model."""
        return f"{self.model.name}, compiled"

    @property
    def n(self) -> int:
        """Number of actuated coordinates."""
        return self.model.n

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """The actuated joints."""
        return self.model.actuators

    @property
    def home(self) -> Posture:
        """Home posture of the model."""
        return self.model.home

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the inertial parameters that are arguments [kg]."""
        return dict(zip(self.options.parameters, self._values.tolist(), strict=True))

    @once
    def batch(self) -> Batch:
        """The same on many states at once."""
        return Batch(self)

    @property
    def plain(self) -> Mechanism:
        """The model that is not compiled, with the present parameters."""
        if np.array_equal(self._values, self._nominal):
            return self.model
        return self._plain_with_values

    @once
    def _plain_with_values(self) -> Mechanism:
        return self._rebuilt(self.parameters)

    def _rebuilt(self, parameters: Mapping[str, float]) -> Mechanism:
        raise AssertionError

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions for the branch of a posture."""
        raise AssertionError

    def positions(self, at: Posture) -> Array:
        """The position variables of a posture."""
        raise AssertionError

    def kernel(self, what: str) -> Kernel:
        """The compiled function called `what`, on the branch of home, for use from other compiled code.

        Raises:
            UnknownNameError: there is none.
            InputError: this model does not have it.
            CompileError: it cannot be compiled.
        """
        return self.library()[what]

    def with_parameters(self, **values: float) -> Self:
        """The same compiled code with other values of the parameters that are arguments; nothing is compiled.

        Raises:
            UnknownNameError: one of them is not an argument.
            InputError: not a finite mass >= 0.
        """
        changed = np.array(self._values)
        for name, value in values.items():
            if name not in self.options.parameters:
                raise UnknownNameError("parameter of the compiled functions", name, self.options.parameters)
            if not np.isfinite(value):
                raise InputError(f"parameter {name} must be a finite number, found {value!r}")
            changed[self.options.parameters.index(name)] = value
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._lock = threading.RLock()
        for cached in ("batch", "_plain_with_values"):
            other.__dict__.pop(cached, None)
        other._values = readonly(changed)
        return other

    # -- the mechanism -----------------------------------------------------------------------------------------------

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """See `Mechanism.tool`."""
        y = self._call("tool", at, np.zeros(self.n) if v is None else v)
        if y is None:
            return self.plain.tool(at, v)
        n = self.n
        return Tool(y[:3], y[3 : 3 + 3 * n].reshape(3, n), np.zeros(3) if v is None else y[3 + 3 * n : 6 + 3 * n])

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """See `Mechanism.terms`."""
        y = self._call("terms", at, np.zeros(self.n) if v is None else v)
        if y is None:
            return self.plain.terms(at, v)
        n = self.n
        square = n * n
        return Terms(y[:square].reshape(n, n), y[square : square + n], y[square + n : square + 2 * n])

    def potential_energy(self, at: Posture) -> float:
        """See `Mechanism.potential_energy`."""
        y = self._call("energy", at, np.zeros(self.n))
        return self.plain.potential_energy(at) if y is None else float(y[1])

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """See `Mechanism.inverse_dynamics`."""
        y = self._call("inverse", at, v, a)
        return self.plain.inverse_dynamics(at, v, a) if y is None else frozen(y[:-1])

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """See `Mechanism.forward_dynamics`."""
        y = self._call("forward", at, v, effort)
        return self.plain.forward_dynamics(at, v, effort) if y is None else frozen(y[:-1])

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
        y = self._call(what, at, v, x)
        if y is None:
            from cutjoint.errors import SingularError

            as_vector("v", v, self.n)
            as_vector("effort" if what == "forward_derivatives" else "a", x, self.n)
            self.plain.terms(at)
            raise SingularError(
                f"{self.name} is too near to a singularity for its derivatives: strain beyond {STRAIN_LIMIT:g}",
                kind="type-2",
                measure=0.0,
                limit=1.0 / STRAIN_LIMIT,
            )
        n = self.n
        parts = [y[n + k * n * n : n + (k + 1) * n * n].reshape(n, n) for k in range(3)]
        return Derivatives(y[:n], *parts)

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> Array | None:
        """One evaluation, or None where the compiled function must not be trusted."""
        given = [_fitting(x, self.n) for x in arguments]
        y = self.library(at)[what](self.positions(at), *given, self._values)
        # a sum is finite only if all its terms are; the strain stands last
        return y if y[-1] <= STRAIN_LIMIT and np.isfinite(y.sum()) else None


def _fitting(values: npt.ArrayLike, size: int) -> Array:
    """As a vector; what is not finite shows in the result."""
    if isinstance(values, np.ndarray) and values.shape == (size,):
        return values
    return as_vector("argument", values, size)


def frozen(values: Array) -> Array:
    """The same array, read-only."""
    values.setflags(write=False)
    return values


def _restored(kind: Any, model: Mechanism, options: Options, values: Array) -> CompiledMechanism:
    """A compiled mechanism that was pickled."""
    made: CompiledMechanism = kind(model, options)
    return made.with_parameters(**dict(zip(options.parameters, values.tolist(), strict=True)))
