"""The workspace: where the tool of a robot can be, without a singularity between, and how well the robot does there."""

from cutjoint.workspace.certified import Certificate, CounterExample, certify
from cutjoint.workspace.files import load, save
from cutjoint.workspace.fitting import FittedShape, largest
from cutjoint.workspace.in_world import WorldShape, in_world
from cutjoint.workspace.map import workspace, workspaces
from cutjoint.workspace.maps import MAPS
from cutjoint.workspace.orientations import orientation_workspace
from cutjoint.workspace.region import FieldMap, GridAxis, Workspace
from cutjoint.workspace.surface import Surface, surface, write_surface

__all__ = [
    "MAPS",
    "Certificate",
    "CounterExample",
    "FieldMap",
    "FittedShape",
    "GridAxis",
    "Surface",
    "Workspace",
    "WorldShape",
    "certify",
    "in_world",
    "largest",
    "load",
    "orientation_workspace",
    "save",
    "surface",
    "workspace",
    "workspaces",
    "write_surface",
]
