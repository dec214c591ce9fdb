"""The workspace: where the tool of a robot can be, without a singularity between, and how well the robot does there."""

from cutjoint.workspace.certified import Certificate, CounterExample, certify
from cutjoint.workspace.map import workspace, workspaces
from cutjoint.workspace.maps import MAPS
from cutjoint.workspace.orientations import orientation_workspace
from cutjoint.workspace.region import FieldMap, GridAxis, Workspace

__all__ = [
    "MAPS",
    "Certificate",
    "CounterExample",
    "FieldMap",
    "GridAxis",
    "Workspace",
    "certify",
    "orientation_workspace",
    "workspace",
    "workspaces",
]
