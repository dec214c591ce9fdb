"""A model whose inertial parameters are arguments of compiled code: their values, and the model that has them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Generic, Self, TypeVar

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.compile.functions.library import Options
from cutjoint.compile.once import once
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism

Model_co = TypeVar("Model_co", bound=Mechanism, covariant=True)


class Parametrised(Generic[Model_co]):
    """A model and the present values of the inertial parameters that are arguments; who it is, it takes from the model.

    Args:
        model: the model.
        options: how it is compiled.
        values: of the parameters that are arguments, as the model has them [kg].

    Attributes:
        name, n, actuators, home: see `Mechanism`; those of the model.
    """

    def __init__(self, model: Model_co, options: Options, values: Array) -> None:
        self.model, self.options = model, options
        self.name, self.n, self.actuators, self.home = f"{model.name}, compiled", model.n, model.actuators, model.home
        self._values = self._nominal = readonly(values)
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        # machine code stays behind, and so does whoever is told of functions that are made
        return _restored, (type(self), self.model, replace(self.options, report=None), self._values)

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the inertial parameters that are arguments [kg]."""
        return dict(zip(self.options.parameters, self._values.tolist(), strict=True))

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

    def with_parameters(self, **values: float) -> Self:
        """The same compiled code with other values of the parameters that are arguments; nothing is compiled.

        Raises:
            UnknownNameError: one of them is not an argument.
            InputError: not a finite mass >= 0.
        """
        changed = np.array(self._values)
        for name, value in values.items():
            if name not in self.options.parameters:
                raise UnknownNameError("parameter of the compiled functions", name, self.options.parameters)
            if not np.isfinite(value):
                raise InputError(f"parameter {name} must be a finite number, found {value!r}")
            changed[self.options.parameters.index(name)] = value
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._lock = threading.RLock()
        for cached in ("batch", "_plain_with_values"):
            other.__dict__.pop(cached, None)
        other._values = readonly(changed)
        return other


def _restored(
    kind: Callable[[Mechanism, Options], Parametrised[Mechanism]], model: Mechanism, options: Options, values: Array
) -> Parametrised[Mechanism]:
    """A compiled mechanism that was pickled."""
    return kind(model, options).with_parameters(**dict(zip(options.parameters, values.tolist(), strict=True)))
