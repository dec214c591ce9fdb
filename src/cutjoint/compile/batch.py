"""Compiled mechanisms on many states at once: arrays of shape (N, n) in, arrays out.

States stand side by side in the vector registers, and blocks of them go to all cores.  Rows whose compiled evaluation
must not be trusted (see `cutjoint.compile.mechanism`) are asked of the model one by one, so an error is the model's
own; it carries a note that names the row.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Posture

if TYPE_CHECKING:
    from cutjoint.compile.mechanism import CompiledMechanism

NEWTON_STEPS = 8


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Batch:
    """Many states of one compiled mechanism.

    `Q` holds actuated coordinates, shape (N, n), on the branch of home; or, quicker because nothing has to be closed,
    what `close` or `reach` returned, shape (N, positions).  `V`, `A` and `effort` have shape (N, n), or (n,) for all
    rows. `parameters` gives the inertial parameters that are arguments: name -> one number or N of them.
    """

    def __init__(self, mechanism: CompiledMechanism) -> None:
        self._mechanism: Any = mechanism
        self.n = mechanism.n
        self.threads = cores()

    @property
    def positions(self) -> int:
        """Position variables of a state: full configuration of a chain, actuated coordinates of a published model."""
        return int(self._mechanism.source.positions)

    def close(self, q: npt.ArrayLike) -> Array:
        """Closed positions, shape (N, positions), for actuated coordinates (N, n).

        Raises:
            InputError: wrong shape.
            ClosureError, SingularError: a row cannot be closed; a note names it.
        """
        target = _matrix("q", q, self.n)
        if self.positions == self.n:
            return target
        found, done = self._walk(np.tile(self._mechanism.home.q_full, (len(target), 1)), target)
        for row in np.flatnonzero(~done).tolist():
            found[row] = self._ask(row, lambda k: self._mechanism.chain.close(target[k])).q_full
        return found

    def reach(self, p: npt.ArrayLike) -> Array:
        """Closed positions, shape (N, positions), with the tool at `p`, shape (N, 3) [m], on the branch of home.

        Raises:
            InputError: wrong shape, or the robot has no tool.
            UnreachableError, ClosureError, SingularError: a row cannot be reached; a note names it.
        """
        target = _matrix("p", p, 3)
        if self.positions == self.n:
            q = self._kernel("reach").batch([target, self._parameters(None, len(target))], threads=self.threads)[0]
            turning = [actuator.kind == "rotation" for actuator in self._mechanism.actuators]
            turns = np.where(turning, 2.0 * np.pi * np.round((self._mechanism.home.q - q) / (2.0 * np.pi)), 0.0)
            q = q + turns
            for row in np.flatnonzero(~np.isfinite(q).all(axis=1)).tolist():
                q[row] = self._ask(row, lambda k: self._mechanism.plain.reach(target[k])).q
            return np.asarray(q)
        found = np.empty((len(target), self.positions))
        last: list[Posture] = []

        def one(row: int) -> Posture:
            # rows are often neighbours, and a walk from one to the next stays on the branch like one from home does
            return self._reach_one(target[row], last[0] if last else None)

        for row in range(len(target)):
            last[:] = [self._ask(row, one)]
            found[row] = last[0].q_full
        return found

    def _reach_one(self, place: Array, near: Posture | None) -> Posture:
        try:
            found: Posture = self._mechanism.reach(place, near)
        except CutjointError:
            found = self._mechanism.reach(place)
        return found

    def tool(self, q: npt.ArrayLike, v: npt.ArrayLike | None = None) -> tuple[Array, Array, Array]:
        """Tool positions (N, 3), Jacobians (N, 3, n) and drifts (N, 3) (zero without `v`)."""
        speed = np.zeros(self.n) if v is None else v
        position, jacobian, drift = self._run(
            "tool", q, {"v": speed}, None, lambda model, at, x: _tool(model.tool(at, x["v"]))
        )
        return position, jacobian.reshape(-1, 3, self.n), drift

    def terms(
        self, q: npt.ArrayLike, v: npt.ArrayLike | None = None, parameters: Mapping[str, npt.ArrayLike] | None = None
    ) -> tuple[Array, Array, Array]:
        """Mass matrices (N, n, n), Coriolis vectors (N, n) and gravity (N, n)."""
        speed = np.zeros(self.n) if v is None else v
        mass, coriolis, gravity = self._run(
            "terms", q, {"v": speed}, parameters, lambda model, at, x: _terms(model.terms(at, x["v"]))
        )
        return mass.reshape(-1, self.n, self.n), coriolis, gravity

    def inverse_dynamics(
        self,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        a: npt.ArrayLike,
        parameters: Mapping[str, npt.ArrayLike] | None = None,
    ) -> Array:
        """Efforts, shape (N, n); errors as the mechanism's own `inverse_dynamics`."""
        return self._run(
            "inverse",
            q,
            {"v": v, "a": a},
            parameters,
            lambda model, at, x: (model.inverse_dynamics(at, x["v"], x["a"]),),
        )[0]

    def forward_dynamics(
        self,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        effort: npt.ArrayLike,
        parameters: Mapping[str, npt.ArrayLike] | None = None,
    ) -> Array:
        """Accelerations, shape (N, n); errors as the mechanism's own `forward_dynamics`."""
        return self._run(
            "forward",
            q,
            {"v": v, "effort": effort},
            parameters,
            lambda model, at, x: (model.forward_dynamics(at, x["v"], x["effort"]),),
        )[0]

    # -- inside ------------------------------------------------------------------------------------------------------

    def _kernel(self, what: str) -> Any:
        if self._mechanism.source.n != self.n:
            self._mechanism.model.terms(self._mechanism.home)  # raises: the actuators do not determine the motion
        return self._mechanism.kernel(what)

    def closed_positions(self, q: npt.ArrayLike) -> Array:
        """`q` as position variables, closed where it holds actuated coordinates only."""
        given = np.asarray(q, dtype=np.float64)
        if given.ndim == 2 and given.shape[1] == self.positions:
            return np.ascontiguousarray(given)
        return self.close(given)

    def _parameters(self, given: Mapping[str, npt.ArrayLike] | None, count: int) -> Array:
        """Values of the parameters: one row for all, or one row each."""
        names = self._mechanism.options.parameters
        values = self._mechanism.parameters
        if not given:
            return np.array([values[name] for name in names], dtype=np.float64)
        for name in given:
            if name not in names:
                raise InputError(
                    f"'{name}' is not an argument of the compiled functions ({', '.join(names) or 'there is none'}); "
                    "name it "
                    "when compiling"
                )
        try:
            columns = [np.broadcast_to(np.asarray(given.get(name, values[name]), float), (count,)) for name in names]
        except ValueError as error:
            raise InputError(f"parameters must be one number or {count} of them: {error}") from error
        return np.ascontiguousarray(np.stack(columns, axis=1))

    def _run(
        self,
        what: str,
        q: npt.ArrayLike,
        arguments: Mapping[str, npt.ArrayLike],
        parameters: Mapping[str, npt.ArrayLike] | None,
        slow: Callable[[Any, Posture, Mapping[str, Array]], tuple[Array, ...]],
    ) -> list[Array]:
        kernel = self._kernel(what)
        positions = self.closed_positions(q)
        count = len(positions)
        given = {name: _matrix(name, x, self.n, count) for name, x in arguments.items()}
        values = self._parameters(parameters, count)
        *results, strain = kernel.batch([positions, *given.values(), values], threads=self.threads)
        good = strain[:, 0] <= STRAIN_LIMIT
        for result in results:
            # one pass over the data: a row with anything not finite has no finite sum
            good &= np.isfinite(result.sum(axis=1))
        for row in np.flatnonzero(~good):

            def answer(k: int) -> tuple[Array, ...]:
                chosen = values if values.ndim == 1 else values[k]
                names = self._mechanism.options.parameters
                model = self._mechanism.with_parameters(**dict(zip(names, chosen.tolist(), strict=True))).plain
                at = self._posture(positions[k])
                return slow(model, at, {name: x if x.ndim == 1 else x[k] for name, x in given.items()})

            for result, value in zip(results, self._ask(int(row), answer), strict=True):
                result[row] = np.ravel(value)
        return list(results)

    def _posture(self, positions: Array) -> Posture:
        """A row as a posture of the model."""
        if self.positions == self.n:
            closed: Posture = self._mechanism.plain.close(positions)
            return closed
        posture: Posture = self._mechanism.chain.posture(positions)
        return posture

    def _ask(self, row: int, answer: Callable[[int], Any]) -> Any:
        try:
            return answer(row)
        except CutjointError as error:
            error.add_note(f"row {row} of the batch")
            raise

    def _walk(self, q: Array, target: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Walk all rows from the closed `q` to their actuated `target`, in steps short against the links.

        Also returns which rows arrived, on the branch they started from.
        """
        kernel = self._kernel("step")
        chain = self._mechanism
        scale = chain._q_scale
        values = self._parameters(None, len(q))
        start = q[:, list(chain.source.actuated)]

        def step(at: Array, to: Array) -> tuple[Array, Array, Array]:
            after, residual, strain = kernel.batch([at, to, values], threads=self.threads)
            bad = ~(strain[:, 0] <= STRAIN_LIMIT) | ~np.isfinite(after.sum(axis=1))
            size = np.abs((after - at) / scale).max(axis=1)
            size[bad] = np.inf
            return after, size, np.abs(residual * chain._row_scale).max(axis=1, initial=0.0)

        _, size, _ = step(q, target)
        pieces = int(np.ceil(min(float(size[np.isfinite(size)].max(initial=0.0)) / 0.1, 200.0))) + 1
        good = np.ones(len(q), dtype=bool)
        for piece in range(1, pieces + 1):
            to = target if piece == pieces else start + (piece / pieces) * (target - start)
            first: Array | None = None
            residual = np.full(len(q), np.inf)
            for count in range(NEWTON_STEPS):
                after, size, residual = step(q, to)
                if count == 0:
                    first = size
                    good &= size <= tolerances.STRIDE.value
                else:
                    good &= size <= 0.5 * np.asarray(first) + 1e-9
                    if float(size[good].max(initial=0.0)) < 1e-13:
                        break
                q = np.where(good[:, None], after, q)
            good &= residual <= tolerances.CLOSURE.value
        return q, good


def _matrix(name: str, values: npt.ArrayLike, columns: int, rows: int | None = None) -> Array:
    """`values` as (N, columns), or (columns,) where `rows` is given and all rows share it."""
    array = np.asarray(values, dtype=np.float64)
    shared = rows is not None and array.shape == (columns,)
    if not shared and (array.ndim != 2 or array.shape[1] != columns or (rows is not None and len(array) != rows)):
        wanted = f"({'N' if rows is None else rows}, {columns})"
        raise InputError(f"{name} must have shape {wanted}, found {array.shape}")
    return np.ascontiguousarray(array)


def _tool(tool: Any) -> tuple[Array, ...]:
    return tool.position, tool.jacobian, tool.drift


def _terms(terms: Any) -> tuple[Array, ...]:
    return terms.mass, terms.coriolis, terms.gravity
