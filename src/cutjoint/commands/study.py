"""`cutjoint study`: many runs by a file, on all cores or a Dask cluster."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped
from cutjoint.reprs import counted
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.studies import BegunStudy, StudyEstimate, StudySummary

SHOWN = 3
"""Paths of a ranking that are shown."""


# long: its options, a line or three each
def command(
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="What to simulate (docs/studies.md).")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FOLDER", help="Where it is kept; default STUDY-runs beside the file."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Run on the Dask cluster of this scheduler, such as tcp://10.0.0.1:8786."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Threads of this process; default one a processor core.")
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Look at everything, say what it takes, and write nothing.")
    ] = False,
    any_processor: Annotated[
        bool,
        typer.Option("--any-processor", help="Mix kinds of processors, whose last digits may differ."),
    ] = False,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write FOLDER/report.html at the end.")] = True,
    json: options.Json = False,
) -> None:
    """Run a study: many simulations that differ in masses, lengths, gains, trajectories or controllers.

    The file says what varies and how: a grid, Monte Carlo, a Latin hypercube, a Sobol sequence, or the draws for Sobol
    indices. Before it starts it says runs, time, disk and memory, and refuses what cannot be. Runs go into FOLDER as
    Parquet, block by block. One that was interrupted, or killed, goes on where it was: give the same command again.
    """
    from cutjoint.studies import begun, summary_of
    from cutjoint.studies.estimate import check_fits, why_not

    folder = out or study.parent / f"{study.stem}-runs"
    with progress(f"{study.stem}: trying a few runs", None) as told:
        ready = begun(study, folder, scheduler=scheduler, workers=workers, any_processor=any_processor, progress=told)
    with ready:
        if dry_run:
            fault = why_not(ready.estimate)
            if json:
                print_json({**_estimate(ready), "folder": str(folder), "refused": fault or None})
            else:
                _say_estimate(ready, folder)
                say(fault or "It fits; without --dry-run it starts.")
            if fault:
                raise typer.Exit(1)
            return
        check_fits(ready.estimate)
        if not json:
            _say_estimate(ready, folder)
        _run(ready)
    summary = summary_of(folder)
    page = None
    if report:
        from cutjoint.report.answers.study import write_study_page

        with progress(f"{study.stem}: the report"):
            page = write_study_page(summary, folder / "report.html")
    if json:
        print_json({**_estimate(ready), **_data(summary), "folder": str(folder), "report": page and str(page)})
        return
    _show(summary)
    say(f"runs: {folder / 'parts'}" + ("" if page is None else f"; report: {page}"))


def _run(ready: BegunStudy) -> None:
    """Run it; one that is interrupted ends the command.

    Raises:
        typer.Exit: it was interrupted.
    """
    from cutjoint.errors import Interrupted

    try:
        with interrupts.asking(), progress(ready.prepared.recipe.study.name, ready.plan.runs, "runs") as told:
            ready.run(told)
    except Interrupted as error:
        raise stopped(str(error).removeprefix("interrupted; ")) from error


def _estimate(ready: BegunStudy) -> dict[str, object]:
    one: StudyEstimate = ready.estimate
    return {
        "estimate": {
            "runs": one.runs,
            "blocks": one.blocks,
            "blocks_done": one.done,
            "workers": one.workers,
            "seconds_per_run": one.per_run,
            "seconds": one.seconds,
            "disk_bytes": one.disk,
            "disk_free_bytes": one.free,
            "memory_bytes": one.memory,
        },
        "chosen": list(ready.told),
    }


def _say_estimate(ready: BegunStudy, folder: Path) -> None:
    from cutjoint.studies.estimate import size_of, time_of

    one, study = ready.estimate, ready.prepared.recipe.study
    where = "threads" if ready.cluster is None else f"threads of {ready.cluster.address}"
    rows = [
        ("runs", f"{one.runs} ({study.method}), in {counted(one.blocks, 'block')} of {ready.plan.size}"),
        ("time", f"{time_of(one.seconds)} with {one.workers} {where}, {1e3 * one.per_run:.3g} ms a run"),
        ("disk", f"{size_of(one.disk)} in {folder}; {size_of(one.free)} are free"),
        ("memory", f"{size_of(one.memory)}; {size_of(one.available)} are available"),
    ]
    if one.done:
        rows.insert(1, ("done", f"{one.done} of {one.blocks} blocks"))
    show(TextTable(study.name, ("", ""), rows))
    for sentence in ready.told:
        say(sentence)


def _data(summary: StudySummary) -> dict[str, object]:
    from cutjoint.studies.summary import QUANTILES

    case = summary.cases
    return {
        "runs": summary.runs,
        "wanted": summary.wanted,
        "failed": summary.failed,
        "slow": summary.slow,
        "cases": list(case),
        "columns": [
            {
                "case": case[one.case],
                "column": one.column,
                "unit": one.unit,
                "runs": one.runs,
                "mean": one.mean,
                "standard_deviation": one.deviation,
                "least": one.least,
                "largest": one.largest,
                "quantiles": dict(zip(map(str, QUANTILES), one.quantiles.tolist(), strict=True)),
            }
            for one in summary.columns
        ],
        "rankings": [
            {
                "case": case[one.case],
                "column": one.column,
                "explained": one.explained,
                "runs": one.runs,
                "paths": [{name: x for name, x in vars(effect).items() if x is not None} for effect in one.effects],
            }
            for one in summary.rankings
        ],
        "failures": dict(summary.reasons),
        "told": list(summary.told),
    }


def _show(summary: StudySummary) -> None:
    from cutjoint.report.answers.study_tables import failure_table, ranking_tables, summary_tables

    for table in summary_tables(summary):
        show(table)
    for table in ranking_tables(summary, SHOWN):
        show(table)
    if summary.reasons:
        show(failure_table(summary))
    for sentence in summary.told:
        say(sentence)
