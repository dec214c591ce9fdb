"""Reports: plots of results, tables, and one self-contained page of HTML.  Needs matplotlib (extra `report`)."""

from cutjoint.report.figures import Panel, Path, figure
from cutjoint.report.page import Section, page
from cutjoint.report.style import LIMBS
from cutjoint.report.tables import Table

__all__ = ["LIMBS", "Panel", "Path", "Section", "Table", "figure", "page"]
