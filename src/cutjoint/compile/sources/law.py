"""Control laws as expressions: a law's own `effort` is run on symbols.

No law is written twice.  The law is given a desired motion, measured coordinates and gains that are expressions, and in
place of its model one that answers with expressions:

- what it asks of the desired posture alone (gravity, inverse dynamics of the desired motion) depends on time only, so
  it becomes columns of the reference table, filled in by the law's model itself;
- what it asks of the measured posture is traced, from the plant's own state if the model is the plant's, or from a
  published model's equations.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import isfunction
from typing import NamedTuple, Protocol, TypeAlias, cast

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.functions import maximum, minimum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.sources.interface import TracedState
from cutjoint.compile.sources.law_answers import efforts_in, same, twin_of
from cutjoint.compile.sources.traced_array import Objects, numbers, traced
from cutjoint.control import GivenEfforts, Law, LawOfFunction
from cutjoint.control.law import Gain
from cutjoint.errors import InputError
from cutjoint.mechanism import JointLimits, Mechanism, is_mechanism
from cutjoint.motion import Desired


class _Place:
    """A posture while tracing: the desired or the measured one."""

    def __init__(self, q: Objects) -> None:
        self.q = q


class TracedDesired:
    """The desired motion, as columns of the reference table.

    Attributes:
        symbols, fillers: of the columns, and what fills them.
    """

    def __init__(self, graph: Graph, n: int, mechanism: Mechanism) -> None:
        self.symbols: list[Expression] = []
        self.fillers: list[Callable[[Desired], Array]] = []
        self._graph, self._known = graph, dict[tuple[str, int], Objects]()
        self.t = self.columns("t", 1, lambda desired: np.array([desired.t]))[0]
        self.q = self.columns("q", n, lambda desired: desired.q)
        self.v = self.columns("v", n, lambda desired: desired.v)
        self.a = self.columns("a", n, lambda desired: desired.a)
        self.mechanism = mechanism
        self.posture = _Place(self.q)

    def columns(self, name: str, size: int, filler: Callable[[Desired], Array], owner: int = 0) -> Objects:
        """Symbols of `size` columns that `filler` computes; asked again, the same ones."""
        key = (name, owner)
        if key not in self._known:
            made = self._graph.symbols(size)
            self.symbols += made
            self.fillers.append(filler)
            self._known[key] = traced(made)
        return self._known[key]

    def posture_of(self, model: object) -> _Place:
        """The desired posture."""
        return self.posture


class TracedModel:
    """A law's model while tracing."""

    def __init__(self, model: Mechanism, desired: TracedDesired, state: TracedState | None) -> None:
        self._model, self._desired, self._state = model, desired, state
        self.n, self.name = model.n, model.name

    def close(self, q: Objects, near: object = None, *, limits: JointLimits = "respect") -> _Place:
        """The posture at the measured or the desired coordinates, which have no limits here."""
        if q is self._desired.q:
            return self._desired.posture
        return _Place(q)

    def terms(self, at: _Place, v: Objects | None = None) -> _DesiredTerms | _MeasuredTerms:
        """The terms of the equation of motion."""
        n = self.n
        if at is self._desired.posture:
            if v is not None and v is not self._desired.v:
                raise InputError("a traced law may ask for terms of the desired posture at the desired velocity only")
            return _DesiredTerms(self._model, self._desired, moving=v is not None)
        state = self._measured()
        speed = None if v is None else numbers(v)
        moving, rubbing = ([[0.0] * n] * 2) if speed is None else (state.coriolis(speed), state.friction(speed))
        rows = traced([x for row in state.mass() for x in row]).reshape(n, n)
        return _MeasuredTerms(rows, traced(moving), traced(state.gravity()), traced(state.springs()), traced(rubbing))

    def inverse_dynamics(self, at: _Place, v: Objects, a: Objects) -> Objects:
        """Effort."""
        desired, model = self._desired, self._model
        if at is desired.posture:
            if v is not desired.v or a is not desired.a:
                raise InputError(
                    "a traced law may ask for inverse dynamics of the desired motion or of the measured one"
                )
            return desired.columns(
                "inverse_dynamics",
                self.n,
                lambda one: model.inverse_dynamics(one.posture_of(model), one.v, one.a),
                id(model),
            )
        return traced(self._measured().inverse(numbers(v), numbers(a)))

    def _measured(self) -> TracedState:
        if self._state is None:
            raise InputError(
                f"the law's model {self._model.name} is asked about the measured posture; to be compiled it must be "
                "the plant's own model or a published one, whose posture follows from the actuators alone"
            )
        return self._state


class _DesiredTerms:
    """Terms of the desired motion; only those that are read become columns, sums of them too."""

    def __init__(self, model: Mechanism, desired: TracedDesired, *, moving: bool) -> None:
        self._model, self._desired, self._moving = model, desired, moving

    def __getattr__(self, name: str) -> Objects:
        if name not in ("mass", "coriolis", "gravity", "springs", "friction", "bias", "holding"):
            raise AttributeError(f"terms of a traced law have no {name}")
        model, moving, n = self._model, self._moving, self._model.n

        def fill(one: Desired) -> Array:
            terms = model.terms(one.posture_of(model), one.v if moving else None)
            return np.ravel(getattr(terms, name))

        key = f"{name}{'' if moving else ' at rest'}"
        columns = self._desired.columns(key, n * n if name == "mass" else n, fill, id(model))
        return columns.reshape(n, n) if name == "mass" else columns


@dataclass(frozen=True, eq=False)
class _MeasuredTerms:
    """Terms of the measured motion; see `cutjoint.mechanism.Terms`."""

    mass: Objects
    coriolis: Objects
    gravity: Objects
    springs: Objects
    friction: Objects

    @property
    def bias(self) -> Objects:
        """(n,)."""
        return cast(Objects, self.coriolis + self.gravity + self.springs + self.friction)

    @property
    def holding(self) -> Objects:
        """(n,)."""
        return cast(Objects, self.gravity + self.springs)


class _SymbolicLaw(Protocol):
    """A law whose gains and models are symbols; see `Law`."""

    def effort(self, desired: TracedDesired, q: Objects, v: Objects, memory: Objects) -> object: ...
    def memory_rate(self, desired: TracedDesired, q: Objects, v: Objects, asked: Objects, given: Objects) -> object: ...


_Ask: TypeAlias = Callable[[TracedDesired, Objects, Objects, Objects], object]
_Kept: TypeAlias = Callable[[], list[object]]


class TracedAnswer(NamedTuple):
    """What a law answers: the effort that it asks for, the same after saturation, length n each, and the rate of its
    memory."""

    asked: list[Number]
    given: list[Number]
    memory_rate: list[Number]


def trace_law(
    law: Law,
    desired: TracedDesired,
    q: Sequence[Number],
    v: Sequence[Number],
    memory: Sequence[Expression],
    gains: Mapping[str, Sequence[Expression]],
    saturated: Callable[[Objects], Objects],
    measured: Callable[[Mechanism], TracedState | None],
) -> TracedAnswer:
    """Run a law on symbols.

    Args:
        law: the law.
        desired: the reference.
        q, v: actuated coordinates and velocities as they are measured.
        memory: the law's own.
        gains: gains that are arguments, one number an actuator each; the others are constants.
        saturated: efforts that are asked for -> those within their limits.
        measured: the measured state as a model of the law sees it, or None where the model cannot follow it.

    Raises:
        InputError: the law does something that cannot be traced, has no such gain, or answers differently when it is
            asked the same again.
    """

    def symbolic(name: str, value: object) -> object:
        if isinstance(value, Gain):
            return _gain(gains.get(name), value)
        return TracedModel(value, desired, measured(value)) if is_mechanism(value) else value

    twin = cast(_SymbolicLaw, twin_of(law, symbolic))
    known = [name for name, value in vars(law).items() if isinstance(value, Gain)]
    for name in gains:
        if name not in known:
            raise InputError(f"controller '{law.name}' has no gain {name} to vary; it has {', '.join(known) or 'none'}")
    place, speed, own = traced(q), traced(v), traced(memory)
    try:
        ask, kept = _asking(law, twin, symbolic)
        before, later = kept(), copy.copy(desired)
        later.t = desired.t + 1.0
        asked, _, again = (
            objects(efforts_in(ask(now, place, speed, own), len(q))) for now in (desired, later, desired)
        )
        if not (all(map(same, asked, again)) and all(one is other for one, other in zip(before, kept(), strict=False))):
            raise InputError(
                "it keeps something from call to call or draws numbers; a law's own states are its memory (see "
                "cutjoint.control.Law), noise is the hardware's; as it is it runs with cutjoint.simulation.run"
            )
        given = saturated(asked)
        rate = numbers(twin.memory_rate(desired, place, speed, traced(asked.tolist()), traced(given.tolist())))
    except (InputError, TypeError, AttributeError, ValueError, IndexError) as error:
        raise InputError(f"controller '{law.name}' cannot be compiled: {error}") from error
    return TracedAnswer(list(asked), list(given), rate)


def _asking(law: Law, twin: _SymbolicLaw, symbolic: Callable[[str, object], object]) -> tuple[_Ask, _Kept]:
    """What gives a law's answer, and what it could keep from one to the next."""
    if isinstance(law, GivenEfforts):
        given = cast(Callable[[object], object], law.efforts)
        return (lambda desired, q, v, memory: given(desired.t)), list
    if not isinstance(law, LawOfFunction):
        return twin.effort, lambda: list(vars(twin).values())
    called: object = law.function
    if isfunction(called):
        cells = called.__closure__ or ()
        kept: _Kept = lambda: [one.cell_contents for one in cells]  # noqa: E731
    else:  # called like a function, with gains and models of its own
        called = twin_of(called, symbolic)
        kept = lambda: list(getattr(called, "__dict__", {}).values())  # noqa: E731
    function = cast(Callable[..., object], called)
    return (lambda desired, q, v, memory: function(desired.t, desired, q, v)), kept


def clipped(limits: Array | None) -> Callable[[Objects], Objects]:
    """Saturation at the largest |efforts| `limits`, shape (n,), or none."""
    if limits is None:
        return lambda asked: asked
    top = limits.tolist()
    return lambda asked: objects([maximum(-most, minimum(most, x)) for x, most in zip(asked, top, strict=True)])


def _gain(symbols: Sequence[Expression] | None, gain: Gain) -> Gain | Callable[[Objects], Objects]:
    if symbols is None:
        return gain
    row = traced(symbols)
    return lambda error: row * error


def objects(values: Sequence[Number]) -> Objects:
    """Expressions and numbers as an array."""
    made = np.empty(len(values), dtype=object)
    made[:] = list(values)
    return made
