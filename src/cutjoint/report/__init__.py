"""Reports: plots of results, tables, and one self-contained page of HTML.  Needs matplotlib (extra `report`)."""

from cutjoint.report.figures import COLOURS, DASHES, LIMBS, ToolPath, figure
from cutjoint.report.page import Section, page
from cutjoint.report.run_page import RunPage, run_report
from cutjoint.report.run_plot import Plot, plot
from cutjoint.simulation.panels import Panel

__all__ = [
    "COLOURS",
    "DASHES",
    "LIMBS",
    "Panel",
    "Plot",
    "RunPage",
    "Section",
    "ToolPath",
    "figure",
    "page",
    "plot",
    "run_report",
]
