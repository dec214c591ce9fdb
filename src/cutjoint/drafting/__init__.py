"""Beginnings: new robots from templates, and where to cut a robot that is there already."""

from cutjoint.drafting.folder import NewRobot, draft, write_draft
from cutjoint.drafting.templates import TEMPLATES, Template

__all__ = ["TEMPLATES", "NewRobot", "Template", "draft", "write_draft"]
