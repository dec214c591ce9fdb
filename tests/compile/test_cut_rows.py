"""Rows of the loops as expressions: they are the rate of what the loops are open by, for every kind of equation."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.equations.coordinates import to_rates
from cutjoint.compile.equations.cut_rows import WRITTEN
from cutjoint.compile.equations.pose import TreePose
from cutjoint.description.cuts import CutType, Kind
from cutjoint.description.model import Coupling


def agrees(chain: ClosedChain) -> None:
    source = compiled(chain, cached=False).source
    q, rng, h = chain.home.q_full, np.random.default_rng(0), 1e-6
    v = rng.normal(size=chain.nv)

    def residual(step: float) -> np.ndarray:
        at = pin.integrate(source.model, q, step * v)
        return np.array([row.residual for row in source.loops.rows(TreePose(source.tree, at.tolist()))], dtype=float)

    pose = TreePose(source.tree, q.tolist())
    u, rows = to_rates(pose, v.tolist()), source.loops.rows(pose)
    assert len(rows) == source.loops.count == len(chain.constraint_jacobian(q))
    found = np.array([sum(c * u[k] for k, c in row.coefficients.items()) for row in rows], dtype=float)
    np.testing.assert_allclose(found, (residual(h) - residual(-h)) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(residual(0.0), 0.0, atol=1e-9)
    assert [row.is_length for row in rows] == source.closure.is_length.tolist()


@pytest.mark.parametrize("kind", CutType)
def test_a_row_is_the_rate_of_its_residual(kit: Any, kind: str) -> None:
    agrees(ClosedChain(kit.two_bodies(kind)))


def test_couplings_too(kit: Any) -> None:
    gear = Coupling.geared("gear", "wrist", "shoulder", -1.5, 0.45)
    agrees(ClosedChain(replace(kit.limb_and_body("prismatic"), couplings=(gear,))))


def test_every_kind_is_written() -> None:
    assert set(WRITTEN) == set(Kind)
