"""Collecting everything that is wrong before giving up, and words that help to mend it."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Literal, Self

from cutjoint.description.model import Joint, Place
from cutjoint.errors import DescriptionError, Problem, shown

MOST = 300
"""Errors after which nothing more is looked at, and three times as many warnings that are listed."""


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
    """The problems found so far.  `file` stands for those that know no better place.

    `closing` holds joints of a graph that became cuts, by name, with the limits and physics that no cut has.
    """

    def __init__(self, file: str = "") -> None:
        self.file = file
        self.problems = Problems()
        self.closing: dict[str, Joint] = {}

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
        self.closing = findings.closing

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
