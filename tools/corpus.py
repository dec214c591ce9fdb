"""Try the published robots of tools/published/corpus.toml, and write docs/corpus.md: a verdict and a reason for each.

    python tools/corpus.py FOLDER                   every robot, each in a process of its own; prints a line each
    python tools/corpus.py FOLDER --json OUT        and keeps everything that was found
    python tools/corpus.py FOLDER --page            and writes docs/corpus.md
    python tools/corpus.py FOLDER --only cassie     those whose name or path has the word

FOLDER holds the sources, each at its commit in OWNER+NAME, or in pypi/NAME for a package.  They are fetched by hand.
A robot that hangs or kills its process is a verdict too.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from published.page import page

TOOLS = Path(__file__).resolve().parent
LIST = TOOLS / "published" / "corpus.toml"
PAGE = TOOLS.parent / "docs" / "corpus.md"
SECONDS = 120.0
"""A robot gets, all in all."""

Found = dict[str, object]


@dataclass(frozen=True)
class Entry:
    """A published robot: what it is called here, the address and commit it is from, and its path there."""

    name: str
    address: str
    commit: str
    path: str

    @property
    def place(self) -> Path:
        """Where it stands in the folder of sources."""
        if self.address.startswith("pypi:"):
            return Path("pypi") / self.address.removeprefix("pypi:").split("==")[0] / self.path
        return Path(self.address.replace("/", "+")) / self.path


def entries(text: str) -> list[Entry]:
    """The robots of a list such as tools/published/corpus.toml."""
    return [
        Entry(name, source["address"], source.get("commit", ""), path)
        for source in tomllib.loads(text)["source"]
        for name, path in source["robots"]
    ]


def run(entry: Entry, folder: Path) -> Found:
    """The trial of one robot in a process of its own."""
    command = [sys.executable, "-m", "published.trial", str((folder / entry.place).resolve())]
    known: Found = {"name": entry.name, "address": entry.address, "commit": entry.commit, "path": entry.path}
    if not (folder / entry.place).is_file():
        return known | {"verdict": "not fetched", "reasons": [f"no {entry.place}"]}
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False, cwd=TOOLS)
    except subprocess.TimeoutExpired:
        return known | {"verdict": "hangs", "reasons": [f"nothing after {SECONDS:g} s"]}
    try:
        return known | dict(json.loads(done.stdout.splitlines()[-1]))
    except (IndexError, ValueError):
        last = (done.stderr.strip().splitlines() or [""])[-1]
        return known | {"verdict": "crashed", "reasons": [f"exit status {done.returncode}: {last}"]}


def _versions() -> str:
    """What the run was done with."""
    installed = [name for name in ("mujoco", "pin", "xacro", "usd-core") if _has(name)]
    return ", ".join(f"{name} {version(name)}" for name in installed)


def _has(name: str) -> bool:
    try:
        return bool(version(name))
    except PackageNotFoundError:
        return False


def main(arguments: list[str] | None = None) -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="corpus", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=1)
    chosen = parser.parse_args(arguments)
    word = chosen.only.lower()
    robots = [one for one in entries(LIST.read_text(encoding="utf-8")) if word in f"{one.name} {one.place}".lower()]
    found: list[Found] = []
    with ThreadPoolExecutor(chosen.jobs) as pool:
        for one in pool.map(lambda entry: run(entry, chosen.folder), robots):
            found.append(one)
            print(f"{one['verdict']!s:14} {one['name']}  {one['address']}: {one['path']}", flush=True)
    if chosen.json is not None:
        chosen.json.write_text(json.dumps(found, indent=1), encoding="utf-8")
    if chosen.page:
        said = tomllib.loads(LIST.read_text(encoding="utf-8")).get("judged", {})
        PAGE.write_text(page(found, said, _versions()), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
