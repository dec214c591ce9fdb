"""Writing a description, under the name that earlier versions gave it."""

from cutjoint.description.formats import WRITERS, write

__all__ = ["WRITERS", "write"]
