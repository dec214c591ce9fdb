"""Studies: many runs over any parameters, by a file, on all cores or a Dask cluster, streamed and resumed."""

from cutjoint.studies.estimate import StudyEstimate
from cutjoint.studies.ranking import PathEffect, Ranking
from cutjoint.studies.running import BegunStudy, begun, run_study
from cutjoint.studies.study_file import read_study
from cutjoint.studies.summary import ColumnSummary, StudySummary, summary_of, table_of
from cutjoint.studies.values import Study

__all__ = [
    "BegunStudy",
    "ColumnSummary",
    "PathEffect",
    "Ranking",
    "Study",
    "StudyEstimate",
    "StudySummary",
    "begun",
    "read_study",
    "run_study",
    "summary_of",
    "table_of",
]
