"""What `tools/fuzz.py` does by the thousand, a few hundred of each kind: no traceback, nothing over 5 s, nothing wrong
accepted."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from attacks.judging import Attack, Wrong, judge


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "count", "must"),
    [
        ("results", 480, ("refused", "accepted")),
        ("meshes", 180, ("refused", "accepted")),
        ("robots", 600, ("refused", "accepted")),
        ("arguments", 200, ("refused", "done")),
        ("names", 81, ("refused", "done")),
        ("methods", 400, ("refused", "done")),
    ],
)
def test_attacks_are_refused_or_do_no_harm(tmp_path: Path, kind: str, count: int, must: tuple[str, ...]) -> None:
    tally = judge(import_module(f"attacks.{kind}").attacks(20, count, tmp_path))
    assert not tally.faults, f"{tally}\n" + "\n".join(tally.faults[:5])
    assert all(tally.counts.get(verdict) for verdict in must), tally


def test_the_judge_sees_what_escapes_and_what_hangs() -> None:
    def raises() -> str:
        raise ValueError("raw")

    def accepts() -> str:
        raise Wrong("accepted")

    def hangs() -> str:
        while True:
            pass

    def warns() -> str:
        return str(np.float64(1e308) * 10.0)

    acts = {"raises": raises, "accepts": accepts, "hangs": hangs, "warns": warns, "sound": lambda: "done"}
    tally = judge((Attack(name, act) for name, act in acts.items()), longest=0.1)
    assert tally.counts == {"fault": 3, "hung": 1, "done": 1}
    assert [fault.split(":")[0] for fault in tally.faults] == ["raises", "accepts", "hangs", "warns"]
