"""What a control law is, and how its gains are read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from inspect import Parameter, signature
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.errors import InputError
from cutjoint.motion import Desired
from cutjoint.reprs import line, one_line, short


@runtime_checkable
class Law(Protocol):
    """A feedback law over n actuators.

    `q` and `v` are the measured actuated coordinates and velocities, shape (n,); `memory` is the law's own state, shape
    (m,), which the loop keeps and integrates; m is 0 for a law without memory.
    """

    @property
    def name(self) -> str:
        """For messages and tables."""

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """The gains by name, as nested lists, for reports and result files."""

    def memory(self, n: int) -> int:
        """Number m of the law's own states for n actuators.

        Raises:
            InputError: gains that do not fit n actuators.
        """

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """What the actuators should give, shape (n,), [N] or [N m], before any saturation."""

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Time derivative of the memory, shape (m,); `asked` is the effort before, `given` after saturation."""


@dataclass(frozen=True)
class GainHelp:
    """What a gain is and its unit, as the command line says it.

    It stands at the parameter of the law's constructor, `kp: Annotated[npt.ArrayLike, GainHelp(...)]`, which makes it
    a gain.
    """

    about: str
    unit: str


class Gain:
    """A gain as a scalar (all actuators alike), one number an actuator, or a full matrix.

    Attributes:
        value: read-only array of 0, 1 or 2 dimensions.
    """

    def __init__(self, name: str, value: npt.ArrayLike) -> None:
        """Check what can be checked before the number of actuators is known.

        Raises:
            InputError: not numbers, not finite, negative (scalar or per actuator), or a matrix that is not square.
        """
        self.name = name
        try:
            self.value = readonly(value)
        except (TypeError, ValueError) as error:
            raise InputError(f"gain {name} must be a number, a list or a square matrix, found {value!r}") from error
        if self.value.ndim > 2 or (self.value.ndim == 2 and self.value.shape[0] != self.value.shape[1]):
            raise InputError(f"gain {name} must be a number, a list or a square matrix, found shape {self.value.shape}")
        if not np.isfinite(self.value).all():
            raise InputError(f"gain {name} must be finite, found {self.value.tolist()}")
        if self.value.ndim < 2 and (self.value < 0.0).any():
            raise InputError(f"gain {name} must be >= 0, found {self.value.tolist()}")

    __repr__ = line("name", "value")

    def __reduce__(self) -> tuple[type[Gain], tuple[str, Array]]:
        return Gain, (self.name, self.value)

    def fit(self, n: int) -> None:
        """Raises InputError where the gain is not for n actuators."""
        if self.value.ndim and self.value.shape[0] != n:
            raise InputError(
                f"gain {self.name} has shape {self.value.shape} but the robot has {n} actuators; "
                f"give one number, {n} numbers or a {n} x {n} matrix"
            )

    def __call__(self, error: Array) -> Array:
        """The gain applied to a vector of shape (n,)."""
        return self.value @ error if self.value.ndim == 2 else self.value * error

    @property
    def listed(self) -> list[list[float]]:
        """As nested lists: [[k]] for a scalar, one row for one number an actuator, else the matrix."""
        return np.atleast_2d(self.value).tolist()  # type: ignore[no-any-return]


def law_in_words(law: object) -> str:
    """A law with its gains and their units, in one line."""
    try:
        parameters: Mapping[str, Parameter] = signature(type(law), eval_str=True).parameters
    except (NameError, TypeError, ValueError):
        parameters = {}
    notes = {name: getattr(one.annotation, "__metadata__", ()) for name, one in parameters.items()}
    units = {name: note.unit for name, found in notes.items() for note in found if isinstance(note, GainHelp)}
    model = [f"model={short(law.model)}"] if hasattr(law, "model") else []
    gains = [f"{name}={short(gain.value, units.get(name, ''))}" for name, gain in gains_in(law).items()]
    return one_line(type(law).__name__, [*model, *gains])


def gains_in(law: object) -> dict[str, Gain]:
    """The gains that a law keeps as attributes, by name."""
    return {one.name: one for one in vars(law).values() if isinstance(one, Gain)}
