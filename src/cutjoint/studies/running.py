"""A study from its file to its folder: looked at, weighed, and run block by block, here or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict, Unpack

from cutjoint import interrupts
from cutjoint.doors import door
from cutjoint.errors import InputError, Interrupted
from cutjoint.extras import needed
from cutjoint.reprs import line
from cutjoint.studies.blocks import BlockPlan, Prepared, processor, workers_here
from cutjoint.studies.cases import recipe_of
from cutjoint.studies.cluster import DaskCluster
from cutjoint.studies.estimate import StudyEstimate, check_fits, estimate_of
from cutjoint.studies.extremes import check_extremes
from cutjoint.studies.folder import StudyFolder
from cutjoint.studies.here import run_here
from cutjoint.studies.study_file import read_study
from cutjoint.studies.taking import Taken
from cutjoint.studies.values import Study

Progress = Callable[[float], None]


class StudyOptions(TypedDict, total=False):
    """Of `begun` and `run_study`, by name."""

    scheduler: str | None
    workers: int | None
    any_processor: bool


@dataclass(frozen=True, eq=False)
class BegunStudy:
    """A study that was looked at and may run; a context, which leaves its cluster.

    Attributes:
        folder: where it is kept.
        plan: how its runs are cut into blocks.
        estimate: what it will take.
        told: what was chosen unasked.
    """

    prepared: Prepared
    folder: StudyFolder
    plan: BlockPlan
    estimate: StudyEstimate
    told: tuple[str, ...]
    cluster: DaskCluster | None
    any_processor: bool
    stack: ExitStack

    __repr__ = line("folder", "plan", "estimate")

    def __enter__(self) -> BegunStudy:
        return self

    def __exit__(self, *_: object) -> None:
        self.stack.close()

    def run(self, progress: Progress | None = None) -> StudyFolder:
        """Run what is not done.  `progress` hears how many runs are done.

        Raises:
            InputError: it does not fit, or the folder holds something else.
            StudyError: the cluster is gone, or a block in the folder is damaged; what is done is kept.
            Interrupted: a `KeyboardInterrupt` came; `result` is the folder, from which the same call goes on.
        """
        check_fits(self.estimate)
        kinds = [processor()] if self.cluster is None else self.cluster.processors
        self.folder.begin()
        todo = [k for k in range(self.plan.count) if k not in self.folder.done]
        spans = map(self.plan.span, self.folder.done)
        taken = Taken(self.folder, sum(one.end - one.begin for one in spans), progress)
        try:
            for kind in kinds[1:]:
                self.folder.also(kind)
            if self.cluster is None:
                run_here(self.prepared, self.plan, todo, self.estimate.workers, taken)
            else:
                self.cluster.run(self.prepared, self.plan, todo, taken, any_processor=self.any_processor)
        except KeyboardInterrupt as error:
            done, count = len(self.folder.done), self.plan.count
            told = f"interrupted; {done} of {count} blocks are in '{self.folder.path}', the same command goes on"
            raise Interrupted(told, done=done / count, result=self.folder) from error
        finally:
            with interrupts.held():
                self.folder.finish()
        return self.folder


@door
def begun(
    study: Study | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    any_processor: bool = False,
    progress: Progress | None = None,
) -> BegunStudy:
    """Look at all of a study, try some runs and say what it will take; nothing is written.

    Args:
        study: what `read_study` gives, or the path of a study file.
        out: folder of the study.
        scheduler: address of the scheduler of a Dask cluster; default threads of this process.
        workers: threads of this process; default one a processor core.
        any_processor: mix blocks of several kinds of processor, whose last digits may differ.
        progress: hears how many cases are tried.

    Raises:
        DescriptionError: the study file, or one of the robot, is wrong.
        UnknownNameError: no such robot, variant, trajectory, controller, gain or path.
        InputError: what it says does not fit the robot, the robot does not close at an end of the ranges, the
            scheduler does not answer, or the folder holds something else.
        MissingPackageError: an optional package is not installed.
    """
    made = study if isinstance(study, Study) else read_study(study)
    _ = made.total
    needed("pyarrow", "a study")
    needed("llvmlite.binding", "a study")
    if made.method == "saltelli":
        needed("SALib", "the Sobol indices of a study")
    if workers is not None and workers < 1:
        raise InputError(f"workers must be a whole number >= 1, found {workers}")
    if workers is not None and scheduler is not None:
        raise InputError("workers are threads of this process; a cluster has its own")
    with ExitStack() as stack:
        cluster = None if scheduler is None else stack.enter_context(DaskCluster(scheduler))
        if cluster is not None and len(cluster.processors) > 1 and not any_processor:
            raise InputError(
                f"the workers have several kinds of processors ({', '.join(cluster.processors)}), whose last digits "
                "may differ; take workers of one kind, or --any-processor"
            )
        prepared = Prepared(recipe_of(made))
        plan = prepared.plan()
        check_extremes(prepared)
        folder = StudyFolder(out)
        folder.check(prepared, plan, processor() if cluster is None else cluster.processors[0], any_processor)
        threads = workers or workers_here() if cluster is None else cluster.threads
        estimate = estimate_of(prepared, plan, folder.path, threads, len(folder.done), progress)
        told = prepared.recipe.told
        return BegunStudy(prepared, folder, plan, estimate, told, cluster, any_processor, stack.pop_all())
    raise AssertionError("not reached")


@door
def run_study(
    study: Study | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    progress: Progress | None = None,
    **options: Unpack[StudyOptions],
) -> Path:
    """Run a study, or go on with one that was interrupted or killed, and give its folder.

    Args:
        study: see `begun`, as all that is not told here.
        out: see `begun`.
        progress: hears how many runs are done.

    Raises:
        InputError, DescriptionError, UnknownNameError: see `begun`.
        StudyError, Interrupted: see `BegunStudy.run`.
    """
    with begun(study, out, **options) as ready:
        return ready.run(progress).path
