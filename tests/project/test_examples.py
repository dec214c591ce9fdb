"""The examples: their inline blocks are true and pinned, the documents quote them word for word, and they end well."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGE = ROOT / "docs" / "neighbours.md"
NO_MODULE = re.compile(r"^ModuleNotFoundError: No module named '([\w.]+)'", re.MULTILINE)


def quoted(text: str) -> list[tuple[str, str]]:
    """Of every section of a document that names an example: its name, and the code that is shown."""
    found = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        names = re.findall(r"\]\(\.\./examples/(\w+)\.py\)", section)
        found += [(names[0], code) for code in re.findall(r"^```py\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)]
    return found


def stands_in(code: str, source: str) -> bool:
    """Whether the lines follow each other in a file, wherever they are indented."""
    rows, wanted = source.splitlines(), textwrap.dedent(code).rstrip().splitlines()
    parts = ("\n".join(rows[k : k + len(wanted)]) for k in range(len(rows)))
    return any(textwrap.dedent(part).splitlines() == wanted for part in parts)


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_what_an_example_lists_is_pinned(file: Path, try_examples: ModuleType) -> None:
    text = file.read_text(encoding="utf-8")
    names = {try_examples.normal(re.split(r"[^A-Za-z0-9._-]", one)[0]) for one in try_examples.dependencies(text)}
    assert names <= set(try_examples.pins())
    assert try_examples.block(text)["requires-python"] == ">=3.11"
    assert "cutjoint itself comes from a checkout: pip install" in text


def test_the_pins_of_the_examples_stand_before_the_others(try_examples: ModuleType) -> None:
    assert try_examples.pins()["numpy"]
    own = (ROOT / "examples" / "constraints.txt").read_text(encoding="utf-8")
    for name, version in re.findall(r"^([\w-]+)==(\S+)$", own, re.MULTILINE):
        assert try_examples.pins()[try_examples.normal(name)] == version


def test_the_page_names_every_example_and_quotes_them_word_for_word() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert {file.stem for file in EXAMPLES} == set(re.findall(r"\]\(\.\./examples/(\w+)\.py\)", text))
    shown = quoted(text)
    assert {name for name, _ in shown} >= {"pink_stewart", "crocoddyl_fivebar", "mujoco_fivebar", "drake_fivebar"}
    for name, code in shown:
        assert stands_in(code, (ROOT / "examples" / f"{name}.py").read_text(encoding="utf-8")), f"{name}:\n{code}"


def test_a_quotation_that_differs_is_noticed() -> None:
    source = "def f():\n    a = 1\n    b = 2\n"
    assert stands_in("a = 1\nb = 2\n", source)
    assert not stands_in("a = 1\nb = 3\n", source)
    assert not stands_in("a = 1\n\nb = 2\n", source)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("print()\n", "found 0 blocks"),
        ("# /// script\n# dependencies = []\n# ///\n\n# /// script\n# dependencies = []\n# ///\n", "found 2 blocks"),
        ('# /// script\n# dependencies = "drake"\n# ///\n', "must be a list"),
        ("# /// script\n# dependencies = [1]\n# ///\n", "must be a list"),
    ],
)
def test_a_block_that_is_none_is_refused(text: str, told: str, try_examples: ModuleType) -> None:
    with pytest.raises(ValueError, match=told):
        try_examples.dependencies(text)


class Installed:
    """An environment in which pip has answered already."""

    python = Path(sys.executable)

    def __init__(self, answer: str = "") -> None:
        self.answer = answer

    def install(self, *wanted: str) -> str:
        return self.answer


@pytest.mark.parametrize(
    ("code", "answer", "verdict", "told"),
    [
        ("print('all is well')", "", "ok", "all is well"),
        ("assert 1 == 2, 'they differ'", "", "FAILED", "they differ"),
        ("", "ERROR: No matching distribution found for thing>=2", "skipped", "thing>=2"),
        (
            "",
            "ERROR: Could not find a version that satisfies the requirement thing>=2 (from versions: none)\n"
            "ERROR: No matching distribution found for thing>=2",
            "skipped",
            "no wheel here: thing>=2",
        ),
        (
            "",
            "WARNING: Retrying after connection broken by 'NewConnectionError'\n"
            "ERROR: No matching distribution found for thing>=2",
            "FAILED",
            "connection broken",
        ),
        ("", "ERROR: could not connect", "FAILED", "could not connect"),
    ],
)
def test_how_an_example_ends(
    tmp_path: Path, try_examples: ModuleType, code: str, answer: str, verdict: str, told: str
) -> None:
    file = tmp_path / "example.py"
    file.write_text(f'# /// script\n# dependencies = ["thing>=2"]\n# ///\n{code}\n', encoding="utf-8")
    outcome = try_examples.tried(file, Installed(answer))
    assert outcome.verdict == verdict
    assert told in str(outcome)


@pytest.mark.slow
@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_example_ends_well(file: Path, tmp_path: Path) -> None:
    """With the packages that are here; `tools/try_examples.py` installs them all."""
    run = subprocess.run(
        [sys.executable, str(file)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=os.environ | {"PYTHONWARNINGS": "ignore"},
    )
    if missing := NO_MODULE.search(run.stderr):
        assert missing[1].split(".")[0] in {"pink", "crocoddyl", "gymnasium", "pydrake", "rosbags", "mujoco"}
        pytest.skip(f"{missing[1]} is not installed")
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.strip()
