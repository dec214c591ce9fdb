"""Robots as straight-line code: a model is traced once, and what is left is compiled for this processor.

`compiled(model)` takes a closed chain or a published model and gives a `Mechanism` with the same answers, its exact
derivatives, a `batch` for many states at once, and `simulate_many` for many runs.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from cutjoint.compile.batch import Batch
from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_minimal import CompiledMinimal
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.compiler import Compiled, compiled, functions_of
from cutjoint.compile.functions.library import Made, Options
from cutjoint.compile.mechanism import CompiledMechanism, Derivatives
from cutjoint.compile.plants import CompiledChainPlant, CompiledPaperPlant, compiled_plant

if TYPE_CHECKING:
    from cutjoint.compile.many.closed_loop import ClosedLoop, simulate_many
    from cutjoint.compile.many.results import Many

_LAZY = {"ClosedLoop": "closed_loop", "simulate_many": "closed_loop", "Many": "results"}

__all__ = [
    "Batch",
    "ClosedLoop",
    "Compiled",
    "CompiledChain",
    "CompiledChainPlant",
    "CompiledMechanism",
    "CompiledMinimal",
    "CompiledPaper",
    "CompiledPaperPlant",
    "Derivatives",
    "Made",
    "Many",
    "Options",
    "compiled",
    "compiled_plant",
    "functions_of",
    "simulate_many",
]


def __getattr__(name: str) -> object:
    if name in _LAZY:
        return getattr(import_module(f"cutjoint.compile.many.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'cutjoint.compile' has no attribute '{name}'")
