"""How much a control law computes at every step: the arithmetic operations between measured state and effort.

The law is run on symbols, as the compiler does, and the operations that its efforts need are counted.  What depends on
the desired motion alone is not among them: it can be computed before the robot moves.
"""

from __future__ import annotations

from cutjoint.compile import CompiledPaper
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.many_loop import measured_state
from cutjoint.compile.sources.law import ReferenceTable, TracedDesired, trace_law
from cutjoint.compile.sources.paper import PaperModel
from cutjoint.control import Law


def operations(law: Law, model: PaperModel) -> int:
    """Operations of one evaluation of `law` on a robot that is `model`; a square root counts as one."""
    plant = CompiledPaper(model)
    n = plant.n
    graph = Graph()
    state = graph.symbols(plant.source.positions + n)
    measured, v = state[:-n], state[-n:]
    table = ReferenceTable(graph)
    traced = plant.source.state(graph, measured, [])
    desired = TracedDesired(table, n, model)
    made = trace_law(
        law, table, desired, traced, v, [], {}, None, lambda one: measured_state(one, plant, traced, graph)
    )
    needed = graph.ancestors([graph.reference(one) for one in made.effort])
    return sum(graph.op[node] not in (Op.CONST, Op.INPUT) for node in needed)
