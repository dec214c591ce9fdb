"""The compiled form of a model: which class serves it, and which functions it can have."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cutjoint.chain import ClosedChain
from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.functions.library import Made, Options
from cutjoint.compile.functions.table import FUNCTIONS
from cutjoint.errors import InputError
from cutjoint.papers.reduced_model import ClosedFormModel

Compiled = CompiledChain | CompiledPaper


def compiled(
    model: object,
    *,
    parameters: Sequence[str] = (),
    fast: bool = False,
    cached: bool = True,
    report: Callable[[Made], None] | None = None,
    backend: str = "llvm",
    quick: bool = False,
) -> Compiled:
    """A closed chain or published model, compiled.

    Args:
        model: a `ClosedChain` or a published model.
        parameters: inertial parameters that stay arguments: `payload`, for a chain also names of links (their masses
            [kg]), for a published model also fields of its parameters.
        fast: allow fast-math.
        cached: use the cache folder.
        report: called with every function that was made.
        backend: what makes machine code of the instructions, a name of `cutjoint.compile.machine.backends`.
        quick: machine code that is made in a third of the time, and a third as quick; the digits are the same.

    Raises:
        InputError: neither of the two.
        UnknownNameError: parameters that the model does not have, or no such back end.
    """
    options = Options(tuple(parameters), fast, cached, report, backend, quick)
    if isinstance(model, ClosedFormModel):
        return CompiledPaper(model, options)
    if isinstance(model, ClosedChain):
        return CompiledChain(model, options)
    raise InputError(
        f"only closed chains and published models with closed forward kinematics can be compiled, found "
        f"{type(model).__name__}; compile the robot's closed chain"
    )


def functions_of(mechanism: Compiled) -> tuple[str, ...]:
    """Names of the functions that a compiled mechanism can have (see `CompiledMechanism.kernel`)."""
    source = mechanism.source
    return tuple(row.name for row in FUNCTIONS.values() if not any(source.lacks(need) for need in row.needs))
