"""The rooms import one way, and the check that says so can fail."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

SOUND = {
    "__init__.py": "",
    "errors.py": "import numpy\n",
    "arrays.py": "from cutjoint.errors import E\n",
    "mechanism/__init__.py": "from cutjoint.mechanism.types import T\n",
    "mechanism/types.py": "from cutjoint.arrays import A\n",
    "papers/__init__.py": "",
    "papers/cpm.py": "import math\nimport numpy as np\nfrom cutjoint.mechanism import T\n",
    "description/__init__.py": "",
    "chain/__init__.py": "def f():\n    import pinocchio\n    from cutjoint import description\n",
}


def write(folder: Path, files: dict[str, str]) -> Path:
    source = folder / "cutjoint"
    for name, text in files.items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
    return source


def test_cutjoint_keeps_its_layers(layers: ModuleType) -> None:
    assert layers.offences(layers.SOURCE) == []


def test_start_is_light(layers: ModuleType) -> None:
    assert layers.loaded_at_start() == []


def test_sound_package_passes(layers: ModuleType, tmp_path: Path) -> None:
    assert layers.offences(write(tmp_path, SOUND)) == []


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("papers/cpm.py", "import pinocchio\n", "papers may not import pinocchio"),
        ("papers/cpm.py", "from cutjoint.description import model\n", "papers may not import description"),
        ("papers/cpm.py", "def f():\n    from cutjoint import chain\n", "papers may not import chain"),
        ("papers/cpm.py", "from .. import chain\n", "papers may not import chain"),
        ("papers/cpm.py", "import_module('cutjoint.chain')\n", "papers may not import chain"),
        (
            "papers/cpm.py",
            "def f(x):\n    importlib.import_module(f'cutjoint.cha{x}')\n",
            "papers may not import chain",
        ),
        ("description/__init__.py", "import_module(f'cutjoint.chain{1}')\n", "description may not import chain"),
        ("papers/__init__.py", "from ..chain import C\n", "papers may not import chain"),
        ("errors.py", "import cutjoint.arrays\n", "errors may not import arrays"),
        (
            "mechanism/types.py",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import cutjoint.chain\n",
            "chain",
        ),
        ("chain/__init__.py", "import meshcat.geometry\n", "chain may not import meshcat"),
        ("chain/__init__.py", "import click\n", "click is not among the packages"),
        ("chain/__init__.py", "import cutjoint.papers\n", "chain may not import papers"),
        ("mechanism/types.py", "from cutjoint.mechanism import T\n", "import cycle"),
        ("description/a.py", "import cutjoint.nowhere\n", "there is no module cutjoint.nowhere"),
        ("attic/__init__.py", "", "attic: a new room"),
    ],
)
def test_broken_rule_is_named(layers: ModuleType, tmp_path: Path, file: str, text: str, said: str) -> None:
    lines = layers.offences(write(tmp_path, SOUND | {file: text}))
    assert any(said in line for line in lines), lines


def test_late_imports_and_those_for_types_make_a_circle_too(layers: ModuleType, tmp_path: Path) -> None:
    late = {"chain/a.py": "def f():\n    import cutjoint.chain.b\n", "chain/b.py": "import cutjoint.chain.a\n"}
    assert "import cycle" in layers.offences(write(tmp_path, SOUND | late))[0]
    types = {"chain/a.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import cutjoint.chain.b\n"}
    assert "import cycle" in layers.offences(write(tmp_path, SOUND | late | types))[0]


def test_modules_that_are_imported_by_name_make_a_circle_too(layers: ModuleType, tmp_path: Path) -> None:
    package = {"description/__init__.py": "def f(x):\n    import_module(f'{__name__}.{x}')\n", "description/a.py": ""}
    assert layers.offences(write(tmp_path, SOUND | package)) == []
    back = {"description/a.py": "import cutjoint.description\n"}
    assert "import cycle" in layers.offences(write(tmp_path, SOUND | package | back))[0]


def test_folders_of_a_room_need_each_other_one_way(layers: ModuleType, tmp_path: Path) -> None:
    inner = {f"chain/{name}/__init__.py": "" for name in "ab"} | {"chain/a/x.py": "", "chain/b/x.py": ""}
    one_way = {"chain/a/y.py": "import cutjoint.chain.b.x\n"}
    assert layers.offences(write(tmp_path, SOUND | inner | one_way)) == []
    back = {"chain/b/y.py": "import cutjoint.chain.a.x\n"}
    found = layers.offences(write(tmp_path, SOUND | inner | one_way | back))
    assert found == ["folders need each other: cutjoint.chain.a, cutjoint.chain.b"]


def test_offence_gives_file_and_line(layers: ModuleType, tmp_path: Path) -> None:
    source = write(tmp_path, SOUND | {"papers/cpm.py": "import math\n\nimport pinocchio\n"})
    assert layers.offences(source)[0].startswith("cutjoint/papers/cpm.py:3: ")
    assert layers.main([str(source)]) == 1


def test_heavy_start_is_noticed(layers: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(layers, "STARTS", {"a start": "import numpy"})
    monkeypatch.setattr(layers, "HEAVY", frozenset({"numpy", "scipy"}))
    assert layers.loaded_at_start() == ["`a start` loads numpy: import them where they are used"]
    monkeypatch.setattr(layers, "STARTS", {"a start": "raise SystemExit(3)"})
    assert "failed" in layers.loaded_at_start()[0]
