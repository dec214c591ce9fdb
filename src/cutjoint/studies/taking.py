"""Who takes blocks that are done: into the folder, each once, and tells how far the study is."""

from __future__ import annotations

from collections.abc import Callable

from cutjoint import interrupts
from cutjoint.studies.folder import StudyFolder


class Taken:
    """Takes blocks.

    Args:
        folder: where they go.
        runs: that are there already.
        progress: hears how many runs are done.
    """

    def __init__(self, folder: StudyFolder, runs: int, progress: Callable[[float], None] | None) -> None:
        self.folder, self._runs, self._progress = folder, runs, progress
        self._most = 0.0

    def block(self, number: int, content: bytes, runs: int) -> None:
        """A block that is done."""
        if self.folder.take(number, content):
            self._runs += runs
        self.look()

    def look(self, going: float = 0.0) -> None:
        """Tell how far it is, with so many runs of blocks that are not done; the place where a signal stops it.

        Raises:
            KeyboardInterrupt: a signal came.
        """
        interrupts.check()
        self._most = max(self._most, self._runs + going)
        if self._progress is not None:
            self._progress(self._most)
