"""The compiled form of a model: which class serves it, and which functions it can have."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import overload

import numpy.typing as npt

from cutjoint.chain import ClosedChain
from cutjoint.chain.minimal import MinimalCoordinates
from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_minimal import CompiledMinimal
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.functions.library import Made, Options
from cutjoint.compile.functions.table import FUNCTIONS
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.papers.reduced_model import ClosedFormModel

Compiled = CompiledChain | CompiledPaper


@overload
def compiled(  # type: ignore[overload-overlap]  # minimal coordinates are no mechanism
    model: MinimalCoordinates,
    *,
    parameters: Sequence[str] = ...,
    ranges: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]] | None = ...,
    fast: bool = ...,
    cached: bool = ...,
    report: Callable[[Made], None] | None = ...,
    backend: str = ...,
    quick: bool = ...,
) -> CompiledMinimal: ...
@overload
def compiled(
    model: object,
    *,
    parameters: Sequence[str] = ...,
    ranges: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]] | None = ...,
    fast: bool = ...,
    cached: bool = ...,
    report: Callable[[Made], None] | None = ...,
    backend: str = ...,
    quick: bool = ...,
) -> Compiled: ...
@door
def compiled(
    model: object,
    *,
    parameters: Sequence[str] = (),
    ranges: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]] | None = None,
    fast: bool = False,
    cached: bool = True,
    report: Callable[[Made], None] | None = None,
    backend: str = "llvm",
    quick: bool = False,
) -> Compiled | CompiledMinimal:
    """A closed chain, its minimal coordinates, or a published model, compiled.

    Args:
        model: a `ClosedChain`, `MinimalCoordinates` or a published model.
        parameters: what stays an argument: `payload`; for a chain also paths into its description
            (`cutjoint.description.paths`) and names of links (their masses [kg]), for a published model fields of its
            parameters.
        ranges: of a chain's parameters, (least, largest), for which the order of elimination shall be good; default a
            neighbourhood of their values.
        fast: allow fast-math.
        cached: use the cache folder.
        report: called with every function that was made.
        backend: what makes machine code of the instructions, a name of `cutjoint.compile.machine.backends`.
        quick: machine code that is made in a third of the time, and a third as quick; the digits are the same.

    Raises:
        InputError: none of these, ranges that are none, or parameters of minimal coordinates.
        UnknownNameError: parameters that the model does not have, or no such back end.
    """
    options = Options(tuple(parameters), fast, cached, report, backend, dict(ranges or {}), quick)
    if isinstance(model, ClosedFormModel):
        if ranges:
            raise InputError("ranges are for the parameters of closed chains; a published model needs none")
        return CompiledPaper(model, options)
    if isinstance(model, ClosedChain):
        return CompiledChain(model, options)
    if isinstance(model, MinimalCoordinates):
        return CompiledMinimal(model, options)
    raise InputError(
        f"only closed chains and published models with closed forward kinematics can be compiled, found "
        f"{type(model).__name__}; compile the robot's closed chain"
    )


@door
def functions_of(mechanism: Compiled | CompiledMinimal) -> tuple[str, ...]:
    """Names of the functions that a compiled mechanism or minimal coordinates can have (see `kernel`)."""
    source = mechanism.source
    return tuple(row.name for row in FUNCTIONS.values() if not any(source.lacks(need) for need in row.needs))
