"""The report's figures of table 3 on compiled plants: the published model and the closed chain as machine code."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.compile import compiled
from cutjoint.experiments import cpm
from cutjoint.simulation import ReducedPlant, RungeKutta4, run


@pytest.mark.slow
@pytest.mark.parametrize("name", cpm.ROWS)
@pytest.mark.parametrize("source", ["equation (39)", "chain, lumped rods"])
def test_a_compiled_plant_reproduces_the_run(name: str, source: str) -> None:
    machine = compiled(cpm.model("equation") if source == "equation (39)" else cpm.chain("lumped"))
    made = cpm.controller(name, "equation")
    found = run(ReducedPlant(machine), made, cpm.reference("equation"), integrator=RungeKutta4(1e-3), every=1e-3)
    wanted = cpm.table_3_run(name, "equation")
    assert found.rmse() == pytest.approx(wanted.rmse(), rel=1e-9)
    np.testing.assert_allclose(found.tool, wanted.tool, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.effort, wanted.effort, rtol=0, atol=1e-6)
