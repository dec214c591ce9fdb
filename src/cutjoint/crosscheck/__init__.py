"""Two models of one robot, compared at random reachable states.  Knows the interface alone, no robot."""

from cutjoint.crosscheck.compare import QUANTITIES, Comparison, Row, compare
from cutjoint.crosscheck.cost import Cost, effort_along, hypothesis_cost
from cutjoint.crosscheck.sampling import Reacher, State, Workspace, sample_states, workspace_box

__all__ = [
    "QUANTITIES",
    "Comparison",
    "Cost",
    "Reacher",
    "Row",
    "State",
    "Workspace",
    "compare",
    "effort_along",
    "hypothesis_cost",
    "sample_states",
    "workspace_box",
]
