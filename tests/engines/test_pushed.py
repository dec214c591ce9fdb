"""Loads from outside against what MuJoCo makes of `xfrc_applied`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.built import built
from kit.loaded import minimal_of, random_loads
from kit.mechanisms import MECHANISMS

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.engines.mujoco import MujocoRobot

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is an optional extra")


def robot(name: str, folder: Path) -> ClosedChain:
    if name in MECHANISMS:
        return built(MECHANISMS[name](np.random.default_rng(51)).plan, folder)[0]
    return cutjoint.load(name)


@pytest.mark.parametrize("name", ["fourbar", "fivebar", "stewart", "underactuated", "floating_fourbar", "hexapod"])
def test_mujoco_pushes_alike(name: str, tmp_path: Path) -> None:
    """Generalised forces of wrenches on bodies, and accelerations under them with MuJoCo's own matrices."""
    chain, rng = robot(name, tmp_path), np.random.default_rng(52)
    theirs, at = MujocoRobot(chain), chain.home
    scale, data, model = theirs._scale, theirs._data, theirs._model
    force = scale.mass * scale.length / scale.time**2
    loads = [load for load in random_loads(chain, rng, force, 6) if load.link not in (None, chain.description.root)]
    still = np.zeros(chain.nv)
    free = theirs.opinion(at.q_full, still, still)
    alone = data.qfrc_smooth.copy()
    placed = chain.link_placements(at)
    for load in loads:
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, load.link)
        assert body > 0
        pose = placed[load.link]
        axes = np.eye(3) if load.axes == "world" else pose[:3, :3]
        push, moment = axes @ load.force / force, axes @ load.moment / scale.energy
        arm = (pose[:3, 3] + pose[:3, :3] @ load.point) / scale.length - data.xipos[body]
        data.xfrc_applied[body] += np.concatenate([push, moment + np.cross(arm, push)])
    theirs.opinion(at.q_full, still, still)
    pushed = data.qfrc_smooth - alone
    turn, _ = theirs._transform(at.q_full / theirs._q_units, still)
    found = chain.full_load_effort(at, loads)
    wanted = scale.energy * (turn.T @ pushed) / theirs.units
    size = np.abs(wanted * theirs.units).max()
    assert np.abs((found - wanted) * theirs.units).max() < 1e-9 * size
    data.xfrc_applied[:] = 0.0
    under = theirs.opinion(at.q_full, still, wanted)
    ours = chain.full_forward_dynamics(at, still, still, loads).acceleration
    largest = np.abs(under.hard / theirs.units).max()
    assert np.abs((ours - under.hard) / theirs.units).max() < 1e-6 * largest
    assert np.abs(under.hard - free.hard).max() > 0.0
    minimal = minimal_of(chain)
    a = minimal.forward_dynamics(at, np.zeros(minimal.n), np.zeros(chain.n), loads)
    assert np.abs(a - minimal.of(under.hard)).max() < 1e-6 * np.abs(under.hard).max()
