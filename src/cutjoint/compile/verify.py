"""Compiled functions against the model they were made from, at a few states, before anybody uses them.

This is what makes a stored program trustworthy beyond its digest, and a fresh one beyond the tracer: a function that
does not reproduce the model is refused.  A chain is evaluated in numbers by another way
(`cutjoint.compile.projection`), a published model by itself.
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.compile.agreement import Checker
from cutjoint.compile.chain_trace import ChainSource
from cutjoint.compile.paper_trace import PaperSource
from cutjoint.compile.verify_chain import ChainChecker
from cutjoint.compile.verify_paper import PaperChecker
from cutjoint.mechanism import Mechanism


def checker(source: ChainSource | PaperSource, model: Mechanism, values: Array) -> Checker:
    """The check that `Library` asks for.

    Args:
        source: what is traced.
        model: the same robot, not compiled, with the inertial parameters at `values`.
        values: the parameters' values.
    """
    return ChainChecker(source, values) if isinstance(source, ChainSource) else PaperChecker(source, model, values)
