"""The compiled form of a model: which class serves it, and which functions it can have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.functions.library import Made
from cutjoint.compile.functions.table import BUILDERS, CHAIN_ONLY, PAPER_ONLY
from cutjoint.compile.mechanism import Options
from cutjoint.errors import InputError
from cutjoint.papers.reduced_model import ClosedFormModel

Compiled = CompiledChain | CompiledPaper


def compiled(
    model: Any,
    *,
    parameters: Sequence[str] = (),
    fast: bool = False,
    cached: bool = True,
    report: Callable[[Made], None] | None = None,
) -> Compiled:
    """A closed chain or published model, compiled.

    Args:
        model: a `ClosedChain` or a published model.
        parameters: inertial parameters that stay arguments: `payload`, for a chain also names of links (their masses
            [kg]), for a published model also fields of its parameters.
        fast: allow fast-math.
        cached: use the cache folder.
        report: called with every function that was made.

    Raises:
        InputError: neither of the two.
        UnknownNameError: parameters that the model does not have.
    """
    options = Options(tuple(parameters), fast, cached, report)
    if isinstance(model, ClosedFormModel):
        return CompiledPaper(model, options)
    if hasattr(model, "full_forward_dynamics") and hasattr(model, "description"):
        return CompiledChain(model, options)
    raise InputError(
        f"only closed chains and published models with closed forward kinematics can be compiled, found "
        f"{type(model).__name__}; compile the robot's closed chain"
    )


def functions_of(mechanism: Compiled) -> tuple[str, ...]:
    """Names of the functions that a compiled mechanism can have (see `CompiledMechanism.kernel`)."""
    if isinstance(mechanism, CompiledPaper):
        return tuple(name for name in BUILDERS if name not in CHAIN_ONLY)
    source = mechanism.source
    if not source.determined:
        return ("full_forward",)
    missing = {*PAPER_ONLY, *(() if source.has_tool else ("tool",)), *(("full_forward",) if source.weightless else ())}
    return tuple(name for name in BUILDERS if name not in missing)
