"""MJCF, the format of MuJoCo."""

from cutjoint.description.formats.mjcf.reader import read
from cutjoint.description.formats.mjcf.writer import mjcf_files

__all__ = ["mjcf_files", "read"]
