"""A study as a value: what is simulated, what varies in it and how, and what is kept of every run."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Frozen, Values
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.simulation.hardware import Hardware
from cutjoint.studies.spreads import Spread

Method = Literal["grid", "random", "latin-hypercube", "sobol", "saltelli"]
METHODS: Mapping[str, str] = {
    "grid": "every combination of the values",
    "random": "independent draws (Monte Carlo)",
    "latin-hypercube": "draws of which every stratum of every path has one",
    "sobol": "a scrambled Sobol sequence",
    "saltelli": "the draws from which Sobol indices are estimated",
}
MOST_RUNS = 10**10
"""Runs of a study; those of more would take thousands of processors for weeks."""
MOST_SOBOL = 2**24
"""Points of a Sobol sequence: to go on in the middle of a longer one takes too long."""


@dataclass(frozen=True)
class VariedPath:
    """What varies from run to run.

    Attributes:
        path: of a parameter (`links.tool.mass`, `payload`), a gain (`gains.kp`), or a starting coordinate
            (`start.ACTUATOR`, added to that of the trajectory).
        spread: where its values come from.
    """

    path: str
    spread: Spread

    __repr__ = line()


@dataclass(frozen=True, eq=False)
class FollowingLaw(Frozen):
    """A controller of a study.

    Attributes:
        name: of the law, as `cutjoint simulate --controller` takes it.
        gains: by name; empty: usual ones.
        believes: the model inside it, "chain" or "published"; empty: what is usual.
    """

    name: str
    gains: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    believes: str = ""

    __repr__ = line("name", "gains", gains="N/m, N m/rad, ...")


@dataclass(frozen=True, eq=False)
class Study(Values):
    """What a study file says.

    Attributes:
        name: of the file, without its suffix.
        robot: name of a robot or path to its file.
        model: "chain", or "published" for the reduced model of its paper.
        variants: named sets of inertias; None is the robot's own.
        ideal: whether its joints move freely, whatever its files say.
        duration: of a run [s]; None: that of the trajectory.
        step: of the integrator [s].
        integrator: name of a method of fixed step.
        method: how runs are chosen, see `METHODS`.
        runs: of every case; of a grid None.
        seed: of all that is drawn.
        trajectories: as `cutjoint simulate --trajectory` takes them.
        laws: the controllers.
        hardware: between controller and joints, by name; None acts continuously.
        varied: what varies.
        keep: quantities that are kept of every run, names of `QUANTITIES`.
        every: distance of the samples that some quantities are made of [s].
        block: runs in a block; None: chosen by the number of runs.
        settings: all that the file says, as JSON with its keys in order.
    """

    name: str
    robot: str
    model: str
    variants: tuple[str | None, ...]
    ideal: bool
    duration: float | None
    step: float
    integrator: str
    method: Method
    runs: int | None
    seed: int
    trajectories: tuple[str, ...]
    laws: tuple[FollowingLaw, ...]
    hardware: tuple[tuple[str, Hardware | None], ...]
    varied: tuple[VariedPath, ...]
    keep: tuple[str, ...]
    every: float
    block: int | None
    settings: str

    __repr__ = line("name", "robot", "method", "runs", "duration", duration="s")

    @property
    def samples(self) -> int:
        """Runs of every case.

        Raises:
            InputError: too many, or a number that the method does not take.
        """
        if self.method == "grid":
            count = 1
            for one in self.varied:
                count *= one.spread.count
        else:
            assert self.runs is not None
            count = self.runs
        if self.method == "saltelli":
            _check_saltelli(count, len(self.varied))
        if self.method == "sobol" and count > MOST_SOBOL:
            raise InputError(f"a Sobol sequence has at most {MOST_SOBOL} points here, found runs = {count}")
        return count

    @property
    def cases(self) -> int:
        """Combinations of variant, trajectory, controller and hardware."""
        return len(self.variants) * len(self.trajectories) * len(self.laws) * len(self.hardware)

    @property
    def total(self) -> int:
        """Runs of all cases.

        Raises:
            InputError: more than `MOST_RUNS`.
        """
        count = self.samples * self.cases
        if count > MOST_RUNS:
            told = f"{self.samples:.3g} runs of {self.cases} cases" if self.cases > 1 else f"{count:.3g} runs"
            raise InputError(f"{told} are more than a study has, {MOST_RUNS:.0e}; found runs = {self.samples}")
        return count

    @property
    def digest(self) -> str:
        """A text that differs where what the file says differs; comments and the order of keys do not count."""
        return hashlib.sha256(self.settings.encode()).hexdigest()


def _check_saltelli(runs: int, varied: int) -> None:
    """Raises InputError where the number of runs is not N (d + 2) with N a power of two."""
    width = varied + 2
    base, rest = divmod(runs, width)
    if rest or base < 2 or base & (base - 1):
        good = 2 ** max(1, int(np.ceil(np.log2(max(runs / width, 2.0)))))
        raise InputError(
            f"method 'saltelli' with {varied} paths takes N ({varied} + 2) runs, N a power of two, such as "
            f"{good * width}; found runs = {runs}"
        )
    if base > MOST_SOBOL:
        raise InputError(f"method 'saltelli' takes at most {MOST_SOBOL * width} runs here, found {runs}")
