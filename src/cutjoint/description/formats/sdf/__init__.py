"""SDF, the format of Gazebo."""

from cutjoint.description.formats.sdf.reader import read

__all__ = ["read"]
