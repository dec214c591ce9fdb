"""A model and the values of what is an argument of its compiled functions: other values are the same code."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Generic, Self, TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Sealed, readonly
from cutjoint.compile.functions.library import Options
from cutjoint.compile.once import once
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.reprs import one_line, quoted, short

Model_co = TypeVar("Model_co", bound=Mechanism, covariant=True)


class Parametrised(Sealed, Generic[Model_co]):
    """A model and the present values of the parameters that are arguments; who it is, it takes from the model.

    Args:
        model: the model.
        options: how it is compiled.
        values: of the parameters that are arguments, as the model has them.

    Attributes:
        name, n, actuators: see `Mechanism`; those of the model.
    """

    _forgotten: tuple[str, ...] = ("batch", "home", "_plain_with_values")
    """What depends on the values of the parameters."""

    def __init__(self, model: Model_co, options: Options, values: Array) -> None:
        self.model, self.options = model, options
        self.name, self.n, self.actuators = f"{model.name}, compiled", model.n, model.actuators
        self._values = self._nominal = readonly(values)
        self._lock = threading.RLock()

    def __repr__(self) -> str:
        names = short([f"{one.name} [{one.unit}]" for one in self.actuators])
        arguments = [f"parameters={short(self.parameters)}"] if self.options.parameters else []
        return one_line(type(self).__name__, [quoted(self.name), f"actuators={names}", *arguments])

    def __reduce__(self) -> tuple[object, ...]:
        # machine code stays behind, and so does whoever is told of functions that are made
        return _restored, (type(self), self.model, replace(self.options, report=None), self._values)

    @once
    def home(self) -> Posture:
        """See `Mechanism.home`."""
        return self.model.home

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters that are arguments."""
        return dict(zip(self.options.parameters, self._values.tolist(), strict=True))

    @property
    def nominal(self) -> dict[str, float]:
        """Their values in the model itself."""
        return dict(zip(self.options.parameters, self._nominal.tolist(), strict=True))

    @property
    def plain(self) -> Model_co:
        """The model that is not compiled, with the present parameters."""
        if np.array_equal(self._values, self._nominal):
            return self.model
        return self._plain_with_values

    @once
    def _plain_with_values(self) -> Model_co:
        return self._rebuilt(self.parameters)

    def _rebuilt(self, parameters: Mapping[str, float]) -> Model_co:
        raise NotImplementedError

    def with_parameters(self, values: Mapping[str, npt.ArrayLike] | None = None, /, **more: npt.ArrayLike) -> Self:
        """The same compiled code with other values of the parameters that are arguments; nothing is compiled.

        Args:
            values, more: by name; paths have dots, so they stand in `values`.

        Raises:
            UnknownNameError: one of them is not an argument.
            InputError: no finite number, or negative where that means nothing.
        """
        changed = np.array(self._values)
        for name, value in self.columns({**(values or {}), **more}).items():
            if value.ndim:
                raise InputError(f"parameter {name} must be one number, found shape {value.shape}")
            changed[self.options.parameters.index(name)] = value
        return self._with(changed)

    def _with(self, values: Array) -> Self:
        """The same with other values of all parameters."""
        other = object.__new__(type(self))
        other.__dict__.update({name: own for name, own in self.__dict__.items() if name not in self._forgotten})
        other._lock = threading.RLock()
        other._values = readonly(values)
        return other

    def arrays(self, values: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
        """Values of parameters for many states or runs, an array each.

        Raises:
            InputError: one of them is not an argument, or not finite numbers.
        """
        try:
            return self.columns(values)
        except UnknownNameError as error:
            raise InputError(f"'{error.name}' is not an argument: {error}; name it when compiling") from error

    def columns(self, values: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
        """Values of parameters by name as an array each, checked.

        Raises:
            UnknownNameError: one of them is not an argument.
            InputError: not finite numbers.
        """
        found: dict[str, Array] = {}
        for name, given in values.items():
            if name not in self.options.parameters:
                raise UnknownNameError("parameter of the compiled functions", name, self.options.parameters)
            try:
                found[name] = np.asarray(given, dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError(f"parameter {name} must be numbers, found {given!r}") from error
            if not np.isfinite(found[name]).all():
                raise InputError(f"parameter {name} must be a finite number, found {given!r}")
        return found


def _restored(
    kind: Callable[[Mechanism, Options], Parametrised[Mechanism]], model: Mechanism, options: Options, values: Array
) -> Parametrised[Mechanism]:
    """A compiled mechanism that was pickled."""
    return kind(model, options)._with(values)
