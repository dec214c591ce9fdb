"""Text as a terminal shows it: how broad it is, wrapped at words, without anything that moves the cursor."""

from __future__ import annotations

from collections.abc import Callable

LONGEST = 200
"""Longest word that is shown whole."""
LIST, LONGEST_ITEM = 3, 30
"""A text of so many parts with commas between them, none longer than this, is a list."""

Paint = Callable[[str, str], str]
"""A text in the look of a style: `bold`, `dim`, `caution`, `good`, `half`, `bad`, or none."""


class Cell(str):
    """A text with a style: `bold`, `dim`, `caution`, or one of a verdict: `good`, `half`, `bad`."""

    style: str

    def __new__(cls, text: str, style: str = "") -> Cell:
        cell = super().__new__(cls, text)
        cell.style = style
        return cell


def plainly(text: str, style: str) -> str:
    """The text, whatever its style."""
    return text


def broad(text: str) -> int:
    """Columns of a terminal that a text takes: two for a wide character, none for a combining one."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def harmless(text: str) -> str:
    """The text with what cannot be printed escaped: line breaks, control and direction characters, halves of pairs."""
    return text if text.isprintable() else "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def cut(text: str) -> str:
    """The text, harmless, with words that are too long to be read cut in their middle."""
    text = harmless(text)
    if len(text) <= LONGEST:
        return text
    return " ".join(
        word if len(word) <= LONGEST else f"{word[: LONGEST // 2]}...{word[-LONGEST // 4 :]}"
        for word in text.split(" ")
    )


def padded(text: str, width: int, *, right: bool = False) -> str:
    """The text flush left, or `right`, in so many columns."""
    blanks = " " * max(0, width - broad(text))
    return blanks + text if right else text + blanks


def wrapped(text: str, width: int, first: str = "", rest: str = "") -> list[str]:
    """Lines of at most `width` columns, broken at blanks alone (in a list of short parts, after its commas alone): what
    is longer has a line to itself.  `first` stands before the first line, `rest` before the others."""
    if broad(first + text) <= width:
        return [first + text] if text else []
    lines, line, bare = [], first, True
    for part in _parts(text, width - max(broad(first), broad(rest))):
        longer = f"{line}{part}" if bare else f"{line} {part}"
        if not bare and broad(longer) > width:
            lines.append(line)
            longer = rest + part
        line, bare = longer, False
    return lines if bare else [*lines, line]


def _parts(text: str, width: int) -> list[str]:
    """What stays together in a line."""
    items = text.split(", ")
    if len(items) >= LIST and all(broad(item) <= min(width, LONGEST_ITEM) for item in items):
        return [*(f"{item}," for item in items[:-1]), items[-1]]
    return text.split()
