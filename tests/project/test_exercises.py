"""A stranger adds things as the guides say: how many files that touches, and that it works."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from kit.exercise import Exercise, last_import, pieces, table_end

GUIDES = {
    "adding-a-controller.md": (1, 1),
    "adding-a-trajectory.md": (1, 1),
    "adding-a-cut-type.md": (0, 1),
    "adding-a-joint-type.md": (0, 3),
    "adding-a-format.md": (1, 1),
    "adding-an-output-column.md": (0, 1),
    "adding-a-paper.md": (3, 1),
    "adding-a-back-end.md": (1, 1),
    "adding-a-command.md": (1, 1),
}
"""Guide -> new files (all in one folder), and files that get a row."""


@pytest.mark.slow
@pytest.mark.parametrize("guide", GUIDES)
def test_what_a_guide_adds_works(guide: str, root: Path, tmp_path: Path) -> None:
    most_new, most_rows = GUIDES[guide]
    exercise = Exercise(root / "docs" / guide, tmp_path)
    assert len(exercise.new) <= most_new
    assert len({Path(name).parent for name in exercise.new}) <= 1
    assert len(set(exercise.rows.values())) <= most_rows
    assert exercise.touched == {*exercise.new, *exercise.rows.values()}
    exercise.run()


def test_every_guide_is_an_exercise(root: Path) -> None:
    guides = {file.name for file in (root / "docs").glob("adding-a*.md")}
    assert guides - {"adding-a-robot.md"} == GUIDES.keys()


GUIDE = """A row, and a file.

```python new=control/zero.py
ZERO = 0
```

```python import=arrays.py
import math
```

```python row=arrays.py table=TABLE
    "b": 2,
```

```console exercise
$ cutjoint --version
```
"""


def test_blocks_of_a_guide_are_read() -> None:
    found = pieces(GUIDE)
    assert [list(piece.said) for piece in found] == [["new"], ["import"], ["row", "table"], ["exercise"]]
    assert found[0].text == "ZERO = 0\n"


def test_the_end_of_a_table_is_found() -> None:
    text = "A = {\n    1: 2,\n}\nB: tuple[int, ...] = (\n    1,\n)\n\n\nclass C:\n    X = 1\n    Y = 2\n\n"
    text += "    def f(self): ...\n"
    assert (table_end(text, "A"), table_end(text, "B"), table_end(text, "C")) == (2, 5, 11)
    with pytest.raises(LookupError, match="no table D"):
        table_end(text, "D")
    with pytest.raises(LookupError, match="line of its own"):
        table_end("A = (1, 2)\n", "A")


def test_imports_go_after_the_last() -> None:
    assert last_import("import a\nfrom b import (\n    c,\n)\n\nX = 1\n") == 4


@pytest.mark.slow
def test_an_exercise_that_fails_is_noticed(root: Path, tmp_path: Path) -> None:
    guide = tmp_path / "guide.md"
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    wrong = GUIDE.replace("row=arrays.py table=TABLE", "row=tolerances.py table=NOTHING")
    guide.write_text(wrong)
    with pytest.raises(LookupError):
        Exercise(guide, tmp_path / "a")
    guide.write_text(
        GUIDE.replace('```python row=arrays.py table=TABLE\n    "b": 2,\n```\n', "")
        .replace("ZERO = 0", "1 / 0")
        .replace("--version", "nothing")
    )
    exercise = Exercise(guide, tmp_path / "b")
    assert exercise.touched == {"control/zero.py", "arrays.py"}
    assert ast.parse((exercise.source / "arrays.py").read_text())
    with pytest.raises(AssertionError, match="nothing"):
        exercise.run()
