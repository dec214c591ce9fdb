"""Reports: plots of results, tables, and one self-contained page of HTML.  Needs matplotlib (extra `report`)."""

from cutjoint.report.figures import LIMBS, ToolPath, figure
from cutjoint.report.page import Section, page
from cutjoint.report.plot import Plot, plot
from cutjoint.report.run_page import RunPage, run_report
from cutjoint.simulation.panels import Panel

__all__ = ["LIMBS", "Panel", "Plot", "RunPage", "Section", "ToolPath", "figure", "page", "plot", "run_report"]
