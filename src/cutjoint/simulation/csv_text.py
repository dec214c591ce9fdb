"""Columns with a heading each as the text of a CSV file, in which any heading can be read back."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array


def csv_text(titles: Sequence[str], columns: Sequence[Array]) -> str:
    """A row of titles, then one a sample; lines end with a line feed.

    Args:
        titles: one a column of the table.
        columns: shape (samples,) or (samples, m) each.
    """
    head, buffer = io.StringIO(), io.StringIO()
    # Python's writer quotes what its own ends of lines have in them, and readers break lines at both.
    csv.writer(head, lineterminator="\r\n").writerow(titles)
    buffer.write(head.getvalue().removesuffix("\r\n") + "\n")
    csv.writer(buffer, lineterminator="\n").writerows(np.column_stack(list(columns)).tolist())
    return buffer.getvalue()
