"""Reports: plots of results, tables, and one self-contained page of HTML.  Needs matplotlib (extra `report`)."""

from cutjoint.report.figures import LIMBS, Panel, ToolPath, figure
from cutjoint.report.page import ReportTable, Section, page

__all__ = ["LIMBS", "Panel", "ReportTable", "Section", "ToolPath", "figure", "page"]
