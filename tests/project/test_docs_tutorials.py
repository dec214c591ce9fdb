"""The tutorials: what they tell to do works, and what they show is what comes out."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = sorted((ROOT / "docs/tutorials").glob("*.md"))


@pytest.fixture(scope="module")
def tutorials() -> ModuleType:
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import tutorials
    finally:
        sys.path.remove(str(ROOT / "tools"))
    return tutorials


@pytest.mark.slow
@pytest.mark.parametrize("file", TUTORIALS, ids=lambda file: file.stem)
def test_tutorial_shows_what_comes_out(file: Path, tmp_path: Path, tutorials: ModuleType) -> None:
    done = tutorials.work(file.read_text(encoding="utf-8"), tmp_path)
    assert done.steps >= 5
    assert done.differences == []


def test_differences_are_noticed_and_put_in(tmp_path: Path, tutorials: ModuleType) -> None:
    text = """# A tutorial

```text title="deep/values.txt"
2
```

```console
$ cat deep/values.txt
3
$ echo one; \\
  echo two words 0.5
one
two ... 0.5
```

```python
print(open("deep/values.txt").read().strip(), "is read")
```

```text
2 is written
```

```text
this is only shown
```
"""
    done = tutorials.work(text, tmp_path)
    assert done.steps == 3
    assert len(done.differences) == 2
    assert done.text == text.replace("txt\n3", "txt\n2").replace("written", "read")


@pytest.mark.parametrize(
    ("shown", "printed", "right"),
    [
        ("a  b\n", "a b\n", True),
        ("a b\n", "a c\n", False),
        ("a b\n", "ab\n", False),
        ("a\n", "a\nb\n", False),
        ("a\n...\n", "a\nb\nc\n", True),
        ("...\nc\n", "a\n\nb\nc\n", True),
        ("...\nd\n...\n", "a\nb\nc\n", False),
        ("a ... c\n", "a 1.5 b c\n", True),
        ("a ... c\n", "a 1.5 b d\n", False),
        ("a (b)\n", "a (b)\n", True),
    ],
)
def test_what_counts_as_the_same(tutorials: ModuleType, shown: str, printed: str, right: bool) -> None:
    assert tutorials.same(shown, printed) is right


def test_a_command_that_fails_ends_it(tmp_path: Path, tutorials: ModuleType) -> None:
    with pytest.raises(SystemExit, match="exit status 3"):
        tutorials.work("```console\n$ exit 3\n```\n", tmp_path)
