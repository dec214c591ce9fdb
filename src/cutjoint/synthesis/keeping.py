"""A synthesis on disk: a folder with the new robot, the page old against new, and all designs as a table."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import replace
from pathlib import Path

from cutjoint.description import write
from cutjoint.errors import InputError
from cutjoint.files import check_place, write_whole
from cutjoint.synthesis.result import Synthesis

PAGE, TABLE = "synthesis.html", "designs.csv"


def check_folder(folder: str | os.PathLike[str]) -> Path:
    """A place for a new folder; worth asking before long work.

    Raises:
        InputError: something is there already, or nothing can be written there.
    """
    place = Path(folder)
    if place.is_dir():
        if any(place.iterdir()):
            raise InputError(f"'{place}' is there already and not empty; name a new folder")
        return place
    if place.exists():
        raise InputError(f"'{place}' is a file; name a new folder")
    return check_place(place)


def keep(found: Synthesis, folder: str | os.PathLike[str], page: str, taken: int | None = None) -> tuple[Path, ...]:
    """Write the design that is taken (default: the best) as a robot's folder, `page` beside it, and all designs.

    Raises:
        InputError: the folder is not new, no design does, or nothing can be written.
    """
    place = check_folder(folder)
    robot = found.description(taken)  # another robot than the one of the old name, which a paper may be about
    files = write(replace(robot, name=place.resolve().name), place, "loops")
    return (*files, write_whole(place / PAGE, page), write_whole(place / TABLE, designs_csv(found)))


def designs_csv(found: Synthesis) -> str:
    """All designs, a row each: values of the variables, what they come to, and why they do not do."""
    problem = found.problem
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    units = [f"{one.name} [{found.units[one.name] or '1'}]" for one in problem.wants]
    writer.writerow(
        ["design", *(f"{one.name} [{one.unit or '1'}]" for one in problem.variables), *units, "front", "why"]
    )
    for k, one in enumerate(found.designs):
        values = [repr(float(x)) for x in one.values]
        told = [repr(one.found[want.name]) if want.name in one.found else "" for want in problem.wants]
        writer.writerow([k, *values, *told, int(k in found.front), one.why])
    return text.getvalue()
