"""Collecting everything that is wrong with a file before giving up: where it stands, and words that help to mend it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Literal, Self

from cutjoint.errors import DescriptionError, FileError, Problem, shown
from cutjoint.files import read_file
from cutjoint.reprs import told

MOST = 300
"""Errors after which nothing more is looked at, and three times as many warnings that are listed."""
LARGEST_FILE = 32 * 2**20
"""Bytes.  The largest robot descriptions in use have about 1 MB."""
MOST_NAMES = 2000
"""Of a folder that are looked through for what may have been meant."""
LARGEST_LENGTH = 1e6
"""Lengths [m] and angles [rad] beyond this are refused: at 1e6 m a double has lost its last tenth of a nanometre."""


@dataclass(frozen=True)
class Place:
    """Where in a file something stands, for messages."""

    file: str = ""
    line: int | None = None

    def __repr__(self) -> str:
        return told(self)


NOWHERE = Place()
"""Of what no file has."""


class Problems(list[Problem]):
    """Problems, each once.  Appending raises a DescriptionError with all of them where there are very many errors."""

    def __init__(self) -> None:
        super().__init__()
        self._seen: set[Problem] = set()
        self._passed = 0

    def append(self, problem: Problem) -> None:
        """Add a problem that is not there yet."""
        passed = problem.severity == "warning" or problem.tolerable
        if passed and self._passed >= 3 * MOST:
            problem = replace(problem, found="more than is listed here", expected="", mend="", line=None)
        if problem in self._seen:
            return
        self._seen.add(problem)
        super().append(problem)
        self._passed += passed
        if len(self) - self._passed == MOST:
            super().append(replace(problem, found=f"{MOST} errors: what follows is not read", expected="", mend=""))
            raise DescriptionError(self)

    def extend(self, problems: Iterable[Problem]) -> None:
        """Add those that are not there yet."""
        for one in problems:
            self.append(one)

    def __iadd__(self, problems: Iterable[Problem]) -> Self:  # type: ignore[override,misc]
        self.extend(problems)
        return self


class Findings:
    """The problems found so far.  `file` stands for those that know no better place."""

    def __init__(self, file: str = "") -> None:
        self.file = file
        self.problems = Problems()

    def error(self, found: str, expected: str = "", mend: str = "", at: Place | int | None = None) -> None:
        """Note an error at a place (or at a line of `file`)."""
        self._add("error", found, expected, mend, at)

    def unknown(self, found: str, name: str, known: Collection[str], at: Place | int | None = None) -> None:
        """Note an error: `name` is none of the names that are known; the nearest of them is suggested."""
        self.error(found, f"one of {', '.join(known)}", nearest(name, known), at)

    def doubt(self, found: str, expected: str = "", mend: str = "", at: Place | int | None = None) -> None:
        """Note an error that does not prevent computing: published files have such flaws, lenient readers pass them."""
        self._add("error", found, expected, mend, at, tolerable=True)

    def warn(self, found: str, expected: str = "", mend: str = "", at: Place | int | None = None) -> None:
        """Note something odd that does not prevent loading."""
        self._add("warning", found, expected, mend, at)

    def _add(
        self,
        severity: Literal["error", "warning"],
        found: str,
        expected: str,
        mend: str,
        at: Place | int | None,
        tolerable: bool = False,
    ) -> None:
        place = at if isinstance(at, Place) else Place(self.file, at)
        words = (_bounded(found), _bounded(expected), _bounded(mend))
        self.problems.append(Problem(*words, shown(place.file or self.file), place.line, severity, tolerable))

    @property
    def failed(self) -> bool:
        """Whether there is an error among them."""
        return any(problem.severity == "error" for problem in self.problems)


LONGEST = 1500
"""Characters of a part of a problem: names in files may be of any length."""


def _bounded(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 4 :]}"


class Harmless(Findings):
    """Notes of what does not matter to motion (shapes, colours, names for people): its errors are doubts."""

    def __init__(self, findings: Findings) -> None:
        super().__init__(findings.file)
        self.problems = findings.problems

    def error(self, found: str, expected: str = "", mend: str = "", at: Place | int | None = None) -> None:
        """Note a doubt."""
        self.doubt(found, expected, mend, at)


def nearest(name: str, known: Iterable[str]) -> str:
    """`did you mean 'x'?` for the known name nearest to `name`, or the empty string."""
    near = closest(name, known)
    return f"did you mean '{near}'?" if near else ""


def closest(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The known name nearest to `name`, case ignored; empty when none is near."""
    return _closest(name.lower()[:200], frozenset(known), cutoff)


@lru_cache(maxsize=256)
def _closest(name: str, known: frozenset[str], cutoff: float) -> str:
    by_lower = {one.lower(): one for one in sorted(known)}
    found = difflib.get_close_matches(name, by_lower, n=1, cutoff=cutoff)
    return by_lower[found[0]] if found else ""


def slip(name: str, known: Iterable[str]) -> str:
    """The known name of three letters or more that one slip of the keyboard turns into `name` (a letter too many, too
    few, another one, or two swapped), case ignored; empty when there is none."""
    said = name.lower()[:200]
    return next((one for one in sorted(known) if len(one) > 2 and _one_slip(said, one.lower())), "")


def _one_slip(a: str, b: str) -> bool:
    """Whether at most one letter is too many, too few or another, or two neighbours are swapped."""
    if abs(len(a) - len(b)) > 1:
        return False
    start = next((at for at, pair in enumerate(zip(a, b, strict=False)) if pair[0] != pair[1]), min(len(a), len(b)))
    a, b = a[start:], b[start:]
    return a[1:] == b[1:] or a[1:] == b or a == b[1:] or (a[:2] == b[1::-1] and a[2:] == b[2:])


def listing(names: Iterable[str], most: int = 12) -> str:
    """Names as `a, b, c`, cut off politely."""
    every = list(names)
    text = ", ".join(clip(name) for name in every[:most])
    return f"{text} and {len(every) - most} more" if len(every) > most else text or "none"


def clip(text: str, most: int = 60) -> str:
    """`text` short enough for a message, without line breaks or control characters."""
    flat = "".join(char if char.isprintable() else " " for char in " ".join(text.split()))
    return flat if len(flat) <= most else flat[: most - 3] + "..."


def check_range(
    numbers: tuple[float, ...], what: str, findings: Findings, at: Place | int | None, largest: float = LARGEST_LENGTH
) -> bool:
    """Whether all `numbers` are finite and at most `largest` in size; notes a problem otherwise."""
    for value in numbers:
        if not math.isfinite(value):
            findings.error(f"{what} is {value}", "a finite number", "", at)
            return False
        if abs(value) > largest:
            findings.error(f"{what} is {value:g}", f"at most {largest:g} in size (SI units)", "check the units", at)
            return False
    return True


def read_text_file(path: Path, findings: Findings, kind: str) -> bytes | None:
    """The bytes of a text file, or None after noting why not.  `kind` names the format for messages."""
    findings.file = findings.file or shown(str(path))
    try:
        data = read_file(path, LARGEST_FILE)
    except FileError as error:
        mend = nearest(path.name, _neighbours(path)) if error.missing else error.mend
        found = "file not found" if error.missing else error.why.removesuffix(", expected a file")
        findings.error(found, f"a {kind} file", mend)
        return None
    if not data.strip():
        findings.error("an empty file", f"a {kind} file", "the copy or download may have failed")
        return None
    if b"\0" in data and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        findings.error("a binary file", f"a {kind} text file", "a mesh or an archive is no text")
        return None
    return data


def _neighbours(path: Path) -> list[str]:
    """Names of the files beside `path`."""
    try:
        return [one.name for one in islice(path.parent.iterdir(), MOST_NAMES) if one.is_file()]
    except (OSError, ValueError):
        return []
