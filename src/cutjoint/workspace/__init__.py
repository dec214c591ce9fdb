"""The workspace: where the tool of a robot can be, without a singularity between, and how well the robot does there."""

from cutjoint.workspace.certified import Certificate, CounterExample, certify
from cutjoint.workspace.region import FieldMap, GridAxis, Workspace

__all__ = ["Certificate", "CounterExample", "FieldMap", "GridAxis", "Workspace", "certify"]
