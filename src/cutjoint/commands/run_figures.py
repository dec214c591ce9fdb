"""What a run comes to, as `cutjoint simulate` tells it: how well it followed, and whether it can be believed."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from cutjoint.commands.output import show
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cutjoint.simulation import Result


def show_run(result: Result, figures: Mapping[str, object]) -> None:
    """Print the `figures_of` a run."""
    from cutjoint.simulation.summary import figure_rows, setting_rows, title_of

    rows = [
        *(("chosen" if i == 0 else "", one) for i, one in enumerate(cast("list[str]", figures.get("chosen", [])))),
        *setting_rows(result),
        *figure_rows(result, figures),
    ]
    if "saved" in figures:
        rows.append(("saved", str(figures["saved"])))
    show(TextTable(title_of(result), ("", ""), rows))
