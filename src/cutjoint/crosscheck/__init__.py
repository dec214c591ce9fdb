"""Two models of one robot, compared at random reachable states.  Knows the interface alone, no robot."""

from cutjoint.crosscheck.compare import (
    QUANTITIES,
    Comparison,
    ComparisonRow,
    Cost,
    compare,
    effort_along,
    hypothesis_cost,
)
from cutjoint.crosscheck.sampling import Reacher, SampledState, TargetBox, sample_states, workspace_box

__all__ = [
    "QUANTITIES",
    "Comparison",
    "ComparisonRow",
    "Cost",
    "Reacher",
    "SampledState",
    "TargetBox",
    "compare",
    "effort_along",
    "hypothesis_cost",
    "sample_states",
    "workspace_box",
]
