"""The native format: loops.toml beside a URDF."""

from cutjoint.description.formats.loops_toml.reader import native_files, read

__all__ = ["native_files", "read"]
