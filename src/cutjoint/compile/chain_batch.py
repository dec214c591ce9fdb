"""A closed chain on many states at once: its loops are closed, and its tool is led, row by row side by side."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.compile.batch import Batch, Given, asked, targets_of
from cutjoint.compile.closing import ChainClosing
from cutjoint.compile.mechanism import CompiledMechanism
from cutjoint.compile.reaching import ChainReaching
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Mechanism, Posture


class ChainBatch(Batch):
    """Many states of a closed chain."""

    def __init__(self, mechanism: CompiledMechanism[Mechanism], closing: ChainClosing) -> None:
        super().__init__(mechanism)
        self._closing, self.positions = closing, closing.source.positions

    @cached_property
    def _reaching(self) -> ChainReaching | None:
        own = self._closing
        return ChainReaching.where_led(own.source, own.library, own.parameters)

    def close(self, q: npt.ArrayLike, parameters: Given = None) -> Array:
        target, values = self._rows("q", q, parameters)
        home = np.tile(self._mechanism.home.q_full, (len(target), 1))
        found, done = self._closing.walk(home, target, self.threads, end=values if parameters else None)
        self._respect_limits(found, done)
        for row in np.flatnonzero(~done).tolist():
            found[row] = asked(row, lambda k: self._geometry(values, k).close(target[k])).q_full
        return found

    def closed_positions(self, q: npt.ArrayLike, parameters: Given = None) -> Array:
        positions = super().closed_positions(q, parameters)
        were_given = np.shape(q) == positions.shape and self.positions != self.n
        if were_given and self._closing.source.placing:
            self._closing.check(positions, self._values(parameters, len(positions)), self.threads)
        return positions

    def reach(self, targets: npt.ArrayLike, parameters: Given = None) -> Array:
        given, last = targets_of(targets), None
        values = self._values(parameters, len(given))
        start, reaching = np.tile(self._mechanism.home.q_full, (len(given), 1)), self._reaching
        if parameters:
            start = self.close(np.tile(self._mechanism.home.q, (len(given), 1)), parameters)
            own = self._closing
            reaching = ChainReaching.where_led(own.source, own.library, values)
        found, done = np.empty((len(given), self.positions)), np.zeros(len(given), dtype=bool)
        if reaching is not None:
            task = self._mechanism.task
            wanted = [asked(row, lambda k: task.target(given[k])) for row in range(len(given))]
            found, done = reaching.many(start, wanted, self.threads)
        self._respect_limits(found, done)

        def one(row: int) -> Posture:
            # rows are often neighbours, and a walk from one to the next stays on the branch like one from home does
            robot = self._geometry(values, row) if parameters else self._mechanism
            try:
                return robot.reach(given[row], None if parameters else last)
            except CutjointError:
                return robot.reach(given[row])

        for row in np.flatnonzero(~done).tolist():
            last = asked(row, one)
            found[row] = last.q_full
        return found

    def reached(self, targets: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.bool_]]:
        """As of `Batch.reached`: what a straight way of the tool from home leads to, within the limits of joints."""
        given = targets_of(targets)
        if self._reaching is None:
            raise InputError(
                f"the compiled equations of {self._mechanism.name} do not lead its tool; reach() asks the robot itself"
            )
        task = self._mechanism.task
        wanted = [asked(row, lambda k: task.target(given[k])) for row in range(len(given))]
        found, done = self._reaching.many(np.tile(self._mechanism.home.q_full, (len(given), 1)), wanted, self.threads)
        self._respect_limits(found, done)
        found[~done] = np.nan
        return found, done

    def _geometry(self, values: Array, k: int) -> Mechanism:
        """The chain that closes the loops at the values of a row."""
        row = values if values.ndim == 1 else values[k]
        source = self._closing.source
        return self._model(values, k) if source.displaced(row) else source.chain

    def _respect_limits(self, found: Array, done: npt.NDArray[np.bool_]) -> None:
        """What goes beyond a joint's limits is not done: the chain will say so."""
        chain, home = self._closing.source.chain, self._mechanism.home.q_full
        lower, upper = self._closing.source.limits
        beyond = done & ~((found >= lower) & (found <= upper)).all(axis=1)
        for row in np.flatnonzero(beyond).tolist():
            done[row] = not chain.goes_beyond(home, found[row])

    def _posture(self, model: Mechanism, positions: Array) -> Posture:
        assert isinstance(model, ClosedChain)
        return model.posture(positions)
