"""Run the benchmarks, print tables, optionally put them into the documents: `python tools/bench.py --help`."""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import asdict
from datetime import date
from pathlib import Path

from benchmarks.rounds import machine
from benchmarks.section import SMALL, Section, Size
from benchmarks.sections import SECTIONS

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / "docs" / "benchmarks.md"
FIGURE = ROOT / "docs" / "work-precision.svg"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"


def main(arguments: list[str] | None = None) -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("sections", nargs="*", default=[], help=f"of {', '.join(SECTIONS)}; default all")
    parser.add_argument("--small", action="store_true", help="tiny sizes: shows that it runs and that results agree")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--document", action="store_true", help="put the tables and the figure into docs/")
    chosen = parser.parse_args(arguments)
    unknown = sorted(set(chosen.sections) - set(SECTIONS))
    if unknown:
        parser.error(f"unknown section {', '.join(unknown)}; known: {', '.join(SECTIONS)}")
    size = SMALL if chosen.small else Size()
    found: dict[str, Section] = {}
    for name in chosen.sections or SECTIONS:
        print(f"{name} ...", file=sys.stderr, flush=True)
        found[name] = SECTIONS[name](size)
    if chosen.json:
        print(json.dumps({"machine": machine(), **{name: asdict(one) for name, one in found.items()}}, indent=2))
    else:
        print(markdown(found))
    if chosen.document:
        document(found)
    return 0


def markdown(found: dict[str, Section]) -> str:
    """All sections as Markdown."""
    parts = [f"Measured on {date.today().isoformat()}: {machine()}."]
    for section in found.values():
        parts += ["", f"### {section.title}", ""]
        parts.append("| " + " | ".join(section.columns) + " |")
        parts.append("|" + " --- |" * len(section.columns))
        parts += ["| " + " | ".join(row) + " |" for row in section.rows]
        if section.ratios:
            parts.append("")
            parts += [f"- {text}: {value:.3g} times" for text, value in section.ratios.items()]
    return "\n".join(parts)


def document(found: dict[str, Section]) -> None:
    """Replace the measured part of docs/benchmarks.md, and draw the work-precision diagram."""
    from cutjoint.files import write_whole

    text = DOCUMENT.read_text(encoding="utf-8")
    between = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.DOTALL)
    if not between.search(text):
        raise SystemExit(f"{DOCUMENT} has no lines {BEGIN} and {END}")
    new = f"{BEGIN}\n\n{markdown(found)}\n\n{END}"
    write_whole(DOCUMENT, between.sub(lambda _: new, text))
    if "loop" in found:
        from benchmarks.figure import draw

        write_whole(FIGURE, draw(found["loop"]))


if __name__ == "__main__":
    sys.exit(main())
