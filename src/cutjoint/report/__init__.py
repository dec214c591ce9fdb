"""Reports: plots of results, tables, and one self-contained page of HTML.  Needs matplotlib (extra `report`)."""

from cutjoint.report.figures import LIMBS, ToolPath, figure
from cutjoint.report.page import Section, page
from cutjoint.simulation.panels import Panel

__all__ = ["LIMBS", "Panel", "Section", "ToolPath", "figure", "page"]
