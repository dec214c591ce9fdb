"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  A chain is evaluated in numbers by another way
(`cutjoint.compile.functions.chain_numbers`), a published model by itself.
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.compile.functions.sample import Checker
from cutjoint.compile.functions.chain_truth import ChainChecker
from cutjoint.compile.functions.paper_truth import PaperChecker
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.mechanism import Mechanism


def checker(source: ChainSource | PaperSource, model: Mechanism, values: Array) -> Checker:
    """The check that `Library` asks for.

    Args:
        source: what is traced.
        model: the same robot, not compiled, with the inertial parameters at `values`.
        values: the parameters' values.
    """
    return ChainChecker(source, values) if isinstance(source, ChainSource) else PaperChecker(source, model, values)
