"""Mechanisms of any size and mass, anywhere: what holds for half a metre and a kilogram holds for all.

The textbooks' mechanisms are built again with lengths from 1e-4 to 1e4 times, masses from 1e-6 to 1e6 times, and with
their base ten kilometres away.  Speeds and efforts are those of the same motion at that size (gravity gives the time),
so that the dimensionless problem is the same one, and its errors may be no larger than a hundred times those of 1e-12.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import built
from kit.by_joint import placed
from kit.mechanisms import MECHANISMS
from kit.postures import moving, random_posture, scale_of
from kit.writing import Mounting

ACCURACY = 1e-10
"""Relative, the same as at scale 1."""

LENGTHS, DENSITIES = (1e-4, 1e-2, 1.0, 1e2, 1e4), (1e-6, 1.0, 1e6)


def check(name: str, length: float, density: float, folder: Path, distance: float = 1.0) -> None:
    rng = np.random.default_rng([11, *name.encode()])
    mechanism = MECHANISMS[name](rng)
    mounting = random_mounting(rng)
    near = Mounting(mounting.rpy, distance * length * mounting.xyz, mounting.gravity_turns)
    chain, oracle = built(mechanism.plan, folder, near, length, density)
    assert oracle.length == pytest.approx(chain.length)
    stops = [random_posture(chain, oracle, rng, mobility=mechanism.mobility)]
    for at in stops if mechanism.at_home else [*stops, chain.home]:
        p = placed(chain, oracle, at.q_full)
        assert p.mobility == mechanism.mobility
        rate, lengths = np.sqrt(9.81 / chain.length), scale_of(chain, oracle)
        v = rate * moving(chain, p, rng.normal(size=p.mobility))
        effort = density * 9.81 * chain.length / lengths * rng.normal(size=chain.nv)
        judge.require(judge.everything(chain, oracle, at, v, effort, rng), ACCURACY, f"{length:g} {density:g}")


@pytest.mark.parametrize(("length", "density"), [(1e-4, 1e-6), (1e4, 1e6), (1e-3, 1e3)])
@pytest.mark.parametrize("name", ["bennett", "prs_3", "geared_fivebar", "ball_rod_slider_crank"])
def test_sizes(name: str, length: float, density: float, tmp_path: Path) -> None:
    check(name, length, density, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_all_sizes_and_masses(name: str, tmp_path: Path) -> None:
    for length in LENGTHS:
        for density in DENSITIES:
            check(name, length, density, tmp_path / f"{length:g} {density:g}")


@pytest.mark.parametrize("name", ["bennett", "prs_3", "scotch_yoke", "spherical_3rrr"])
def test_ten_kilometres_away(name: str, tmp_path: Path) -> None:
    check(name, 1.0, 1.0, tmp_path, distance=1e4)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MECHANISMS if name not in ("floating_fourbar", "hexapod")])
def test_every_fixed_base_ten_kilometres_away(name: str, tmp_path: Path) -> None:
    check(name, 1.0, 1.0, tmp_path, distance=1e4)
