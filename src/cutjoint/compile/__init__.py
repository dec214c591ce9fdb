"""Robots as straight-line code: a model is traced once, and what is left is compiled for this processor.

`compiled(model)` takes a closed chain or a published model and gives a `Mechanism` with the same answers, its exact
derivatives, a `batch` for many states at once, and `simulate_many` for many runs.
"""

from cutjoint.compile.batch import Batch
from cutjoint.compile.compiled import (
    CompiledChain,
    CompiledMechanism,
    CompiledPaper,
    Derivatives,
    Options,
    compiled,
)
from cutjoint.compile.library import Made

__all__ = [
    "Batch",
    "CompiledChain",
    "CompiledMechanism",
    "CompiledPaper",
    "Derivatives",
    "Made",
    "Options",
    "compiled",
]
