"""What a run keeps of its instants until somebody looks: a plant that can, is asked about many states at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.motion import Desired
from cutjoint.simulation.hardware.electronics import Signals
from cutjoint.simulation.observables import OBSERVABLES, Instant, Works, gathered
from cutjoint.simulation.plant import Advancing, Plant, State


class Kept(NamedTuple):
    """What is recorded of an instant, before the state is looked at; see `Instant`."""

    t: float
    state: State
    desired: Desired | None
    effort: Array
    works: Works
    signals: Signals | None


class Recorder:
    """The samples of a run of `plant`."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._at_once = plant if isinstance(plant, Advancing) else None
        self._samples: dict[str, list[npt.ArrayLike]] = {name: [] for name in OBSERVABLES}
        self._kept: list[Kept] = []

    def keep(self, one: Kept) -> None:
        """Take one sample."""
        self._kept.append(one)
        if self._at_once is None:
            self._look()

    def columns(self) -> dict[str, Array]:
        """All samples until now, by name."""
        self._look()
        return gathered({name: samples for name, samples in self._samples.items() if samples})

    def _look(self) -> None:
        states = [one.state for one in self._kept]
        seen = map(self._plant.observe, states) if self._at_once is None else self._at_once.observe_all(states)
        for one, observation in zip(self._kept, seen, strict=True):
            now = Instant(one.t, observation, one.desired, one.effort, one.works, one.signals)
            for name, observable in OBSERVABLES.items():
                if (taken := observable.take(now)) is not None:
                    self._samples[name].append(taken)
        self._kept.clear()
