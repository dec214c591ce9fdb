"""Compiled mechanisms: the same interface and answers as the model they were made from, from straight-line code.

Every evaluation returns its strain (`cutjoint.compile.reduction`).  Where it exceeds the limit, or anything is not a
finite number, the compiled answer is thrown away and the model itself is asked, which either has the right number or
raises its own error.  So there is no wrong number in between, and errors are those of the model.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.compile.batch import Batch
from cutjoint.compile.chain_trace import PAYLOAD, ChainSource
from cutjoint.compile.kernels import BUILDERS, CHAIN_ONLY, PAPER_ONLY
from cutjoint.compile.library import Library, Made
from cutjoint.compile.native import Kernel
from cutjoint.compile.once import once
from cutjoint.compile.paper_trace import PaperModel, PaperSource
from cutjoint.compile.reduction import STRAIN_LIMIT
from cutjoint.compile.verify import checker
from cutjoint.description.model import Inertial
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
        return self.plain.inverse_dynamics(at, v, a) if y is None else _frozen(y[:-1])

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """See `Mechanism.forward_dynamics`."""
        y = self._call("forward", at, v, effort)
        return self.plain.forward_dynamics(at, v, effort) if y is None else _frozen(y[:-1])

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


def _frozen(values: Array) -> Array:
    values.setflags(write=False)
    return values


class CompiledChain(CompiledMechanism):
    """A closed chain, compiled.

    Args:
        chain: the chain (`cutjoint.chain.ClosedChain`).
        options: how to compile.

    Raises:
        InputError, UnknownNameError: parameters that the chain does not have.

    Functions are traced and compiled when first used; `kernel` makes one at once.
    """

    def __init__(self, chain: Any, options: Options | None = None) -> None:
        options = Options() if options is None else options
        self.source = ChainSource(chain, options.parameters)
        nominal = np.array(
            [0.0 if name == PAYLOAD else self._mass(chain, name) for name in options.parameters], dtype=np.float64
        )
        super().__init__(chain, options, nominal, nominal)
        self.chain = chain
        self._library = Library(
            self.source,
            checker(self.source, chain, nominal),
            fast=options.fast,
            cached=options.cached,
            report=options.report,
        )

    @staticmethod
    def _mass(chain: Any, link: str) -> float:
        inertial = chain.description.link(link).inertial
        return float(inertial.mass)

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions; they hold on every branch."""
        return self._library

    def positions(self, at: Posture) -> Array:
        """The full configuration."""
        return at.q_full

    def _rebuilt(self, parameters: Mapping[str, float]) -> Mechanism:
        from cutjoint.chain import ClosedChain

        description = self.chain.description
        for name, mass in parameters.items():
            if name == PAYLOAD:
                continue
            old = description.link(name).inertial
            scaled = Inertial(mass, old.com, old.inertia * (mass / old.mass))
            description = description.with_inertial(name, scaled)
        if PAYLOAD in parameters:
            description = description.with_payload(parameters[PAYLOAD])
        made: Mechanism = ClosedChain(description)
        return made

    def with_payload(self, mass: float) -> CompiledChain:
        """The same robot with a further point mass [kg] at the tool point.  Compiled anew unless `payload` is an
        argument.

        Raises:
            InputError: no tool, or not a mass.
        """
        if PAYLOAD in self.options.parameters:
            self.chain.description.with_payload(mass)
            return self.with_parameters(**{PAYLOAD: self.parameters[PAYLOAD] + mass})
        return CompiledChain(self.chain.with_payload(mass), self.options)

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `ClosedChain.close`.  Steps that are long against the links are left to the chain's own continuation."""
        target = as_vector("q", q, self.n)
        found = self._newton(self._start(near), target) if self.source.determined else None
        return self.chain.close(target, near) if found is None else found

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See `ClosedChain.reach`.  Targets that are far away are left to the chain's own continuation."""
        target = as_vector("p", p, 3, "m")
        n = self.n
        if 0 < n <= 3 and self.source.has_tool and self.source.determined:
            at: Posture | None = self.home if near is None else near
            far = np.inf
            # what is left of the digits of a position, where the robot is and in its own size
            rounding = 4e-15 * max(self.chain.length, float(np.abs(target).max()))
            for _ in range(NEWTON_STEPS):
                assert at is not None
                y = self._call("tool", at, np.zeros(n))
                if y is None:
                    break
                miss = target - y[:3]
                size = float(np.abs(miss).max())
                if size < rounding or (size < 100.0 * rounding and size > 0.1 * far):
                    return at
                if size > 0.5 * far or size > 0.2 * self.chain.length:
                    break
                far = size
                jacobian = y[3 : 3 + 3 * n].reshape(3, n)
                try:
                    # with fewer motors than directions a target is on the tool's surface or curve, or is not reached
                    square = n == 3
                    move = np.linalg.solve(jacobian, miss) if square else np.linalg.lstsq(jacobian, miss, rcond=None)[0]
                except np.linalg.LinAlgError:  # the tool cannot move in some direction here
                    break
                at = self._newton(at.q_full, at.q + move)
                if at is None:
                    break
        found: Posture = self.chain.reach(target, near)
        return found

    def _start(self, near: Posture | None) -> Array:
        q = self.home.q_full if near is None else near.q_full
        if q.shape != (self.chain.nq,):
            raise InputError(
                f"this posture has {q.size} coordinates, {self.chain.name} has {self.chain.nq}; make it with this "
                "robot's "
                "close() or reach()"
            )
        return q

    def _newton(self, q: Array, target: Array) -> Posture | None:
        """Newton's method by the compiled step; None where it is not plainly on the same branch."""
        step = self._library["step"]
        rows = step.program.result_slice("residual")
        nq = self.chain.nq
        last, worst = np.inf, np.inf
        for count in range(NEWTON_STEPS):
            y = step(q, target, self._values)
            if not (y[-1] <= STRAIN_LIMIT and np.isfinite(y.sum())):
                return None
            size = float(np.abs((y[:nq] - q) / self._q_scale).max(initial=0.0))
            open_by = float(np.abs(y[rows] * self._row_scale).max(initial=0.0))
            if count and (open_by < 1e-15 or (open_by < tolerances.CLOSURE.value and open_by > 0.1 * worst)):
                gap = np.abs(y[rows])
                lengths = self._is_length
                pair = float(gap[lengths].max(initial=0.0)), float(gap[~lengths].max(initial=0.0))
                return Posture(q[list(self.source.actuated)], q, pair)
            if size > (tolerances.STRIDE.value if count == 0 else 0.5 * last + 1e-9):
                return None
            last, worst = size, open_by
            q = y[:nq]
        return None

    @once
    def _is_length(self) -> npt.NDArray[np.bool_]:
        return np.array(self.source.row_is_length, dtype=bool)

    @once
    def _row_scale(self) -> Array:
        """What makes the loops' rows dimensionless."""
        return np.where(self._is_length, 1.0 / self.chain.length, 1.0)

    @once
    def _q_scale(self) -> Array:
        """Configuration coordinates that are lengths, in robot lengths."""
        return np.array(self.source.position_scale)

    @property
    def idle_is_cyclic(self) -> bool:
        """See `ClosedChain.idle_is_cyclic`: whether the actuated coordinates tell the whole motion."""
        return bool(getattr(self.chain, "idle_is_cyclic", True))

    def mobility(self, at: Posture | None = None) -> Any:
        """See `ClosedChain.mobility`."""
        return self.chain.mobility(at)

    # -- full coordinates --------------------------------------------------------------------------------------------

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n); errors as `ClosedChain.tangent`."""
        y = self._call("tangent", at)
        if y is None or not self.source.determined:
            return np.asarray(self.chain.tangent(at))
        return _frozen(y[:-1].reshape(self.chain.nv, self.n))

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.tangent(at) @ as_vector("v", v, self.n)

    def full_acceleration(self, q_full: Array, v_full: Array, effort_full: Array) -> Array:
        """Acceleration of all joints at a closed configuration, for any actuation, shape (nv,); see
        `ClosedChain.full_acceleration`."""
        if not self.source.weightless:
            y = self._library["full_forward"](q_full, v_full, effort_full, self._values)
            if y[-1] <= STRAIN_LIMIT and np.isfinite(y.sum()):
                return y[:-1]
        plain: Any = self.plain
        return np.asarray(plain.full_forward_dynamics(q_full, v_full, effort_full).acceleration)

    def _call(self, what: str, at: Posture, *arguments: npt.ArrayLike) -> Array | None:
        if not self.source.determined:
            return None
        if at.q_full.shape != (self.chain.nq,):
            self._start(at)
        return super()._call(what, at, *arguments)

    def _derivatives(self, what: str, at: Posture, v: npt.ArrayLike, x: npt.ArrayLike) -> Derivatives:
        self.source.need_actuated()
        return super()._derivatives(what, at, v, x)


class CompiledPaper(CompiledMechanism):
    """A published model, compiled from its own equations.  Each branch is compiled when first used.

    Args:
        model: the published model.
        options: how to compile.

    Raises:
        UnknownNameError: parameters that the model does not have.
    """

    def __init__(self, model: PaperModel, options: Options | None = None) -> None:
        options = Options() if options is None else options
        nominal = np.array(
            [0.0 if name == PAYLOAD else getattr(model.parameters, name, 0.0) for name in options.parameters],
            dtype=np.float64,
        )
        super().__init__(model, options, nominal, nominal)
        self.paper = model
        self.source = PaperSource(model, options.parameters)
        self._libraries: dict[Any, Library] = {}
        self._making = threading.Lock()

    def library(self, at: Posture | None = None) -> Library:
        """The compiled functions for the branch of `at` (default: of home)."""
        branch = self.source.branch if at is None else self.paper.branch(at)
        found = self._libraries.get(branch)
        if found is not None:
            return found
        with self._making:
            found = self._libraries.get(branch)
            if found is not None:
                return found
            source = PaperSource(self.paper, self.options.parameters, branch)
            on_branch = self.paper
            if branch != self.source.branch:
                signs: Any = getattr(branch, "signs", branch)
                on_branch = self._made(self.paper.parameters, signs)
            found = self._libraries[branch] = Library(
                source,
                checker(source, on_branch, self._nominal),
                fast=self.options.fast,
                cached=self.options.cached,
                report=self.options.report,
            )
        return found

    def positions(self, at: Posture) -> Array:
        """The actuated coordinates."""
        return at.q

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See the published model; closed form, so there is nothing to compile."""
        return self.plain.close(q, near)

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """See the published model; closed form, so there is nothing to compile."""
        return self.plain.reach(p, near)

    def _made(self, parameters: Any, signs: Sequence[int]) -> PaperModel:
        """A model of the same kind."""
        kind: Any = type(self.paper)
        made: PaperModel = kind(parameters, signs)
        return made

    def _rebuilt(self, parameters: Mapping[str, float]) -> Mechanism:
        own: Any = self.paper.parameters
        changed = replace(own, **{name: value for name, value in parameters.items() if name != PAYLOAD})
        made = self._made(changed, self.paper.signs)
        return made.with_payload(parameters[PAYLOAD]) if parameters.get(PAYLOAD) else made

    def with_payload(self, mass: float) -> CompiledPaper:
        """The same robot carrying `mass` [kg] more.  Compiled anew unless `payload` is an argument."""
        if PAYLOAD in self.options.parameters:
            self.paper.with_payload(mass)
            return self.with_parameters(**{PAYLOAD: self.parameters[PAYLOAD] + mass})
        return CompiledPaper(self.paper.with_payload(mass), self.options)


def _restored(kind: Any, model: Mechanism, options: Options, values: Array) -> CompiledMechanism:
    """A compiled mechanism that was pickled."""
    made: CompiledMechanism = kind(model, options)
    return made.with_parameters(**dict(zip(options.parameters, values.tolist(), strict=True)))


Compiled = CompiledChain | CompiledPaper


def compiled(
    model: Any,
    *,
    parameters: Sequence[str] = (),
    fast: bool = False,
    cached: bool = True,
    report: Callable[[Made], None] | None = None,
) -> Compiled:
    """A closed chain or published model, compiled.

    Args:
        model: a `ClosedChain` or a published model.
        parameters: inertial parameters that stay arguments: `payload`, for a chain also names of links (their masses
            [kg]), for a published model also fields of its parameters.
        fast: allow fast-math.
        cached: use the cache folder.
        report: called with every function that was made.

    Raises:
        InputError: neither of the two.
        UnknownNameError: parameters that the model does not have.
    """
    options = Options(tuple(parameters), fast, cached, report)
    if isinstance(model, PaperModel):
        return CompiledPaper(model, options)
    if hasattr(model, "full_forward_dynamics") and hasattr(model, "description"):
        return CompiledChain(model, options)
    raise InputError(
        f"only closed chains and published models with closed forward kinematics can be compiled, found "
        f"{type(model).__name__}; compile the robot's closed chain"
    )


def functions_of(mechanism: Compiled) -> tuple[str, ...]:
    """Names of the functions that a compiled mechanism can have (see `CompiledMechanism.kernel`)."""
    if isinstance(mechanism, CompiledPaper):
        return tuple(name for name in BUILDERS if name not in CHAIN_ONLY)
    source = mechanism.source
    if not source.determined:
        return ("full_forward",)
    missing = {*PAPER_ONLY, *(() if source.has_tool else ("tool",)), *(("full_forward",) if source.weightless else ())}
    return tuple(name for name in BUILDERS if name not in missing)
