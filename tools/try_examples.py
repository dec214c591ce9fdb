"""Runs every example in an environment of its own: what its inline block lists is installed, and it must end well.

    python tools/try_examples.py                    a fresh environment in the folder for temporary files
    python tools/try_examples.py --venv DIR         one that is kept and used again
    python tools/try_examples.py pink_stewart ...   only these

The checkout is installed with the extras of `EXTRAS`, then the packages that an example's block lists (PEP 723), as
wheels and in the versions of constraints.txt and examples/constraints.txt.  An example whose packages have no wheel for
this Python and system is skipped, and the reason told.  Exit status 1 where one fails, or none was run.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
PINS = (ROOT / "constraints.txt", EXAMPLES / "constraints.txt")
EXTRAS = "viewer,compile,engines,ros"
SECONDS = 300
"""Of one example."""
NO_WHEEL = re.compile(r"No matching distribution found for (.+)|satisfies the requirement (.+?) \(from")
NO_NETWORK = re.compile(r"connection broken|Failed to establish a new connection|Max retries exceeded")
"""What pip says where it could not ask; that there is no wheel then means nothing."""
BLOCK = re.compile(r"^# /// script\n(?P<content>(?:#(?: .*)?\n)+?)# ///$", re.MULTILINE)


@dataclass(frozen=True)
class Outcome:
    """How an example ended: `ok`, `skipped` or `FAILED`, after how many seconds, and what there is to say."""

    name: str
    verdict: str
    seconds: float
    told: str

    def __str__(self) -> str:
        lines = self.told.strip().splitlines() or [""]
        head = f"{self.verdict:8} {self.name:20} {self.seconds:5.1f} s  {lines[0]}".rstrip()
        return "\n".join([head, *(f"{'':38}{line}" for line in lines[1:])])


def block(text: str) -> Mapping[str, object]:
    """What the inline block of a script says (PEP 723).

    Raises:
        ValueError: it has none, or more than one.
    """
    found = BLOCK.findall(text)
    if len(found) != 1:
        raise ValueError(f"found {len(found)} blocks `# /// script`, expected one")
    return tomllib.loads("\n".join(line[2:] for line in found[0].splitlines()))


def dependencies(text: str) -> list[str]:
    """The packages that a script lists.

    Raises:
        ValueError: as `block`, or it lists none of the kind.
    """
    wanted = block(text).get("dependencies")
    if not isinstance(wanted, list) or not all(isinstance(one, str) for one in wanted):
        raise ValueError(f"dependencies must be a list of texts, found {wanted!r}")
    return wanted


def normal(name: str) -> str:
    """A distribution's name as packaging tools compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def pins() -> dict[str, str]:
    """Name -> version of all that may be installed; the last file counts."""
    found: dict[str, str] = {}
    for file in PINS:
        for line in file.read_text(encoding="utf-8").splitlines():
            if line.strip() and not line.startswith("#"):
                name, _, version = line.strip().partition("==")
                found[normal(name)] = version
    return found


class Environment:
    """A virtual environment with the checkout in it."""

    def __init__(self, place: Path) -> None:
        self.python = place / "bin" / "python"
        self._pins = place / "constraints.txt"
        if not self.python.exists():
            subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
        lines = (f"{name}=={version}\n" for name, version in pins().items())
        self._pins.write_text("".join(lines), encoding="utf-8")
        failed = self.install("--editable", f"{ROOT}[{EXTRAS}]", only_wheels=False)
        if failed:
            raise SystemExit(f"cutjoint itself cannot be installed:\n{failed}")

    def install(self, *wanted: str, only_wheels: bool = True) -> str:
        """Install packages; what pip said where that failed, else nothing."""
        command = [str(self.python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        command += ["--constraint", str(self._pins), *(["--only-binary", ":all:"] if only_wheels else [])]
        done = subprocess.run([*command, *wanted], capture_output=True, text=True, check=False, env=_clean())
        return (done.stdout + done.stderr) if done.returncode else ""

    def unpinned(self) -> list[str]:
        """What is installed in another version than the pins say, or without one."""
        command = [str(self.python), "-m", "pip", "list", "--format", "freeze", "--exclude-editable"]
        listed = subprocess.run(command, capture_output=True, text=True, check=True, env=_clean()).stdout
        known = pins() | dict.fromkeys(("pip", "setuptools", "wheel"), "")
        rows = (line.partition("==") for line in listed.splitlines() if "==" in line)
        return [f"{name}=={version}" for name, _, version in rows if known.get(normal(name)) not in (version, "")]


def _clean() -> dict[str, str]:
    """The surroundings without what would lead Python elsewhere."""
    return {name: one for name, one in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME", "PIP_CONSTRAINT")}


def tried(file: Path, environment: Environment) -> Outcome:
    """Install what an example lists, and run it in an empty folder."""
    wanted = dependencies(file.read_text(encoding="utf-8"))
    failed = environment.install(*wanted) if wanted else ""
    if (missing := NO_WHEEL.search(failed)) and not NO_NETWORK.search(failed):
        return Outcome(file.stem, "skipped", 0.0, f"no wheel here: {(missing[1] or missing[2]).strip()}")
    if failed:
        return Outcome(file.stem, "FAILED", 0.0, failed)
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        try:
            done = subprocess.run(
                [str(environment.python), str(file)],
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=SECONDS,
                check=False,
                env=_clean(),
            )
        except subprocess.TimeoutExpired:
            return Outcome(file.stem, "FAILED", time.perf_counter() - start, f"not done after {SECONDS} s")
    seconds = time.perf_counter() - start
    if done.returncode:
        return Outcome(file.stem, "FAILED", seconds, f"exit status {done.returncode}\n{done.stdout}{done.stderr}")
    return Outcome(file.stem, "ok", seconds, done.stdout)


def chosen(names: Sequence[str]) -> Iterator[Path]:
    """The examples by name; all of them where none is named."""
    files = {file.stem: file for file in sorted(EXAMPLES.glob("*.py"))}
    for name in names or files:
        if name not in files:
            raise SystemExit(f"there is no example {name}; known: {', '.join(files)}")
        yield files[name]


def main() -> int:
    """Try the examples; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help="of examples; default all")
    parser.add_argument("--venv", type=Path, help="folder of the environment; default one that is thrown away")
    given = parser.parse_args()
    files = list(chosen(given.names))
    with tempfile.TemporaryDirectory() as folder:
        environment = Environment(given.venv or Path(folder) / "venv")
        outcomes = []
        for file in files:
            outcomes.append(tried(file, environment))
            print(outcomes[-1], flush=True)
        for one in environment.unpinned():
            print(f"not pinned: {one}")
    verdicts = [one.verdict for one in outcomes]
    print(f"examples: {len(verdicts)}, {verdicts.count('FAILED')} failed, {verdicts.count('skipped')} skipped")
    return 1 if "FAILED" in verdicts or "ok" not in verdicts else 0


if __name__ == "__main__":
    sys.exit(main())
