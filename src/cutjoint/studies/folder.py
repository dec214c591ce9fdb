"""The folder of a study: `parts/part-000000.parquet` and on, a block each, and `manifest.json`, which says what they
are.

All files are written whole.  A block counts once the manifest names it with its SHA-256; one that was written after the
manifest was, when a program was killed, is simulated again.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import cast

from cutjoint.errors import FileError, InputError, StudyError
from cutjoint.files import path_name, read_file, write_whole
from cutjoint.findings import listing
from cutjoint.reprs import line
from cutjoint.studies.blocks import BlockPlan, Prepared, digest

try:
    import fcntl
except ImportError:  # a system without such locks
    fcntl = None  # type: ignore[assignment]

FORMAT = 1
PACKAGES = ("cutjoint", "numpy", "scipy", "llvmlite", "pyarrow", "pin")
"""Those whose versions decide about digits or bytes."""
LARGEST_MANIFEST = 2**30
LARGEST_PART = 2**31
EVERY = 1.0
"""Least seconds between two manifests."""
SHARE = 0.02
"""Most of the time that goes into writing manifests."""


class StudyFolder:
    """Where a study is kept.

    Args:
        path: of the folder; made where it does not exist.

    Attributes:
        done: number of a block -> its SHA-256.
    """

    __repr__ = line("path")

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.done: dict[int, str] = {}
        self._about: Mapping[str, object] = {}
        self._lock: int | None = None
        self._written, self._cost, self._unwritten = 0.0, 0.0, False

    @property
    def manifest(self) -> Path:
        """The file that says what is there."""
        return self.path / "manifest.json"

    def part(self, block: int) -> Path:
        """The file of a block."""
        return self.path / "parts" / f"part-{block:06d}.parquet"

    def content(self, block: int) -> bytes:
        """The file of a block that is done.

        Raises:
            StudyError: it is not as it was written.
        """
        try:
            content = read_file(self.part(block), LARGEST_PART)
            found = digest(content)
        except FileError as error:
            content, found = b"", error.why
        if found != self.done[block]:
            raise StudyError(
                f"block {block} in '{self.path}' is not as it was written ({found[:60]}); delete '{self.part(block)}' "
                'and its line under "done" in manifest.json to have it simulated again',
                done=len(self.done),
            )
        return content

    def check(self, prepared: Prepared, plan: BlockPlan, processor: str, any_processor: bool = False) -> None:
        """Whether the folder is free, or holds the beginning of the same study, whose blocks are then `done`.

        Raises:
            InputError: the folder holds something else, another study, or one of other versions or processors.
            StudyError: a block in it is not as it was written.
        """
        about = about_of(prepared, plan, processor)
        if self.manifest.exists():
            known = read_manifest(self.path)
            self._check_same(known, about, any_processor=any_processor)
            about = {**about, "processors": sorted({*_texts(known.get("processors")), processor})}
            self.done = _done(known)
            self._check_parts()
        elif self.path.exists() and not self._is_free():
            raise InputError(f"'{self.path}' is there and no folder of a study; give another one (--out)")
        elif not self.path.parent.is_dir():
            raise InputError(f"the folder '{self.path.parent}' does not exist; make it first")
        self._about = about

    def begin(self) -> None:
        """Make the folder, which was checked, and keep other processes out of it until `finish`.

        Raises:
            InputError: another process is at the same study.
        """
        parts = self.path / "parts"
        parts.mkdir(parents=True, exist_ok=True)
        self._take_lock(parts)
        try:
            # what one that was killed left of a file that was about to take its place
            for left in (*self.path.glob(".manifest.json.*"), *parts.glob(".part-*")):
                left.unlink(missing_ok=True)
            known = _done(read_manifest(self.path)) if self.manifest.exists() else {}
            if known != self.done:
                raise InputError(f"another process was at the study in '{self.path}' meanwhile; start again")
            self.write()
        except BaseException:
            self._release()
            raise

    def take(self, block: int, content: bytes) -> bool:
        """Keep a block that is done, once; whether it is new."""
        if block in self.done:
            return False
        write_whole(self.part(block), content)
        self.done[block] = digest(content)
        self._unwritten = True
        if time.monotonic() - self._written > max(EVERY, self._cost / SHARE):
            self.write()
        return True

    def also(self, processor: str) -> None:
        """Note that blocks come from another kind of processor too."""
        processors = sorted({*_texts(self._about.get("processors")), processor})
        self._about, self._unwritten = {**self._about, "processors": processors}, True

    def write(self) -> None:
        """Write the manifest."""
        began = time.monotonic()
        blocks = {str(block): self.done[block] for block in sorted(self.done)}
        write_whole(self.manifest, json.dumps({**self._about, "done": blocks}, indent=1) + "\n")
        self._written, self._unwritten = time.monotonic(), False
        self._cost = self._written - began

    def finish(self) -> None:
        """Write the manifest where it lacks something, and let others into the folder."""
        try:
            if self._unwritten:
                self.write()
        finally:
            self._release()

    def _is_free(self) -> bool:
        """Whether there is a folder with nothing in it, or no more than a study that was killed at once has left."""
        if not self.path.is_dir():
            return False
        seen = [one for one in self.path.iterdir() if not one.name.startswith(".manifest.json.")]
        return all(one.name == "parts" and one.is_dir() and not any(one.iterdir()) for one in seen)

    def _take_lock(self, parts: Path) -> None:
        """Keep other processes out; the system lets them in when this one ends, however it ends."""
        if fcntl is None:
            return
        self._lock = os.open(parts, os.O_RDONLY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._release()
            raise InputError(f"another process is at the study in '{self.path}'; wait, or end it") from error

    def _release(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _check_parts(self) -> None:
        for block in self.done:
            self.content(block)

    def _check_same(self, known: Mapping[str, object], about: Mapping[str, object], *, any_processor: bool) -> None:
        """Raises InputError where the folder holds the beginning of something else."""
        told = {
            "digest": "another study, or what its file says was changed",
            "robot": "a study of another robot, or the robot was changed",
            "files": "a study along other motions, or a file of one was changed",
            "versions": "a study that other versions began",
            "block": "a study in blocks of another size",
        }
        for key, what in told.items():
            if known.get(key) != about[key]:
                was, now = _difference(known.get(key), about[key])
                raise InputError(
                    f"'{self.path}' holds {what} ({key}: {was} there, {now} now); give another folder (--out), or go "
                    "on with what it was begun with"
                )
        others = set(_texts(known.get("processors"))) - set(_texts(about["processors"]))
        if others and not any_processor:
            raise InputError(
                f"'{self.path}' was begun on another kind of processor ({listing(sorted(others))}; here "
                f"{listing(_texts(about['processors']))}), whose last digits may differ; go on there, give another "
                "folder, or take --any-processor"
            )


def read_manifest(path: Path) -> dict[str, object]:
    """The manifest of a folder.

    Raises:
        InputError: there is none, or it is damaged.
    """
    try:
        found = json.loads(read_file(Path(path_name(path)) / "manifest.json", LARGEST_MANIFEST))
    except (ValueError, RecursionError) as error:
        if isinstance(error, FileError):
            raise
        raise InputError(f"the manifest in '{path}' is damaged: {str(error)[:100]}") from error
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise InputError(f"the manifest in '{path}' is none of this version (format {FORMAT})")
    return found


def about_of(prepared: Prepared, plan: BlockPlan, processor: str) -> dict[str, object]:
    """What a manifest says of a study."""
    recipe, study, first = prepared.recipe, prepared.recipe.study, prepared.case(0)
    return {
        "format": FORMAT,
        "study": study.name,
        "digest": study.digest,
        "robot": recipe.fingerprint,
        "files": recipe.motions,
        "versions": versions(),
        "processors": [processor],
        "settings": json.loads(study.settings),
        "method": study.method,
        "cases": [one.name for one in recipe.cases],
        "samples": plan.samples,
        "paths": list(first.paths),
        "units": first.units(),
        "runs": plan.runs,
        "block": plan.size,
        "blocks": plan.count,
    }


def versions() -> dict[str, str]:
    """Of the packages that decide about digits or bytes."""
    found = {"python": ".".join(map(str, sys.version_info[:2]))}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def opened(path: str | os.PathLike[str]) -> tuple[StudyFolder, Mapping[str, object]]:
    """The folder of a study that was begun, and its manifest.

    Raises:
        InputError: there is none.
    """
    folder = StudyFolder(path)
    known = read_manifest(folder.path)
    folder.done, folder._about = _done(known), known
    return folder, known


def _done(known: Mapping[str, object]) -> dict[int, str]:
    try:
        return {int(block): str(one) for block, one in cast("dict[str, str]", known["done"]).items()}
    except (AttributeError, KeyError, ValueError) as error:
        raise InputError('the manifest is damaged: "done" has no blocks') from error


def _texts(value: object) -> list[str]:
    return [str(one) for one in value] if isinstance(value, list) else []


def _difference(was: object, now: object) -> tuple[str, str]:
    if isinstance(was, dict) and isinstance(now, dict):
        keys = [key for key in {**was, **now} if was.get(key) != now.get(key)]
        return ", ".join(f"{key} {was.get(key)}" for key in keys), ", ".join(f"{key} {now.get(key)}" for key in keys)
    return str(was)[:24], str(now)[:24]
