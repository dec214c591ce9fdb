"""docs/corpus.md of what was found."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from published.contents import TIES

Found = Mapping[str, object]

AGREES = 1e-8
"""Up to this relative difference accelerations count as those of MuJoCo."""
_HEAD = """\
# Published robots

Written by `tools/corpus.py FOLDER --page`; the files, with addresses and commits, are listed in
`tools/published/corpus.toml`. They are fetched by hand for a run and are no part of this repository.

Each file is read, strictly and where that fails leniently, its loops are closed at home, and the robot is let go there,
at rest and in motion. Files of MJCF are also loaded by MuJoCo itself: mass matrix, bias, passive forces and the rows of
the active equalities at the same posture, solved for constraints that do not give. Limits, contacts, dry friction and
actuators are switched off for that. What closes loops or couples joints is counted in the text of each file by other
code than the readers', and compared with what was read.
"""
_LEGEND = """\
*In file* counts what closes loops, couples joints or draws on them in the text, *read* the cuts (c), bushings (b) and
couplings (k) that were made of it; a tendon that an actuator draws on is a coupling too. *Mobility* is that at home,
of so many velocities of the open tree. *MuJoCo* is the largest relative difference of accelerations at home, at rest
and in motion; `=` stands for at most 1e-8, and numbers in brackets are explained below.
"""


def page(found: Sequence[Found], judged: Mapping[str, str], versions: str) -> str:
    """The document: numbers, a row a robot, and the reasons.

    Args:
        found: what `trial` found, in the order of the list.
        judged: name -> what a person says to a verdict or a difference.
        versions: what it was run with.
    """
    notes = [one for one in found if str(one["name"]) in judged or one["verdict"] != "loads" or _differs(one)]
    numbers = {id(one): number for number, one in enumerate(notes, 1)}
    lines = [_HEAD, _summary(found), "", f"Run with {versions}.", "", _LEGEND]
    lines += [
        "| robot | source | format | verdict | in file | read | mobility | MuJoCo |",
        "|---|---|---|---|---|---|---|---|",
    ]
    sources = list(dict.fromkeys((str(one["address"]), str(one["commit"])) for one in found))
    for one in found:
        source = sources.index((str(one["address"]), str(one["commit"]))) + 1
        note = f" [{numbers[id(one)]}]" if id(one) in numbers else ""
        lines.append(f"| {one['name']} | {source} | {one.get('format', '')} | {one['verdict']}{note} | {_row(one)} |")
    lines += ["", "## Reasons", ""]
    for one in notes:
        lines += _note(numbers[id(one)], one, judged.get(str(one["name"]), ""))
    lines += ["", "## Sources", ""]
    for number, (address, commit) in enumerate(sources, 1):
        place = (
            f"`{address.removeprefix('pypi:')}` of PyPI"
            if address.startswith("pypi:")
            else f"`{address}` at {commit[:12]}"
        )
        lines.append(f"{number}. {place}")
    return "\n".join(lines) + "\n"


def _summary(found: Sequence[Found]) -> str:
    verdicts = Counter(str(one["verdict"]) for one in found)
    compared = [value for one in found if (value := worst(one)) is not None]
    agree = sum(value <= AGREES for value in compared)
    told = ", ".join(f"{number} {verdict}" for verdict, number in sorted(verdicts.items()))
    loaded = sum(number for verdict, number in verdicts.items() if verdict.startswith("loads"))
    share = 100.0 * loaded / max(1, len(found))
    return textwrap.fill(
        f"**{len(found)} files: {told}; {share:.0f} % load and close. Of {len(compared)} that MuJoCo loads as well,"
        f" {agree} have its accelerations to {AGREES:g}.**",
        119,
    )


def worst(one: Found) -> float | None:
    """The largest difference to MuJoCo, NaN where the two could not be compared; None where MuJoCo was not asked."""
    peer = one.get("mujoco")
    if not isinstance(peer, Mapping):
        return None
    values = [float(peer["rest"]), float(peer["moving"])]
    return math.nan if any(math.isnan(value) for value in values) else max(values)


def _differs(one: Found) -> bool:
    value = worst(one)
    return "dynamics" in one or lost(one) or (value is not None and not value <= AGREES)


def lost(one: Found) -> bool:
    """Whether fewer cuts and couplings were made than the text of the file has."""
    counted, made = one.get("closures"), one.get("made")
    return isinstance(counted, int) and isinstance(made, int) and made < counted


def _row(one: Found) -> str:
    contents = one.get("contents")
    counted = sum(number for kind, number in contents.items() if kind in _TIES) if isinstance(contents, Mapping) else 0
    has_xacro = isinstance(contents, Mapping) and "xacro" in contents
    read = one.get("read")
    made = "-"
    if isinstance(read, Mapping):
        cuts = sum(number for kind, number in read.items() if kind not in ("couplings", "bushings"))
        parts = ((cuts, "c"), (read["bushings"], "b"), (read["couplings"], "k"))
        made = " ".join(f"{number}{kind}" for number, kind in parts if number) or "0"
    mobility = f"{one['mobility']} of {one['velocities']}" if "mobility" in one else "-"
    value = worst(one)
    peer = "-" if value is None else "=" if value <= AGREES else f"{value:.0e}"
    return " | ".join(("xacro" if has_xacro else str(counted), made, mobility, peer))


_TIES = TIES | {"tendon actuator"}
"""What a reader makes cuts and couplings of, one each at least."""


def _note(number: int, one: Found, judged: str) -> list[str]:
    """A robot's entry among the reasons."""
    told: list[str] = []
    verdict = str(one["verdict"])
    if verdict != "loads":
        told += _some(one.get("strict") if verdict == "loads lenient" else one.get("reasons"))
    if lost(one):
        told.append(f"{one['closures']} in the file, {one['made']} made")
    for key in ("dynamics", "mujoco_refuses"):
        if key in one:
            told.append(f"MuJoCo: {one[key]}" if key == "mujoco_refuses" else str(one[key]))
    text = f"{number}. **{one['name']}**: {judged + ' ' if judged else ''}" + "".join(
        f"`{_plain(part)}` " for part in told
    )
    return textwrap.wrap(text.rstrip(), 119, subsequent_indent="   ", break_long_words=False, break_on_hyphens=False)


def _some(reasons: object, most: int = 2) -> list[str]:
    every = [str(one) for one in reasons] if isinstance(reasons, Iterable) else []
    more = [f"and {len(every) - most} more"] if len(every) > most else []
    return [*every[:most], *more]


def _plain(text: str) -> str:
    """What was found, without the folder of this run, short, and without what markdown reads."""
    found = text.replace("`", "'").split("; expected ")[0]
    words = [word.rsplit("/", 1)[-1] if word.startswith("/") else word for word in found.split()]
    flat = " ".join(words)
    return flat if len(flat) <= 160 else flat[:157] + "..."
