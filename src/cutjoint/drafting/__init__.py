"""Beginnings: new robots from templates, and where to cut a robot that is there already."""

from cutjoint.drafting.folder import Draft, draft, write_draft
from cutjoint.drafting.templates import TEMPLATES, Template

__all__ = ["TEMPLATES", "Draft", "Template", "draft", "write_draft"]
