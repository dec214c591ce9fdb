"""A study as tables, for a terminal and for its page."""

from __future__ import annotations

from collections.abc import Iterator

from cutjoint.studies import PathEffect, Ranking, StudySummary
from cutjoint.tables import TextTable

HEADINGS = ("quantity", "unit", "mean", "std. dev.", "least", "5 %", "median", "95 %", "largest")
INDICES = "S1: what it does alone; ST: with others; ± half a 95 % interval (Saltelli et al. 2010)"
CORRELATIONS = "Spearman's rank correlation, in brackets the standardised regression coefficient"


def summary_tables(summary: StudySummary) -> Iterator[TextTable]:
    """A table a case: mean, spread and quantiles of every quantity."""
    for k in range(len(summary.cases)):
        rows = [
            (
                one.column,
                one.unit,
                *(
                    f"{x:.3g}"
                    for x in (
                        one.mean,
                        one.deviation,
                        one.least,
                        one.quantiles[0],
                        one.quantiles[2],
                        one.quantiles[4],
                        one.largest,
                    )
                ),
            )
            for one in summary.columns
            if one.case == k
        ]
        runs = next((one.runs for one in summary.columns if one.case == k), 0)
        if rows:
            yield TextTable(f"{titled(summary, k)}: {runs} runs", HEADINGS, rows, right=HEADINGS[2:])


def ranking_tables(summary: StudySummary, most: int | None = None) -> Iterator[TextTable]:
    """A table a case: what matters most to which quantity."""
    for k in range(len(summary.cases)):
        own = [one for one in summary.rankings if one.case == k]
        if own:
            rows = [
                (one.column, "" if one.explained is None else f"{one.explained:.2f}", _effects(one, most))
                for one in own
            ]
            note = INDICES if own[0].explained is None else CORRELATIONS
            note += ". R2: share of the variance that a linear fit explains" * (own[0].explained is not None)
            if own[0].explained is None:
                short = [(column, effects) for column, _, effects in rows]
                yield TextTable(f"{titled(summary, k)}: what matters most", ("quantity", "paths"), short, note=note)
            else:
                headings = ("quantity", "R2", "paths")
                yield TextTable(f"{titled(summary, k)}: what matters most", headings, rows, right=("R2",), note=note)


def failure_table(summary: StudySummary) -> TextTable:
    """Why runs failed."""
    rows = [(str(count), why) for why, count in summary.reasons]
    title = f"{summary.failed} of {summary.runs} runs failed"
    return TextTable(title, ("runs", "why"), rows, right=("runs",))


def titled(summary: StudySummary, case: int) -> str:
    """The name of a study and a case."""
    return f"{summary.name} ({summary.cases[case]})" if summary.cases[case] else summary.name


def _effects(ranking: Ranking, most: int | None) -> str:
    shown = ranking.effects[:most]
    more = len(ranking.effects) - len(shown)
    return "; ".join(map(_told, shown)) + (f"; and {more} more" if more else "")


def _told(one: PathEffect) -> str:
    if one.total is not None:
        return f"{one.path} ST {one.total:.2f} ±{one.total_within:.2f}, S1 {one.first:.2f} ±{one.first_within:.2f}"
    return f"{one.path} {one.rank:+.2f} ({one.regression:+.2f})"
