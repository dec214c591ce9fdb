"""Loops in every dialect of URDF: the same robot as with a loops.toml, to the last digits of its accelerations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.in_urdf import DIALECTS, PAIRS, write

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description


def compared(dialect: str, kind: str, seed: int, folder: Path) -> tuple[np.ndarray, np.ndarray, float]:
    """Accelerations of both robots in one random motion, and how large they are without the loop."""
    rng = np.random.default_rng(seed)
    native, other = (load_description(path) for path in write(dialect, kind, rng, folder))
    joints = [joint.name for joint in native.joints]
    assert [joint.name for joint in other.joints if joint.name in joints] == joints
    assert len(other.cuts) == 1
    assert other.cuts[0].type is native.cuts[0].type
    chains = [ClosedChain(replace(one, actuators=(), homes=())) for one in (native, other)]
    q = chains[0].home.q_full
    q, v = chains[0].project(q, rng.normal(size=q.size))
    effort = rng.normal(size=v.size)
    found = [chain.full_acceleration(q, v, effort) for chain in chains]
    bare = ClosedChain(replace(native, cuts=(), actuators=(), homes=())).full_acceleration(q, v, effort)
    return found[0], found[1], float(np.abs(bare).max())


@pytest.mark.parametrize(("dialect", "kind"), [(name, kinds[0]) for name, (_, kinds) in DIALECTS.items()])
def test_a_loop_in_any_dialect_moves_the_same(dialect: str, kind: str, tmp_path: Path) -> None:
    native, other, size = compared(dialect, kind, 0, tmp_path)
    assert np.abs(native).max() > 1e-3 * size
    assert np.abs(native - other).max() <= 1e-12 * max(size, np.abs(native).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(25))
def test_many_loops_in_any_dialect_move_the_same(seed: int, tmp_path: Path) -> None:
    for dialect, kind in PAIRS:
        native, other, size = compared(dialect, kind, seed, tmp_path / f"{dialect}_{kind}")
        assert np.abs(native - other).max() <= 1e-12 * max(size, np.abs(native).max()), (dialect, kind)
