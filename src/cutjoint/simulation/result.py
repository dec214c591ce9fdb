"""What a run leaves behind: samples over time, and the checks that tell whether to believe them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, NamedTuple, TypedDict

import numpy as np

from cutjoint.arrays import Array, Values, readonly, readonly_mapping
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import clipped, told
from cutjoint.simulation.hardware.parts import Parts
from cutjoint.simulation.observables import OBSERVABLES
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint import Plot, RunPage

ROUNDING = 16.0 * np.finfo(float).eps
"""Part of an energy that its rounding may be."""
FREE = "free motion"
_NAMED = (("plant", "?"), ("law", "?"), ("trajectory", "free motion"))
"""What stands for a trajectory where there was none."""


class Rmse(NamedTuple):
    """Root mean square error of the tool: position [m] and velocity [m/s]."""

    position: float
    velocity: float

    def __repr__(self) -> str:
        return told(self, position="m", velocity="m/s")


class About(TypedDict, total=False):
    """How a run was made, as plain JSON values."""

    robot: str
    plant: str
    not_compiled: str
    law: str
    gains: dict[str, list[list[float]]]
    trajectory: str
    reference: str
    integrator: str
    rate: float | None
    limits: list[float] | None
    hardware: Parts
    run_number: int
    actuators: list[list[str]]
    joints: list[list[str]]
    locked: list[str]
    loads: str | list[dict[str, object]]
    steps: int
    evaluations: int
    strayed: float
    stopped: str
    fingerprint: str
    file: str
    options: dict[str, object]


# long: measures of a run, a line or two of code each
@dataclass(frozen=True, eq=False)
class Result(Values):
    """A run: m samples of a robot with n actuators.  Read-only.

    Its columns are the rows of `OBSERVABLES`.  Those that every result has are fields; further ones are attributes just
    the same, of the results that were made with them: what was desired of runs that follow something, orientations of
    tools that can turn.

    Attributes:
        about: how it was made.
        more: the further columns by name.
    """

    __doc__ = f"{__doc__}    " + "\n        ".join(f"{name}: {one}" for name, one in OBSERVABLES.items())

    time: Array
    q: Array
    v: Array
    tool: Array
    tool_velocity: Array
    effort: Array
    gap: Array
    kinetic: Array
    potential: Array
    work: Array
    q_full: Array
    about: About = field(default_factory=lambda: About())
    more: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ARRAYS:
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "about", readonly_mapping(self.about))
        object.__setattr__(self, "more", readonly_mapping({name: readonly(one) for name, one in self.more.items()}))
        unknown = [name for name in self.more if name not in OBSERVABLES or name in ARRAYS]
        if unknown:
            raise InputError(f"a result has no further column {', '.join(unknown)}; give OBSERVABLES a row for it")
        m = len(self) if self.time.ndim == 1 and self.time.size else -1
        n = self.q.shape[1] if self.q.ndim == 2 else -1
        wrong = [
            f"{name} {one.shape}" for name, one in self.columns.items() if not OBSERVABLES[name].fits(one.shape, m, n)
        ]
        if wrong:
            raise InputError(f"a result of {self.time.size} samples has arrays that do not fit: {', '.join(wrong)}")
        if not all(np.isfinite(one).all() for one in self.columns.values()):
            raise InputError("a result holds finite numbers only")
        if (np.diff(self.time) <= 0.0).any():
            raise InputError("the times of a result must increase strictly")

    def __getattr__(self, name: str) -> Array:
        more: Mapping[str, Array] = self.__dict__.get("more", {})
        if name not in more:
            raise AttributeError(f"this result has no column {name!r}; it has {', '.join((*ARRAYS, *more))}")
        return more[name]

    @property
    def columns(self) -> dict[str, Array]:
        """Every column by name, in the order of `OBSERVABLES`."""
        return {name: getattr(self, name) for name in OBSERVABLES if name in ARRAYS or name in self.more}

    def __len__(self) -> int:
        return int(self.time.size)

    def __repr__(self) -> str:
        what = self.about
        names = ", ".join(clipped(str(what.get(one, usual)), 24) for one, usual in _NAMED)
        return f"Result({names}: {len(self)} samples over {self.time[-1] - self.time[0]:g} s)"

    def _repr_html_(self) -> str:
        return self.table().html()

    def table(self) -> TextTable:
        """What was run and what it came to, a row each."""
        rows = [(name, str(self.about.get(name, "?"))) for name in ("plant", "law", "integrator")]
        rows += [("trajectory", str(self.about.get("trajectory", FREE)))]
        rows += [("samples", f"{len(self)} over {self.time[-1] - self.time[0]:g} s")]
        if self.followed:
            mean, worst = self.rmse_over_time().position, self.worst_error()
            rows += [("tool error", f"{mean:.4g} m rms over time, {worst:.4g} m at worst")]
        places = self.about.get("actuators", [[f"actuator {k + 1}", ""] for k in range(self.q.shape[1])])
        units = {"translation": "N", "rotation": "N m", "": "N or N m"}
        peaks = zip(places, self.peak_effort(), strict=True)
        rows += [(f"peak effort of {name}", f"{peak:.4g} {units.get(kind, units[''])}") for (name, kind), peak in peaks]
        gap = self.loop_gap()
        rows += [("loops", f"closed to {gap[0]:.1e} m, {gap[1]:.1e} rad")]
        return TextTable(
            "result", ("", ""), [*rows, ("energy drift", f"{self.energy_drift():.1e} of what was turned over")]
        )

    @property
    def followed(self) -> bool:
        """Whether there was a desired motion; without one there are no errors of the tool."""
        return "desired_tool" in self.more

    @property
    def error(self) -> Array:
        """Desired minus actual position of the tool, shape (m, 3), [m].

        Raises:
            InputError: nothing was followed.
        """
        return readonly(self._desired("desired_tool") - self.tool)

    @property
    def velocity_error(self) -> Array:
        """Desired minus actual velocity of the tool, shape (m, 3), [m/s].

        Raises:
            InputError: nothing was followed.
        """
        return readonly(self._desired("desired_tool_velocity") - self.tool_velocity)

    def _desired(self, name: str) -> Array:
        if name not in self.more:
            raise InputError(f"this run followed nothing, so its tool has no error (there is no column {name!r})")
        return self.more[name]

    def rmse(self) -> Rmse:
        """Root of the mean over the samples of |error|^2 (Elkady et al. 2008, equations 48 and 49).

        It depends on where the samples lie: steps of an adaptive solver crowd where the motion is fast.
        """
        return Rmse(*(float(np.sqrt(np.mean(_squares(e)))) for e in (self.error, self.velocity_error)))

    def rmse_over_time(self) -> Rmse:
        """Root of the mean over time of |error|^2, by the trapezoidal rule; it does not depend on the samples."""
        span = self.time[-1] - self.time[0]
        if span == 0.0:
            return self.rmse()
        means = (np.trapezoid(_squares(e), self.time) / span for e in (self.error, self.velocity_error))
        return Rmse(*(float(np.sqrt(mean)) for mean in means))

    @door
    def worst_error(self, after: float = 0.0) -> float:
        """Largest |error| of the tool from time `after` [s] on [m]."""
        return float(np.sqrt(_squares(self.error[_from(self, after)]).max()))

    @door
    def worst_axis_error(self, after: float = 0.0) -> float:
        """Largest error of the tool along any one axis from time `after` [s] on [m]."""
        return float(np.abs(self.error[_from(self, after)]).max())

    @door
    def worst_turn(self, after: float = 0.0) -> float:
        """Largest angle between desired and actual orientation of the tool from time `after` [s] on [rad].

        Raises:
            InputError: nothing was followed, or the tool cannot turn.
        """
        if self.followed and "orientation_error" not in self.more:
            raise InputError("the tool of this run cannot turn, or the file is from before orientations were recorded")
        return float(self._desired("orientation_error")[_from(self, after)].max())

    def peak_effort(self) -> Array:
        """Largest |effort| of each actuator, shape (n,), [N] or [N m]."""
        return readonly(np.abs(self.effort).max(axis=0))

    @property
    def energy(self) -> Array:
        """Kinetic and potential energy, shape (m,), [J]."""
        return readonly(self.kinetic + self.potential)

    @property
    def unaccounted(self) -> Array:
        """Change of energy less work, plus what friction took: energy that came from nowhere, shape (m,), [J]."""
        pushed, taken = (self.more.get(name, np.zeros_like(self.work)) for name in ("load_work", "dissipated"))
        return readonly(self.energy - self.energy[0] - self.work - pushed + taken)

    def energy_drift(self) -> float:
        """Energy that came from nowhere, relative to the energy that was turned over.

        The largest |change of energy - work of actuators and loads + what friction took|, over the largest of: kinetic
        energy, range of the potential energy, |work| of each.  0 for a robot that did not move, and where the energies
        round by more.
        """
        pushed, taken = (self.more.get(name, np.zeros_like(self.work)) for name in ("load_work", "dissipated"))
        lost = np.abs(self.unaccounted).max()
        if lost <= ROUNDING * np.abs(self.potential).max():
            return 0.0
        works = (float(np.abs(work).max()) for work in (self.work, pushed, taken))
        turned = max(self.kinetic.max(), np.ptp(self.potential), *works)
        return float(lost / turned) if turned > 0.0 else float(lost)

    def loop_gap(self) -> tuple[float, float]:
        """Worst loop residual of the run, ([m], [rad])."""
        return float(self.gap[:, 0].max()), float(self.gap[:, 1].max())

    def plot(self, what: str | Sequence[str] = (), file: str | os.PathLike[str] | None = None) -> Plot:
        """Curves of the run: shows itself in a notebook, `save`s as .svg, .png or .html.

        Args:
            what: names of `simulation.panels.PANELS`, as a list or with commas between; default the usual ones.
            file: where to write it too.

        Raises:
            UnknownNameError: there is no panel of that name.
            InputError: the run has nothing to show in one, or no place for the file.
            MissingPackageError: matplotlib is not installed.
        """
        from cutjoint import plot

        return plot(self, what, file=file)

    def report(self, file: str | os.PathLike[str] | None = None) -> RunPage:
        """All about the run as one page: shows itself in a notebook, `save`s as .html.

        Args:
            file: where to write it too.

        Raises:
            InputError: no place for the file.
        """
        from cutjoint import run_report

        return run_report(self, file=file)


ARRAYS = tuple(one.name for one in fields(Result) if one.name in OBSERVABLES)
"""The columns that every result has."""


def result_of(columns: Mapping[str, Array], about: About) -> Result:
    """The result of all its columns; those that every result has must be there."""
    own = {name: columns[name] for name in ARRAYS}
    return Result(**own, about=about, more={name: one for name, one in columns.items() if name not in own})


def _from(result: Result, after: float) -> slice:
    first = int(np.searchsorted(result.time, after))
    if first == len(result):
        raise InputError(f"the run ends at {result.time[-1]:g} s, before {after:g} s")
    return slice(first, None)


def _squares(error: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", error, error))
