"""Writes docs/tolerances.md from cutjoint.tolerances: `python tools/tolerances.py`."""

from __future__ import annotations

from pathlib import Path

from cutjoint import tolerances

FILE = Path(__file__).resolve().parents[1] / "docs" / "tolerances.md"
HEAD = """\
# Tolerances

The numbers below which two things count as equal, or a posture as singular, with the reason of each. They live in
`src/cutjoint/tolerances.py`; `tools/tolerances.py` writes this page.

| name | value | unit | why |
|---|---|---|---|
"""


def page() -> str:
    """The whole document."""
    found = {name: one for name, one in vars(tolerances).items() if isinstance(one, tolerances.Tolerance)}
    return HEAD + "".join(f"| `{name}` | {one.value:g} | {one.unit} | {one.reason} |\n" for name, one in found.items())


if __name__ == "__main__":
    fresh = FILE.with_suffix(".new")
    fresh.write_text(page(), encoding="utf-8")
    fresh.replace(FILE)
