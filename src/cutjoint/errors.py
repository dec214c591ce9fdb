"""Every error that cutjoint raises on purpose.

One root, a class per cause.  An error says what was found, what was expected and how to mend it, and holds the
offending numbers as attributes so that a program can act on them.  Every error can be pickled and copied whole, so a
worker process can hand it over; arrays in it are read-only.
"""

# long: every error of the package, a class per cause

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt


class _Whole(BaseException):
    """What is raised with its attributes, in another process too.

    Python would pickle an error by calling its class with `args`, which no class with further arguments survives: a
    pool of workers then waits for ever.  Here the error is made anew without its constructor, and gets back its
    arguments and attributes; that holds for every class derived from this one, whatever its constructor takes.
    """

    def __reduce__(self) -> tuple[object, ...]:
        return _bare, (type(self), self.args), dict(self.__dict__)

    def __setstate__(self, state: Mapping[str, object] | None) -> None:
        for value in (state or {}).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        self.__dict__.update(state or {})


class CutjointError(_Whole, Exception):
    """Root of all errors of cutjoint."""


def _bare(kind: type[_Whole], args: tuple[object, ...]) -> _Whole:
    """An error with its arguments and without attributes."""
    return kind.__new__(kind, *args)


def _still(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """A read-only float copy."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def shown(path: str, longest: int = 200) -> str:
    """A path as messages show it: one that is very long is cut in the middle, what cannot be printed is escaped."""
    whole = path if len(path) <= longest else f"{path[: longest // 2]}...{path[-longest // 4 :]}"
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in whole)


class RoundingWarning(UserWarning):
    """Loops that close only up to the rounding of their lengths; the message names the rows and what stays open."""


class DescriptionWarning(UserWarning):
    """A flaw in a robot's files that a lenient reader passed: where, what was found, what was expected."""


class InputError(CutjointError, ValueError):
    """An argument has the wrong shape, is not finite or is out of its range."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong in a description: where, what was found, what was expected, how to mend it.

    An error is `tolerable` where it does not prevent computing; a lenient reader makes a warning of it.
    """

    found: str
    expected: str = ""
    mend: str = ""
    file: str = ""
    line: int | None = None
    severity: Literal["error", "warning"] = "error"
    tolerable: bool = False

    def __repr__(self) -> str:
        return f"Problem({self.severity}: {shown(str(self), 80)})"

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.line else self.file
        text = f"{place}: {self.found}" if place else self.found
        if self.expected:
            text += f"; expected {self.expected}"
        if self.mend:
            text += f" ({self.mend})"
        return text


class DescriptionError(CutjointError):
    """A robot's files are wrong.  `problems` holds all of them, not only the first."""

    where = "the description"

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        count = len(self.problems)
        head = f"{count} problems in {self.where}" if count > 1 else f"a problem in {self.where}"
        lines = [head + ":", *map(str, self.problems)]
        errors = [one for one in self.problems if one.severity == "error"]
        if errors and all(one.tolerable for one in errors):
            lines.append("--lenient, or lenient=True, passes these: it tells each, and what it leaves out")
        super().__init__("\n  ".join(lines))


class SettingsError(DescriptionError, InputError):
    """A file of settings (a study, hardware, springs, tolerances, ...) is wrong.  `problems` holds all of it."""

    where = "the settings"


MOST_KNOWN = 8
"""So many known names are told, where there are more the first ones."""
NEAR, AS_NEAR = 0.6, 0.04
"""Likeness (0 to 1) from which on a name is near, and how much less than the nearest another one may have."""


def nearest(name: str, known: Sequence[str]) -> tuple[str, ...]:
    """The known names that `name` may be meant for, nearest first, three at most; upper or lower case does not
    matter."""
    from difflib import SequenceMatcher

    told = name[:200].casefold()
    likeness: dict[str, float] = {}
    for one in dict.fromkeys(known):
        match = SequenceMatcher(None, one[:200].casefold(), told)
        if match.real_quick_ratio() >= NEAR and match.quick_ratio() >= NEAR and match.ratio() >= NEAR:
            likeness[one] = match.ratio()
    best = max(likeness.values(), default=0.0)
    found = sorted((one for one in likeness if likeness[one] >= best - AS_NEAR), key=lambda one: -likeness[one])
    return tuple(found or [one for one in known if len(told) > 1 and one.casefold().startswith(told)])[:3]


class UnknownNameError(CutjointError, KeyError):
    """A name (robot, joint, controller, ...) is not known; the nearest known ones are suggested.

    Attributes:
        kind: of what it should be the name.
        name: as it was given.
        known: the names that there are.
    """

    def __init__(self, kind: str, name: str, known: Sequence[str], everything: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = [f"'{shown(one)}'" for one in nearest(name, self.known)]
        hint = (
            f"; did you mean {' or '.join([*([', '.join(near[:-1])] if near[1:] else []), near[-1]])}?" if near else "."
        )
        more = len(self.known) - MOST_KNOWN
        if more > 0 and near:
            told = ""
        else:
            told = f" Known: {', '.join(map(shown, self.known[:MOST_KNOWN])) or 'none'}"
            if more > 0:
                told += f" and {more} more" + (everything and f"; {everything}")
        self.message = f"unknown {kind} '{shown(name)}'{hint}{told}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class ClosureError(CutjointError):
    """The loops do not close.  Nothing is returned.

    Attributes:
        gap: the residual left at the worst cut joint, [m] and [rad].
        cut: name of the cut joint that stays open.
        progress: how far from the start towards the target the loops could be kept closed, 0 to 1.
    """

    def __init__(self, message: str, *, gap: tuple[float, float], cut: str, progress: float = 0.0) -> None:
        self.gap, self.cut, self.progress = gap, cut, progress
        super().__init__(message)


class UnreachableError(CutjointError):
    """The target lies outside the workspace (of the branch that was asked for).

    Attributes:
        target: what was asked for.
        reached: the nearest point on the way that was reached.
        progress: fraction of the way, 0 to 1.
    """

    def __init__(
        self,
        message: str,
        *,
        target: npt.NDArray[np.float64],
        reached: npt.NDArray[np.float64] | None = None,
        progress: float = 0.0,
    ) -> None:
        self.target, self.progress = _still(target), progress
        self.reached = None if reached is None else _still(reached)
        super().__init__(message)


class LimbReachError(UnreachableError, ClosureError):
    """A limb would have to be longer or shorter than it is: the target is out of reach, so the loops stay open.

    Attributes:
        limb: number of the limb, from 1.
        reach: distance the limb would have to span [m].
        bounds: the distances it can span, folded and stretched [m].
    """

    def __init__(
        self,
        message: str,
        *,
        limb: int,
        reach: float,
        bounds: tuple[float, float],
        target: npt.NDArray[np.float64],
    ) -> None:
        self.limb, self.reach, self.bounds = limb, reach, bounds
        self.target, self.reached, self.progress = _still(target), None, 0.0
        self.gap = (max(bounds[0] - reach, reach - bounds[1], 0.0), 0.0)
        self.cut = f"limb {limb}"
        CutjointError.__init__(self, message)


class LimitError(UnreachableError, ClosureError):
    """A joint would have to go beyond its limits.

    Attributes:
        joint: its name.
        value: where it would have to be, [m] or [rad].
        bounds: its limits.
        progress: fraction of the straight way at which it meets its limit, 0 to 1.
    """

    def __init__(
        self,
        message: str,
        *,
        joint: str,
        value: float,
        bounds: tuple[float, float],
        target: npt.NDArray[np.float64],
        progress: float = 0.0,
    ) -> None:
        self.joint, self.value, self.bounds = joint, value, bounds
        self.target, self.reached, self.progress = _still(target), None, progress
        self.gap, self.cut = (0.0, 0.0), ""
        CutjointError.__init__(self, message)


class SingularError(CutjointError):
    """The posture is singular (or so near that no digit of the answer would hold).

    Attributes:
        kind: `type-1` (the tool cannot move in some direction), `type-2` (the robot can move with all actuators locked)
            or `limb` (a limb alone is stretched or folded).
        measure: the singular value (or sine) that vanished, dimensionless.
        limit: the smallest value that is accepted.
    """

    def __init__(self, message: str, *, kind: str, measure: float, limit: float) -> None:
        self.kind, self.measure, self.limit = kind, measure, limit
        super().__init__(message)


class ActuationError(CutjointError):
    """The actuators do not determine the motion, so reduced coordinates do not exist.

    Attributes:
        mobility: degrees of freedom of the closed robot.
        actuators: number of actuated coordinates.
        free: names of passive joints that still move with all actuators locked.
    """

    def __init__(self, message: str, *, mobility: int, actuators: int, free: Sequence[str]) -> None:
        self.mobility, self.actuators, self.free = mobility, actuators, tuple(free)
        super().__init__(message)


class DynamicsError(CutjointError):
    """Constrained dynamics did not converge: the accelerations would not respect the cut joints.

    Attributes:
        residual: |J a + gamma| of the solution that was thrown away [m/s2].
    """

    def __init__(self, message: str, *, residual: float) -> None:
        self.residual = residual
        super().__init__(message)


class ToleranceError(CutjointError):
    """Two models disagree by more than the tolerance.

    Attributes:
        worst: quantity -> (found, allowed).
    """

    def __init__(self, message: str, *, worst: Mapping[str, tuple[float, float]]) -> None:
        self.worst = dict(worst)
        super().__init__(message)


class RetimingError(CutjointError):
    """No motion along a way keeps its limits.

    Attributes:
        limits: which limits leave none, such as `effort of arm1`.
        place: where on the way, 0 to 1.
        t: when the trajectory was there [s].
    """

    def __init__(self, message: str, *, limits: Sequence[str], place: float, t: float) -> None:
        self.limits, self.place, self.t = tuple(limits), place, t
        super().__init__(message)


class SimulationError(CutjointError):
    """A run could not go on.  Nothing is lost: what was simulated until then is in `result`.

    Attributes:
        t: time of the last good state [s].
        q: actuated coordinates then, shape (n,).
        v: actuated velocities then, shape (n,).
        result: the `cutjoint.simulation.Result` up to `t`.
    """

    def __init__(
        self,
        message: str,
        *,
        t: float,
        q: npt.NDArray[np.float64],
        v: npt.NDArray[np.float64],
        result: object,
    ) -> None:
        self.t, self.q, self.v, self.result = t, _still(q), _still(v), result
        super().__init__(message)


class Interrupted(_Whole, KeyboardInterrupt):
    """Ctrl-C, or a `KeyboardInterrupt` from elsewhere, in a simulation.  Nothing is lost: what was done is in `result`.

    It is a `KeyboardInterrupt` and no `CutjointError`, so that what catches errors does not go on.

    Attributes:
        done: how much was done, 0 to 1.
        result: of `simulation.run` the `Result` until then; of `compile.simulate_many` the `Many` of the first runs
            that were done to their ends, or where they go elsewhere (`into`) their `Summary`; None if there is none.
    """

    def __init__(self, message: str, *, done: float, result: object) -> None:
        self.done, self.result = done, result
        super().__init__(message)


class MissingPackageError(InputError):
    """An optional package is needed and not installed.

    Attributes:
        package: as it is imported.
        extra: the extra of cutjoint that brings it.
    """

    def __init__(self, what: str, package: str, extra: str) -> None:
        self.package, self.extra = package, extra
        super().__init__(f"{what} needs {package}, which is not installed: pip install 'cutjoint[{extra}]'")


class FileError(InputError):
    """A path at which there is no file that could be read.

    Attributes:
        path: as it was given.
        why: what is wrong with it, without the path.
        mend: what to do; empty where that is plain.
        missing: whether nothing is there at all.
    """

    def __init__(self, path: str, why: str, mend: str = "", *, missing: bool = False) -> None:
        self.path, self.why, self.mend, self.missing = path, why, mend, missing
        super().__init__(f"{shown(path)}: {why}{mend and f' ({mend})'}")


class ResultFileError(CutjointError):
    """A result file is damaged, of another version or not a result file at all.

    Attributes:
        path: the file.
    """

    def __init__(self, message: str, *, path: str) -> None:
        self.path = path
        super().__init__(message)


class ViewerError(CutjointError):
    """The viewer cannot start, finds no browser, or waited in vain."""


class BrowserError(ViewerError):
    """The browser that was to take a picture ended, hung or refused, however often it was started.

    Attributes:
        starts: how often it was started.
        status: its exit status the last time, 128 and the number of the signal if one ended it; None if it did not end
            by itself.
        words: the end of what it wrote to its error stream the last time.
    """

    def __init__(self, message: str, *, starts: int, status: int | None, words: str) -> None:
        self.starts, self.status, self.words = starts, status, words
        super().__init__(message)


class CompileError(CutjointError):
    """A model cannot be compiled, or what was compiled does not agree with it."""


class StudyError(CutjointError):
    """A study cannot go on, or its folder is not as it was left.  Blocks that are done are kept.

    Attributes:
        done: how many blocks are done.
    """

    def __init__(self, message: str, *, done: int = 0) -> None:
        self.done = done
        super().__init__(message)


class WaypointError(InputError):
    """A way-point does not fit the others: its time, its place or its orientation.

    Attributes:
        waypoint: its number, from 0.
    """

    def __init__(self, message: str, *, waypoint: int) -> None:
        self.waypoint = waypoint
        super().__init__(message)


class MotionFileError(InputError):
    """A file tells no motion.

    Attributes:
        path: the file.
        line: number of the line that is wrong, from 1; None where it is the whole file.
        column: heading of the column that is wrong; None where it is the whole line.
    """

    def __init__(self, message: str, *, path: str, line: int | None = None, column: str | None = None) -> None:
        self.path, self.line, self.column = path, line, column
        super().__init__(message)
