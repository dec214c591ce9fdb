"""The robot.yaml of Gepetto, beside a URDF."""

from cutjoint.description.formats.gepetto.reader import read

__all__ = ["read"]
