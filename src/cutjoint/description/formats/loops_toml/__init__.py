"""The native format: loops.toml beside a URDF."""

from cutjoint.description.formats.loops_toml.reader import read
from cutjoint.description.formats.loops_toml.writer import native_files

__all__ = ["native_files", "read"]
