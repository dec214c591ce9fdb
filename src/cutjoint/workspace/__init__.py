"""The workspace: where the tool of a robot can be, without a singularity between, and how well the robot does there."""

from cutjoint.workspace.map import workspace
from cutjoint.workspace.maps import MAPS
from cutjoint.workspace.region import FieldMap, GridAxis, Workspace

__all__ = ["MAPS", "FieldMap", "GridAxis", "Workspace", "workspace"]
