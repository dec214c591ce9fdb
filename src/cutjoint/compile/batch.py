"""Compiled mechanisms on many states at once: arrays of shape (N, n) in, arrays out.

States stand side by side in the vector registers, and blocks of them go to all cores.  Rows whose compiled evaluation
must not be trusted (see `cutjoint.compile.mechanism`) are asked of the model one by one, so an error is the model's
own; it carries a note that names the row.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.compile.functions.sample import nearest_turn
from cutjoint.compile.mechanism import WRENCH, CompiledMechanism
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Load, Mechanism, Posture
from cutjoint.reprs import line, told

Answer = TypeVar("Answer")
Given = Mapping[str, npt.ArrayLike] | None
"""Values of parameters by name."""
Slow = Callable[[Mechanism, Posture, Mapping[str, Array]], Mapping[str, Array]]
"""(model, posture, arguments) -> parts of the result, as the model itself gives them."""


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Tools(NamedTuple):
    """Kinematics of the tool at N states, see `cutjoint.mechanism.Tool`.

    Attributes:
        position: shape (N, 3), [m].
        rotation: shape (N, 3, 3).
        frame_jacobian: shape (N, 6, n).
        frame_drift, twist: shape (N, 6); without velocities zero.
    """

    position: Array
    rotation: Array
    frame_jacobian: Array
    frame_drift: Array
    twist: Array

    def __repr__(self) -> str:
        return told(self, position="m")

    @property
    def jacobian(self) -> Array:
        """Of the tool point, shape (N, 3, n)."""
        return self.frame_jacobian[:, :3]

    @property
    def drift(self) -> Array:
        """Of the tool point, shape (N, 3), [m/s2]."""
        return self.frame_drift[:, :3]


class ManyTerms(NamedTuple):
    """The equation of motion at N states, see `cutjoint.mechanism.Terms`.

    Attributes:
        mass: shape (N, n, n).
        coriolis, gravity, springs, friction: shape (N, n).
    """

    mass: Array
    coriolis: Array
    gravity: Array
    springs: Array
    friction: Array

    def __repr__(self) -> str:
        efforts = dict.fromkeys(("coriolis", "gravity", "springs", "friction"), "N or N m")
        return told(self, mass="kg, kg m or kg m2", **efforts)


class Batch:
    """Many states of one compiled mechanism.

    `Q` holds actuated coordinates, shape (N, n), on the branch of home; or, quicker because nothing has to be closed,
    what `close` or `reach` returned, shape (N, positions).  `V`, `A` and `effort` have shape (N, n), or (n,) for all
    rows. `parameters` gives the parameters that are arguments: name -> one number or N of them, and what names several
    numbers -> those along the last axis.  Where N values of a parameter are given, `Q` may be one row for all.
    """

    positions: int
    """Position variables of a state: full configuration of a chain, actuated coordinates of a published model."""

    __repr__ = line("n", "threads")

    def __init__(self, mechanism: CompiledMechanism[Mechanism]) -> None:
        self._mechanism, self.n, self.threads = mechanism, mechanism.n, cores()

    def close(self, q: npt.ArrayLike, parameters: Given = None) -> Array:
        """Closed positions, shape (N, positions), for actuated coordinates (N, n), or (n,) for N values of a parameter.

        Raises:
            InputError: wrong shape, or not an argument.
            ClosureError, SingularError: a row cannot be closed; a note names it.
        """
        raise NotImplementedError

    def reach(self, targets: npt.ArrayLike, parameters: Given = None) -> Array:
        """Closed positions, shape (N, positions), with the tool at N targets, on the branch of home.

        Args:
            targets: points (N, 3) [m], or poses (N, 7) (x y z qx qy qz qw) or (N, 4, 4).

        Raises:
            InputError: wrong shape, no target of this robot, or the robot has no tool.
            UnreachableError, ClosureError, SingularError: a row cannot be reached; a note names it.
        """
        raise NotImplementedError

    def reached(self, targets: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Closed positions as of `reach`, shape (N, positions), NaN where the compiled equations do not find any; and
        which rows they find, shape (N,).  No error says why a row is missing.

        Args:
            targets: as of `reach`.

        Raises:
            InputError: wrong shape, no target of this robot, or the robot has no tool.
        """
        raise NotImplementedError

    def _posture(self, model: Mechanism, positions: Array) -> Posture:
        """A row as a posture of a model."""
        raise NotImplementedError

    def tool(self, q: npt.ArrayLike, v: npt.ArrayLike | None = None, parameters: Given = None) -> Tools:
        """Tool poses, Jacobians, drifts and twists."""
        given = {"v": np.zeros(self.n) if v is None else v}
        return Tools(**self._run("tool", q, given, parameters, lambda model, at, x: vars(model.tool(at, x["v"]))))

    def terms(self, q: npt.ArrayLike, v: npt.ArrayLike | None = None, parameters: Given = None) -> ManyTerms:
        """The equation of motion; without velocities Coriolis vectors and friction are zero."""
        given = {"v": np.zeros(self.n) if v is None else v}
        return ManyTerms(**self._run("terms", q, given, parameters, lambda model, at, x: vars(model.terms(at, x["v"]))))

    def inverse_dynamics(
        self,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        a: npt.ArrayLike,
        parameters: Given = None,
        wrench: npt.ArrayLike | None = None,
    ) -> Array:
        """Efforts, shape (N, n), with a `wrench` at the tool, shape (N, 6) or (6,); see `forward_loaded`, and for
        errors the mechanism's own `inverse_dynamics`."""

        def slow(model: Mechanism, at: Posture, x: Mapping[str, Array]) -> Mapping[str, Array]:
            loads = [Load(x["wrench"][:3], x["wrench"][3:])] if "wrench" in x else ()
            return {"effort": model.inverse_dynamics(at, x["v"], x["a"], loads)}

        given = {"v": v, "a": a}
        if wrench is None:
            return self._run("inverse", q, given, parameters, slow)["effort"]
        return self._run("inverse_loaded", q, given | {"wrench": wrench}, parameters, slow)["effort"]

    def forward_dynamics(
        self,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        effort: npt.ArrayLike,
        parameters: Given = None,
        wrench: npt.ArrayLike | None = None,
    ) -> Array:
        """Accelerations, shape (N, n), with a `wrench` at the tool, shape (N, 6) or (6,); see `forward_loaded`, and for
        errors the mechanism's own `forward_dynamics`."""

        def slow(model: Mechanism, at: Posture, x: Mapping[str, Array]) -> Mapping[str, Array]:
            loads = [Load(x["wrench"][:3], x["wrench"][3:])] if "wrench" in x else ()
            return {"a": model.forward_dynamics(at, x["v"], x["effort"], loads)}

        given = {"v": v, "effort": effort}
        if wrench is None:
            return self._run("forward", q, given, parameters, slow)["a"]
        return self._run("forward_loaded", q, given | {"wrench": wrench}, parameters, slow)["a"]

    # -- inside ------------------------------------------------------------------------------------------------------

    def closed_positions(self, q: npt.ArrayLike, parameters: Given = None) -> Array:
        """`q` as position variables, closed where it holds actuated coordinates only."""
        given = np.asarray(q, dtype=np.float64)
        if given.ndim == 2 and given.shape[1] == self.positions:
            return np.ascontiguousarray(given)
        return self.close(given, parameters)

    def _values(self, given: Given, count: int | None = None) -> Array:
        """Values of the parameters: one row for all, or one row each."""
        names = self._mechanism.options.parameters
        own = np.array([self._mechanism.parameters[name] for name in names], dtype=np.float64)
        columns = self._mechanism.arrays(given) if given else {}
        sizes = {len(one) for one in columns.values() if one.ndim == 1}
        rows = count if count is not None else next(iter(sizes), None)
        wrong = [name for name, one in columns.items() if one.ndim > 1 or (one.ndim and one.shape != (rows,))]
        if wrong:
            shape = columns[wrong[0]].shape
            raise InputError(f"parameter {wrong[0]} must be one number or {rows} of them, found shape {shape}")
        values = own if rows is None or not columns else np.tile(own, (rows, 1))
        for name, one in columns.items():
            values[..., names.index(name)] = one
        return np.ascontiguousarray(values)

    def _rows(self, name: str, q: npt.ArrayLike, parameters: Given) -> tuple[Array, Array]:
        """Actuated coordinates (N, n) and values of the parameters; one row of either stands for all."""
        given = np.asarray(q, dtype=np.float64)
        values = self._values(parameters, None if given.ndim == 1 else len(given))
        if given.shape == (self.n,) and values.ndim == 2:
            given = np.tile(given, (len(values), 1))
        return rows_of(name, given, self.n), values

    def _model(self, values: Array, k: int) -> Mechanism:
        """The model that is not compiled, with the values of a row."""
        row = values if values.ndim == 1 else values[k]
        names = self._mechanism.options.parameters
        return self._mechanism.with_parameters(dict(zip(names, row.tolist(), strict=True))).plain

    def _run(
        self,
        what: str,
        q: npt.ArrayLike,
        arguments: Mapping[str, npt.ArrayLike],
        parameters: Given,
        slow: Slow,
    ) -> dict[str, Array]:
        """The parts of the results of a function, a row a state."""
        function = self._mechanism.library()[what]
        positions = self.closed_positions(q, parameters)
        count = len(positions)
        wide = {"wrench": WRENCH}
        given = {name: rows_of(name, x, wide.get(name, self.n), count) for name, x in arguments.items()}
        values = self._values(parameters, count)
        parts, good = function.batch([positions, *given.values(), values], self.threads)

        def answer(k: int) -> Mapping[str, Array]:
            model = self._model(values, k)
            row = {name: x[k] if x.ndim > 1 else x for name, x in given.items()}
            return slow(model, self._posture(model, positions[k]), row)

        for row in np.flatnonzero(~good).tolist():
            for name, value in asked(row, answer).items():
                parts[name][row] = value
        return parts


class PaperBatch(Batch):
    """Many states of a published model, whose kinematics are in closed form."""

    def __init__(self, mechanism: CompiledMechanism[Mechanism]) -> None:
        super().__init__(mechanism)
        self.positions = self.n

    def close(self, q: npt.ArrayLike, parameters: Given = None) -> Array:
        return self._rows("q", q, parameters)[0]

    def reach(self, targets: npt.ArrayLike, parameters: Given = None) -> Array:
        given, model = targets_of(targets), self._mechanism
        values = self._values(parameters, len(given))
        if given.shape[1:] != (3,):
            rows = range(len(given))
            return np.array([asked(k, lambda k: self._model(values, k).reach(given[k])).q for k in rows])
        target = given
        parts, trusted = model.library()["reach"].batch([target, values], self.threads)
        q = nearest_turn(parts["q_reached"], model.home.q, [one.kind == "rotation" for one in model.actuators])
        for row in np.flatnonzero(~trusted).tolist():
            q[row] = asked(row, lambda k: self._model(values, k).reach(target[k])).q
        return q

    def reached(self, targets: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.bool_]]:
        target = targets_of(targets)
        if target.shape[1:] != (3,):
            raise InputError(f"a published model is led by points (N, 3), found shape {target.shape}")
        q, found = self.reached_in_any(target)
        tool, trusted = self._mechanism.library()["tool"].batch(
            [np.ascontiguousarray(q[found]), np.zeros(self.n), self._values(None)], self.threads
        )
        # the tool that goes with these actuators on the branch of home, another one behind a type-2 singularity
        away = np.abs(tool["position"] - target[found]).max(axis=1, initial=0.0)
        size = np.abs(target[found] - self._mechanism.tool(self._mechanism.home).position).max(initial=0.0)
        found[found] = trusted & (away <= tolerances.REACHED.value * max(size, np.finfo(float).tiny))
        q[~found] = np.nan
        return q, found

    def reached_in_any(self, target: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """The same with the tool at points (N, 3), on whichever side of type-2 singularities."""
        model = self._mechanism
        given = [np.ascontiguousarray(target), self._values(None)]
        found_q, strain = model.library()["reach"].kernel.batch(given, threads=self.threads)
        q = np.array(found_q)
        found = np.isfinite(q).all(axis=1) & np.isfinite(strain[:, 0])
        q[found] = nearest_turn(q[found], model.home.q, [one.kind == "rotation" for one in model.actuators])
        return q, found

    def _posture(self, model: Mechanism, positions: Array) -> Posture:
        return model.close(positions)


def asked(row: int, answer: Callable[[int], Answer]) -> Answer:
    """What the model answers to one row; an error gets a note that names it."""
    try:
        return answer(row)
    except CutjointError as error:
        error.add_note(f"row {row} of the batch")
        raise


def targets_of(values: npt.ArrayLike) -> Array:
    """Points (N, 3) or poses (N, 7) or (N, 4, 4)."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape[1:] not in ((3,), (7,), (4, 4)):
        raise InputError(f"targets must have shape (N, 3), (N, 7) or (N, 4, 4), found {array.shape}")
    return np.ascontiguousarray(array)


def rows_of(name: str, values: npt.ArrayLike, columns: int, rows: int | None = None) -> Array:
    """`values` as (N, columns), or (columns,) where `rows` is given and all rows share it."""
    array = np.asarray(values, dtype=np.float64)
    shared = rows is not None and array.shape == (columns,)
    if not shared and (array.ndim != 2 or array.shape[1] != columns or (rows is not None and len(array) != rows)):
        wanted = f"({'N' if rows is None else rows}, {columns})"
        raise InputError(f"{name} must have shape {wanted}, found {array.shape}")
    return np.ascontiguousarray(array)
