"""What a run keeps of its instants until somebody looks: a plant that can, is asked about many states at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.motion import Desired
from cutjoint.simulation.hardware.electronics import Signals
from cutjoint.simulation.observables import OBSERVABLES, Instant, Works, gathered
from cutjoint.simulation.plant import Advancing, Observation, Plant, State


class Kept(NamedTuple):
    """What is recorded of an instant, before the state is looked at; see `Instant`."""

    t: float
    state: State
    desired: Desired | None
    effort: Array
    works: Works
    signals: Signals | None


class Recorder:
    """The samples of a run of `plant`.  An interrupt leaves whole samples, wherever it comes."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._at_once = plant if isinstance(plant, Advancing) else None
        # looked at, and not yet: one attribute, so that an interrupt never finds a sample in both
        self._rows: tuple[list[dict[str, npt.ArrayLike]], list[Kept]] = ([], [])

    def keep(self, one: Kept) -> None:
        """Take one sample."""
        rows, kept = self._rows
        if self._at_once is None:
            rows.append(_row(one, self._plant.observe(one.state)))
        else:
            kept.append(one)

    def columns(self) -> dict[str, Array]:
        """All samples until now, by name."""
        rows, kept = self._rows
        if self._at_once is not None and kept:
            seen = self._at_once.observe_all([one.state for one in kept])
            rows = rows + [_row(one, observation) for one, observation in zip(kept, seen, strict=True)]
            self._rows = rows, []
        return gathered({name: [row[name] for row in rows] for name in rows[0]})


def _row(one: Kept, observation: Observation) -> dict[str, npt.ArrayLike]:
    """A sample by the names of its columns."""
    now = Instant(one.t, observation, one.desired, one.effort, one.works, one.signals)
    taken = {name: observable.take(now) for name, observable in OBSERVABLES.items()}
    return {name: value for name, value in taken.items() if value is not None}
